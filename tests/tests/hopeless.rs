//! Who is lost for certain, and when that is found: of those who wait for an encoder of their frame above all.

use red_core::{
    Action, BestCase, Caps, Config, Dag, Duration, Frame, Instant, LaneId, Node, Scheduler, ShedReason,
    TaskId, Timing, UnitId, Wcet,
};
use red_sim::simulate;
use red_tests::differential::options;
use red_tests::oracle;
use red_workload::{Format, parse};

const MS: u64 = 1_000_000;

/// A task of one stage, which reads the same frame as the others and has a decoder of 1 ms.
struct Stage {
    encoder_ms: u64,
    deadline_ms: u64,
    offset_ms: u64,
    value: u32,
}

const FIVE: Stage = Stage { encoder_ms: 5, deadline_ms: 100, offset_ms: 0, value: 1 };

impl Stage {
    fn named(&self, name: &str) -> String {
        let Self { encoder_ms, deadline_ms, offset_ms, value } = self;
        format!(
            r#"
            [[task]]
            name = "{name}"
            deadline = "{deadline_ms}ms"
            offset = "{offset_ms}ms"
            value = {value}
            once = true
            [[task.node]]
            name = "stage"
            mimonet = {{ weights = "w", frame = "front", encoder = {{ wcet = "{encoder_ms}ms" }},
                decoders = [{{ name = "decoder", wcet = "1ms" }}] }}
            "#
        )
    }
}

fn lanes(lanes: u64) -> String {
    format!("[[pool]]\nname = 'gpu'\nlanes = {lanes}\n[[sensor]]\nname = 'front'\nperiod = '100ms'\n")
}

/// Runs T1 and T2 on one lane. The sheds, as `task at`, in microseconds.
fn sheds(t1: &Stage, t2: &Stage) -> Vec<String> {
    sheds_in(&format!("{}{}{}", lanes(1), t1.named("T1"), t2.named("T2")))
}

/// Runs a file for 50 ms, which the oracle has to do in the same way. The sheds, as `task at`, in microseconds.
fn sheds_in(text: &str) -> Vec<String> {
    let workload = parse(text.as_bytes(), Format::Toml, "stages.toml").unwrap_or_else(|e| panic!("{e}"));
    let options = options(oracle::Policy::Redrt, 50 * MS);
    let report = simulate(&workload, &options).expect("the tasks fit");
    let found = report.sheds.unwrap_or_default();
    let found: Vec<String> = found.iter().map(|s| format!("{} {}", s.task, s.at_ns / 1_000)).collect();
    let expected = oracle::simulate(&workload, oracle::Policy::Redrt, 50 * MS).sheds;
    assert_eq!(found, expected.iter().map(|s| format!("{} {}", s.task, s.at_ns / 1_000)).collect::<Vec<_>>());
    found
}

#[test]
fn a_job_that_would_be_late_by_its_own_encoder_lives_on_the_running_one() {
    // 20 ms of its own would end after 11 ms; the hit at 5 ms and the decoder end at 6 ms.
    assert!(sheds(&FIVE, &Stage { encoder_ms: 20, deadline_ms: 10, offset_ms: 1, ..FIVE }).is_empty());
}

#[test]
fn a_job_that_waits_for_the_running_encoder_is_lost_when_that_one_ends() {
    // It has to wait until 5 ms, and is due then. An encoder that is being computed counts 0: until 4 ms it could end in
    // time for all that is certain. That it will not is predicted from 1 ms on, but nobody is in its way.
    let late = Stage { encoder_ms: 1, deadline_ms: 4, offset_ms: 1, ..FIVE };
    assert_eq!(sheds(&FIVE, &late), ["T2 5000"]);
}

