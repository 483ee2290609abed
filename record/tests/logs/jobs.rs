//! Jobs in logs: two jobs may have the same nodes, so a unit's name does not tell whose it is.

use crate::{Scratch, header};
use red_core::{
    Action, Capacity, Caps, Config, Dag, DeadlineRule, Duration, Empty, Frame, Instant, LaneId, Node,
    Scheduler, SensorId, TaskId, Timing, Wcet,
};
use red_record::{Answer, Call, Difference, Entry, Header, Reader, Recorder, Replay, Writer, replay};
use std::fs;

type Small = crate::Small;

pub(crate) const LANE: LaneId = LaneId::new(0);

pub(crate) fn at(ms: u64) -> Instant {
    Instant::from_nanos(ms * 1_000_000)
}

pub(crate) fn chain<C: Capacity>(nodes: &[Node]) -> Dag<C> {
    let mut dag = Dag::new();
    let mut before = None;
    for node in nodes {
        let node = dag.add_node(*node).expect("room");
        if let Some(before) = before.replace(node) {
            dag.add_edge(before, node).expect("no cycle");
        }
    }
    dag
}

/// Two tasks with these deadlines, each a chain of these nodes.
fn scheduler(config: Config, deadlines_ms: [u64; 2], nodes: &[Node]) -> Box<Scheduler<Small>> {
    let mut scheduler: Box<Scheduler<Small>> = Box::new(Scheduler::EMPTY);
    scheduler.configure(config);
    scheduler.add_sensor(Duration::from_millis(50)).expect("room");
    let dag = chain(nodes);
    for deadline in deadlines_ms {
        scheduler.add_task(&dag, Timing::new(Duration::from_millis(deadline))).expect("room");
    }
    scheduler
}

/// As [`fed_to`], with two tasks.
fn fed(
    name: &str,
    scheduler: Box<Scheduler<Small>>,
    lane: Option<LaneId>,
    other: Box<Scheduler<Small>>,
) -> Replay {
    fed_to(name, scheduler, lane, other, &[(0, None), (1, None)])
}

/// Records these jobs, each of a task and with a capture, until all have ended: completes what runs, and asks for `lane` until there is nothing.
/// Then feeds it to `other`.
pub(crate) fn fed_to<C: Capacity>(
    name: &str,
    mut scheduler: Box<Scheduler<C>>,
    lane: Option<LaneId>,
    mut other: Box<Scheduler<C>>,
    jobs: &[(u32, Option<u64>)],
) -> Replay {
    let file = Scratch::new(&format!("jobs-{name}"));
    let header = Header { capacities: Header::capacities_of::<C>(), ..header() };
    let (writer, mut tape) = Writer::start(&file.0, &header).expect("a folder for temporary files");
    let recorder = &mut Recorder::new(&mut scheduler, Some(&mut tape));
    for (task, capture) in jobs {
        recorder.release_at(TaskId::from_bits(*task), at(0), *capture, at(0)).expect("room");
    }
    let (mut now, mut running) = (0, Vec::new());
    while recorder.jobs_in_flight() > 0 || !running.is_empty() {
        if let Some(unit) = running.pop() {
            let _late = recorder.complete(unit, at(now));
        }
        while let Some(action) = match lane {
            Some(lane) => recorder.poll_on(lane, at(now)),
            None => recorder.poll(at(now)),
        } {
            match action {
                Action::Dispatch(started) => running.push(started.unit),
                Action::Preempt(stopped) => running.retain(|unit| *unit != stopped.unit),
                _ => {}
            }
        }
        now += 1;
    }
    recorder.end(at(now));
    drop(tape);
    assert!(writer.finish().1.is_none());
    let bytes = fs::read(&file.0).expect("it was written");
    replay(&mut Reader::new(&*bytes).expect("a log"), &mut other, |_, _, _| Ok(()), |_, _| {})
        .expect("a whole log")
}

fn plain(deadlines_ms: [u64; 2], nodes: usize) -> Box<Scheduler<Small>> {
    scheduler(Config::EDF, deadlines_ms, &vec![Node::new(Wcet::from_millis(1)); nodes])
}

/// The difference is a start: of the very unit that was recorded, and of another job.
fn is_of_another_job(found: &Replay, input: u64) {
    let difference = found.difference.as_ref().expect("the jobs changed places");
    let Difference { recorded: Entry { call: Call::Poll(_), answer: Answer::Started(recorded), .. }, .. } =
        difference
    else {
        panic!("{difference:?}")
    };
    let Answer::Started(replayed) = difference.now else { panic!("{difference:?}") };
    assert_eq!((recorded.unit, difference.input), (replayed.unit, input), "{difference:?}");
    assert_ne!(recorded.job, replayed.job);
}

