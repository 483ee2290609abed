use super::*;
use std::path::Path;

/// The table of this workspace.
fn table() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(TABLE);
    fs::read_to_string(path).expect("it is there")
}

fn log(lines: &[&str]) -> BTreeMap<String, Verdict> {
    let mut log = Log::default();
    lines.iter().for_each(|line| log.read(line));
    log.verdicts()
}

#[test]
fn a_table_with_a_row_too_few_too_many_or_of_another_test_is_refused() {
    let table = table();
    assert_eq!(rows(&table).map(|rows| rows.len()), Ok(ROWS));
    let row =
        |number: usize| table.lines().find(|line| line.starts_with(&format!("| {number} |"))).expect("a row");
    let planted = [
        table.replace(&format!("{}\n", row(7)), ""),
        table.replace(row(76), &format!("{}\n{}", row(76), row(76).replace("76", "77"))),
        table.replace(row(7), &format!("{}\n{}", row(7), row(7))),
        table.replace("`row_07_", "`row_08_"),
        table.replace("`row_07_", "`"),
        table.replace("`row_68_", "not run: `row_68_"),
        table.replace("| 7 | edge capacity", "| 7 | edge | capacity"),
    ];
    for (i, planted) in planted.iter().enumerate() {
        assert_ne!(*planted, table, "plant {i} took");
        assert!(rows(planted).is_err(), "plant {i}");
    }
}

#[test]
fn a_name_that_no_test_looks_for_is_refused() {
    let table = "|---|\n".to_owned();
    let row = Row { number: 1, fault: "", outcome: "`A::B`; and `c`", test: "" };
    assert_eq!(names_are_there(&[row], "assert_eq!(c, Err(A::B))"), Ok(()));
    let row = Row { number: 1, fault: "", outcome: "`A::B`", test: "" };
    assert!(names_are_there(&[row], "A::C").is_err());
    assert!(rows(&table).is_err(), "no rows at all");
}

#[test]
fn a_test_without_a_row_and_a_row_without_a_test_are_refused() {
    let row = || Row { number: 1, fault: "f", outcome: "", test: "row_01_a" };
    let of = |names: &[&str]| names.iter().map(|name| ((*name).to_owned(), Verdict::Pass)).collect();
    assert_eq!(connected(&[row()], &of(&["row_01_a"])), Ok(()));
    assert!(connected(&[row()], &of(&[])).is_err());
    assert!(connected(&[row()], &of(&["row_01_a", "row_01_b"])).is_err());
}

#[test]
fn what_failed_or_was_not_run_does_not_pass() {
    let verdicts = log(&[
        "running 3 tests",
        "test graph::row_01_a ... ok",
        "test host::row_02_b ... FAILED",
        "test host::row_03_c ... FAILED",
        "",
        "failures:",
        "",
        "---- host::row_02_b stdout ----",
        "thread 'host::row_02_b' panicked at host.rs:1:1:",
        "assertion failed",
        "---- host::row_03_c stdout ----",
        "thread 'host::row_03_c' panicked at rights.rs:1:1:",
        "not run: needs root",
        "test result: FAILED. 1 passed; 2 failed; 0 ignored",
    ]);
    let row = |number, test| Row { number, fault: "f", outcome: "", test };
    let told = |row: &Row<'_>| told(row, &verdicts);
    assert!(told(&row(1, "row_01_a")).1);
    let (line, passes) = told(&row(2, "row_02_b"));
    assert!(line.contains("FAIL") && !passes, "{line}");
    let (line, passes) = told(&row(3, "row_03_c"));
    assert!(line.contains("not run: needs root") && !passes, "{line}");
    assert!(!told(&row(4, "row_04_d")).1, "it was not even there");
}

#[test]
fn a_build_that_fails_is_no_matter_of_rows() {
    let is_cut_short = |lines: &[&str], succeeded| {
        let mut log = Log::default();
        lines.iter().for_each(|line| log.read(line));
        log.is_cut_short(succeeded)
    };
    let (good, bad) = ("test graphs::row_01_a ... ok", "test graphs::row_02_b ... FAILED");
    assert!(is_cut_short(&[], false), "it does not compile");
    assert!(is_cut_short(&[good], false), "it died between two tests");
    assert!(!is_cut_short(&[good, bad], false) && !is_cut_short(&[good], true));
}
