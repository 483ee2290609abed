//! Pools that dispatch ahead: nothing starts on the device before its predecessors ended there, whatever the host
//! learns when, and every lane is given back.

mod streams;

use red_core::{
    Action, Caps, CompleteError, Config, Dag, Duration, Empty, EventKind, Frame, Instant, Node, NodeId,
    Outcome, PoolId, Scheduler, TaskId, Timing, UnitId, Wcet,
};
use red_sim::Lab;
use red_tests::rng::{Rng, Shape, random_workload};
use red_workload::build::{self, Plan};
use red_workload::model::{Arrival, Workload};
use red_workload::{Format, parse};
use std::fmt::Write;
use streams::Streams;

type Robot = Caps<2, 16, 4, 4, 2, 1, 64>;

const MS: u64 = 1_000_000;

fn at(nanos: u64) -> Instant {
    Instant::from_nanos(nanos)
}

fn node(millis: u64) -> Node {
    Node::new(Wcet::from_millis(millis))
}

/// A scheduler of one pool of so many lanes that dispatches ahead, and a job of this graph.
fn released(config: Config, lanes: u8, dag: &Dag<Robot>) -> Scheduler<Robot> {
    let mut scheduler = Scheduler::new(config.with_lanes(lanes));
    assert!(scheduler.dispatch_ahead(PoolId::new(0)));
    let task = scheduler.add_task(dag, Timing::new(Duration::from_millis(100))).expect("it fits");
    scheduler.release(task, Instant::ZERO).expect("room");
    scheduler
}

fn dispatched(scheduler: &mut Scheduler<Robot>, now: u64) -> Vec<(char, UnitId)> {
    let mut all = Vec::new();
    while let Some(action) = scheduler.poll(at(now)) {
        match action {
            Action::Dispatch(d) => all.push(('d', d.unit)),
            Action::Ahead(d) => all.push(('a', d.unit)),
            _ => {}
        }
    }
    all
}

/// What was dispatched, as kind, node and lane.
fn told(units: &[(char, UnitId)]) -> String {
    let word =
        |(kind, unit): &(char, UnitId)| format!("{kind}{}@{}", unit.node().index(), unit.lane().index());
    units.iter().map(word).collect::<Vec<_>>().join(" ")
}

/// An encoder with three decoders, and what follows them.
fn mimonet() -> Dag<Robot> {
    let mut dag = Dag::new();
    let frame = Frame { weights: 1, frame: 1, sensor: None };
    let encoder = dag.add_node(Node::shared_encoder(Wcet::from_millis(4), frame)).expect("room");
    let last = dag.add_node(node(1)).expect("room");
    for millis in [3, 2, 1] {
        let decoder = dag.add_node(Node::decoder(Wcet::from_millis(millis))).expect("room");
        dag.add_edge(encoder, decoder).expect("no cycle");
        dag.add_edge(decoder, last).expect("no cycle");
    }
    dag
}

#[test]
fn decoders_wait_on_the_device_for_their_encoder() {
    let mut scheduler = released(Config::REDRT, 2, &mimonet());
    let first = dispatched(&mut scheduler, 0);
    // The most pressing behind the encoder, where it needs no event; the next on the idle lane, after the encoder.
    assert_eq!(told(&first), "d0@0 a2@0 a3@1");
    let [(_, encoder), (_, behind), (_, beside)] = first[..] else { panic!("three") };
    assert_eq!(scheduler.waits_for(behind).count(), 0);
    assert_eq!(scheduler.waits_for(beside).collect::<Vec<_>>(), [encoder]);
    // They read what the encoder writes, and are nobody's yet.
    let output = scheduler.unit(encoder).expect("it runs").output;
    assert!(output.is_some());
    for unit in [behind, beside] {
        let known = scheduler.unit(unit).expect("it waits");
        assert_eq!((known.output, known.first.node), (output, unit.node()));
        assert_eq!(scheduler.members(unit).count(), 1);
    }
    assert_eq!(scheduler.running_units(), 1);
    scheduler.complete(encoder, at(4 * MS)).expect("it ran");
    assert_eq!(scheduler.running_units(), 2);
    assert_eq!(scheduler.waits_for(beside).count(), 0);
    // The third is ready and finds no lane; the last waits for it, too.
    assert_eq!(told(&dispatched(&mut scheduler, 4 * MS)), "");
    scheduler.complete(beside, at(6 * MS)).expect("it ran");
    assert_eq!(told(&dispatched(&mut scheduler, 6 * MS)), "d4@1 a1@0");
}

