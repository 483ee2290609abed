//! The soak finds what is planted, and keeps what repeats it. All without real-time rights.

use red_record::{Reader, replay};
use red_workload::policy::Policy;
use red_workload::{Format, build, parse};
use std::fs::{self, File};
use std::io::BufReader;
use std::os::unix::fs::MetadataExt;
use std::os::unix::process::CommandExt;
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
    // As a shell starts it: in a group of processes of its own.
    command.process_group(0);
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
    let (output, text, _) = soak("replay", &["--repeat", "1", "--plant", "replay"]);
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
    let (output, text, folder) = soak("start", &["--repeat", "6", "--plant", "start"]);
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(text.contains("VIOLATION: seed 6") && text.contains("a second time"), "{text}");
    assert!(text.contains("again: cargo xtask soak --repeat 6 "), "{text}");
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
fn a_soak_of_few_workloads_is_not_clean() {
    // The heap is not judged either; in the second, where threads died, it never is.
    for words in [&["--workloads", "11"][..], &["--workloads", "2", "--apart"]] {
        let (output, text, _) = soak("few", words);
        assert_eq!(output.status.code(), Some(1), "{text}");
        assert!(text.contains("soak: not clean") && text.contains("too short to judge"), "{text}");
    }
}

#[test]
fn a_soak_apart_leaves_the_heap_alone() {
    let (output, text, _) = soak("apart", &["--workloads", "20", "--length-ms", "300", "--apart"]);
    assert_eq!(output.status.code(), Some(0), "{text}");
    assert!(text.contains("memory: not judged, threads that died") && text.contains("soak: clean"), "{text}");
}

/// The second seed's process is halted and not let go on.
#[test]
fn a_workload_that_does_not_end_is_told_as_a_violation_is() {
    for seed in ["1", "3"] {
        let (output, text, folder) = soak("stuck", &["--repeat", seed, "--plant", "stuck"]);
        assert_eq!(output.status.code(), Some(1), "{text}");
        assert!(text.contains(&format!("VIOLATION: seed {seed} (policy ")), "{text}");
        assert!(text.contains(&format!("again: cargo xtask soak --repeat {seed} ")), "{text}");
        let [log] = &logs(&folder)[..] else { panic!("one log: {folder:?}") };
        assert!(text.contains(&format!("redrt replay {}", log.display())), "{text}");
    }
}

fn tell(process: &str) {
    // Negative, it is a group of processes.
    let told = Command::new("kill").args(["-INT", "--", process]).status();
    assert!(told.expect("every system has it").success());
}

#[test]
fn a_signal_ends_it_with_its_summary() {
    let stop = |child: &mut Child, folder: &PathBuf| {
        while logs(folder).is_empty() && child.try_wait().expect("ours").is_none() {
            thread::yield_now();
        }
        tell(&child.id().to_string());
    };
    let (output, text, folder) = watched("stop", &["--minutes", "10"], stop);
    // Stopped in its first workload: nothing is wrong, and nothing is shown.
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(text.contains("jobs released") && text.contains("soak: stopped by SIGINT"), "{text}");
    assert!(text.contains("no violation") && text.contains("too short to judge"), "{text}");
    assert_eq!(logs(&folder), Vec::<PathBuf>::new());
}

/// Whether the process has a child, and that is halted.
fn has_halted_child(process: u32) -> bool {
    let read = |path: String| fs::read_to_string(path).unwrap_or_default();
    let children = read(format!("/proc/{process}/task/{process}/children"));
    children.split_whitespace().any(|child| {
        read(format!("/proc/{child}/stat")).rsplit(')').next().is_some_and(|state| state.starts_with(" T"))
    })
}

#[test]
fn a_signal_to_all_processes_finds_none_halted_for_good() {
    // The halt is short: where others have the CPUs for as long, a soak ends before it is seen.
    const TRIES: usize = 20;
    for _ in 0..TRIES {
        let mut was_told = false;
        let stop = |child: &mut Child, _: &PathBuf| {
            while !was_told && child.try_wait().expect("ours").is_none() {
                was_told = has_halted_child(child.id());
                thread::yield_now();
            }
            if was_told {
                tell(&format!("-{}", child.id()));
            }
        };
        let (_, text, folder) = watched("group", &["--repeat", "3", "--length-ms", "2000"], stop);
        assert_eq!(text.contains("soak: stopped by SIGINT"), was_told, "{text}");
        assert!(!text.contains("VIOLATION"), "{text}");
        assert_eq!(logs(&folder), Vec::<PathBuf>::new());
        if was_told {
            return;
        }
    }
    panic!("not halted, as far as could be seen, in {TRIES} soaks");
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
    let refused = without_rights(&["--repeat", "1"]);
    let told = String::from_utf8_lossy(&refused.stderr);
    assert_eq!((refused.status.code(), refused.stdout.len()), (Some(3), 0), "{told}");
    assert!(told.contains("fix: ") && told.contains("`--best-effort`"), "{told}");
    let labelled = without_rights(&["--repeat", "1", "--length-ms", "50", "--best-effort"]);
    let text = String::from_utf8_lossy(&labelled.stdout);
    assert_eq!(labelled.status.code(), Some(0), "{text}");
    let (first, last) = (text.lines().next().unwrap_or(""), text.lines().last().unwrap_or(""));
    assert!([first, last].iter().all(|line| line.contains("BEST EFFORT, not real time")), "{text}");
    assert!(first.contains("fix: "), "{text}");
}

#[test]
fn wrong_arguments_are_refused() {
    for words in [
        &["--plant", "nothing"][..],
        &["--minutes"],
        &["--minutes", "many"],
        &["--hours", "1"],
        &["--workloads", "0"],
        &["--seconds", "0"],
    ] {
        let output = Command::new(env!("CARGO_BIN_EXE_red-soak")).args(words).output().expect("it starts");
        assert_eq!(output.status.code(), Some(2), "{words:?}");
    }
}
