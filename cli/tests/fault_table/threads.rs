//! Rows 29, 30, 32 to 34 and 40: what goes wrong with the threads of lanes.

use crate::alone::alone;
use crate::apart::{apart, passed};
use crate::lanes::{FAR_NS, NODES, Notes, Plan, TwoLanes};
use crate::plugin;
use crate::redrt::{count, jobs, run, summary, workload};
use crate::rights::need_real_time;
use nix::sys::signal::{SaFlags, SigAction, SigHandler, SigSet, Signal, raise, sigaction};
use nix::unistd::{Pid, gettid};
use red_bodies::plugin::{Host as PluginHost, Plugin};
use red_bodies::{Body, Call};
use red_core::{
    CommitError, Event, Instant, JobId, NodeId, Outcome, ReleaseError, Scheduler, ShedReason, TaskId,
};
use red_record::Recorder;
use red_rt::control::{Control, Refused};
use red_rt::handler::{Failed, Work};
use red_rt::stop::StopSignals;
use red_rt::timeline::Host;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicI32, AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use std::thread;
use std::time::Duration;

/// The threads of the two lanes; the newest, where a lane got a spare.
static LANES: [AtomicI32; 2] = [const { AtomicI32::new(0) }; 2];

fn enlist(lane: usize) {
    LANES[lane].store(gettid().as_raw(), Ordering::Relaxed);
}

/// Sends a signal to one thread of this process.
fn tell(thread: i32, signal: Signal) {
    // SAFETY: takes three integers.
    unsafe { libc::syscall(libc::SYS_tgkill, Pid::this().as_raw(), thread, signal as i32) };
}

fn handle(signal: Signal, handler: extern "C" fn(i32)) {
    let action = SigAction::new(SigHandler::Handler(handler), SaFlags::empty(), SigSet::empty());
    // SAFETY: the handlers of this file make at most one system call.
    unsafe { sigaction(signal, &action) }.expect("nothing forbids it");
}

fn no_body(_lane: usize, _work: &Work) -> Result<(), Failed> {
    Ok(())
}

#[test]
fn row_29_a_body_that_keeps_its_cpu_is_demoted_and_a_run_without_lanes_gives_up() {
    need_real_time();
    let _alone = alone();
    let path = workload("row-29", "spins", 1, "");
    let output = run(&path, &["--duration", "500ms"]).output().expect("the command starts");
    let (spun, told) = summary(&output, 0);
    assert_eq!((&spun["realtime"], jobs(&spun)), (&true.into(), [10, 9, 1]), "{told}");
    assert_eq!((count(&spun, "failed"), count(&spun, "lanes_lost")), (1, 0));
    assert!(told.contains("`t.a`") && told.contains("did not return") && told.contains("spare"), "{told}");
    // Where nothing ever comes back there is an end to spares, and then to the run: a supervisor starts it anew.
    let path = workload("row-29-always", "always_hangs", 1, "");
    let output = run(&path, &["--duration", "600s"]).output().expect("the command starts");
    let (hung, told) = summary(&output, 3);
    assert_eq!(count(&hung, "lanes_lost"), 1);
    assert!(hung["gave_up"].as_str().is_some_and(|why| why.contains("no lane is left")), "{hung}");
    assert!(count(&hung, "horizon_ns") < 600_000_000_000, "it did not wait for the duration");
    assert!(told.contains("error: the run gave up: no lane is left"), "{told}");
}

#[test]
fn row_30_a_panic_in_a_body_fails_its_job_and_never_unwinds_into_c() {
    let body = |_lane: usize, work: &Work| {
        assert!((work.job, work.node) != (1, NodeId::new(2)), "this row wants this panic");
        Ok(())
    };
    let told = {
        let _alone = alone();
        Plan::of(body).run(Notes::default(), |_, _| (), |_| ())
    };
    told.is_sound();
    let failed = |outcome: &&Outcome| outcome.shed == Some(ShedReason::Fault);
    let failed: Vec<u64> = told.host.ended.iter().filter(failed).map(|outcome| outcome.index).collect();
    assert_eq!((failed, told.shed()), (vec![1], 1));
    assert_eq!((told.report.failed, told.report.hung, told.report.lanes_lost), (1, 0, 0));
    let [panic] = &told.report.panics[..] else { panic!("one panic: {:?}", told.report.panics) };
    assert!(panic.job == 1 && panic.message.contains("this row wants this panic"), "{panic:?}");

    // The one function of ours that C calls: a panic in it ends the process instead of passing through C.
    let object = Path::new(env!("CARGO_TARGET_TMPDIR")).join(plugin::built("faults", "row-30"));
    let Some(output) = apart(&[], || {
        let host = PluginHost::new(|_task| panic!("into C"));
        let mut body =
            Plugin::load(&object, "releases", &host).and_then(|plugin| plugin.instance(0)).expect("good");
        let call = Call { now_ns: 0, release_ns: 0, deadline_ns: 0, job: 0, task: 0, lane: 0 };
        let returned = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| body.run(&call).is_ok()));
        println!("came back: {returned:?}");
    }) else {
        return;
    };
    let (out, err) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(!output.status.success() && !out.contains("came back"), "{}: {out}", output.status);
    assert!(err.contains("into C") && err.contains("cannot unwind"), "{err}");
}

