//! Calls in any order: late reports, double reports, a clock that steps back, places that are used again.

use std::collections::HashSet;

use proptest::prelude::*;
use red_core::{
    Action, Caps, CompleteError, Config, Dag, Duration, Frame, Instant, Late, Node, NodeId, ReleaseError,
    Scheduler, Shed, TaskId, Timing, UnitId, Wcet,
};

use crate::cases;

type Small = Caps<2, 4, 3, 2>;

#[derive(Clone, Debug)]
enum Call {
    /// Time goes on by so many microseconds.
    Wait(u64),
    /// A call that says an earlier time, by so many microseconds.
    StepBack(u64),
    Release(usize),
    Complete(usize),
    Fail(usize),
    /// A unit that was reported already is reported again.
    Again(usize),
    Remove(usize),
    Poll,
}

fn call() -> impl Strategy<Value = Call> {
    prop_oneof![
        3 => (0u64..3_000).prop_map(Call::Wait),
        1 => (1u64..5_000).prop_map(Call::StepBack),
        4 => (0usize..2).prop_map(Call::Release),
        6 => (0usize..2).prop_map(Call::Complete),
        1 => (0usize..2).prop_map(Call::Fail),
        2 => (0usize..100).prop_map(Call::Again),
        1 => (0usize..2).prop_map(Call::Remove),
        8 => Just(Call::Poll),
    ]
}

/// An encoder and two decoders behind a camera; the encoder's frames are the jobs' own.
fn graph() -> Dag<Small> {
    let mut dag = Dag::new();
    let camera = dag.add_node(Node::new(Wcet::from_millis(1))).unwrap();
    let frame = Frame { weights: 0, frame: 0, sensor: None };
    let encoder = dag.add_node(Node::shared_encoder(Wcet::from_millis(2), frame)).unwrap();
    dag.add_edge(camera, encoder).unwrap();
    for _ in 0..2 {
        let decoder = dag.add_node(Node::decoder(Wcet::from_millis(1))).unwrap();
        dag.add_edge(encoder, decoder).unwrap();
    }
    dag
}

/// One host that says what a clock says, and one whose clock never goes back; both must see the same.
struct Twins {
    raw: Scheduler<Small>,
    held: Scheduler<Small>,
    now: Instant,
    back: u64,
}

impl Twins {
    fn new(config: Config) -> Self {
        let [raw, held] = [0, 1].map(|_| Scheduler::new(config.with_lanes(2)));
        let mut twins = Self { raw, held, now: Instant::from_nanos(10_000_000), back: 0 };
        assert_eq!(twins.tell_time(), 0);
        twins
    }

    /// Calls both, the raw one at a time that may be before the last.
    fn call<T: PartialEq + std::fmt::Debug>(
        &mut self,
        mut f: impl FnMut(&mut Scheduler<Small>, Instant) -> T,
    ) -> T {
        let raw = f(&mut self.raw, Instant::from_nanos(self.now.as_nanos().saturating_sub(self.back)));
        let held = f(&mut self.held, self.now);
        assert_eq!(raw, held, "a clock that stepped back made a difference");
        raw
    }

    /// Tells both what time it is, with a handle that nobody has; how many steps back the raw one counts for it.
    fn tell_time(&mut self) -> u64 {
        let before = self.raw.counters().clock_steps_back;
        let refused = self.call(|s, now| s.complete(UnitId::from_bits(0), now));
        assert_eq!(refused, Err(CompleteError::NotRunning));
        assert_eq!(self.held.counters().clock_steps_back, 0);
        self.raw.counters().clock_steps_back - before
    }

    fn add(&mut self) -> TaskId {
        let timing = Timing::new(Duration::from_millis(6)).floor(1, 3);
        self.call(|s, _| s.add_task(&graph(), timing).expect("there is room"))
    }

    fn seen(&self) -> [usize; 3] {
        [self.raw.jobs_in_flight(), self.raw.ready_sub_jobs(), self.raw.running_units()]
    }
}

