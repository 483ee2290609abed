//! Rows 50, 51, 53, 54 and 57 to 60: what the machine takes away, before a run and in the middle of it.

use crate::alone::alone;
use crate::apart::{apart, passed};
use crate::lanes::{Notes, Plan};
use crate::process::ended;
use crate::redrt::{count, jobs, run, summary, workload};
use crate::rights::{NO_PRIORITY, need_real_time, need_root, not_run, without};
use nix::sys::resource::{Resource, setrlimit};
use nix::sys::signal::{Signal, kill};
use nix::unistd::{Pid, gettid};
use red_rt::bell::{Bell, Woken};
use red_rt::clock::now_ns;
use red_rt::pi_lock::PiLock;
use red_rt::placement::usable_cpus;
use red_rt::preflight::{Severity, examine};
use red_rt::setup::{Fifo, SetupError, hold_cpu_dma_latency};
use red_workload::{Refusal, Source};
use serde_json::Value;
use std::fs::{self, File, OpenOptions};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, AtomicI32, Ordering};
use std::sync::{Arc, mpsc};
use std::thread;
use std::time::Duration;

/// Between two looks at another process.
const LOOK: Duration = Duration::from_millis(10);
/// Looks until something counts as never to come.
const LOOKS: usize = 3_000;

const NO_MEMORY: [&str; 1] = ["--memlock=65536:65536"];

/// Refused with the cure and nothing run; with `--best-effort` it runs, and its status says what it is.
fn is_refused_or_labelled(row: &str, limits: &[&str], capabilities: &str, call: &str) {
    let path = workload(row, "good", 1, "");
    let path = path.to_str().unwrap();
    let _alone = alone();
    let ask = |more: &[&str]| {
        let arguments = [&["run", path, "--json", "--duration", "200ms"], more].concat();
        let output = without(limits, capabilities, &arguments).output();
        let output = output.expect("no prlimit or setpriv; install them with: apt-get install util-linux");
        let (status, out, err) = ended(&output);
        assert!(
            !err.contains("setpriv:") && !err.contains("prlimit:"),
            "the rights cannot be dropped here: {err}"
        );
        (status, out, err)
    };
    let (status, out, err) = ask(&[]);
    assert_eq!((status, &*out), (3, ""), "{err}");
    assert!(err.contains(call) && err.contains("fix:") && err.contains("--best-effort"), "{err}");
    let (status, out, err) = ask(&["--best-effort"]);
    assert_eq!(status, 0, "{err}");
    assert!(err.contains("BEST EFFORT") && err.contains(call), "{err}");
    let status: Value = serde_json::from_str(&out).expect("one JSON object");
    assert_eq!((&status["realtime"], jobs(&status)), (&false.into(), [4, 4, 0]));
}

#[test]
fn row_50_without_the_right_to_a_priority_nothing_runs_unless_as_best_effort() {
    is_refused_or_labelled(
        "row-50",
        &NO_PRIORITY,
        "-sys_nice,-sys_resource",
        "sched_setscheduler(SCHED_FIFO)",
    );
}

#[test]
fn row_51_with_too_little_memory_to_lock_the_same_rule_holds() {
    need_real_time();
    is_refused_or_labelled("row-51", &NO_MEMORY, "-ipc_lock,-sys_resource", "mlockall");
}

/// A root of a file system with these two files.
fn machine(name: &str, version: &str, flag: Option<&str>) -> PathBuf {
    let root = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    for folder in ["proc/sys/kernel", "sys/kernel"] {
        fs::create_dir_all(root.join(folder)).expect("the folder for tests takes folders");
    }
    fs::write(root.join("proc/sys/kernel/version"), version).expect("and files");
    if let Some(flag) = flag {
        fs::write(root.join("sys/kernel/realtime"), flag).expect("and files");
    }
    root
}