#[test]
fn whoever_reports_a_unit_says_that_what_it_waited_for_has_ended() {
    let mut scheduler = released(Config::REDRT, 2, &mimonet());
    let [(_, encoder), (_, behind), (_, beside)] = dispatched(&mut scheduler, 0)[..] else { panic!("three") };
    scheduler.complete(beside, at(6 * MS)).expect("the encoder ended with it");
    assert_eq!(scheduler.complete(encoder, at(6 * MS)), Err(CompleteError::Stale));
    assert_eq!(scheduler.running_units(), 1, "the one behind it runs");
    assert_eq!(told(&dispatched(&mut scheduler, 6 * MS)), "d4@1 a1@0");
    scheduler.complete(behind, at(7 * MS)).expect("it ran");
    assert_eq!(scheduler.complete(behind, at(7 * MS)), Err(CompleteError::Stale));
}

#[test]
fn a_failure_of_what_it_waits_for_leaves_the_lane_busy_until_it_is_reported() {
    let mut scheduler = released(Config::REDRT, 2, &mimonet());
    let [(_, encoder), (_, behind), (_, beside)] = dispatched(&mut scheduler, 0)[..] else { panic!("three") };
    scheduler.fail(encoder, at(MS)).expect("it ran");
    assert_eq!(scheduler.jobs_in_flight(), 0);
    assert_eq!((scheduler.running_units(), scheduler.unit(behind)), (2, None));
    for unit in [behind, beside] {
        assert_eq!(scheduler.complete(unit, at(2 * MS)), Err(CompleteError::Late));
    }
    assert_eq!(scheduler.running_units(), 0);
    assert!(scheduler.retire_lane(beside.lane()));
}

#[test]
fn one_that_fails_while_it_waits_gives_its_job_up_and_its_lane_back() {
    let mut scheduler = released(Config::REDRT, 2, &mimonet());
    let [(_, encoder), (_, behind), (_, beside)] = dispatched(&mut scheduler, 0)[..] else { panic!("three") };
    assert!(!scheduler.retire_lane(beside.lane()), "something waits on it");
    scheduler.fail(beside, at(MS)).expect("it waited");
    assert_eq!((scheduler.jobs_in_flight(), scheduler.running_units()), (0, 1));
    assert!(scheduler.retire_lane(beside.lane()));
    assert_eq!(scheduler.fail(beside, at(MS)), Err(CompleteError::Stale));
    // The stream reports in its order; one report for both says as much.
    assert_eq!(scheduler.complete(behind, at(2 * MS)), Err(CompleteError::Late));
    assert_eq!(scheduler.complete(encoder, at(2 * MS)), Err(CompleteError::Stale));
    assert_eq!(scheduler.running_units(), 0);
}

#[test]
fn nothing_goes_ahead_of_what_is_more_pressing_and_ready() {
    let mut dag = Dag::<Robot>::new();
    let [long, pressing, after] =
        [(2, 2), (3, 3), (1, 1)].map(|(millis, _)| dag.add_node(node(millis)).expect("room"));
    dag.add_edge(long, after).expect("no cycle");
    let tail = dag.add_node(node(9)).expect("room");
    dag.add_edge(pressing, tail).expect("no cycle");
    let mut scheduler = released(Config::REDRT, 1, &dag);
    let first = dispatched(&mut scheduler, 0);
    // The tail is more pressing than anything that is ready, and goes behind its predecessor.
    assert_eq!(told(&first), "d1@0 a3@0");
    scheduler.complete(first[0].1, at(3 * MS)).expect("it ran");
    // What is ready comes first now, and is not ahead of anything.
    assert_eq!(told(&dispatched(&mut scheduler, 3 * MS)), "");
    scheduler.complete(first[1].1, at(12 * MS)).expect("it ran");
    assert_eq!(told(&dispatched(&mut scheduler, 12 * MS)), "d0@0 a2@0");
}

#[test]
fn memory_is_held_from_then_on_and_what_does_not_fit_is_not_promised() {
    let mut dag = Dag::<Robot>::new();
    let bytes = |mib: u64| red_core::Bytes(mib << 20);
    let first = dag.add_node(node(1).memory(bytes(3))).expect("room");
    for mib in [2, 5] {
        let next = dag.add_node(node(1).memory(bytes(mib))).expect("room");
        dag.add_edge(first, next).expect("no cycle");
    }
    let config = Config::REDRT.with_memory(bytes(6));
    let mut scheduler = released(config, 3, &dag);
    let units = dispatched(&mut scheduler, 0);
    assert_eq!(told(&units), "d0@0 a1@0");
    assert_eq!(scheduler.memory_used(PoolId::new(0)), bytes(5));
    scheduler.complete(units[0].1, at(MS)).expect("it ran");
    assert_eq!(scheduler.memory_used(PoolId::new(0)), bytes(2));
    assert_eq!(told(&dispatched(&mut scheduler, MS)), "");
    scheduler.complete(units[1].1, at(2 * MS)).expect("it ran");
    assert_eq!(told(&dispatched(&mut scheduler, 2 * MS)), "d2@0");
}