fn configurations() -> impl Strategy<Value = Config> {
    prop_oneof![
        Just(Config::REDRT),
        Just(Config::RED),
        Just(Config::RED_FG),
        Just(Config::EDF),
        Just(Config { late: Late::AbortJob, shed: Shed::Never, ..Config::REDRT }),
    ]
}

proptest! {
    #![proptest_config(cases(400))]

    #[test]
    fn no_call_reaches_what_is_not_its_own(
        config in configurations(), calls in prop::collection::vec(call(), 1..150)
    ) {
        let mut twins = Twins::new(config);
        let mut tasks = [twins.add(), twins.add()];
        let mut old_tasks: Vec<TaskId> = Vec::new();
        let (mut live, mut dead): (Vec<UnitId>, Vec<UnitId>) = (Vec::new(), Vec::new());
        let (mut jobs, mut ended, mut units) = (HashSet::new(), HashSet::new(), HashSet::new());
        for call in calls {
            match call {
                Call::Wait(us) => {
                    twins.now = twins.now.saturating_add(Duration::from_micros(us));
                    twins.back = 0;
                    prop_assert_eq!(twins.tell_time(), 0);
                }
                Call::StepBack(us) => {
                    twins.back = us * 1_000;
                    prop_assert_eq!(twins.tell_time(), 1);
                }
                Call::Release(task) => {
                    // The release itself is told rightly; only the time of the call is not.
                    let release = twins.now;
                    match twins.call(|s, now| s.release_at(tasks[task], release, None, now)) {
                        Ok(job) => prop_assert!(jobs.insert(job), "{job:?} was another job's name"),
                        Err(error) => prop_assert_eq!(error, ReleaseError::Full),
                    }
                }
                Call::Complete(which) | Call::Fail(which) if !live.is_empty() => {
                    let unit = live.swap_remove(which % live.len());
                    let fails = matches!(call, Call::Fail(_));
                    let answer = twins.call(|s, now| if fails { s.fail(unit, now) } else { s.complete(unit, now) });
                    prop_assert!(matches!(answer, Ok(()) | Err(CompleteError::Late)), "{answer:?}");
                    dead.push(unit);
                }
                Call::Again(which) if !dead.is_empty() => {
                    let unit = dead[which % dead.len()];
                    let before = twins.seen();
                    for late in [Scheduler::complete, Scheduler::fail] {
                        prop_assert_eq!(twins.call(|s, now| late(s, unit, now)), Err(CompleteError::Stale));
                    }
                    prop_assert!(twins.raw.unit(unit).is_none() && twins.raw.members(unit).next().is_none());
                    prop_assert_eq!(twins.seen(), before);
                }
                Call::Remove(task) => {
                    let old = tasks[task];
                    prop_assert!(twins.call(|s, now| s.remove_task(old, now)));
                    prop_assert!(!twins.call(|s, now| s.remove_task(old, now)));
                    old_tasks.push(old);
                    tasks[task] = twins.add();
                    prop_assert!(!old_tasks.contains(&tasks[task]));
                    let refused = twins.call(|s, now| s.release(old, now));
                    prop_assert_eq!(refused, Err(ReleaseError::UnknownTask));
                    prop_assert!(twins.raw.edit(old).is_none() && twins.raw.task_node(old, NodeId::new(0)).is_none());
                }
                Call::Poll => while let Some(action) = twins.call(|s, now| s.poll(now)) {
                    match action {
                        Action::Dispatch(started) => {
                            prop_assert!(units.insert(started.unit), "{started:?} was another unit's handle");
                            prop_assert!(live.iter().all(|unit| unit.lane() != started.lane));
                            live.push(started.unit);
                        }
                        Action::Ended(outcome) => {
                            prop_assert!(ended.insert(outcome.job), "{outcome:?} twice");
                            prop_assert!((outcome.release..=twins.now).contains(&outcome.at));
                        }
                        other => panic!("nobody asked for {other:?}"),
                    }
                },
                Call::Complete(_) | Call::Fail(_) | Call::Again(_) => {}
            }
            prop_assert_eq!(twins.raw.running_units(), live.len());
        }
        prop_assert!(ended.is_subset(&jobs));
    }
}
