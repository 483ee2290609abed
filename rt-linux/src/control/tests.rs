use super::{AskError, Control, DEPTH, PRODUCERS, Refused, Shared};
use crate::shared::Held;
use crate::stop::Stopper;
use crate::timeline::{Host, Timeline};
use red_core::{Caps, Config, Event, Instant, JobId, Outcome, ReleaseError, Scheduler, TaskId};
use red_sync::{Request, TicketLock};
use std::sync::Arc;
use std::thread;

type Small = Caps<1, 1, 1, 1>;

struct Silent;

impl Host<Small> for Silent {
    fn released(&mut self, _task: usize, _release: Instant, _taken: Result<JobId, ReleaseError>) {}
    fn ended(&mut self, _outcome: &Outcome) {}
    fn event(&mut self, _event: &Event) {}
}

type Run = Shared<Small, Silent, TicketLock<Scheduler<Small>>>;

/// A run of which no lane is heard.
fn run(until_ns: u64) -> Arc<Run> {
    let held = Held { timeline: Timeline::new(&[], until_ns), host: Some(Silent), tape: None, stood_ns: 0 };
    Shared::new(Box::new(Scheduler::new(Config::EDF)), held, 0, until_ns, 0, Arc::new(Stopper::new(None)))
}

fn task() -> TaskId {
    TaskId::from_bits(0)
}

/// What was asked for, in the order in which a lane would take it.
fn taken(run: &Run) -> Vec<Request> {
    run.scheduler.with(|_, requests| std::iter::from_fn(|| requests.next()).collect())
}

#[test]
fn requests_of_a_thread_stay_in_order_until_its_box_is_full() {
    let run = run(u64::MAX);
    for capture in 0..DEPTH as u64 {
        assert_eq!(run.release(task(), Some(capture)), Ok(()));
    }
    assert_eq!(run.release(task(), None), Err(Refused::Full));
    let requests = taken(&run);
    assert!(requests.iter().map(|request| request.capture).eq((0..DEPTH as u64).map(Some)));
    assert!(requests.is_sorted_by_key(|request| request.at));
    assert_eq!(run.release(task(), None), Ok(()), "there is room again");
}

#[test]
fn a_request_goes_to_any_place_that_is_free_and_is_refused_where_none_is() {
    let run = run(u64::MAX);
    for free in 0..PRODUCERS {
        let others = (0..PRODUCERS).filter(|place| *place != free);
        let _held: Vec<_> = others.map(|place| run.scheduler.producer(place).expect("free")).collect();
        assert_eq!(run.release(task(), None), Ok(()));
    }
    assert_eq!(taken(&run).len(), PRODUCERS);
    let _held: Vec<_> =
        (0..PRODUCERS).map(|place| run.scheduler.producer(place).expect("it was given back")).collect();
    assert_eq!(run.release(task(), None), Err(Refused::Busy));
}

#[test]
fn nothing_is_accepted_once_the_run_is_over() {
    let over = run(0);
    assert_eq!(over.release(task(), None), Err(Refused::Over));
    let stopped = run(u64::MAX);
    for _ in 0..2 {
        stopped.stop();
        assert_eq!(stopped.release(task(), None), Err(Refused::Over));
        assert_eq!(stopped.ask(Box::new(|_, _| panic!("it ran"))).err(), Some(AskError::Over));
    }
    assert!(taken(&stopped).is_empty());
}

#[test]
fn who_waits_for_a_lane_is_told_that_none_comes() {
    let run = run(u64::MAX);
    thread::scope(|threads| {
        let asks: Vec<_> = (0..3).map(|_| threads.spawn(|| run.ask(Box::new(|_, _| ())).err())).collect();
        run.end();
        for ask in asks {
            assert_eq!(ask.join().expect("it only asks"), Some(AskError::Over));
        }
    });
}

#[test]
fn the_clock_of_a_run_counts_from_its_origin() {
    let run = run(0);
    let (before, origin) = (run.now_ns(), run.origin_ns());
    let now = crate::clock::now_ns() - origin;
    assert!(before <= now && now <= run.now_ns());
}