#[test]
fn who_has_less_to_do_does_not_wait_for_a_longer_encoder_of_its_frame() {
    // Both are released at 0, T1 has the smaller key, and T2 cannot wait for its 20 ms. In the order of deadlines both are
    // in time, whatever T1 is worth.
    let t2 = Stage { encoder_ms: 1, deadline_ms: 15, ..FIVE };
    for value in [1, 2] {
        assert!(sheds(&Stage { encoder_ms: 20, deadline_ms: 31, value, ..FIVE }, &t2).is_empty());
    }
}

#[test]
fn contention_is_no_part_of_what_is_left() {
    // 3 ms are left of the job that is due at 3 ms; with contention it would be 4 ms.
    let text = r#"
        [[task]]
        name = "T"
        deadline = "3ms"
        once = true
        [[task.node]]
        name = "n"
        wcet = "3ms"
        atomic = true
        contention = "1ms"
    "#;
    assert!(sheds_in(&format!("{}{text}", lanes(1))).is_empty());
}

type Robot = Caps<3, 4, 4>;

fn at(ms: u64) -> Instant {
    Instant::from_nanos(ms * MS)
}

fn robot(best_case: BestCase, lanes: u8) -> Scheduler<Robot> {
    Scheduler::new(Config { best_case, ..Config::REDRT.with_lanes(lanes) })
}

/// A chain of nodes that never take less than their WCET.
fn add(scheduler: &mut Scheduler<Robot>, nodes: &[Node], deadline_ms: u64) -> TaskId {
    let mut dag = Dag::new();
    let exact = nodes.iter().map(|node| node.best_case(node.wcet().get()));
    let ids: Vec<_> = exact.map(|node| dag.add_node(node).expect("it fits")).collect();
    ids.windows(2).for_each(|pair| dag.add_edge(pair[0], pair[1]).expect("a chain"));
    scheduler.add_task(&dag, Timing::new(Duration::from_millis(deadline_ms))).expect("there is room")
}

/// Starts what can start, and the last unit of it.
fn start(scheduler: &mut Scheduler<Robot>, now: Instant) -> Option<UnitId> {
    let started = std::iter::from_fn(|| scheduler.poll(now)).map(|action| match action {
        Action::Dispatch(started) => started.unit,
        other => panic!("nobody asked for {other:?}"),
    });
    started.last()
}

/// Why jobs of a task are given up now.
fn given_up(scheduler: &mut Scheduler<Robot>, task: TaskId, now: Instant) -> Vec<ShedReason> {
    let ended = std::iter::from_fn(|| scheduler.poll(now)).filter_map(|action| match action {
        Action::Ended(job) if job.task == task => job.shed,
        _ => None,
    });
    ended.collect()
}

/// What happens to the task of the unit that runs, and to the unit.
type Happening = fn(&mut Scheduler<Robot>, TaskId, UnitId, Instant);

#[test]
fn any_event_finds_who_is_lost() {
    // The lanes are busy until 50 and 7 ms. A job of 5 ms that is due at 10 ms can start at 5 ms at the latest.
    let happenings: [(&str, Happening); 4] = [
        ("complete", |s, _, unit, now| s.complete(unit, now).expect("it runs")),
        ("fail", |s, _, unit, now| s.fail(unit, now).expect("it runs")),
        ("release", |s, task, _, now| assert!(s.release(task, now).is_ok())),
        ("commit", |s, task, _, now| {
            let edit = s.edit(task).expect("it is there");
            let _fits = s.commit(&edit, now).expect("nothing changes");
        }),
    ];
    for best_case in [BestCase::Observed, BestCase::Declared] {
        for (what, happens) in happenings {
            for (ms, expected) in [(5, vec![]), (6, vec![ShedReason::Hopeless])] {
                let mut scheduler = robot(best_case, 2);
                let node = |ms| [Node::new(Wcet::from_millis(ms))];
                let long = add(&mut scheduler, &node(50), 100);
                let short = add(&mut scheduler, &node(7), 200);
                let lost = add(&mut scheduler, &node(5), 10);
                scheduler.release(long, at(0)).expect("there is room");
                scheduler.release(short, at(0)).expect("there is room");
                let unit = start(&mut scheduler, at(0)).expect("short starts last");
                scheduler.release(lost, at(0)).expect("there is room");
                assert_eq!(start(&mut scheduler, at(0)), None, "both lanes are busy");
                happens(&mut scheduler, short, unit, at(ms));
                let found = given_up(&mut scheduler, lost, at(ms));
                assert_eq!(found, expected, "{what} at {ms} ms, {best_case:?}");
            }
        }
    }
}

