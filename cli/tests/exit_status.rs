//! Exit statuses, and what goes where: answers to standard output, everything else to standard error.

mod process;
#[path = "process/refused.rs"]
mod refusal;

use process::{command, ended, file, run};
use std::process::Stdio;

const SUBCOMMANDS: [&str; 7] = ["demo", "plan", "verify", "sim", "run", "profile", "doctor"];

const TIGHT: &str = r#"
pool = [{ name = "gpu", lanes = 1 }]
[[task]]
name = "t"
deadline = "10ms"
period = "10ms"
node = [{ name = "a", wcet = "8ms" }, { name = "b", wcet = "8ms" }]
"#;

/// Every bound of one task holds, and the pool is exactly full.
const BLOCKED: &str = r#"
pool = [{ name = "gpu", lanes = 1 }]
[[task]]
name = "short"
deadline = "10ms"
period = "11ms"
offset = "500us"
node = [{ name = "a", wcet = "5ms" }]
[[task]]
name = "long"
deadline = "20ms"
period = "11ms"
node = [{ name = "a", wcet = "6ms" }]
"#;

fn refused(arguments: &[&str], words: &[&str]) {
    refusal::refused(run(arguments), 2, words);
}

#[test]
fn every_help_has_an_example() {
    for subcommand in SUBCOMMANDS {
        let (status, out, err) = run(&[subcommand, "--help"]);
        assert_eq!((status, &*err), (0, ""), "{subcommand}");
        assert!(out.contains("Example") && out.contains(&format!("redrt {subcommand}")), "{out}");
    }
    let (status, out, _) = run(&["--help"]);
    assert_eq!(status, 0);
    assert!(SUBCOMMANDS.iter().all(|subcommand| out.contains(subcommand)), "{out}");
    assert!(out.contains("Example") && out.contains("`redrt demo`"), "{out}");
}

#[test]
fn wrong_usage_is_refused() {
    refused(&["plna"], &["plan"]);
    refused(&["plan"], &["<FILE>"]);
    refused(&["plan", "examples/cruise.toml", "--jsno"], &["--json"]);
    refused(&["sim", "examples/cruise.toml", "--policy", "redtr"], &["redtr", "'redrt'"]);
    for horizon in ["60", "-1s", "1.5s", "1h", "nan", "", "99999999999999999999s"] {
        refused(
            &["sim", "examples/cruise.toml", &format!("--horizon={horizon}")],
            &["--horizon", "such as 60s"],
        );
    }
    for model in ["uniform:1..0", "uniform", "gauss:0..1"] {
        refused(&["sim", "examples/cruise.toml", "--execution", model], &["uniform:LOW..HIGH"]);
    }
    refused(&["sim", "examples/cruise.toml", "--seed=-1"], &["--seed"]);
    refused(&["--json", "plan", "examples/cruise.toml"], &["plan"]);
}

#[test]
fn a_bound_that_sharing_may_break_is_told_not_to_be_sufficient() {
    let stage = |name: &str, encoder: &str| {
        format!(
            "[[task.node]]\nname = '{name}'\n[task.node.mimonet]\nweights = 'w'\nframe = 'f'\n\
             encoder = {{ wcet = '{encoder}' }}\ndecoders = [{{ name = 'd', wcet = '1ms' }}]\n"
        )
    };
    let head =
        "pool = [{ name = 'gpu', lanes = 2 }]\n[[task]]\nname = 't'\ndeadline = '30ms'\nperiod = '30ms'\n";
    let of_file = |encoder| {
        let text = format!("{head}{}{}", stage("p", "1ms"), stage("q", encoder));
        let path = file(&format!("encoder-{encoder}.toml"), text.as_bytes());
        run(&["plan", path.to_str().unwrap()])
    };
    let (_, even, _) = of_file("1ms");
    assert!(even.contains("alone: ") && !even.contains("not sufficient"), "{even}");
    let (_, uneven, _) = of_file("9ms");
    assert!(
        uneven.contains("not sufficient, for an encoder may wait for a longer one of its frame"),
        "{uneven}"
    );
}