#[test]
fn a_pool_that_cannot_dispatch_ahead_says_so() {
    let preempts = Config { preempt: true, ..Config::REDRT };
    for config in [preempts, Config::RED_FG] {
        let mut scheduler = Scheduler::<Robot>::new(config);
        assert!(!scheduler.dispatch_ahead(PoolId::new(0)));
    }
    let mut scheduler = Scheduler::<Robot>::new(Config::EDF);
    assert!(!scheduler.dispatch_ahead(PoolId::new(1)) && scheduler.dispatch_ahead(PoolId::new(0)));
}

/// What nodes take of their WCET, and how late the host hears of their ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Acts {
    /// Anything from a tenth on, often by milliseconds.
    Wildly,
    /// A little less, by as much as a thread takes to wake.
    Really,
    /// All of it, at once.
    Exactly,
}

/// A host that learns late and out of order of what streams do.
struct Host<'a> {
    scheduler: Box<Scheduler<Lab>>,
    tasks: Vec<TaskId>,
    plan: Plan<Lab>,
    workload: &'a Workload,
    device: Streams,
    rng: Rng,
    /// Units that another's report has reported as well.
    told: Vec<UnitId>,
    faults: bool,
    acts: Acts,
    last: Option<Outcome>,
    on_time: u32,
    ahead: u32,
    waits: u32,
    jobs: u32,
}

impl<'a> Host<'a> {
    /// With pools that all dispatch ahead.
    fn new(workload: &'a Workload, config: Config, faults: bool, seed: u64) -> Self {
        let mut host = Self::plain(workload, config, faults, seed);
        for pool in 0..workload.pools.len() {
            assert!(host.scheduler.dispatch_ahead(PoolId::new(pool as u8)));
        }
        host
    }

    /// With pools that do not.
    fn plain(workload: &'a Workload, config: Config, faults: bool, seed: u64) -> Self {
        let mut scheduler = Box::new(Scheduler::EMPTY);
        let (plan, tasks) =
            build::admit(&mut scheduler, workload, config).expect("random workloads are valid");
        let (device, rng) = (Streams::default(), Rng::new(seed));
        Self {
            scheduler,
            tasks,
            plan,
            workload,
            device,
            rng,
            told: Vec::new(),
            faults,
            acts: Acts::Wildly,
            last: None,
            on_time: 0,
            ahead: 0,
            waits: 0,
            jobs: 0,
        }
    }

    fn run(&mut self, horizon_ns: u64) {
        let mut releases: Vec<Option<u64>> =
            self.workload.tasks.iter().map(|task| Some(task.offset_ns)).collect();
        loop {
            let release = releases.iter().flatten().copied().min();
            let poll = self.scheduler.poll_at().map(Instant::as_nanos);
            let Some(now) = [release, self.device.next_at(), poll].into_iter().flatten().min() else { break };
            self.device_to(now);
            self.hear(now);
            for (task, release) in releases.iter_mut().enumerate().filter(|(_, at)| **at == Some(now)) {
                *release = match self.workload.tasks[task].arrival {
                    Arrival::Periodic { period_ns: t } | Arrival::Sporadic { min_interarrival_ns: t } => {
                        Some(now + t).filter(|next| *next < horizon_ns)
                    }
                    Arrival::Once => None,
                };
                self.jobs += u32::from(self.scheduler.release(self.tasks[task], at(now)).is_ok());
            }
            self.poll(now);
            // What starts at once and takes no time.
            self.device_to(now);
            self.events();
        }
        assert!(self.device.is_idle());
        assert_eq!((self.scheduler.jobs_in_flight(), self.scheduler.running_units()), (0, 0));
        for pool in 0..self.workload.pools.len() {
            assert_eq!(self.scheduler.memory_used(PoolId::new(pool as u8)).0, 0);
        }
        let lanes = self.scheduler.lanes() as u8;
        assert!(
            (0..lanes).all(|lane| self.scheduler.retire_lane(red_core::LaneId::new(lane))),
            "all are idle"
        );
    }

