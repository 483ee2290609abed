//! Logs that need no workload: hosts that set their schedulers up by calls, and change graphs by calls.

use crate::ends::{blocks, totals_at};
use crate::{Scratch, recorded};
use red_core::{
    Action, AddTaskError, Admission, Bytes, Capacity, CommitError, Config, Contention, Dag, Duration, Empty,
    Frame, Instant, LaneId, Node, NodeId, PoolError, PoolId, Ppm, Scheduler, SensorError, SensorId,
    ShedReason, TaskId, Timing, UnitId, Wcet,
};
use red_record::class::{self, ForClass, Large, Medium, Small, with_class};
use red_record::{
    Answer, Call, Entry, Header, LogError, Reader, Recorder, Replay, Writer, replay, replay_calls,
};
use std::collections::{HashSet, VecDeque};
use std::fs;
use std::mem::discriminant;

const CONFIG: Config = Config {
    lanes: 2,
    memory: Some(Bytes(1_000)),
    admission: Admission::Enforce,
    preempt: true,
    ..Config::REDRT
};

fn at(ms: u64) -> Instant {
    Instant::from_nanos(ms * 1_000_000)
}

fn ms(ms: u64) -> Node {
    Node::new(Wcet::from_millis(ms))
}

fn due(ms: u64) -> Timing {
    Timing::new(Duration::from_millis(ms))
}

/// Records what `host` does with a scheduler that was just configured.
fn log_of<C: Capacity>(name: &str, host: impl FnOnce(&mut Recorder<'_, C>)) -> Vec<u8> {
    log_with(CONFIG, name, host)
}

fn log_with<C: Capacity>(config: Config, name: &str, host: impl FnOnce(&mut Recorder<'_, C>)) -> Vec<u8> {
    let file = Scratch::new(&format!("calls-{name}"));
    let header = Header::by_calls::<C>("test", "redrt", config);
    let (writer, mut tape) = Writer::start(&file.0, &header).expect("a folder for temporary files");
    let mut scheduler: Box<Scheduler<C>> = Box::new(Scheduler::EMPTY);
    scheduler.configure(config);
    host(&mut Recorder::new(&mut scheduler, Some(&mut tape)));
    drop(tape);
    let (totals, failed) = writer.finish();
    assert!(failed.is_none() && totals.cut.is_none(), "{failed:?}");
    fs::read(&file.0).expect("it was written")
}

fn entries(log: &[u8]) -> Result<Vec<Entry>, LogError> {
    let (mut log, mut entries) = (Reader::new(log)?, Vec::new());
    while let Some(entry) = log.next_entry()? {
        entries.push(entry);
    }
    Ok(entries)
}

/// Feeds a log to a scheduler of its class, in which something else was before.
struct Again<'a>(&'a [u8]);

impl ForClass for Again<'_> {
    type Output = Result<Replay, LogError>;

    fn with<C: Capacity>(self) -> Self::Output {
        let mut scheduler: Box<Scheduler<C>> = Box::new(Scheduler::EMPTY);
        scheduler.configure(Config::EDF);
        let mut dag = Dag::new();
        dag.add_node(ms(1)).expect("room");
        scheduler.add_task(&dag, due(1)).expect("room");
        replay_calls(&mut Reader::new(self.0)?, &mut scheduler, |_, _| {}).map_err(|broken| broken.error)
    }
}

fn again(log: &[u8]) -> Result<Replay, LogError> {
    let capacities = Reader::new(log)?.header().capacities;
    with_class(capacities, Again(log)).expect("a class")
}

/// A camera, an encoder with two decoders, and an atomic node in the other pool after these.
fn stage<C: Capacity>(sensor: SensorId) -> Dag<C> {
    let mut dag = Dag::new();
    let mut add = |node| dag.add_node(node).expect("room");
    let frame = Frame { weights: 3, frame: 1, sensor: Some(sensor) };
    let [camera, gone] = [add(ms(1).best_case(Duration::from_micros(200))), add(ms(9))];
    let encoder = add(Node::shared_encoder(Wcet::from_millis(3), frame).memory(Bytes(300)));
    let decoders = [0; 2].map(|_| add(Node::decoder(Wcet::from_millis(1)).memory(Bytes(100))));
    let act = add(ms(1).atomic(Contention::from_millis(1)).in_pool(PoolId::new(1)));
    // Places are not counted through.
    assert!(dag.remove_node(gone));
    dag.add_edge(camera, encoder).expect("no cycle");
    for decoder in decoders {
        dag.add_edge(encoder, decoder).expect("no cycle");
        dag.add_edge(decoder, act).expect("no cycle");
    }
    dag
}

