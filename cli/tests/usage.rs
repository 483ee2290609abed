//! Wrong usage: what was given, escaped and cut, and what was expected.

mod process;
#[path = "process/refused.rs"]
mod refusal;

use process::{command, ended, file, run};

const CRUISE: &str = "examples/cruise.toml";

fn refused(arguments: &[&str], words: &[&str]) -> String {
    refusal::refused(run(arguments), 2, words)
}

#[test]
fn a_wrong_value_is_told_with_what_was_expected() {
    for seed in ["-1", "x", "", "1.5", "18446744073709551616"] {
        refused(&["sim", CRUISE, "--seed", seed], &["--seed", "expected a whole number from 0"]);
    }
    for (subcommand, option) in [("sim", "--horizon"), ("run", "--duration"), ("demo", "--duration")] {
        let mut arguments = vec![subcommand, CRUISE, option, "-1s"];
        arguments.retain(|argument| subcommand != "demo" || *argument != CRUISE);
        refused(&arguments, &["invalid value '-1s'", option, "such as 60s"]);
    }
    refused(&["sim", CRUISE, "--horizon", "4611686019s"], &["--horizon", "146 years"]);
    refused(&["sim", CRUISE, "--policy", "EDF"], &["'EDF'", "a similar value exists: 'edf'"]);
}

#[test]
fn foreign_text_reaches_no_terminal_as_it_is() {
    let forged = "a\u{1b}[0m\nerror: /etc/passwd: forged line";
    let long = format!("\u{1b}[0m{}", "x".repeat(5_000));
    for arguments in [
        &["plan", CRUISE, forged][..],
        &["plan", CRUISE, &long],
        &["sim", CRUISE, "--policy", "\u{1b}[0m\u{202e}\r\u{8}x"],
        &["sim", CRUISE, "--seed", "\u{1b}[31mred"],
        &["plan", CRUISE, "-\u{202e}a"],
        &[forged],
    ] {
        let err = refused(arguments, &["\\u{"]);
        assert!(err.chars().count() < 500 && !err.contains('\u{202e}'), "{err}");
        assert!(!err.contains("\nerror:"), "{err}");
    }
}

#[test]
fn a_trace_without_a_place_is_refused_before_anything_runs() {
    let node = "node = [{ name = \"a\", wcet = \"1ms\", body = { spin = \"10us\" } }]\n";
    let task = "[[task]]\nname = \"t\"\nperiod = \"10ms\"\ndeadline = \"20s\"\n";
    let path = file(
        "usage-trace.toml",
        format!("pool = [{{ name = \"cpu\", lanes = 1 }}]\n{task}{node}").as_bytes(),
    );
    let long = format!("{}/t.json", "no-such-folder".repeat(9));
    for (place, words) in [
        ("no-such-folder/t.json", "`no-such-folder/t.json`"),
        ("no-such-folder/\u{1b}[31m.json", "\\u{1b}[31m.json`"),
        (&long, "`…"),
        ("models", "is a directory"),
    ] {
        let run = ["run", path.to_str().unwrap(), "--best-effort", "--duration", "600s", "--trace", place];
        refused(&run, &["cannot write the trace", words]);
    }
}

#[test]
fn a_trace_never_takes_the_place_of_the_workload() {
    let text = "pool = [{ name = \"cpu\", lanes = 1 }]\n[[task]]\nname = \"t\"\nonce = true\ndeadline = \"1s\"\n\
                node = [{ name = \"a\", wcet = \"1ms\", body = { spin = \"10us\" } }]\n";
    let path = file("usage-itself.toml", text.as_bytes());
    let (soft, hard) = (path.with_extension("soft"), path.with_extension("hard"));
    for link in [&soft, &hard] {
        let _none_there = std::fs::remove_file(link);
    }
    std::os::unix::fs::symlink(&path, &soft).unwrap();
    std::fs::hard_link(&path, &hard).unwrap();
    let roundabout = path.parent().unwrap().join("../tmp/usage-itself.toml");
    for trace in [&path, &soft, &hard, &roundabout] {
        let run = ["run", path.to_str().unwrap(), "--best-effort", "--trace", trace.to_str().unwrap()];
        refused(&run, &["is the workload file itself"]);
    }
    assert_eq!(std::fs::read_to_string(&path).unwrap(), text);
}

#[test]
fn a_run_of_no_time_is_refused() {
    for arguments in [&["run", CRUISE, "--duration", "0s"][..], &["demo", "--duration", "0ms"]] {
        refused(arguments, &["--duration", "expected more than 0"]);
    }
}

#[test]
fn a_simulation_tells_why_jobs_were_given_up() {
    let task = "[[task]]\nname = \"t\"\nperiod = \"1ms\"\ndeadline = \"1s\"\nnode = [{ name = \"a\", wcet = \"9ms\" }]\n";
    let path =
        file("usage-full.toml", format!("pool = [{{ name = \"cpu\", lanes = 1 }}]\n{task}").as_bytes());
    let sim = |more: &[&str]| {
        let (status, out, err) =
            run(&[&["sim", path.to_str().unwrap(), "--policy", "edf", "--horizon", "1s"], more].concat());
        assert_eq!(status, 0, "{err}");
        out
    };
    let listed = sim(&["--schedule"]);
    assert!(
        listed.contains("t gave up: full ") && listed.contains("full: no place for a 65th job"),
        "{listed}"
    );
    assert!(sim(&[]).contains("t gave up: full "), "also where they are not listed");
    let (_, none, _) = run(&["sim", CRUISE, "--schedule", "--horizon", "1s"]);
    assert!(!none.contains("reason"), "{none}");
}

#[test]
fn margins_and_sums_are_exact_or_refused() {
    let task = |name: &str, node: &str| {
        format!(
            "[[task]]\nname = \"{name}\"\ndeadline = \"1ns\"\nperiod = \"1ns\"\n\
             node = [{{ name = \"a\", wcet = \"18446744073709551615ns\", {node} }}]\n"
        )
    };
    let pool = "pool = [{ name = \"cpu\", lanes = 1 }]\n";
    let late = file("margin.toml", format!("{pool}{}", task("t", "")).as_bytes());
    let (status, out, _) = ended(&command(&["plan", "--json"]).arg(&late).output().unwrap());
    assert_eq!(status, 1);
    assert!(out.contains(r#""margin_ns":-18446744073709551614}"#), "{out}");
    let (_, out, _) = ended(&command(&["plan"]).arg(&late).output().unwrap());
    assert!(out.contains("margin -18446744073.709 s"), "{out}");

    let huge = "memory = \"17179869183GiB\"";
    let both = file("memory.toml", format!("{pool}{}{}", task("t", huge), task("u", huge)).as_bytes());
    for subcommand in ["plan", "sim", "run"] {
        refused(&[subcommand, both.to_str().unwrap()], &["memory.toml:11:18:", "sum", "overflows 64 bits"]);
    }
}