#[test]
fn a_unit_of_another_job_is_a_difference_where_it_starts() {
    for (name, lane) in [("own", Some(LANE)), ("handed", Some(LaneId::new(1))), ("polled", None)] {
        let same = fed(name, plain([10, 12], 2), lane, plain([10, 12], 2));
        assert!(same.difference.is_none(), "{name}: {same:?}");
        // Two releases; then the job that is due first is the other one.
        is_of_another_job(&fed(name, plain([10, 12], 2), lane, plain([12, 10], 2)), 3);
    }
}

#[test]
fn a_unit_of_another_job_is_a_difference_in_the_middle_of_a_turn() {
    // The first has to start by 10 ms and its second node by 11 ms; the others, of one node, between the two.
    let three = |due_us: [u64; 3]| {
        let mut scheduler: Box<Scheduler<Caps<3, 8, 4>>> = Box::new(Scheduler::EMPTY);
        scheduler.configure(Config { rule: DeadlineRule::LatestStart, ..Config::EDF });
        for (due, length) in due_us.into_iter().zip([2, 1, 1]) {
            let dag = chain(&vec![Node::new(Wcet::from_millis(1)); length]);
            scheduler.add_task(&dag, Timing::new(Duration::from_micros(due))).expect("room");
        }
        scheduler
    };
    let found = fed_to(
        "turn",
        three([12_000, 11_400, 11_700]),
        Some(LANE),
        three([12_000, 11_700, 11_400]),
        &[(0, None), (1, None), (2, None)],
    );
    // Three releases, the first unit, nothing more for its lane, its end, and the start.
    is_of_another_job(&found, 7);
}

#[test]
fn a_preempted_unit_comes_back_as_the_job_that_it_was() {
    let config = Config { preempt: true, ..Config::EDF };
    let nodes = [Node::new(Wcet::from_millis(2)), Node::new(Wcet::from_millis(2))];
    let both = || scheduler(config, [40, 12], &nodes);
    let found = fed("preempted", both(), Some(LANE), both());
    assert!(found.difference.is_none(), "{found:?}");
}

#[test]
fn a_unit_of_other_members_is_a_difference_where_it_starts() {
    let frame = Frame { weights: 0, frame: 0, sensor: Some(SensorId::new(0)) };
    let nodes = [Node::shared_encoder(Wcet::from_millis(3), frame), Node::decoder(Wcet::from_millis(1))];
    let with = |merges: bool| {
        let merge_skew = merges.then_some(Duration::from_millis(100));
        scheduler(Config { merge_skew, frame_cache: false, ..Config::REDRT }, [40, 40], &nodes)
    };
    for (recorded, replayed) in [(true, true), (false, false)] {
        let same = fed("members", with(recorded), Some(LANE), with(replayed));
        assert!(same.difference.is_none(), "{same:?}");
    }
    for (recorded, replayed) in [(true, false), (false, true)] {
        let found = fed("members", with(recorded), Some(LANE), with(replayed));
        let difference = found.difference.expect("the second encoder shares the execution or not");
        let (Answer::Started(recorded), Answer::Started(replayed)) =
            (difference.recorded.answer, difference.now)
        else {
            panic!("{difference:?}")
        };
        assert_eq!((recorded.unit, recorded.job, difference.input), (replayed.unit, replayed.job, 3));
        let all = recorded.members.or(replayed.members).expect("one of them is merged");
        assert_eq!(all.jobs.count_ones(), 2, "{difference:?}");
    }
}

#[test]
fn an_encoder_whose_result_has_no_place_has_its_members_too() {
    type Many = Caps<1, 8, 16>;
    let frame = Frame { weights: 0, frame: 0, sensor: Some(SensorId::new(0)) };
    let with = |merges: bool| {
        let mut scheduler: Box<Scheduler<Many>> = Box::new(Scheduler::EMPTY);
        let merge_skew = merges.then_some(Duration::from_millis(100));
        scheduler.configure(Config { merge_skew, frame_cache: false, ..Config::REDRT });
        scheduler.add_sensor(Duration::from_millis(50)).expect("room");
        // All encoders start before the first decoder, so all results are there at once.
        let nodes = [Node::shared_encoder(Wcet::from_millis(1), frame), Node::decoder(Wcet::from_millis(1))];
        scheduler.add_task(&chain(&nodes), Timing::new(Duration::from_millis(900))).expect("room");
        scheduler
    };
    // As many captures as there are places, and then two jobs of one more.
    let jobs: Vec<_> = (0..8).chain([8, 8]).map(|capture| (0, Some(capture))).collect();
    let same = fed_to("no-place", with(true), Some(LANE), with(true), &jobs);
    assert!(same.difference.is_none(), "{same:?}");
    let found = fed_to("no-place", with(true), Some(LANE), with(false), &jobs);
    let difference = found.difference.expect("the last two encoders share their execution or not");
    let Answer::Started(recorded) = difference.recorded.answer else { panic!("{difference:?}") };
    assert_eq!(recorded.members.map(|all| all.jobs.count_ones()), Some(2), "{difference:?}");
}