#[test]
fn row_53_a_kernel_without_preempt_rt_is_told_and_no_bound_is_claimed() {
    let found = |root: &Path| {
        let findings = examine(root);
        let finding = findings.into_iter().find(|finding| finding.id == "kernel.preempt_rt");
        finding.expect("every machine gets this finding")
    };
    let ordinary = found(&machine("row-53-ordinary", "#1 SMP PREEMPT_DYNAMIC", None));
    assert_eq!(ordinary.severity, Severity::Warn);
    assert!(
        ordinary.why.contains("no bound is claimed") && ordinary.fix.contains("PREEMPT_RT"),
        "{ordinary}"
    );
    for root in
        [machine("row-53-version", "#1 SMP PREEMPT_RT", None), machine("row-53-flag", "#1 SMP", Some("1\n"))]
    {
        assert_eq!(found(&root).severity, Severity::Pass);
    }
    // The status of a run, and what is shown of it.
    let here = found(Path::new("/")).severity == Severity::Pass;
    let path = workload("row-53", "good", 1, "");
    let _alone = alone();
    let arguments = ["--best-effort", "--duration", "100ms"];
    let (status, _) = summary(&run(&path, &arguments).output().expect("the command starts"), 0);
    assert_eq!(status["preempt_rt"], here);
    if status["realtime"] == true {
        let shown = crate::process::run(&["run", path.to_str().unwrap(), "--duration", "100ms"]).1;
        assert_eq!(shown.contains("without PREEMPT_RT, so without a bound"), !here, "{shown}");
    }
}

#[test]
fn row_54_a_page_fault_after_the_start_is_counted_and_told() {
    need_real_time();
    let _alone = alone();
    let of = |symbol: &str| {
        let path = workload(&format!("row-54-{symbol}"), symbol, 1, "");
        summary(&run(&path, &["--duration", "300ms"]).output().expect("the command starts"), 0)
    };
    let (calm, told) = of("good");
    assert_eq!((&calm["realtime"], count(&calm, "page_faults")), (&true.into(), 0), "{told}");
    assert!(!told.contains("page faults"), "{told}");
    let (faulted, told) = of("faults_pages");
    assert!(count(&faulted, "page_faults") > 0, "{faulted}");
    assert!(told.contains("page faults while running: "), "{told}");
}

/// What the kernel says of a thread: its effective priority, where -1 - P is that of real-time priority P.
fn priority(thread: i32) -> i64 {
    let stat =
        fs::read_to_string(format!("/proc/self/task/{thread}/stat")).expect("a thread of this process");
    // The name, in parentheses, may contain blanks; what follows begins with the third field.
    let (_, fields) = stat.rsplit_once(')').expect("the name is in parentheses");
    fields.split_whitespace().nth(18 - 3).expect("so many fields").parse().expect("a number")
}

/// Three priorities on one CPU. Without inheritance the middle one would keep the holder, and so the highest,
/// waiting until it has used up its time.
#[test]
fn row_57_the_holder_of_a_lock_inherits_the_priority_of_the_waiter() {
    /// Real-time threads here spin this long at most, so that a broken test cannot take the machine.
    const LONGEST_SPIN_NS: u64 = 500_000_000;
    fn become_fifo(priority: u8) {
        let cpu = *usable_cpus().expect("an affinity mask").last().expect("at least one CPU");
        Fifo { priority, cpu }.apply().expect("asked for before");
    }
    need_real_time();
    let _alone = alone();
    let lock = Arc::new(PiLock::new(()).expect("the kernel has priority inheritance"));
    let release = Arc::new(Bell::new());
    let got_it = Arc::new(AtomicBool::new(false));
    let holder = Arc::new(AtomicI32::new(0));

    let (held, is_held) = mpsc::channel();
    let low = thread::spawn({
        let (lock, release, holder) = (lock.clone(), release.clone(), holder.clone());
        move || {
            become_fifo(10);
            holder.store(gettid().as_raw(), Ordering::Relaxed);
            let guard = lock.lock();
            held.send(()).expect("the test waits for it");
            let woken = release.wait(Some(now_ns() + 20 * LONGEST_SPIN_NS), 0);
            drop(guard);
            woken
        }
    });
    is_held.recv_timeout(Duration::from_secs(20)).expect("the lock is free and the rights are there");

    let high = thread::spawn({
        let (lock, got_it) = (lock.clone(), got_it.clone());
        move || {
            become_fifo(30);
            drop(lock.lock());
            got_it.store(true, Ordering::Relaxed);
        }
    });
    let is_lifted = (0..LOOKS).any(|_| {
        let is_lifted = priority(holder.load(Ordering::Relaxed)) == -31;
        if !is_lifted {
            thread::sleep(Duration::from_millis(1));
        }
        is_lifted
    });
    assert!(is_lifted, "the holder was never lifted to 30");

    let middle = thread::spawn(move || {
        become_fifo(20);
        release.ring();
        let end = now_ns() + LONGEST_SPIN_NS;
        while !got_it.load(Ordering::Relaxed) && now_ns() < end {
            std::hint::spin_loop();
        }
        got_it.load(Ordering::Relaxed)
    });
    assert!(middle.join().expect("the spin is bounded"), "the middle priority kept the highest waiting");
    assert_eq!(low.join().expect("no panic"), Woken::Rung);
    high.join().expect("no panic");
}