    fn device_to(&mut self, now: u64) {
        let (plan, tasks, rng) = (&self.plan, &self.tasks, &mut self.rng);
        let may_start = |done: &std::collections::BTreeSet<_>, member: &red_core::Member| {
            let task = tasks.iter().position(|task| *task == member.task).expect("one of ours");
            let dag = &plan.dags[task];
            let before = |from: &NodeId| dag.successors(*from).contains(member.node.index());
            dag.nodes().filter(before).all(|from| done.contains(&(member.job, from)))
        };
        let acts = self.acts;
        let delay = || match acts {
            Acts::Wildly if rng.chance(50) => rng.within(1, 2 * MS),
            Acts::Really => rng.within(1, MS / 20),
            Acts::Wildly | Acts::Exactly => 0,
        };
        self.device.go_on(now, delay, may_start);
    }

    /// Results that are there need not be computed again.
    fn events(&mut self) {
        while let Some(event) = self.scheduler.take_event().copied() {
            if event.kind == EventKind::Hit
                && let Some(job) = self.scheduler.job_id(event.task, event.job)
            {
                self.device.done.insert((job, event.node));
            }
        }
    }

    fn hear(&mut self, now: u64) {
        // Failures first: whoever reports a unit as done knows that what it waited for did not fail.
        for wants_failed in [true, false] {
            for lane in 0..self.scheduler.lanes() {
                while let Some(report) =
                    self.device.reports.get(&lane).and_then(|reports| reports.front().copied())
                    && report.due <= now
                    && report.failed == wants_failed
                {
                    self.device.reports.entry(lane).or_default().pop_front();
                    self.report(report.unit, report.failed, now);
                    self.events();
                }
            }
        }
        for lane in 0..self.scheduler.lanes() {
            while let Some(report) =
                self.device.reports.get(&lane).and_then(|reports| reports.front().copied())
                && report.due <= now
            {
                self.device.reports.entry(lane).or_default().pop_front();
                self.report(report.unit, report.failed, now);
                self.events();
            }
        }
    }

    fn report(&mut self, unit: UnitId, failed: bool, now: u64) {
        let before: Vec<UnitId> = self.scheduler.waits_for(unit).collect();
        let answer =
            if failed { self.scheduler.fail(unit, at(now)) } else { self.scheduler.complete(unit, at(now)) };
        let was_told = self.told.iter().position(|told| *told == unit);
        match answer {
            Ok(()) => assert_eq!(was_told, None),
            Err(CompleteError::Late) => {}
            Err(error) => {
                assert_eq!(error, CompleteError::Stale);
                self.told.swap_remove(was_told.unwrap_or_else(|| panic!("{unit:?} was reported once only")));
            }
        }
        if answer.is_ok() && !failed {
            self.told.extend(before);
        }
    }

    fn poll(&mut self, now: u64) {
        let mut waiting = vec![0; self.scheduler.lanes()];
        while let Some(action) = self.scheduler.poll(at(now)) {
            self.events();
            let given = match action {
                Action::Dispatch(given) | Action::Ahead(given) => given,
                Action::Ended(outcome) => {
                    self.on_time += u32::from(outcome.shed.is_none() && outcome.at <= outcome.deadline);
                    self.last = Some(outcome);
                    continue;
                }
                _ => continue,
            };
            let members: Vec<_> = self.scheduler.members(given.unit).collect();
            let after: Vec<UnitId> = self.scheduler.waits_for(given.unit).collect();
            if let Action::Ahead(_) = action {
                self.ahead += 1;
                waiting[given.lane.index()] += 1;
                assert!(waiting[given.lane.index()] < 2, "a lane has one promise");
            } else {
                assert!(after.is_empty(), "what is ready waits for nothing");
            }
            self.waits += after.len() as u32;
            let wcet = self.scheduler.unit(given.unit).expect("it was given just now").wcet.as_nanos();
            let cost = match self.acts {
                Acts::Wildly => wcet * self.rng.within(10, 100) / 100,
                Acts::Really => wcet * self.rng.within(940, 960) / 1_000,
                Acts::Exactly => wcet,
            };
            let fails = self.faults && self.rng.chance(3);
            self.device.give(given.unit, after, members, cost, fails);
        }
    }
}

fn random(seeds: std::ops::Range<u64>, faults: bool, load_percent: (u64, u64)) {
    let shape = Shape { events: false, sync: false, load_percent, ..Shape::default() };
    let (mut ahead, mut waits, mut jobs) = (0, 0, 0);
    for seed in seeds {
        let workload = random_workload(seed, &shape);
        for config in [Config::REDRT, Config::EDF, Config::RED] {
            let mut host = Host::new(&workload, config, faults, seed);
            host.run(300 * MS);
            (ahead, waits, jobs) = (ahead + host.ahead, waits + host.waits, jobs + host.jobs);
        }
    }
    assert!(ahead > 1000 && waits > 100 && jobs > 1000, "{ahead} ahead, {waits} waits, {jobs} jobs");
}

