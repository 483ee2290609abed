//! The loop, from a release to an outcome, and what a host may ask meanwhile.

use super::{Block, Graph, Machine, config, headed, node, ok};
use crate::action::red_action_head;
use crate::*;
use core::ptr;
use red_core::Empty;

/// Where an action comes out, of which the outcome is written only where there is one.
struct Told(Block<red_action>);

impl Told {
    fn new() -> Self {
        Self(Block::of(1))
    }

    const fn at(&self) -> *mut red_action {
        self.0.pointer()
    }

    /// What an action begins with; nothing else is there unless a job ended.
    fn head(&self) -> (u32, u64) {
        // SAFETY: every poll writes it.
        let head = unsafe { self.at().cast::<red_action_head>().read() };
        (head.kind, head.unit)
    }
}

/// A scheduler of so many lanes, and a task of two nodes of which one follows the other.
fn pair(config: red_config) -> (Machine, u32) {
    let (mut machine, mut graph) = (Machine::new(config), Graph::new());
    graph.add(node(4));
    graph.add(node(2));
    graph.edge(0, 1);
    let task = machine.add(&graph, 50);
    graph.close();
    (machine, task)
}

#[test]
fn a_job_goes_from_its_release_to_its_outcome() {
    let (mut machine, task) = pair(config(red_preset::Redrt, 1));
    let (mut same, mut at, mut count) = (RED_NONE, 0, 7);
    ok(red_scheduler_poll_at(machine.at(), &raw mut at));
    assert_eq!(at, RED_NONE_64);
    let job = machine.release(task, 10);
    ok(red_scheduler_job(machine.at(), task, 0, &raw mut same));
    assert_eq!(job, same);
    let told = Told::new();
    ok(red_scheduler_poll_on(machine.at_mut(), 0, 10, told.at()));
    let (kind, first) = told.head();
    assert_eq!(kind, red_action_kind::Dispatch as u32);
    let mut unit = headed!(red_unit {});
    ok(red_scheduler_unit(machine.at(), first, &raw mut unit));
    assert_eq!((unit.first.job, unit.first.deadline_ns, unit.wcet_ns), (job, 60, 4));
    ok(red_scheduler_complete_and_poll(machine.at_mut(), first, 13, told.at()));
    let second = told.head().1;
    assert_eq!(second >> 8 & 0xff, 1, "the node that follows");
    let stale = red_scheduler_complete_and_poll(machine.at_mut(), first, 13, told.at());
    assert_eq!(stale, red_status::Stale);
    ok(red_scheduler_complete(machine.at_mut(), second, 15));
    let outcome = Block::<red_outcome>::of(1);
    ok(red_scheduler_take_outcome(machine.at_mut(), outcome.pointer(), &raw mut count));
    assert_eq!((count, outcome.get(0).at_ns, outcome.get(0).shed), (1, 15, 0));
    let none = Block::<red_outcome>::of(1);
    ok(red_scheduler_take_outcome(machine.at_mut(), none.pointer(), &raw mut count));
    assert_eq!(count, 0);
    ok(red_scheduler_poll(machine.at_mut(), 16, told.at()));
    assert_eq!(told.head(), (red_action_kind::Nothing as u32, 0));

    let mut seen = headed!(red_executions {});
    ok(red_scheduler_executions(machine.at(), task, 0, &raw mut seen));
    assert_eq!((seen.mean_ns, seen.maximum_ns), (3, 3));
    assert_eq!(red_scheduler_executions(machine.at(), task, 2, &raw mut seen), red_status::UnknownNode);
    let mut figures = headed!(red_figures {});
    ok(red_scheduler_figures(machine.at(), &raw mut figures));
    assert_eq!((figures.units, figures.lanes, figures.running), (2, 1, 0));
    // As many as there is room for, then the rest.
    let (events, mut len) = (Block::<red_event>::of(4), 0);
    ok(red_scheduler_take_events(machine.at_mut(), events.pointer(), 4, &raw mut len));
    let kinds: Vec<u32> = (0..len).map(|i| events.get(i).kind).collect();
    assert_eq!(kinds, [1, 3, 4, 3]);
    ok(red_scheduler_take_events(machine.at_mut(), events.pointer(), 4, &raw mut len));
    assert_eq!((len, events.get(1).kind), (2, red_event_kind::Ended as u32));
    machine.close();
}

#[test]
fn encoders_of_two_jobs_are_one_unit_of_two_members() {
    let (mut machine, mut graph) = (Machine::new(config(red_preset::Redrt, 2)), Graph::new());
    graph.add(red_node { role: red_role::SharedEncoder as u32, ..node(4) });
    let (task, mut job) = (machine.add(&graph, 50), RED_NONE);
    for release_ns in [0, 1] {
        ok(red_scheduler_release_at(machine.at_mut(), task, release_ns, 7, 1, &raw mut job));
    }
    let unit = machine.poll(1).unit;
    let (both, one, mut count) = (Block::<red_member>::of(2), Block::<red_member>::of(1), 0);
    ok(red_scheduler_members(machine.at(), unit, both.pointer(), 2, &raw mut count));
    assert_eq!((count, both.get(0).index, both.get(1).index), (2, 0, 1));
    let short = red_scheduler_members(machine.at(), unit, one.pointer(), 1, &raw mut count);
    assert_eq!((short, count), (red_status::TooShort, 2));
    let none = red_scheduler_members(machine.at(), 0, ptr::null_mut(), 0, &raw mut count);
    assert_eq!(none, red_status::NotRunning);
    // With jobs in flight and a unit that runs.
    graph.close();
    machine.close();
}