/// An encoder that reads a sensor which no scheduler has.
fn blind() -> Node {
    let frame = Frame { weights: 0, frame: 0, sensor: Some(SensorId::new(255)) };
    Node::shared_encoder(Wcet::from_nanos(1), frame)
}

fn one<C: Capacity>(node: Node) -> Dag<C> {
    let mut dag = Dag::new();
    dag.add_node(node).expect("room");
    dag
}

/// As many nodes as there may be; the first leads to all others.
fn widest<C: Capacity>() -> Dag<C> {
    let mut dag = one(Node::new(Wcet::ZERO));
    while let Ok(node) = dag.add_node(Node::new(Wcet::from_nanos(1))) {
        dag.add_edge(NodeId::new(0), node).expect("no cycle");
    }
    assert_eq!(dag.len(), C::NODES);
    dag
}

/// The task's graph with a node more.
fn more<C: Capacity>(host: &Recorder<'_, C>, task: TaskId, node: Node) -> Dag<C> {
    let mut edit = Scheduler::edit(host, task).expect("the task is there");
    let _full = edit.add_node(node).map(|new| edit.add_edge(NodeId::new(0), new));
    edit
}

/// Pools, sensors and tasks, each answer of theirs given once.
fn set_up<C: Capacity>(host: &mut Recorder<'_, C>) -> [TaskId; 2] {
    assert_eq!(host.add_pool(1, Some(Bytes(50))), Ok(PoolId::new(1)));
    assert_eq!(host.add_pool(0, None), Err(PoolError::NoLane));
    assert_eq!(host.add_pool(255, None), Err(PoolError::Full));
    assert!(!host.dispatch_ahead(PoolId::new(1)), "they preempt");
    assert!(!host.lose_pool(PoolId::new(9), at(0)));
    assert!(host.observe_use(PoolId::new(1), Ppm(7)) && !host.observe_use(PoolId::new(9), Ppm(7)));
    let sensor = host.add_sensor(Duration::from_millis(10)).expect("room");
    assert_eq!(host.add_sensor(Duration::from_millis(10)), Ok(sensor));
    assert_eq!(host.add_sensor(Duration::ZERO), Err(SensorError::ZeroPeriod));
    let seeing = due(40).every(Duration::from_millis(20)).value(7).floor(3, 4);
    let tasks = [host.add_task(&stage(sensor), seeing), host.add_task(&stage(sensor), due(60))];
    let mut refused = |dag: &Dag<C>, timing: Timing| host.add_task(dag, timing).expect_err("refused");
    assert_eq!(refused(&Dag::new(), due(9)), AddTaskError::Empty);
    assert_eq!(refused(&one(ms(1)), due(0)), AddTaskError::Deadline);
    assert_eq!(refused(&one(ms(1).in_pool(PoolId::new(9))), due(9)), AddTaskError::UnknownPool);
    assert_eq!(refused(&one(blind()), due(9)), AddTaskError::UnknownSensor);
    assert_eq!(refused(&one(ms(1).memory(Bytes(1_001))), due(9)), AddTaskError::Memory);
    assert_eq!(refused(&one(ms(10)), due(9)), AddTaskError::Unschedulable);
    let mut all = vec![host.add_task(&widest(), due(30)).expect("room")];
    while let Ok(task) = host.add_task(&one(ms(1)), due(30).floor(5, 1_000)) {
        all.push(task);
    }
    assert_eq!(all.len() + 2, C::TASKS);
    // One place has another task from then on.
    assert!(host.remove_task(all[1], at(0)));
    assert_ne!(host.add_task(&one(ms(2)), due(30)).expect("room"), all[1]);
    tasks.map(|task| task.expect("room"))
}

