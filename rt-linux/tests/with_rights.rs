//! What needs the right to a real-time priority and to locked memory. Without it these tests fail and name it;
//! they are a file of their own so that the others can be run without.

use std::fs;
use std::hint::spin_loop;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, mpsc};
use std::thread;
use std::time::Duration;

use nix::unistd::gettid;
use red_rt::clock::now_ns;
use red_rt::placement::usable_cpus;
use red_rt::preflight::{Severity, measure};
use red_rt::setup::{Fifo, SetupError, hold_cpu_dma_latency, lock_memory};
use red_rt::watchdog::{Bound, Expiry, Slot, Watchdog};

/// Real-time threads here spin this long at most, so that a broken test cannot take the machine.
const LONGEST_SPIN_NS: u64 = 500_000_000;
/// Reaching it means that something never happened.
const FAR: Duration = Duration::from_secs(20);

const ORDINARY: i64 = 0;
const FIFO: i64 = 1;
const IDLE: i64 = 5;

fn need<T>(right: &str, result: Result<T, SetupError>) -> T {
    result.unwrap_or_else(|error| panic!("this test needs {right}: {error}"))
}

fn become_fifo(priority: u8) {
    let cpu = *usable_cpus().expect("an affinity mask").last().expect("at least one CPU");
    need("SCHED_FIFO (root, CAP_SYS_NICE or RLIMIT_RTPRIO)", Fifo { priority, cpu }.apply());
}

/// What the kernel says of a thread: its real-time priority and its policy.
fn scheduling(thread: i32) -> (i64, i64) {
    let stat =
        fs::read_to_string(format!("/proc/self/task/{thread}/stat")).expect("a thread of this process");
    // The name, in parentheses, may contain blanks; what follows begins with the third field.
    let (_, fields) = stat.rsplit_once(')').expect("the name is in parentheses");
    let fields: Vec<&str> = fields.split_whitespace().collect();
    let field = |number: usize| fields[number - 3].parse().expect("a number");
    (field(40), field(41))
}

#[test]
fn a_fifo_thread_has_its_priority_and_its_cpu_and_its_children_have_not() {
    let (mine, child, cpus) = thread::spawn(|| {
        become_fifo(7);
        let child = thread::spawn(|| scheduling(gettid().as_raw())).join().expect("reads only");
        (scheduling(gettid().as_raw()), child, usable_cpus().expect("an affinity mask"))
    })
    .join()
    .expect("the rights are there");
    assert_eq!(mine, (7, FIFO));
    assert_eq!(child.1, ORDINARY);
    assert_eq!(cpus.len(), 1);
}

#[test]
fn a_priority_that_does_not_exist_is_not_a_missing_right() {
    let cpu = usable_cpus().expect("an affinity mask")[0];
    let error = thread::spawn(move || Fifo { priority: 100, cpu }.apply()).join().expect("no panic");
    assert!(matches!(error, Err(SetupError::System { .. })), "{error:?}");
}

#[test]
fn locked_memory_is_locked() {
    need("locked memory (root, CAP_IPC_LOCK or RLIMIT_MEMLOCK)", lock_memory());
    let status = fs::read_to_string("/proc/self/status").expect("every process has one");
    let line = status.lines().find(|line| line.starts_with("VmLck:")).expect("Linux has it");
    let locked: u64 = line.split_whitespace().nth(1).expect("a number").parse().expect("a number");
    assert!(locked > 1_000, "{line}");
}

#[test]
fn the_latency_request_is_in_force_while_it_is_held() {
    let _held = need("write access to /dev/cpu_dma_latency (root)", hold_cpu_dma_latency());
    let bytes = fs::read("/dev/cpu_dma_latency").map(|bytes| bytes[..4].try_into().expect("four bytes"));
    assert_eq!(bytes.map(i32::from_ne_bytes).expect("readable where it is writable"), 0);
}

#[test]
fn the_watchdog_demotes_a_real_time_thread_that_does_not_return() {
    let slots: Arc<[Slot]> = [Slot::new(), Slot::new()].into();
    let (report, expired) = mpsc::channel();
    let cpu = usable_cpus().expect("an affinity mask")[0];
    let watchdog = need(
        "SCHED_FIFO (root, CAP_SYS_NICE or RLIMIT_RTPRIO)",
        Watchdog::start(slots.clone(), Some(Fifo { priority: 41, cpu }), move |index, expiry| {
            let _ = report.send((index, expiry));
        }),
    );
    let seen = Arc::new(AtomicBool::new(false));
    let lane = thread::spawn({
        let seen = seen.clone();
        move || {
            become_fifo(40);
            slots[1].adopt();
            let now = now_ns();
            let armed = slots[1].arm(now + 2_000_000);
            while !seen.load(Ordering::Relaxed) && now_ns() < now + LONGEST_SPIN_NS {
                spin_loop();
            }
            let hung = scheduling(gettid().as_raw());
            let bound = slots[1].disarm(armed);
            become_fifo(40);
            (hung, bound, scheduling(gettid().as_raw()))
        }
    });
    assert_eq!(expired.recv_timeout(FAR), Ok((1, Expiry::Demoted)));
    seen.store(true, Ordering::Relaxed);
    let (hung, bound, back) = lane.join().expect("the spin is bounded");
    assert_eq!(hung.1, IDLE);
    assert_eq!(bound, Bound::Passed);
    assert_eq!(back, (40, FIFO), "the lane takes its priority back");
    drop(watchdog);
    assert_eq!(expired.try_iter().count(), 0, "one report");
}

#[test]
fn a_measurement_reports_every_number_of_a_real_time_thread() {
    let findings = measure(Duration::from_millis(50));
    let ids: Vec<_> = findings.iter().map(|finding| finding.id).collect();
    assert_eq!(
        ids,
        [
            "measure.timer_resolution",
            "measure.mlockall",
            "measure.fifo",
            "measure.wake_up",
            "measure.page_faults",
            "measure.involuntary_switches",
            "measure.gap"
        ]
    );
    for right in ["measure.mlockall", "measure.fifo"] {
        let finding = findings.iter().find(|finding| finding.id == right).expect("listed above");
        assert_eq!(finding.severity, Severity::Pass, "this test needs the right of {finding}");
    }
    assert!(findings[3].value.starts_with("50 of SCHED_FIFO"), "{}", findings[3]);
}