#[test]
fn random_graphs_keep_precedence_on_the_device() {
    random(0..150, false, (30, 150));
}

#[test]
fn random_graphs_keep_precedence_where_units_fail() {
    random(1000..1100, true, (100, 300));
}

#[test]
fn no_job_alone_takes_longer_than_its_certificate_says() {
    let shape = Shape { events: false, sync: false, memory: false, tasks: 1, ..Shape::default() };
    let (mut ahead, mut held) = (0, 0);
    for seed in 0..400 {
        let mut workload = random_workload(seed, &shape);
        workload.tasks[0].arrival = Arrival::Once;
        // Under EDF stages are whole; under ours nothing is given up in time.
        workload.tasks[0].deadline_ns = u64::MAX / 4;
        let mut host = Host::new(&workload, Config::REDRT, false, seed);
        host.acts = Acts::Exactly;
        let certificate = host.scheduler.certificate(host.tasks[0]).expect("admitted");
        let mut without: Box<Scheduler<Lab>> = Box::new(Scheduler::EMPTY);
        let (_, tasks) = build::admit(&mut without, &workload, Config::REDRT).expect("it is valid");
        let plain = without.certificate(tasks[0]).expect("admitted");
        assert!(certificate.response >= plain.response);
        held += u32::from(certificate.response > plain.response);
        host.run(u64::MAX / 8);
        let outcome = host.last.expect("its job ended");
        let response = outcome.at.since(outcome.release);
        assert!(response <= certificate.response, "seed {seed}: {response:?}, and {certificate:?}");
        ahead += host.ahead;
    }
    assert!(ahead > 500 && held > 100, "{ahead} ahead, {held} with lanes that wait");
}

/// One graph, with more to do than two or four lanes can.
fn overloaded(lanes: u64, branches: &[u64], load_percent: u64) -> Workload {
    let work: u64 = 13 + branches.iter().sum::<u64>() + 7;
    let (period_us, deadline) = (work * 100_000 / (lanes * load_percent), 3 * work / 2);
    let mut file = format!(
        "[[pool]]\nname = 'gpu'\nlanes = {lanes}\n[[task]]\nname = 'sees'\ndeadline = '{deadline}ms'\n\
         period = '{period_us}us'\n[[task.node]]\nname = 'encode'\npool = 'gpu'\nwcet = '13ms'\n"
    );
    let names: Vec<String> = (0..branches.len()).map(|nth| format!("branch{nth}")).collect();
    for (name, wcet) in names.iter().zip(branches) {
        let _infallible = write!(
            file,
            "[[task.node]]\nname = '{name}'\npool = 'gpu'\nafter = ['encode']\nwcet = '{wcet}ms'\n"
        );
    }
    let _infallible =
        write!(file, "[[task.node]]\nname = 'fuse'\npool = 'gpu'\nafter = {names:?}\nwcet = '7ms'\n");
    parse(file.as_bytes(), Format::Toml, "overloaded.toml").unwrap_or_else(|e| panic!("{e}\n{file}"))
}

/// The lanes are the same: to hand work out sooner must not have less of it end in time.
#[test]
fn under_overload_dispatch_ahead_costs_next_to_no_job_its_deadline() {
    let (mut all_ahead, mut all_plain) = (0, 0);
    for lanes in [1, 2, 4] {
        for branches in [&[9, 11][..], &[6, 6, 6], &[3, 14], &[10]] {
            for load_percent in [110, 133, 200] {
                let workload = overloaded(lanes, branches, load_percent);
                let on_time = |mut host: Host<'_>| {
                    host.acts = Acts::Really;
                    host.run(4_000 * MS);
                    host.on_time
                };
                let plain = on_time(Host::plain(&workload, Config::REDRT, false, 1));
                let ahead = on_time(Host::new(&workload, Config::REDRT, false, 1));
                assert!(
                    100 * ahead >= 97 * plain,
                    "{lanes} lanes, {branches:?}, load {load_percent} %: {ahead} jobs on time, {plain} without"
                );
                (all_ahead, all_plain) = (all_ahead + ahead, all_plain + plain);
            }
        }
    }
    assert!(1_000 * all_ahead >= 995 * all_plain && all_plain > 9_000, "{all_ahead} of {all_plain}");
}
