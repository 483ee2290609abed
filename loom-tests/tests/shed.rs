//! *Claim.* A job that is given up while one of its units completes ends once and frees each lane once: the completion
//! counts, or it is told that it comes late, or that somebody reported before.
//!
//! *Threads.* The lane that completes and who gives up; then another who gives up, or reports the same unit.
//! *Bound.* None for two; two preemptions for three threads, three with `--deep`, with the checker's lock.
//! *Sources.* `sync/src/shared.rs`
#![cfg(loom)]

use loom::thread;
use red_core::{Action, CompleteError, Instant, Scheduler, ShedReason, UnitId};
use red_loom_tests::Exclusive;
use red_loom_tests::ideal::Ideal;
use red_loom_tests::lanes::{IdealHost, Small};
use red_loom_tests::model::explore;
use red_loom_tests::ticket_lock::TicketLock;
use std::sync::Arc;

const NOW: Instant = Instant::from_nanos(5);

/// One job of one node, on a lane.
struct Shared<L> {
    lock: L,
    unit: UnitId,
}

fn running<L: Exclusive<Scheduler<Small>>>() -> Shared<L> {
    // The task of a host is as good as any.
    let host = IdealHost::new(&[(0, 1)], 1);
    let mut scheduler = Scheduler::<Small>::new(red_core::Config::REDRT);
    let dag = red_loom_tests::lanes::dag(&[(0, 1)]);
    let timing = red_core::Timing::new(red_core::Duration::from_secs(1));
    let task = scheduler.add_task(&dag, timing).expect("room for one task");
    assert_eq!(task, host.task);
    scheduler.release(task, NOW).expect("room for one job");
    let Some(Action::Dispatch(dispatch)) = scheduler.poll(NOW) else { panic!("a lane is free") };
    Shared { lock: L::new(scheduler), unit: dispatch.unit }
}

fn outcomes(scheduler: &mut Scheduler<Small>) -> Vec<Option<ShedReason>> {
    std::iter::from_fn(|| scheduler.take_outcome()).map(|outcome| outcome.shed).collect()
}

/// The lane completes; others give the task up or fail the unit, as the watchdog does. `twice`: the lane reports again.
fn ends_once<L: Exclusive<Scheduler<Small>> + Send + Sync + 'static>(
    removers: usize,
    failers: usize,
    twice: bool,
) {
    let shared = Arc::new(running::<L>());
    let act = |f: fn(&Shared<L>)| {
        let shared = shared.clone();
        thread::spawn(move || f(&shared))
    };
    let mut others: Vec<_> = (0..removers)
        .map(|_| act(|shared| shared.lock.with(|scheduler| assert!(scheduler.remove_task(task_of(), NOW)))))
        .collect();
    others.extend(
        (0..failers).map(|_| act(|shared| shared.lock.with(|s| s.fail(shared.unit, NOW).unwrap_or(())))),
    );
    let told = shared.lock.with(|scheduler| scheduler.complete(shared.unit, NOW));
    if twice {
        let again = shared.lock.with(|scheduler| scheduler.complete(shared.unit, NOW));
        assert_eq!(again, Err(CompleteError::Stale), "the lane was freed twice");
    }
    others.into_iter().for_each(|other| other.join().unwrap());
    shared.lock.with(|scheduler| {
        let ended = outcomes(scheduler);
        let late = scheduler.counters().late_completions;
        let next = scheduler.running_units() + scheduler.ready_sub_jobs();
        match told {
            // The job went on, unless it was given up afterwards.
            Ok(()) => assert!(ended.len() <= 1 && late == 0, "{ended:?}"),
            Err(CompleteError::Late) => assert_eq!((&ended[..], late), (&[Some(ShedReason::Removed)][..], 1)),
            Err(CompleteError::Stale) => {
                // Who failed it was told that it was late, if the job had been removed before.
                assert_eq!((ended.len(), failers > 0), (1, true), "{ended:?}");
            }
            Err(other) => panic!("{other:?}"),
        }
        assert!(removers == 0 || ended.len() == 1, "given up once: {ended:?}");
        assert_eq!(scheduler.jobs_in_flight(), 1 - ended.len(), "each job ends once");
        assert_eq!(next, 1 - ended.len(), "each lane is freed once");
    });
}

fn task_of() -> red_core::TaskId {
    red_core::TaskId::default()
}

#[test]
fn a_removed_job_and_its_completion() {
    explore(2, || ends_once::<Ideal<_>>(1, 0, true));
}

#[test]
fn a_failed_unit_and_its_completion() {
    explore(2, || ends_once::<TicketLock<_>>(0, 1, false));
}

#[test]
fn a_removed_job_its_failed_unit_and_its_completion() {
    explore(3, || ends_once::<Ideal<_>>(1, 1, false));
}

/// A lock that lets everybody in.
struct Open<T>(loom::cell::UnsafeCell<T>);

// SAFETY: planted; the checker says that it is not.
unsafe impl<T: Send> Sync for Open<T> {}
// SAFETY: the value goes with it.
unsafe impl<T: Send> Send for Open<T> {}

impl<T> Exclusive<T> for Open<T> {
    fn new(value: T) -> Self {
        Self(loom::cell::UnsafeCell::new(value))
    }

    fn with<R>(&self, f: impl FnOnce(&mut T) -> R) -> R {
        // SAFETY: planted.
        self.0.with_mut(|value| f(unsafe { &mut *value }))
    }
}

#[test]
#[should_panic(expected = "Causality violation")]
fn a_lock_that_lets_everybody_in_is_caught() {
    explore(2, || ends_once::<Open<_>>(0, 1, false));
}