/// Waits until the kernel says that the process is in this state.
fn wait_for(process: u32, state: char) {
    let is_there = (0..LOOKS).any(|_| {
        let stat = fs::read_to_string(format!("/proc/{process}/stat")).unwrap_or_default();
        let is_there = stat.rsplit_once(") ").is_some_and(|(_, rest)| rest.starts_with(state));
        if !is_there {
            thread::sleep(LOOK);
        }
        is_there
    });
    assert!(is_there, "process {process} was never `{state}`");
}

#[test]
fn row_58_a_halted_process_goes_on_at_its_absolute_times_and_tells_the_gap() {
    let path = workload("row-58", "good", 2, "");
    let _alone = alone();
    let mut command = run(&path, &["--best-effort", "--duration", "3s"]);
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the command starts");
    let process = Pid::from_raw(child.id().cast_signed());
    // After the start of the run, which the wait of its lanes shows.
    let begins = |child: &Child| {
        let threads = fs::read_dir(format!("/proc/{}/task", child.id()));
        threads.map_or(0, Iterator::count) >= 4
    };
    assert!(
        (0..LOOKS).any(|_| begins(&child) || {
            thread::sleep(LOOK);
            false
        }),
        "the lanes never started"
    );
    thread::sleep(20 * LOOK);
    kill(process, Signal::SIGSTOP).expect("a child");
    wait_for(child.id(), 'T');
    thread::sleep(50 * LOOK);
    kill(process, Signal::SIGCONT).expect("a child");
    let (halted, told) = summary(&child.wait_with_output().expect("it ends"), 0);
    // Releases are those of the clock: none is lost, none is moved.
    assert_eq!(jobs(&halted), [60, 60, 0]);
    assert!(
        count(&halted, "standstills") >= 1 && count(&halted, "longest_standstill_ns") > 100_000_000,
        "{halted}"
    );
    assert!(told.contains("standstills: "), "{told}");
}