#[test]
fn foreign_text_in_a_message_is_cut_and_escaped() {
    let long = "x".repeat(100_000);
    refused(&["sim", "examples/cruise.toml", "--policy", &long], &["…"]);
    refused(&[&long], &["…"]);
    refused(&["plan", &long], &["…"]);
    let (_, _, err) = run(&["plan", "examples/cruise.toml", "\u{1b}[31m"]);
    assert!(!err.contains('\u{1b}'), "{err:?}");
}

#[test]
fn files_that_are_no_workload_are_refused() {
    let empty = file("empty.toml", b"");
    let binary = file("binary.toml", &[0, 159, 146, 150]);
    let truncated = file("truncated.toml", b"pool = [{ name = \"gpu\"");
    let misspelt = file("misspelt.toml", TIGHT.replace("deadline", "dedline").as_bytes());
    for subcommand in ["plan", "sim", "run"] {
        refused(&[subcommand, "no-such-file.toml"], &["no-such-file.toml"]);
        refused(&[subcommand, "examples"], &["a directory"]);
        for path in [&empty, &binary, &truncated] {
            refused(&[subcommand, path.to_str().unwrap()], &["expected"]);
        }
        refused(&[subcommand, misspelt.to_str().unwrap()], &[":5:1:", "dedline", "did you mean `deadline`?"]);
    }
    refused(&["plan", misspelt.to_str().unwrap(), "--json"], &["deadline"]);
}

#[test]
fn what_fits_is_yes_and_what_does_not_is_no() {
    let (status, out, _) = run(&["plan", "examples/cruise.toml"]);
    assert_eq!(status, 0);
    assert!(out.contains("fits: yes") && out.contains("perception.encoder"), "{out}");

    let tight = file("tight.toml", TIGHT.as_bytes());
    let tight = tight.to_str().unwrap();
    let (status, out, err) = run(&["plan", tight]);
    assert_eq!((status, &*err), (1, ""));
    assert!(out.contains("fits: no") && out.contains("pool `gpu`: 2 lanes"), "{out}");

    let (status, out, err) = run(&["plan", tight, "--json"]);
    assert_eq!(status, 1);
    assert!(out.contains(r#""fits":false"#), "{out}");
    assert!(err.contains("does not fit"), "{err}");

    let (status, _, _) = run(&["sim", tight, "--horizon", "1s"]);
    assert_eq!(status, 0, "a simulation that shows misses is done all the same");
}

#[test]
fn a_workload_that_misses_in_a_simulation_does_not_fit_although_every_bound_holds() {
    let blocked = file("blocked.toml", BLOCKED.as_bytes());
    let (status, out, err) = run(&["plan", blocked.to_str().unwrap(), "--json"]);
    assert_eq!(status, 1);
    assert!(out.contains(r#""fits":false,"guarantee":"best-effort""#), "{out}");
    assert!(err.contains("does not fit: every bound holds, but in a simulation"), "{err}");
}

#[test]
fn a_reader_that_has_gone_is_no_failure() {
    for closed in ["1", "2", "1 2"] {
        let mut command = command(&["sim", "examples/cruise.toml", "--schedule", "--json"]);
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().expect("the command starts");
        if closed.contains('1') {
            drop(child.stdout.take());
        }
        if closed.contains('2') {
            drop(child.stderr.take());
        }
        let (status, _, err) = ended(&child.wait_with_output().unwrap());
        assert_eq!((status, &*err), (0, ""), "closed {closed}");
    }
    let mut bad = command(&["plan", "no-such-file.toml"]);
    let mut child = bad.stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stderr.take());
    assert_eq!(child.wait().unwrap().code(), Some(2));
}

#[test]
fn an_answer_that_cannot_be_written_is_a_failure_of_the_machine() {
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").expect("Linux has it");
    let mut command = command(&["plan", "examples/cruise.toml"]);
    let (status, _, err) = ended(&command.stdout(full).output().unwrap());
    assert_eq!(status, 3);
    assert!(err.contains("cannot write"), "{err}");
}

#[test]
fn the_doctor_says_no_exactly_when_a_check_fails() {
    let (status, out, err) = run(&["doctor", "--quick"]);
    let starts = |severity: &str| out.lines().filter(|line| line.starts_with(severity)).count();
    assert_eq!(status, i32::from(starts("FAIL ") > 0), "{out}");
    assert_eq!(err, "");
    assert_eq!(starts("PASS ") + starts("WARN ") + starts("FAIL ") + 1, out.lines().count(), "{out}");
}