/// Commits, each answer of theirs given once but those that need jobs.
fn change<C: Capacity>(host: &mut Recorder<'_, C>, [task, other]: [TaskId; 2]) -> TaskId {
    let old = more(host, task, ms(1));
    assert!(host.commit(&more(host, task, ms(2)), at(1)).expect("it fits").fits());
    assert_eq!(host.commit(&old, at(1)), Err(CommitError::Conflict));
    let mut refused = |change: &dyn Fn(&mut Dag<C>)| {
        let mut edit = Scheduler::edit(host, task).expect("the task is there");
        change(&mut edit);
        host.commit(&edit, at(2)).expect_err("refused")
    };
    let add = |dag: &mut Dag<C>, node| _ = dag.add_node(node).expect("room");
    assert_eq!(refused(&|dag| dag.nodes().for_each(|node| _ = dag.remove_node(node))), CommitError::Empty);
    assert_eq!(refused(&|dag| add(dag, ms(1).in_pool(PoolId::new(9)))), CommitError::UnknownPool);
    assert_eq!(refused(&|dag| add(dag, blind())), CommitError::UnknownSensor);
    assert_eq!(refused(&|dag| add(dag, ms(1).memory(Bytes(1_001)))), CommitError::Memory);
    assert_eq!(refused(&|dag| add(dag, ms(100))), CommitError::Unschedulable);
    let periods = (1..=C::NODES as u64).map(Duration::from_micros);
    assert_eq!(periods.map(|period| host.add_sensor(period)).last(), Some(Err(SensorError::Full)));
    // A graph of a task that is gone, and one that `edit` did not make.
    let left = more(host, other, ms(1));
    assert!(host.remove_task(other, at(2)));
    assert_eq!(host.commit(&left, at(2)), Err(CommitError::UnknownTask));
    assert_eq!(host.commit(&one(ms(1)), at(2)), Err(CommitError::Conflict));
    let next = host.add_task(&stage(SensorId::new(0)), due(60)).expect("the place of the one that is gone");
    assert_eq!(host.commit(&left, at(2)), Err(CommitError::UnknownTask));
    next
}

/// Two tasks run for `turns` milliseconds, and the first gets a node and loses it again all the time. What its commits
/// answered.
fn run<C: Capacity>(host: &mut Recorder<'_, C>, tasks: [TaskId; 2], turns: u64) -> Vec<Option<CommitError>> {
    let [task, _] = tasks;
    let mut running: Vec<Option<UnitId>> = vec![None; host.lanes()];
    let mut refusals = Vec::new();
    for turn in 3..turns {
        let now = Instant::from_nanos(turn * 1_000_000 + turn % 7);
        for (lane, place) in (0..).map(LaneId::new).zip(&mut running) {
            if let Some(unit) = place.take_if(|_| (turn + lane.index() as u64).is_multiple_of(3)) {
                let failed = turn % 31 == 0;
                _ = if failed { host.fail(unit, now) } else { host.complete(unit, now) };
                if failed && host.retire_lane(lane) {
                    assert!(host.restore_lane(lane) && !host.restore_lane(lane));
                }
            }
        }
        if turn % 20 == 3 {
            for task in tasks {
                _ = host.release_at(task, now, (turn % 40 == 3).then_some(turn), now);
            }
        }
        if turn % 7 == 5 {
            let mut edit = Scheduler::edit(host, task).expect("the task is there");
            let last = edit.nodes().last().filter(|last| last.index() > 5);
            match last {
                Some(last) => _ = edit.remove_node(last),
                None => edit = more(host, task, ms(1)),
            }
            refusals.push(host.commit(&edit, now).err());
        }
        for lane in (0..running.len() as u8).map(LaneId::new) {
            while let Some(action) = host.poll_on(lane, now) {
                match action {
                    Action::Dispatch(start) => running[start.lane.index()] = Some(start.unit),
                    Action::Preempt(stop) => running[stop.lane.index()] = None,
                    _ => {}
                }
            }
        }
    }
    refusals
}