#[test]
fn row_59_logs_that_nobody_reads_or_that_fit_nowhere_stop_no_job() {
    let path = workload("row-59", "good", 1, "");
    let _alone = alone();
    let is_whole = |output: &std::process::Output| {
        let (run, _) = summary(output, 0);
        assert_eq!(jobs(&run), [80, 80, 0]);
    };
    let arguments = ["--best-effort", "--duration", "4s"];
    // Full, and closed.
    let full = OpenOptions::new().write(true).open("/dev/full").expect("Linux has it");
    is_whole(&run(&path, &arguments).stderr(full).output().expect("the command starts"));
    let mut gone =
        run(&path, &arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
    drop(gone.stderr.take());
    is_whole(&gone.wait_with_output().expect("it ends"));
    // A pipe that is full already and that nobody reads until all the jobs are done: what wants to be told waits, and
    // what has to be done does not.
    let (mut reader, mut writer) = std::io::pipe().expect("a pipe");
    let fill = thread::spawn({
        let mut writer = writer.try_clone().expect("another end");
        // More than any pipe holds; the rest goes in when it is read.
        move || writer.write_all(&vec![b'.'; 1 << 21])
    });
    thread::sleep(10 * LOOK);
    let trace = path.with_extension("json");
    let mut command =
        run(&path, &[&arguments[..], &["--force", "--trace", trace.to_str().unwrap()]].concat());
    let child = command.stdout(Stdio::piped()).stderr(writer.try_clone().expect("another end")).spawn();
    let child = child.expect("the command starts");
    drop(command);
    // The line at two seconds holds the thread that tells, and so the end of the run; not the lanes. Their threads tell
    // that they ran: each job is a switch to the lane that slept.
    thread::sleep(Duration::from_secs(6));
    let mut said = Vec::new();
    let output = thread::scope(|scope| {
        let ends = scope.spawn(|| child.wait_with_output().expect("it ends"));
        writer.flush().expect("a pipe");
        drop(writer);
        reader.read_to_end(&mut said).expect("a pipe");
        ends.join().expect("no panic")
    });
    fill.join().expect("no panic").expect("it was read in the end");
    is_whole(&output);
    // Nobody waited for it: a lane that had would have ended what came at two seconds only now, at six and more.
    let read_late: Value = serde_json::from_slice(&output.stdout).expect("one JSON object");
    let slowest = count(&read_late["tasks"][0]["response_ns"], "max");
    assert!(slowest < 3_000_000_000, "a job waited {slowest} ns for who reads");
    // No room for a trace: told by its name, and the figures are there all the same.
    let short = ["--best-effort", "--duration", "200ms"];
    let output =
        run(&path, &[&short[..], &["--trace", "/dev/full"]].concat()).output().expect("the command starts");
    let (figures, told) = summary(&output, 3);
    assert_eq!(jobs(&figures), [4, 4, 0]);
    assert!(told.contains("cannot write the trace to `/dev/full`"), "{told}");
    // A disk that is full in the middle of a log: what is there is kept, the rest is counted, and no job waits.
    need_root();
    let disk = Disk::new("row-59", "64k");
    let log = disk.0.join("run.redlog");
    let text = fs::read_to_string(&path).expect("UTF-8").replace("50ms", "1ms");
    let fast = crate::process::file("row-59-fast.toml", text.as_bytes());
    let arguments = ["--best-effort", "--duration", "3s", "--record", log.to_str().unwrap()];
    let (logged, told) = summary(&run(&fast, &arguments).output().expect("the command starts"), 3);
    let [released, completed, shed] = jobs(&logged);
    assert_eq!((released, completed + shed), (3_000, 3_000), "{logged}");
    assert!(count(&logged["record"], "dropped") > 0 && count(&logged["record"], "inputs") > 0, "{logged}");
    assert!(logged["record"]["failed"].as_str().expect("why").contains("No space left"), "{logged}");
    assert!(told.contains("No space left on device") && told.contains("cannot be replayed"), "{told}");
    let refusal = crate::process::run(&["replay", log.to_str().unwrap()]);
    assert!(refusal.0 == 2 && refusal.2.contains("cannot be replayed"), "{}", refusal.2);
}

/// A small disk of this test.
struct Disk(PathBuf);

impl Disk {
    fn new(name: &str, size: &str) -> Self {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        fs::create_dir_all(&folder).expect("the folder for tests takes folders");
        let options = format!("size={size}");
        let mounted =
            Command::new("mount").args(["-t", "tmpfs", "-o", &options, "tmpfs"]).arg(&folder).status();
        if !mounted.is_ok_and(|status| status.success()) {
            not_run("needs the right to mount (CAP_SYS_ADMIN)");
        }
        Self(folder)
    }
}

impl Drop for Disk {
    fn drop(&mut self) {
        // A process that ended a moment ago may still have it.
        let _gone = (0..100).any(|_| {
            let gone = Command::new("umount").arg(&self.0).status().is_ok_and(|status| status.success());
            if !gone {
                thread::sleep(LOOK);
            }
            gone
        });
    }
}

#[test]
fn row_60_without_a_file_descriptor_left_the_start_is_refused_by_type() {
    let path = workload("row-60", "good", 1, "");
    let Some(output) = apart(&[], || {
        let opened = File::open("/dev/null").expect("one is left");
        let next = std::os::fd::AsRawFd::as_raw_fd(&opened);
        drop(opened);
        setrlimit(Resource::RLIMIT_NOFILE, next as u64, next as u64).expect("a limit may be lowered");
        let error = Source::load(&path).expect_err("there is no descriptor for it");
        assert_eq!(error.refusal, Refusal::Unreadable);
        assert!(error.to_string().contains("Too many open files"), "{error}");
        let held = hold_cpu_dma_latency().expect_err("nor for that");
        assert!(matches!(held, SetupError::System { errno: nix::errno::Errno::EMFILE, .. }), "{held:?}");
        // Bells, timers and lanes are made of futexes, and need none.
        let told =
            Plan::of(|_: usize, _: &red_rt::handler::Work| Ok(())).run(Notes::default(), |_, _| (), |_| ());
        told.is_sound();
        assert!(told.host.released > 0);
    }) else {
        return;
    };
    passed(&output);
}