#[test]
fn a_lane_that_is_lost_counts_for_the_jobs_to_come() {
    for (is_lost, expected) in [(false, vec![]), (true, vec![ShedReason::Hopeless])] {
        let mut scheduler = robot(BestCase::Declared, 2);
        let mut dag = Dag::new();
        for _ in 0..2 {
            let node = Node::new(Wcet::from_millis(10)).best_case(Duration::from_millis(10));
            dag.add_node(node).expect("it fits");
        }
        let task = scheduler.add_task(&dag, Timing::new(Duration::from_millis(15))).expect("there is room");
        if is_lost {
            assert!(scheduler.retire_lane(LaneId::new(1)));
        }
        scheduler.release(task, at(5)).expect("there is room");
        assert_eq!(given_up(&mut scheduler, task, at(5)), expected);
    }
}

#[test]
fn a_job_that_waits_for_an_encoder_that_fails_has_its_own_to_run() {
    // The encoder of 5 ms fails at 3 ms. The second job waited for it, is due at 11 ms, and has 1 ms of decoder.
    for (encoder_ms, expected) in [(7, vec![]), (8, vec![ShedReason::Hopeless])] {
        let mut scheduler = robot(BestCase::Declared, 1);
        let sensor = scheduler.add_sensor(Duration::from_millis(100)).expect("there is room");
        let frame = Frame { weights: 0, frame: 0, sensor: Some(sensor) };
        let stage = |encoder_ms| {
            let encoder = Node::shared_encoder(Wcet::from_millis(encoder_ms), frame);
            [encoder, Node::decoder(Wcet::from_millis(1))]
        };
        let first = add(&mut scheduler, &stage(5), 100);
        let second = add(&mut scheduler, &stage(encoder_ms), 10);
        scheduler.release(first, at(0)).expect("there is room");
        let unit = start(&mut scheduler, at(0)).expect("the lane is free");
        scheduler.release(second, at(1)).expect("there is room");
        assert_eq!(start(&mut scheduler, at(1)), None, "it waits");
        scheduler.fail(unit, at(3)).expect("it runs");
        assert_eq!(given_up(&mut scheduler, second, at(3)), expected, "{encoder_ms} ms");
    }
}

#[test]
fn a_job_whose_result_was_thrown_away_is_lost_at_the_next_event() {
    // At 10 ms the result of T stands in the way of X, which one decoder overtakes. At 15 ms the result goes, X runs until
    // 18 ms, and the 10 + 5 ms that are left of T then end at 33 ms. An eviction is no event, so that the end of X tells.
    let of = |deadline_ms: u64| {
        sheds_in(&format!(
            r#"
            [[pool]]
            name = "gpu"
            lanes = 1
            memory = "100MiB"
            [[task]]
            name = "T"
            deadline = "{deadline_ms}ms"
            once = true
            [[task.node]]
            name = "stage"
            mimonet = {{ weights = "w", frame = "rear", encoder = {{ wcet = "10ms", memory = "60MiB" }}, decoders = [
                {{ name = "p", wcet = "5ms", memory = "10MiB" }}, {{ name = "q", wcet = "5ms", memory = "10MiB" }}] }}
            [[task]]
            name = "X"
            deadline = "19ms"
            offset = "10ms"
            once = true
            [[task.node]]
            name = "x"
            wcet = "3ms"
            memory = "50MiB"
            "#
        ))
    };
    assert!(of(33).is_empty());
    assert_eq!(of(32), ["T 18000"]);
}