/// Everything, in a scheduler of these capacities.
fn everything<C: Capacity>(name: &str) -> Vec<u8> {
    log_of::<C>(name, |host| {
        let tasks = set_up(host);
        let next = change(host, tasks);
        assert!(!host.remove_task(tasks[1], at(2)));
        // All nodes of the widest graph run, so that what follows knows of each.
        let wide = TaskId::from_bits(2);
        host.release_at(wide, at(2), None, at(2)).expect("room");
        let mut nodes = 0;
        while let Some(Action::Dispatch(start)) = host.poll_on(LaneId::new(0), at(2)) {
            let waits = nodes > 0 || host.poll_on(LaneId::new(1), at(2)).is_none();
            assert!(waits, "all others come after the first");
            host.complete(start.unit, at(2)).expect("it runs");
            nodes += 1;
        }
        assert_eq!(nodes, C::NODES);
        let refusals = run(host, [tasks[0], next], 400);
        for expected in [None, Some(CommitError::Busy)] {
            assert!(refusals.contains(&expected), "{expected:?} among {refusals:?}");
        }
        let counters = host.counters();
        assert!(counters.units > 50 && counters.encoder_runs_saved > 5, "{counters:?}");
        host.end(at(400));
    })
}

#[test]
fn a_run_that_was_set_up_by_calls_is_replayed_without_a_difference_in_every_class() {
    let logs = [everything::<Small>("small"), everything::<Medium>("medium"), everything::<Large>("large")];
    assert_eq!(class::ALL.len(), logs.len());
    for (log, capacities) in logs.iter().zip(class::ALL) {
        assert_eq!(Reader::new(&**log).unwrap().header().capacities, *capacities);
        let entries = entries(log).unwrap();
        let found = again(log).unwrap();
        assert!(found.difference.is_none(), "{:?}", found.difference);
        assert_eq!(found.inputs, entries.len() as u64);
        let calls: HashSet<_> = entries.iter().map(|entry| discriminant(&entry.call)).collect();
        // All but those that take an outcome without a poll, and changes with a number.
        assert_eq!(calls.len(), 17, "{capacities:?}");
    }
}

/// A stream that runs an encoder with three decoders, units behind others, and reports in its order.
fn streams(host: &mut Recorder<'_, Small>) {
    assert!(host.dispatch_ahead(PoolId::new(0)) && !host.dispatch_ahead(PoolId::new(9)));
    let mut dag = Dag::new();
    let frame = Frame { weights: 3, frame: 1, sensor: None };
    let encoder = dag.add_node(Node::shared_encoder(Wcet::from_millis(3), frame)).expect("room");
    for _ in 0..3 {
        let decoder = dag.add_node(Node::decoder(Wcet::from_millis(1))).expect("room");
        dag.add_edge(encoder, decoder).expect("no cycle");
    }
    let task = host.add_task(&dag, due(50)).expect("room");
    let (mut queues, mut ahead) = ([const { VecDeque::new() }; 2], 0);
    for now in 0..400 {
        if now % 5 == 0 {
            for (lane, queue) in queues.iter_mut().enumerate() {
                // Every so often only one of them is heard, or one fails.
                if now % 35 != 10 * lane as u64
                    && let Some(unit) = queue.pop_front()
                {
                    _ = if now % 65 == 0 { host.fail(unit, at(now)) } else { host.complete(unit, at(now)) };
                }
            }
        }
        if now % 12 == 0 {
            host.release_at(task, at(now), None, at(now)).expect("room");
        }
        while let Some(action) = host.poll(at(now)) {
            if let Action::Dispatch(given) | Action::Ahead(given) = action {
                queues[given.lane.index()].push_back(given.unit);
            }
            ahead += u32::from(matches!(action, Action::Ahead(_)));
        }
    }
    host.end(at(400));
    assert!(ahead > 20, "{ahead}");
}

#[test]
fn a_run_whose_units_were_dispatched_ahead_is_replayed_without_a_difference() {
    let config = Config { lanes: 2, ..Config::REDRT };
    let log = log_with::<Small>(config, "ahead", streams);
    let found = again(&log).unwrap();
    assert!(found.difference.is_none(), "{:?}", found.difference);
    let is_ahead = |entry: &Entry| matches!(entry.answer, Answer::Ahead(_));
    assert!(entries(&log).unwrap().iter().any(is_ahead));
}