/// A run and its task, once it has started.
type Running = Arc<OnceLock<(Arc<dyn Control<TwoLanes>>, TaskId)>>;

/// A host that releases and edits from inside of its callbacks, under the scheduler's lock.
struct Reenters {
    control: Running,
    released: u64,
    refused: u64,
    ended: u64,
    edits: u64,
    busy: u64,
    asked: u64,
    taken: u64,
}

impl Host<TwoLanes> for Reenters {
    fn due(&mut self, scheduler: &mut Recorder<'_, TwoLanes>, now: Instant) {
        let Some((_, task)) = self.control.get() else { return };
        let again = |scheduler: &mut Scheduler<TwoLanes>| {
            let edit = scheduler.edit(*task).expect("admitted");
            scheduler.commit(&edit, now).map(drop)
        };
        match scheduler.edit(0, now, again) {
            Ok(()) => self.edits += 1,
            Err(error) => {
                assert_eq!(error, CommitError::Busy);
                self.busy += 1;
            }
        }
    }

    fn released(&mut self, _task: usize, _release: Instant, taken: Result<JobId, ReleaseError>) {
        self.released += 1;
        self.refused += u64::from(taken.is_err());
    }

    fn ended(&mut self, _outcome: &Outcome) {
        self.ended += 1;
        if let Some((control, task)) = self.control.get().filter(|_| self.asked < 20) {
            self.asked += 1;
            self.taken += u64::from(control.release(*task, None).is_ok());
        }
    }

    fn event(&mut self, _event: &Event) {}
}

#[test]
fn row_32_a_callback_may_call_back_and_is_told_what_is_busy() {
    let control: Running = Arc::default();
    let (told, of_bodies) = (control.clone(), Arc::new(AtomicU64::new(0)));
    let (from_body, counted) = (control.clone(), of_bodies.clone());
    let body = move |_lane: usize, work: &Work| {
        // The first nodes of the jobs that came by the clock, so that it ends.
        if work.node.index() == 0 && work.job < 20 {
            let (control, task) = from_body.get().ok_or(Failed)?;
            counted.fetch_add(u64::from(control.release(*task, None).is_ok()), Ordering::Relaxed);
        }
        Ok(())
    };
    let host = Reenters { control, released: 0, refused: 0, ended: 0, edits: 0, busy: 0, asked: 0, taken: 0 };
    let plan = Plan { period_ns: Some(20_000_000), ..Plan::of(body) };
    let done = {
        let _alone = alone();
        plan.run(host, |control, task| assert!(told.set((control, task)).is_ok()), |_| ())
    };
    let Reenters { released, refused, ended, edits, busy, taken, .. } = done.host;
    // Twenty by the clock; those that were taken are released, none is lost, and nobody waited for himself.
    assert_eq!(released, 20 + taken + of_bodies.load(Ordering::Relaxed));
    assert_eq!((ended + refused, taken > 0, edits > 0, busy > 0), (released, true, true, true));
    // The run has ended: a call from outside is refused.
    let (control, task) = told.get().expect("it started");
    assert_eq!(control.release(*task, None), Err(Refused::Over));
}

extern "C" fn end_this_thread(_signal: i32) {
    // SAFETY: takes an integer; ends the thread past all that Rust knows of it, as a kill of the thread would.
    unsafe { libc::syscall(libc::SYS_exit, 0) };
}

