use super::*;

fn table() -> Table {
    let column = |head: &str, measures: &str, is_paper| Column {
        head: head.into(),
        measures: measures.into(),
        is_paper,
    };
    Table {
        name: "one".into(),
        title: "A <title>".into(),
        columns: vec![
            column("system", "system", false),
            column("latency, paper (s)", "latency", true),
            column("latency (s)", "latency", false),
        ],
        rows: vec![vec![
            Cell::Words("EDF".into()),
            Cell::Number("10".into(), Some((10.0, 0.0))),
            Cell::Number("5 ± 1".into(), Some((5.0, 1.0))),
        ]],
        claims: vec![Claim {
            claim: "faster".into(),
            paper: "-24.7 %".into(),
            ours: "-18.0 ± 0.2 %".into(),
            verdict: "shape only".into(),
            why: "another machine".into(),
        }],
        ..Table::default()
    }
}

#[test]
fn a_value_and_the_papers_have_one_scale() {
    let page = page(&Head::default(), &[table()]);
    assert!(page.contains("<i class=\"k-paper\" style=\"margin-left:0.0%;width:100.0%\"></i>"), "{page}");
    assert!(
        page.contains(
            "<i class=\"k-ours\" style=\"margin-left:0.0%;width:50.0%\"></i><u style=\"left:40.0%;width:20.0%\"></u>"
        )
    );
    assert!(page.contains("A &lt;title&gt;") && !page.contains("A <title>"));
}

#[test]
fn changes_in_percent_are_drawn_and_other_words_are_not() {
    assert_eq!(percent("-18.0 ± 0.2 %"), Some((-18.0, 0.2)));
    assert_eq!(percent("+34.8 %"), Some((34.8, 0.0)));
    for words in ["30.0 %", "low", "-33.2 % by its table, -23.2 % by its text", ""] {
        assert_eq!(percent(words), None, "{words}");
    }
    let page = page(&Head::default(), &[table()]);
    assert!(
        page.contains("aria-label=\"here -18.0 %, the paper -24.7 %\"")
            && page.contains("badge fair\">shape only")
    );
}

#[test]
fn what_is_below_zero_goes_the_other_way() {
    let mut table = table();
    table.rows[0][2] = Cell::Number("-30 ± 10".into(), Some((-30.0, 10.0)));
    let page = page(&Head::default(), &[table]);
    let low = "<i class=\"k-ours\" style=\"margin-left:20.0%;width:60.0%\"></i><b style=\"left:80.0%\"></b>\
               <u style=\"left:0.0%;width:40.0%\"></u>";
    assert!(page.contains(low), "{page}");
}
