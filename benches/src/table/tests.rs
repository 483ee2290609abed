use super::*;
use crate::not_run::NotRun;

fn row(name: &str, figure: f64) -> Row {
    Row { name: name.to_owned(), ours: name == "red", rounds: Ok(vec![figure; 3]) }
}

fn table(must: &[Must], rows: Vec<Row>) -> Table<'_> {
    Table { title: "t".to_owned(), unit: "ns", reference: "base", must, rows }
}

#[test]
fn a_ratio_at_its_bound_is_kept_and_one_over_it_is_not() {
    let rows = || vec![row("base", 10.0), row("red", 15.0)];
    assert_eq!(table(&[Must::Ratio(1.5)], rows()).print(), Outcome { above: 0, missing: 0, absent: 0 });
    assert_eq!(table(&[Must::Ratio(1.4)], rows()).print(), Outcome { above: 1, missing: 0, absent: 0 });
    assert!(table(&[Must::Ratio(1.4)], rows()).to_string().contains("ABOVE"));
}

#[test]
fn below_peers_means_below_each_but_not_below_the_ideal() {
    let rows = |peer| vec![row("base", 10.0), row("peer", peer), row("red", 10.5)];
    assert_eq!(table(&[Must::RatioBelowPeers(1.1)], rows(11.0)).print().above, 0);
    let level = table(&[Must::RatioBelowPeers(1.1)], rows(10.5));
    assert_eq!(level.print().above, 1);
    assert!(level.to_string().contains("ABOVE: not below peer"));
    let mut absent = rows(11.0);
    absent[1].rounds = Err(NotRun::Unpackaged("bring your own"));
    assert!(table(&[Must::RatioBelowPeers(1.1)], absent).to_string().contains("ok, of those at hand"));
}

#[test]
fn a_figure_needs_no_reference() {
    assert_eq!(table(&[Must::Figure(9.0)], vec![row("red", 10.0)]).print().above, 1);
}

#[test]
fn a_missing_tool_fails_and_an_unpackaged_one_is_shown() {
    let absent = |why| vec![Row { name: "base".to_owned(), ours: false, rounds: Err(why) }, row("red", 1.0)];
    assert_eq!(table(&[Must::Ratio(1.0)], absent(NotRun::Missing("g++"))).print().missing, 1);
    let unpackaged = table(&[Must::Ratio(1.0)], absent(NotRun::Unpackaged("bring your own")));
    assert_eq!(unpackaged.print(), Outcome { absent: 1, ..Outcome::default() });
    assert!(unpackaged.to_string().contains("not run: bring your own"));
}

#[test]
fn each_row_of_ours_has_its_bound_and_the_last_bound_goes_for_the_rest() {
    let bounds = [Must::Figure(10.0), Must::Figure(20.0)];
    let rows = |figures: [f64; 3]| figures.map(|figure| row("red", figure)).into();
    assert_eq!(table(&bounds, rows([10.0, 20.0, 20.0])).print().above, 0);
    assert_eq!(table(&bounds, rows([11.0, 20.0, 21.0])).print().above, 2);
}