#[test]
fn row_33_the_thread_of_a_lane_dies_and_a_spare_takes_its_place() {
    // In a body: its node fails.
    let path = workload("row-33", "dies", 1, "");
    {
        let _alone = alone();
        let output = run(&path, &["--best-effort", "--duration", "1s"]).output().expect("the command starts");
        let (died, told) = summary(&output, 0);
        assert_eq!(jobs(&died), [20, 19, 1], "{told}");
        assert_eq!((count(&died, "threads_died"), count(&died, "lanes_lost")), (1, 0));
        assert!(told.contains("lane threads that ended by themselves: 1"), "{told}");
        // As POSIX has it, through the frames of others: no answer pretends that all is well.
        let path = workload("row-33-leaves", "leaves", 1, "");
        let output = run(&path, &["--best-effort", "--duration", "1s"]).output().expect("the command starts");
        assert!(!output.status.success() && output.stdout.is_empty(), "{}", output.status);
    }
    // Asleep, one lane after the other, so also the one that keeps the time: nothing is lost.
    let Some(output) = apart(&[], || {
        handle(Signal::SIGUSR1, end_this_thread);
        let plan = Plan {
            period_ns: Some(400_000_000),
            duration_ns: 2_000_000_000,
            drain_ns: 10_000_000_000,
            begin: enlist,
            ..Plan::of(no_body)
        };
        let mut kills = [(200_000_000, 0), (1_000_000_000, 1)].into_iter().peekable();
        let told = plan.run(
            Notes::default(),
            |_, _| (),
            |now| {
                if let Some((_, lane)) = kills.next_if(|(at, _)| now >= *at) {
                    tell(LANES[lane].load(Ordering::Relaxed), Signal::SIGUSR1);
                }
            },
        );
        told.is_sound();
        assert_eq!((told.report.threads_died, told.report.lanes_lost, told.report.gave_up), (2, 0, None));
        // A unit that was under way to the dead lane fails; the others run.
        assert!(told.host.released + told.host.refused == 5 && told.shed() <= 2, "{:?}", told.host.ended);

        // Again and again: each leaves its stack behind, so a run does not go on like that for ever.
        let dies = |_: usize, _: &Work| {
            end_this_thread(0);
            Ok(())
        };
        let plan = Plan { duration_ns: 6_000_000_000, drain_ns: 0, ..Plan::of(dies) };
        let told = plan.run(Notes::default(), |_, _| (), |_| ());
        assert_eq!((told.report.threads_died, told.report.lanes_lost), (17, 1));
    }) else {
        return;
    };
    passed(&output);
}

extern "C" fn nothing(_signal: i32) {}