#[test]
fn a_unit_fails_and_a_task_goes() {
    let (mut machine, task) = pair(config(red_preset::Redrt, 1));
    machine.release(task, 0);
    let failed = machine.poll(0).unit;
    ok(red_scheduler_fail(machine.at_mut(), failed, 1));
    assert_eq!(red_scheduler_fail(machine.at_mut(), failed, 1), red_status::Stale);
    assert_eq!(machine.poll(1).outcome.shed, red_shed::Fault as u32);
    machine.release(task, 2);
    let left = machine.poll(2).unit;
    ok(red_scheduler_remove_task(machine.at_mut(), task, 3));
    assert_eq!(red_scheduler_remove_task(machine.at_mut(), task, 3), red_status::UnknownTask);
    assert_eq!(red_scheduler_complete(machine.at_mut(), left, 4), red_status::Late);
    assert_eq!(machine.poll(4).outcome.shed, red_shed::Removed as u32);
    let mut job = RED_NONE;
    assert_eq!(red_scheduler_release(machine.at_mut(), task, 5, &raw mut job), red_status::UnknownTask);
    assert_eq!(red_scheduler_complete(machine.at_mut(), u64::MAX, 5), red_status::NotRunning);
    assert_eq!(job, RED_NONE);
    machine.close();
}

#[test]
fn a_smaller_key_takes_the_lane() {
    let (mut machine, slow) = pair(red_config { preempt: 1, ..config(red_preset::Edf, 1) });
    let mut graph = Graph::new();
    graph.add(node(1));
    let fast = machine.add(&graph, 5);
    machine.release(slow, 0);
    let first = machine.poll(0).unit;
    machine.release(fast, 1);
    let preempted = machine.poll(1);
    assert_eq!((preempted.kind, preempted.unit), (red_action_kind::Preempt as u32, first));
    assert_eq!(red_scheduler_complete(machine.at_mut(), first, 2), red_status::Stale);
    graph.close();
    machine.close();
}

#[test]
fn a_pointer_that_cannot_be_is_refused_before_anything_happens() {
    let (mut machine, task) = pair(config(red_preset::Redrt, 1));
    machine.release(task, 0);
    let unit = machine.poll(0).unit;
    let (odd, mut action, mut count) = (Block::<u64>::of(16), red_action::EMPTY, 7);
    let at = machine.at_mut();
    for (wrong, status) in [(ptr::null_mut(), red_status::NullPointer), (odd.lent(2), red_status::Misaligned)]
    {
        let answers = [
            red_scheduler_poll(wrong.cast(), 0, &raw mut action),
            red_scheduler_poll(at, 0, wrong.cast()),
            red_scheduler_release(at, task, 0, wrong.cast()),
            red_scheduler_complete_and_poll(at, unit, 0, wrong.cast()),
            red_scheduler_members(at, unit, wrong.cast(), 1, &raw mut count),
            red_scheduler_take_events(at, ptr::null_mut(), 0, wrong.cast()),
            red_scheduler_take_outcome(at, wrong.cast(), wrong.cast()),
            red_scheduler_figures(at, wrong.cast()),
            red_scheduler_commit(at, wrong.cast(), 0, wrong.cast()),
            red_scheduler_close(wrong.cast()),
        ];
        assert_eq!(answers, [status; 10]);
    }
    assert_eq!(count, 7);
    ok(red_scheduler_complete(at, unit, 1));
    machine.close();
}

#[test]
fn as_many_jobs_as_there_are_places_and_no_more() {
    let (mut machine, task) = pair(config(red_preset::Redrt, 4));
    let jobs: Vec<u32> = (0..16).map(|now_ns| machine.release(task, now_ns)).collect();
    assert!(jobs.is_sorted());
    let mut job = RED_NONE;
    assert_eq!(red_scheduler_release(machine.at_mut(), task, 16, &raw mut job), red_status::JobsFull);
    let far = red_scheduler_release_at(machine.at_mut(), task, 1 << 63, RED_NONE_64, 16, &raw mut job);
    assert_eq!(far, red_status::TimeOverflow);
    let mut action = red_action::EMPTY;
    let no_lane = red_scheduler_poll_on(machine.at_mut(), 4, 16, &raw mut action);
    assert_eq!((no_lane, job), (red_status::UnknownLane, RED_NONE));
    machine.close();
}

#[test]
fn texts_are_there_for_every_number() {
    for number in (-1..=128).chain([7_000]) {
        // SAFETY: the header says that it is a text, and constant.
        let text = unsafe { core::ffi::CStr::from_ptr(red_status_text(number)) };
        assert!(!text.is_empty());
    }
    // SAFETY: as above.
    let version = unsafe { core::ffi::CStr::from_ptr(red_version()) };
    assert_eq!(version.to_str(), Ok(env!("CARGO_PKG_VERSION")));
    assert_eq!(red_abi_version(), RED_ABI_VERSION);
}