/// Lanes that get more than they can do from three tasks, of which one is worth more and one has a floor.
fn overloaded(host: &mut Recorder<'_, Small>) {
    let timings = [due(30), due(30).value(9), due(30).floor(1, 1)];
    let tasks = timings.map(|timing| host.add_task(&one(ms(8)), timing).expect("room"));
    let (mut running, mut shed) = (Vec::new(), [0; 3]);
    for now in 0..600 {
        for (unit, _) in running.extract_if(.., |(_, until)| *until <= now) {
            let _late = host.complete(unit, at(now));
        }
        for task in tasks.into_iter().filter(|_| matches!(now % 11, 0 | 6)) {
            _ = host.release_at(task, at(now), None, at(now));
        }
        while let Some(action) = host.poll(at(now)) {
            match action {
                Action::Dispatch(start) => running.push((start.unit, now + 4)),
                Action::Ended(outcome) if outcome.shed == Some(ShedReason::Overload) => {
                    shed[outcome.task.index()] += 1;
                }
                _ => {}
            }
        }
    }
    host.end(at(600));
    let [plain, worth, kept] = shed;
    assert!(plain > kept + worth, "{shed:?}");
}

#[test]
fn what_tasks_are_worth_and_their_floors_are_those_that_were_recorded() {
    let log = log_of::<Small>("worth", overloaded);
    let found = again(&log).unwrap();
    assert!(found.difference.is_none(), "{:?}", found.difference);
}

#[test]
fn a_difference_in_what_was_set_up_is_told_where_it_is() {
    let log = log_of::<Small>("where", |host| {
        host.add_pool(2, None).expect("room");
        let task = host.add_task(&one(ms(1)), due(30)).expect("room");
        let _proof = host.commit(&more(host, task, ms(2)), at(1)).expect("it fits");
        host.end(at(2));
    });
    // The same entries, fed to schedulers in which something is otherwise.
    let with = |plant: &dyn Fn(&mut Scheduler<Small>)| {
        let mut scheduler: Box<Scheduler<Small>> = Box::new(Scheduler::EMPTY);
        scheduler.configure(CONFIG);
        plant(&mut scheduler);
        let found =
            replay(&mut Reader::new(&*log).unwrap(), &mut scheduler, |_, _, _| Ok(()), |_, _| {}).unwrap();
        found.difference.map(|difference| discriminant(&difference.recorded.answer))
    };
    assert_eq!(with(&|_| {}), None);
    let answers: Vec<_> = entries(&log).unwrap().iter().map(|entry| discriminant(&entry.answer)).collect();
    let [pool, _node, task, _nodes @ .., committed, _end] = &*answers else { panic!("{answers:?}") };
    let another_pool = with(&|scheduler| _ = scheduler.add_pool(1, None).expect("room"));
    assert_eq!(another_pool, Some(*pool));
    let another_task = with(&|scheduler| _ = scheduler.add_task(&one(ms(1)), due(9)).expect("room"));
    assert_eq!(another_task, Some(*task));
    // The bound on two lanes is another one.
    let fewer_lanes = with(&|scheduler| assert!(scheduler.retire_lane(LaneId::new(0))));
    assert_eq!(fewer_lanes, Some(*committed));
}

/// The log with this bit of this block's words changed, and the block's checksum right.
fn flipped(log: &[u8], block: usize, bit: usize) -> Vec<u8> {
    let mut log = log.to_vec();
    let length = u32::from_le_bytes(log[block + 4..block + 8].try_into().unwrap()) as usize;
    let words = block + 12..block + 12 + length;
    log[words.clone()][bit / 8] ^= 1 << (bit % 8);
    let crc = crc32fast::hash(&log[words]).to_le_bytes();
    log[block + 8..block + 12].copy_from_slice(&crc);
    log
}