/// From now on no wake-up that the calling thread sends through the kernel arrives.
fn lose_wake_ups(_lane: usize) {
    let op = |code: u32, jt: u8, jf: u8, k: u32| libc::sock_filter { code: code as u16, jt, jf, k };
    let (load, equal, and, answer) = (
        libc::BPF_LD | libc::BPF_W | libc::BPF_ABS,
        libc::BPF_JMP | libc::BPF_JEQ | libc::BPF_K,
        libc::BPF_ALU | libc::BPF_AND | libc::BPF_K,
        libc::BPF_RET | libc::BPF_K,
    );
    // Of `seccomp_data`: the number of the call, and the low half of its second argument.
    let (number, second) = (0, if cfg!(target_endian = "little") { 24 } else { 28 });
    let mut filter = [
        op(load, 0, 0, number),
        op(equal, 0, 4, libc::SYS_futex as u32),
        op(load, 0, 0, second),
        op(and, 0, 0, 0x7f),
        op(equal, 0, 1, libc::FUTEX_WAKE as u32),
        // Done, says the kernel, and wakes nobody.
        op(answer, 0, 0, libc::SECCOMP_RET_ERRNO),
        op(answer, 0, 0, libc::SECCOMP_RET_ALLOW),
    ];
    let program = libc::sock_fprog { len: filter.len() as u16, filter: filter.as_mut_ptr() };
    // SAFETY: takes integers.
    let may = unsafe { libc::prctl(libc::PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 };
    // SAFETY: the program lives for the call and is copied.
    let set = may
        && unsafe { libc::prctl(libc::PR_SET_SECCOMP, libc::SECCOMP_MODE_FILTER, &raw const program) == 0 };
    assert!(set, "seccomp: {}", std::io::Error::last_os_error());
}

#[test]
fn row_34_spurious_wake_ups_start_nothing_twice_and_lost_ones_cost_no_more_than_a_look() {
    let Some(output) = apart(&[], || {
        // Each wait of the lanes ends for no reason, again and again.
        handle(Signal::SIGUSR1, nothing);
        let is_over = Arc::new(AtomicBool::new(false));
        let over = is_over.clone();
        let pest = thread::spawn(move || {
            while !over.load(Ordering::Relaxed) {
                let threads = LANES.iter().map(|thread| thread.load(Ordering::Relaxed));
                threads.filter(|thread| *thread != 0).for_each(|thread| tell(thread, Signal::SIGUSR1));
                thread::sleep(Duration::from_micros(50));
            }
        });
        let told = Plan { begin: enlist, ..Plan::of(no_body) }.run(Notes::default(), |_, _| (), |_| ());
        is_over.store(true, Ordering::Relaxed);
        pest.join().expect("it only tells");
        told.is_sound();
        let Notes { released, refused, .. } = told.host;
        assert_eq!((released + refused, told.ran.len(), told.shed()), (80, released * NODES, 0));

        // Every hand-off to a lane that sleeps is lost.
        let plan = Plan {
            period_ns: Some(50_000_000),
            duration_ns: 1_000_000_000,
            drain_ns: 10_000_000_000,
            begin: lose_wake_ups,
            ..Plan::of(no_body)
        };
        let told = plan.run(Notes::default(), |_, _| (), |_| ());
        told.is_sound();
        let Notes { released, refused, .. } = told.host;
        assert_eq!((released + refused, told.ran.len(), told.shed()), (20, released * NODES, 0));
    }) else {
        return;
    };
    passed(&output);
}

#[test]
fn row_40_a_stop_ends_the_run_whatever_the_lanes_do_and_a_second_one_changes_nothing() {
    let Some(output) = apart(&[], || {
        static STOPPED: AtomicBool = AtomicBool::new(false);
        let stop = || {
            for signal in [Signal::SIGTERM, Signal::SIGINT] {
                raise(signal).expect("to this thread");
            }
            STOPPED.store(true, Ordering::Relaxed);
        };
        type Body = fn(usize, &Work) -> Result<(), Failed>;
        let in_a_body: Body = |_, _| {
            while !STOPPED.load(Ordering::Relaxed) {
                thread::sleep(Duration::from_millis(1));
            }
            Ok(())
        };
        let for_ever: Body = |_, _| loop {
            thread::park();
        };
        let dead: Body = |_, _| {
            end_this_thread(0);
            Ok(())
        };
        // What lanes do when the signal comes; with it, whether the job that was released then ends.
        let states: [(&str, Option<u64>, Body, u64); 6] = [
            ("idle", None, no_body, 250_000_000),
            ("between two jobs", Some(5_000_000), no_body, 250_000_000),
            ("in a body", Some(FAR_NS), in_a_body, 50_000_000),
            ("in a body that hangs", Some(FAR_NS), for_ever, 0),
            ("with a body that was given up", Some(FAR_NS), for_ever, 400_000_000),
            ("dead", Some(FAR_NS), dead, 0),
        ];
        for (state, period_ns, body, at) in states {
            STOPPED.store(false, Ordering::Relaxed);
            let plan = Plan { period_ns, duration_ns: FAR_NS, ..Plan::of(body) };
            let (mut told_at, mut is_told) = (0, false);
            let told = plan.run(
                Notes::default(),
                |_, _| (),
                |now| {
                    told_at = now;
                    if now >= at && !is_told {
                        is_told = true;
                        stop();
                    }
                },
            );
            assert!(told.report.stopped_by.is_some() && told_at < FAR_NS, "{state}");
            assert!(told.host.ended.len() <= told.host.released, "{state}");
        }
        // Before it began, and held by somebody else all the while.
        let signals = StopSignals::install().expect("nothing forbids it");
        stop();
        for _ in 0..2 {
            let plan = Plan { period_ns: Some(5_000_000), duration_ns: FAR_NS, ..Plan::of(no_body) };
            let told = plan.run(Notes::default(), |_, _| (), |_| ());
            assert_eq!((told.host.released, told.ran.len()), (0, 0));
            assert!(told.report.stopped_by.is_some() && signals.requested().is_some());
        }
    }) else {
        return;
    };
    passed(&output);
}
