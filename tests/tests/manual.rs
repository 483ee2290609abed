//! The manual of the workload file is true: its examples are read, and its tables name the keys that the reader takes.

use std::collections::BTreeSet;
use std::panic::resume_unwind;
use std::thread;

use red_sim::{Execution, Lab, Options, simulate};
use red_workload::model::Workload;
use red_workload::plan::plan;
use red_workload::policy::Policy;
use red_workload::{Format, Refusal, parse};

const MANUAL: &str = include_str!("../../docs/workload-file.md");

/// Heads of the manual's tables, each with the text that opens such a table in the TOML example.
const TABLES: [(&str, &str); 9] = [
    ("## The file\n", ""),
    ("## Pool\n", "[[pool]]\n"),
    ("## Sensor\n", "[[sensor]]\n"),
    ("## Task\n", "[[task]]\n"),
    ("## Stage\n", "[task.node.mimonet]\n"),
    ("| key of `cuda` |", "[task.node.mimonet.decoders.body.cuda]\n"),
    ("## Event\n", "[[event]]\n"),
    ("## Sync\n", "[sync]\n"),
    // Inline: a comma after it.
    ("## Body\n", "body = { "),
];

/// The manual's code block of a language.
fn example(language: &str) -> &'static str {
    let (_, block) = MANUAL.split_once(&format!("```{language}\n")).expect("there is such a block");
    block.split_once("```").expect("the block ends").0
}

fn read(format: Format) -> Workload {
    let language = if format == Format::Toml { "toml" } else { "yaml" };
    parse(example(language).as_bytes(), format, language).unwrap_or_else(|error| panic!("{error}"))
}

/// The first column of the first table with keys after `head`.
fn documented(head: &str) -> BTreeSet<&'static str> {
    let at = MANUAL.find(head).expect("the manual has this place");
    let rows = MANUAL[at..].lines().skip_while(|line| !line.starts_with("| key")).skip(2);
    rows.map_while(|row| row.strip_prefix("| `")?.split('`').next()).collect()
}

/// The keys that the reader takes where `opening` opens a table of this text: the refusal of another key lists them.
fn taken(text: &str, opening: &str) -> BTreeSet<String> {
    let end = if opening.ends_with("{ ") { ", " } else { "\n" };
    let planted = text.replacen(opening, &format!("{opening}planted = 1{end}"), 1);
    let error = parse(planted.as_bytes(), Format::Toml, "planted").expect_err("a key that no table has");
    assert_eq!(error.refusal, Refusal::UnknownKey, "{error}");
    error.expected.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

#[test]
fn both_examples_are_one_workload_that_can_be_planned_and_simulated() {
    let workload = read(Format::Toml);
    assert_eq!(workload, read(Format::Yaml));
    let all = || {
        assert!(plan::<Lab>(&workload).expect("the example can be planned").admission.fits);
        for policy in Policy::ALL {
            let (execution, horizon_ns) = (Execution::Wcet, 7_000_000_000);
            let options = Options { policy, horizon_ns, seed: 1, execution, preempt: false, schedule: false };
            let report = simulate(&workload, &options).expect("the example can be simulated");
            assert!(report.tasks.iter().all(|task| task.released > 0), "{policy}");
        }
    };
    // A scheduler for the largest workload file does not fit the stack that a test's thread gets.
    thread::scope(|scope| {
        let thread = thread::Builder::new().stack_size(64 << 20).spawn_scoped(scope, all);
        thread.expect("a thread for the test").join().unwrap_or_else(|panic| resume_unwind(panic));
    });
}

#[test]
fn the_tables_name_the_keys_that_the_reader_takes() {
    let text = example("toml");
    let agree = |head: &str, opening: &str| {
        let taken = taken(text, opening);
        assert_eq!(documented(head), taken.iter().map(String::as_str).collect(), "{head}");
    };
    assert_ne!(documented("## Pool\n"), documented("## Sensor\n"));
    for (head, opening) in TABLES {
        agree(head, opening);
    }
    // A node of an event takes all keys of a node, and `before`.
    agree("## Node\n", "add  = [{ ");
}

#[test]
fn the_example_has_every_key_of_the_tables() {
    let text = example("toml");
    let has = |key: &str| {
        let before =
            |at: usize| text[..at].chars().next_back().is_none_or(|c| !c.is_alphanumeric() && c != '_');
        let after = |at: usize| text[at + key.len()..].trim_start().starts_with(['=', ']', '.']);
        text.match_indices(key).any(|(at, _)| before(at) && after(at))
    };
    assert!(!has("planted") && has("min_interarrival"));
    for (head, _) in TABLES.into_iter().chain([("## Node\n", "")]) {
        let missing: Vec<&str> = documented(head).into_iter().filter(|key| !has(key)).collect();
        assert!(missing.is_empty(), "{head}: {missing:?}");
    }
}