#[test]
fn what_was_set_up_is_as_recorded_to_the_bit_or_refused() {
    let log = log_of::<Small>("bits", |host| {
        let tasks = set_up(host);
        let _next = change(host, tasks);
        host.end(at(3));
    });
    let said = |entries: Vec<Entry>| -> Vec<_> { entries.into_iter().map(|e| (e.call, e.answer)).collect() };
    let recorded = said(entries(&log).unwrap());
    let kinds: HashSet<_> = recorded.iter().map(|(call, _)| discriminant(call)).collect();
    assert_eq!(kinds.len(), 11, "nine that set up, one that removes, and the end");
    let (mut refused, mut differ, mut same) = (0, 0, 0);
    for (block, _) in blocks(&log, totals_at(&log) + 24) {
        let length = u32::from_le_bytes(log[block + 4..block + 8].try_into().unwrap()) as usize;
        for bit in 0..length * 8 {
            let changed = flipped(&log, block, bit);
            match (entries(&changed).map(said), again(&changed)) {
                (_, Err(LogError::Damaged { .. } | LogError::Unended | LogError::Truncated { .. })) => {
                    refused += 1;
                }
                (_, Ok(Replay { difference: Some(_), .. })) => differ += 1,
                // Times of calls that are given none, and bits of other heads.
                (Ok(read), Ok(_)) if read == recorded => same += 1,
                (read, found) => {
                    let changed = read.unwrap().into_iter().zip(&recorded).find(|(now, then)| now != *then);
                    panic!("bit {bit}, {changed:?}: {found:?}");
                }
            }
        }
    }
    assert!(refused > 1_000 && differ > 1_000, "{refused} refused, {differ} differ, {same} same");
    assert!(same < refused + differ, "{refused} refused, {differ} differ, {same} same");
}

#[test]
fn logs_of_one_kind_are_not_taken_for_the_other() {
    let (file, _) = recorded("of-a-file", 10);
    let of_a_file = fs::read(&file.0).unwrap();
    let mut scheduler: Box<Scheduler<crate::Small>> = Box::new(Scheduler::EMPTY);
    let found = replay_calls(&mut Reader::new(&*of_a_file).unwrap(), &mut scheduler, |_, _| {});
    let broken = found.expect_err("it needs its workload");
    assert!(matches!(broken.error, LogError::NotByCalls) && broken.to_string().contains("redrt replay"));
    // Changes with a number are the host's: nobody else knows them.
    let numbered = log_of::<Small>("numbered", |host| {
        let task = host.add_task(&one(ms(1)), due(30)).expect("room");
        let change = |scheduler: &mut Scheduler<Small>| {
            let mut edit = scheduler.edit(task).ok_or(CommitError::UnknownTask)?;
            let _room = edit.add_node(ms(1));
            scheduler.commit(&edit, at(1)).map(drop)
        };
        host.edit(0, at(1), change).expect("it fits");
        host.end(at(2));
    });
    let difference = again(&numbered).unwrap().difference.expect("it was made");
    assert_eq!(difference.recorded.call, Call::Edit(0));
    assert_eq!(difference.now, Answer::Edited(Err(CommitError::UnknownTask)));
}

#[test]
fn capacities_of_no_class_and_of_another_are_refused() {
    let log = log_of::<Medium>("medium-only", |host| host.end(at(1)));
    let mut scheduler: Box<Scheduler<Small>> = Box::new(Scheduler::EMPTY);
    let found = replay_calls(&mut Reader::new(&*log).unwrap(), &mut scheduler, |_, _| {});
    assert!(matches!(found.map_err(|broken| broken.error), Err(LogError::Capacities { .. })));
    assert!(with_class(Header::capacities_of::<crate::Small>(), Again(&log)).is_none());
}

#[test]
fn a_configuration_comes_back_as_it_was_written() {
    let odd = Config {
        memory: None,
        merge_skew: None,
        preempt: false,
        overload: red_core::Overload {
            utilisation: red_core::Ppm(u32::MAX),
            queue: u16::MAX,
            ticks: 0,
            tick: Duration::from_nanos(u64::MAX),
        },
        late: red_core::Late::AbortJob,
        best_case: red_core::BestCase::Declared,
        ..CONFIG
    };
    for config in [CONFIG, odd, Config::EDF, Config::RED_FG, Config::RED_IDA, Config::RED, Config::REDRT] {
        let header = Header::by_calls::<Small>("test", "p", config);
        let text = serde_json::to_string(&header).unwrap();
        assert_eq!(serde_json::from_str::<Header>(&text).unwrap(), header, "{text}");
        // What this version has no word for would be replayed otherwise.
        for other in [text.replace("\"preempt\"", "\"x\""), text.replace("\"lanes\"", "\"y\":0,\"lanes\"")] {
            assert!(other != text && serde_json::from_str::<Header>(&other).is_err(), "{other}");
        }
    }
    let of_a_file = serde_json::to_string(&crate::header()).unwrap();
    assert!(!of_a_file.contains("config"), "{of_a_file}");
}
