//! The fault table: `docs/faults.md` is its data, and each of its rows has one test.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;

use crate::process::Failure;
use crate::report::Tally;
use crate::tools;
use crate::workspace::{Workspace, entries};

/// Where the table lies, and where its tests.
const TABLE: &str = "docs/faults.md";
const TESTS: &str = "cli/tests/fault_table";
/// How many rows there are.
const ROWS: usize = 76;
/// The processors that row 76 builds for.
const TARGETS: [&str; 2] = ["thumbv6m-none-eabi", "thumbv7em-none-eabihf"];

/// A row, as it is written.
#[derive(Debug, PartialEq, Eq)]
struct Row<'a> {
    number: usize,
    fault: &'a str,
    outcome: &'a str,
    /// The test's name.
    test: &'a str,
}

/// How a test went.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Verdict {
    Pass,
    Fail,
    /// The machine cannot try it: why.
    NotRun(String),
}

/// Runs the tests and prints the table.
///
/// # Errors
/// A row does not pass, or rows and tests do not belong together.
pub(crate) fn run(workspace: &Workspace) -> Result<Tally, Failure> {
    let path = workspace.root.join(TABLE);
    let text = read(&path)?;
    let rows = rows(&text).map_err(Failure::Wrong)?;
    let (mut sources, mut open) = (String::new(), vec![workspace.root.join(TESTS)]);
    while let Some(place) = open.pop() {
        if place.is_dir() {
            open.extend(entries(&place)?);
        } else {
            sources += &read(&place)?;
        }
    }
    names_are_there(&rows, &sources).map_err(Failure::Wrong)?;
    // What rows 75 and 76 need. Where the latter cannot be had, the row says what is missing.
    tools::cargo_deny(workspace)?;
    // The gate looks at the dependencies of every target, and without the network.
    workspace.cargo(&["fetch", "--locked"]).stream()?;
    let _told_by_the_row = workspace.command("rustup").args(&["target", "add"]).args(&TARGETS).stream();
    let mut log = Log::default();
    // With the features of the whole workspace, by which it is built already.
    let test = ["test", "--workspace", "--test", "fault_table", "--", "--test-threads=1"];
    let cargo = workspace.cargo(&test);
    let command = cargo.line();
    let status = cargo.observe(|line| log.read(line))?;
    let verdicts = log.verdicts();
    if log.is_cut_short(status.success()) {
        return Err(Failure::Status { command, status, tally: Tally::default() });
    }
    connected(&rows, &verdicts).map_err(Failure::Wrong)?;
    let mut tally = Tally::default();
    for row in &rows {
        let (line, passes) = told(row, &verdicts);
        say!("{line}");
        match passes {
            true => tally.passed += 1,
            false => tally.failed += 1,
        }
    }
    let Tally { passed, failed, .. } = tally;
    say!("\n{passed} rows pass, {failed} do not");
    if failed == 0 {
        return Ok(tally);
    }
    say!("\n{}", log.failures.join("\n"));
    Err(Failure::Wrong(format!("{} rows of {TABLE} do not pass", tally.failed)))
}

fn read(path: &std::path::Path) -> Result<String, Failure> {
    fs::read_to_string(path).map_err(Failure::of_file(path))
}

/// The rows of the table, all of them in their order.
fn rows(text: &str) -> Result<Vec<Row<'_>>, String> {
    let lines = text.lines().skip_while(|line| !line.starts_with("|---"));
    let mut rows = Vec::new();
    for line in lines.skip(1).take_while(|line| line.starts_with('|')) {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        let [number, fault, outcome, test] = cells[..] else {
            return Err(format!("{TABLE}: not four cells: {line}"));
        };
        let wanted = rows.len() + 1;
        let number = number.parse().ok().filter(|number| *number == wanted);
        let number =
            number.ok_or_else(|| format!("{TABLE}: row {wanted} is not where it belongs: {line}"))?;
        let name = test.strip_prefix('`').and_then(|rest| rest.strip_suffix('`'));
        let test = name.filter(|name| name.starts_with(&format!("row_{number:02}_")));
        let test = test.ok_or_else(|| format!("{TABLE}: row {number} has no test of its number: {line}"))?;
        rows.push(Row { number, fault, outcome, test });
    }
    if rows.len() == ROWS { Ok(rows) } else { Err(format!("{TABLE}: {} rows of {ROWS}", rows.len())) }
}

