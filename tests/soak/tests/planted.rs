//! The soak finds what is planted, and keeps what repeats it. All without real-time rights.

use red_record::{Reader, replay};
use red_workload::policy::Policy;
use red_workload::{Format, build, parse};
use std::fs::{self, File};
use std::io::BufReader;
use std::os::unix::fs::MetadataExt;
use std::path::PathBuf;
use std::process::{Child, Command, Output, Stdio};
use std::sync::{Mutex, PoisonError};
use std::thread;

/// As `redrt` has it.
type Robot = red_core::Caps<16, 256, 64, 32, 32, 4, 4096>;

/// A soak whose logs lie in a folder of the test, which is empty before.
fn soak(test: &str, words: &[&str]) -> (Output, String, PathBuf) {
    watched(test, words, |_, _| {})
}

/// The same, with something to do while it runs.
fn watched(
    test: &str,
    words: &[&str],
    meanwhile: impl FnOnce(&mut Child, &PathBuf),
) -> (Output, String, PathBuf) {
    // Where real-time rights are there, the lanes of two would keep the CPU from each other.
    static ALONE: Mutex<()> = Mutex::new(());
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(test);
    let _none = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).expect("a folder of the target");
    let mut command = Command::new(env!("CARGO_BIN_EXE_red-soak"));
    command.args(["--best-effort", "--length-ms", "150"]).args(words).env("TMPDIR", &folder);
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("the program starts");
    meanwhile(&mut child, &folder);
    let output = child.wait_with_output().expect("it ends");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    (output, text, folder)
}

/// The logs that were kept.
fn logs(folder: &PathBuf) -> Vec<PathBuf> {
    fs::read_dir(folder).expect("it is there").map(|entry| entry.expect("readable").path()).collect()
}

#[test]
fn a_soak_without_faults_of_ours_is_clean_and_leaves_nothing() {
    let (output, text, folder) = soak("clean", &["--workloads", "24", "--length-ms", "300"]);
    assert_eq!(output.status.code(), Some(0), "{text}");
    assert!(text.contains("soak: clean") && text.contains("bytes a workload"), "{text}");
    assert_eq!(logs(&folder), Vec::<PathBuf>::new());
}

#[test]
fn a_kibibyte_that_each_workload_leaves_behind_is_found() {
    let (output, text, _) = soak("leak", &["--workloads", "32", "--plant", "leak"]);
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(text.contains("VIOLATION: memory grows"), "{text}");
}

#[test]
fn a_replay_that_differs_is_found() {
    let (output, text, _) = soak("replay", &["--workloads", "1", "--plant", "replay"]);
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(text.contains("VIOLATION: seed 1") && text.contains("is replayed as"), "{text}");
}

#[test]
fn a_soak_that_edits_nothing_is_not_clean() {
    let (output, text, _) = soak("edits", &["--workloads", "12", "--plant", "edits"]);
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(text.contains("it never happened: edits committed"), "{text}");
}

#[test]
fn what_repeats_a_violation_is_kept_and_named() {
    let (output, text, folder) = soak("start", &["--workloads", "1", "--seed", "6", "--plant", "start"]);
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(text.contains("VIOLATION: seed 6") && text.contains("a second time"), "{text}");
    assert!(text.contains("again: cargo xtask soak --workloads 1 --seed 6"), "{text}");
    let [log] = &logs(&folder)[..] else { panic!("one log: {folder:?}") };
    assert!(text.contains(&format!("redrt replay {}", log.display())), "{text}");
    // As `redrt replay` does it: from the log alone.
    let mut reader = Reader::new(BufReader::new(File::open(log).expect("kept"))).expect("a whole log");
    let header = reader.header();
    let policy: Policy = header.policy.parse().expect("known");
    let workload = parse(header.workload.as_bytes(), Format::Toml, &header.file).expect("valid");
    let mut scheduler = Box::new(red_core::Scheduler::<Robot>::new(policy.config()));
    let (plan, tasks) = build::admit(&mut scheduler, &workload, policy.config()).expect("valid");
    let change = |scheduler: &mut red_core::Scheduler<Robot>, number: u32, now| {
        let change = plan.changes.get(number as usize).ok_or(red_core::CommitError::UnknownTask)?;
        build::apply(scheduler, change, tasks[change.task], now)
    };
    let found = replay(&mut reader, &mut scheduler, change, |_, _| {}).expect("readable");
    assert!(found.difference.is_none() && found.inputs > 0, "{found:?}");
}

#[test]
fn a_signal_ends_it_with_its_summary() {
    let stop = |child: &mut Child, folder: &PathBuf| {
        while logs(folder).is_empty() && child.try_wait().expect("ours").is_none() {
            thread::yield_now();
        }
        let told = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
        assert!(told.expect("every system has it").success());
    };
    let (output, text, folder) = watched("stop", &["--minutes", "10"], stop);
    assert_eq!(output.status.code(), Some(0), "{text}");
    assert!(text.contains("jobs released") && text.contains("soak: stopped by SIGINT"), "{text}");
    assert_eq!(logs(&folder), Vec::<PathBuf>::new());
}

/// The soak where the kernel grants no real-time priority.
fn without_rights(words: &[&str]) -> Output {
    let mut command = Command::new("prlimit");
    command.args(["--rtprio=0:0", "--nice=0:0", "--"]);
    // A process belongs to the user that it runs as.
    if fs::metadata("/proc/self").expect("Linux has it").uid() == 0 {
        command.args(["setpriv", "--bounding-set", "-sys_nice", "--inh-caps", "-sys_nice", "--"]);
    }
    command.arg(env!("CARGO_BIN_EXE_red-soak")).args(words);
    command.output().expect("util-linux is there")
}

#[test]
fn without_rights_it_is_refused_or_labelled_as_best_effort() {
    let refused = without_rights(&["--workloads", "1"]);
    let told = String::from_utf8_lossy(&refused.stderr);
    assert_eq!((refused.status.code(), refused.stdout.len()), (Some(3), 0), "{told}");
    assert!(told.contains("fix: ") && told.contains("`--best-effort`"), "{told}");
    let labelled = without_rights(&["--workloads", "1", "--length-ms", "50", "--best-effort"]);
    let text = String::from_utf8_lossy(&labelled.stdout);
    assert_eq!(labelled.status.code(), Some(0), "{text}");
    let (first, last) = (text.lines().next().unwrap_or(""), text.lines().last().unwrap_or(""));
    assert!([first, last].iter().all(|line| line.contains("BEST EFFORT, not real time")), "{text}");
    assert!(first.contains("fix: "), "{text}");
}

#[test]
fn wrong_arguments_are_refused() {
    for words in [&["--plant", "nothing"][..], &["--minutes"], &["--minutes", "many"], &["--hours", "1"]] {
        let output = Command::new(env!("CARGO_BIN_EXE_red-soak")).args(words).output().expect("it starts");
        assert_eq!(output.status.code(), Some(2), "{words:?}");
    }
}