/// What a row calls by its name is what a test looks for.
fn names_are_there(rows: &[Row<'_>], sources: &str) -> Result<(), String> {
    for row in rows {
        // Every other piece is between two ticks.
        let names = row.outcome.split('`').skip(1).step_by(2);
        if let Some(name) = names.into_iter().find(|name| !sources.contains(name)) {
            return Err(format!("{TABLE}: row {}: no test in {TESTS} knows `{name}`", row.number));
        }
    }
    Ok(())
}

/// Each test belongs to a row, and each row's test is there.
fn connected(rows: &[Row<'_>], verdicts: &BTreeMap<String, Verdict>) -> Result<(), String> {
    let named: BTreeSet<&str> = rows.iter().map(|row| row.test).collect();
    if let Some(stray) = verdicts.keys().find(|test| !named.contains(test.as_str())) {
        return Err(format!("{stray} belongs to no row of {TABLE}"));
    }
    match named.into_iter().find(|test| !verdicts.contains_key(*test)) {
        Some(absent) => Err(format!("{TABLE} names {absent}, and there is no such test in {TESTS}")),
        None => Ok(()),
    }
}

/// A row's line, and whether it passes.
fn told(row: &Row<'_>, verdicts: &BTreeMap<String, Verdict>) -> (String, bool) {
    let (verdict, passes) = match verdicts.get(row.test) {
        Some(Verdict::Pass) => ("pass", true),
        Some(Verdict::NotRun(why)) => (why.as_str(), false),
        Some(Verdict::Fail) | None => ("FAIL", false),
    };
    (format!("{:>2}  {:<58}  {verdict:<4}  {}", row.number, row.fault, row.test), passes)
}

/// What the test program writes.
#[derive(Default)]
struct Log {
    passed: BTreeMap<String, bool>,
    /// Of tests that failed, why they could not be run.
    why: BTreeMap<String, String>,
    /// Whose output is being read.
    of: Option<String>,
    failures: Vec<String>,
}

impl Log {
    fn read(&mut self, line: &str) {
        let bare = |path: &str| path.rsplit("::").next().unwrap_or(path).to_owned();
        if let Some((path, result)) = line.strip_prefix("test ").and_then(|rest| rest.split_once(" ... "))
            && (result == "ok" || result == "FAILED")
        {
            self.passed.insert(bare(path), result == "ok");
        } else if let Some(path) =
            line.strip_prefix("---- ").and_then(|rest| rest.strip_suffix(" stdout ----"))
        {
            self.of = Some(bare(path));
        }
        if let Some(of) = &self.of {
            self.failures.push(line.to_owned());
            if line.starts_with("not run: ") {
                self.why.entry(of.clone()).or_insert_with(|| line.to_owned());
            }
        }
    }

    /// Whether cargo failed for another reason than a test that failed: nothing was built, or it died on its way.
    fn is_cut_short(&self, succeeded: bool) -> bool {
        !succeeded && self.passed.values().all(|passed| *passed)
    }

    fn verdicts(&self) -> BTreeMap<String, Verdict> {
        let verdict = |(test, passed): (&String, &bool)| {
            let verdict = match self.why.get(test) {
                _ if *passed => Verdict::Pass,
                Some(why) => Verdict::NotRun(why.clone()),
                None => Verdict::Fail,
            };
            (test.clone(), verdict)
        };
        self.passed.iter().map(verdict).collect()
    }
}

#[cfg(test)]
mod tests;
