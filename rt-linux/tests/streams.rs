//! Lanes that give their units to streams, here of a device that only takes time.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration as Time;

use red_core::{
    Caps, Config, Dag, Duration, Event, Frame, Instant, JobId, Node, NodeId, Outcome, PoolId, ReleaseError,
    Scheduler, ShedReason, Timing, UnitId, Wcet,
};
use red_rt::clock::now_ns;
use red_rt::handler::{Failed, Handler, Work};
use red_rt::report::{RunReport, Surrender};
use red_rt::runtime::{Mode, Setup, run};
use red_rt::stop::StopBy;
use red_rt::stream::{Progress, Stream, Submitted};
use red_rt::stream_seat::StreamSeat;
use red_rt::timeline::{Host, Releases};

type Robot = Caps<2, 16, 16, 4, 2, 1, 64>;

const MS: u64 = 1_000_000;

/// A run has signal handlers, which are the process's.
static ONE_RUN: Mutex<()> = Mutex::new(());

/// What a unit was to the device.
#[derive(Clone, Copy, Debug)]
struct Ran {
    lane: usize,
    job: u64,
    node: usize,
    begin: u64,
    end: u64,
}

/// All streams: every unit that was given, and when it begins and ends, which is known by then.
#[derive(Default)]
struct Device {
    ran: HashMap<UnitId, Ran>,
    waits: usize,
}

type Shared = Arc<Mutex<Device>>;

fn of(device: &Shared) -> std::sync::MutexGuard<'_, Device> {
    device.lock().unwrap_or_else(PoisonError::into_inner)
}

/// How long a node takes; `None` for ever.
type Takes = fn(&Work) -> Option<u64>;

struct OnDevice {
    lane: usize,
    device: Shared,
    takes: Takes,
    /// Given and not told as done, the oldest first.
    given: Vec<UnitId>,
    free_at: u64,
    quarantined: bool,
}

impl Handler for OnDevice {
    fn run(&mut self, _: &Work) -> Result<(), Failed> {
        panic!("what has a stream runs nothing itself");
    }

    fn stream(&mut self) -> Option<&mut dyn Stream> {
        Some(self)
    }
}

impl Stream for OnDevice {
    fn submit(&mut self, work: &Work, after: &[UnitId]) -> Submitted {
        assert!(!self.quarantined, "nothing is given to a stream that hangs");
        let mut device = of(&self.device);
        let mut begin = now_ns().max(self.free_at);
        for unit in after {
            assert_ne!(unit.lane().index(), self.lane, "its own stream keeps the order");
            let Some(ran) = device.ran.get(unit) else { return Submitted::NotYet };
            begin = begin.max(ran.end);
        }
        device.waits += after.len();
        let end = (self.takes)(work).map_or(u64::MAX, |takes| begin.saturating_add(takes));
        let ran = Ran { lane: self.lane, job: work.job, node: work.node.index(), begin, end };
        assert!(device.ran.insert(work.unit, ran).is_none(), "given twice");
        self.given.push(work.unit);
        self.free_at = end;
        if work.node.index() == 9 { Submitted::Failed } else { Submitted::Given }
    }

    fn look(&mut self) -> Progress {
        let oldest = of(&self.device).ran[&self.given[0]];
        let now = now_ns();
        if now >= oldest.end {
            self.given.remove(0);
            return Progress::Done(Ok(()));
        }
        if now < oldest.begin { Progress::Waits } else { Progress::Runs }
    }

    fn call(&mut self, seat: &Arc<StreamSeat>) -> Result<(), Failed> {
        let (end, seat) = (of(&self.device).ran[&self.given[0]].end, seat.clone());
        if end < u64::MAX {
            thread::spawn(move || {
                thread::sleep(Time::from_nanos(end.saturating_sub(now_ns())));
                seat.bell.ring();
            });
        }
        Ok(())
    }

    fn quarantine(&mut self) {
        self.quarantined = true;
    }
}

/// A body of the host's, for a pool of the CPU.
struct OnHost;

impl Handler for OnHost {
    fn run(&mut self, _: &Work) -> Result<(), Failed> {
        Ok(())
    }
}

#[derive(Default)]
struct Ends {
    on_time: usize,
    faults: usize,
}

impl Host<Robot> for Ends {
    fn released(&mut self, _task: usize, _release: Instant, taken: Result<JobId, ReleaseError>) {
        taken.expect("jobs end before the next ones come");
    }

    fn ended(&mut self, outcome: &Outcome) {
        self.on_time += usize::from(outcome.on_time());
        self.faults += usize::from(outcome.shed == Some(ShedReason::Fault));
    }

    fn event(&mut self, _event: &Event) {}
}

/// Two streams and a lane of the host. Every 20 ms: a camera on the host, an encoder with three decoders on the device,
/// a node after these, and control on the host.
fn mimonet() -> Dag<Robot> {
    let mut dag = Dag::new();
    let host = PoolId::new(1);
    let mut add = |node| dag.add_node(node).expect("room");
    let camera = add(Node::new(Wcet::from_millis(1)).in_pool(host));
    let encoder =
        add(Node::shared_encoder(Wcet::from_millis(4), Frame { weights: 1, frame: 1, sensor: None }));
    let decoders = [4, 3, 2].map(|millis| add(Node::decoder(Wcet::from_millis(millis))));
    let fusion = add(Node::new(Wcet::from_millis(1)));
    let control = add(Node::new(Wcet::from_millis(1)).in_pool(host));
    let mut edge = |from, to| dag.add_edge(from, to).expect("no cycle");
    edge(camera, encoder);
    for decoder in decoders {
        edge(encoder, decoder);
        edge(decoder, fusion);
    }
    edge(fusion, control);
    dag
}

fn go(takes: Takes, ahead: bool, duration_ms: u64, dag: &Dag<Robot>) -> (Ends, RunReport, Device) {
    let _alone = ONE_RUN.lock().unwrap_or_else(PoisonError::into_inner);
    let mut scheduler = Box::new(Scheduler::<Robot>::new(Config::REDRT.with_lanes(2)));
    let _host = scheduler.add_pool(1, None).expect("room");
    assert_eq!(scheduler.dispatch_ahead(PoolId::new(0)) && ahead, ahead);
    if !ahead {
        scheduler = Box::new(Scheduler::<Robot>::new(Config::REDRT.with_lanes(2)));
        let _host = scheduler.add_pool(1, None).expect("room");
    }
    let task = scheduler.add_task(dag, Timing::new(Duration::from_secs(10))).expect("it fits");
    let device = Shared::default();
    let of_lanes = device.clone();
    let setup = Setup {
        scheduler,
        lanes: 3,
        streams: 0b011,
        mode: Mode::BestEffort,
        releases: vec![Releases { task, first_ns: 0, period_ns: Some(20 * MS) }],
        duration_ns: duration_ms * MS,
        drain_ns: 1_000 * MS,
        stop: StopBy::Signals,
        tape: None,
        handlers: Arc::new(move |lane| match lane {
            2 => Box::new(OnHost),
            lane => {
                let (given, device) = (Vec::with_capacity(4), of_lanes.clone());
                Box::new(OnDevice { lane, device, takes, given, free_at: 0, quarantined: false })
            }
        }),
        enclose: Arc::new(|main| main()),
    };
    let (ends, report) = run(setup, Ends::default(), drop, |_| {}).expect("needs no rights");
    let device = std::mem::take(&mut *of(&device));
    (ends, report, device)
}

fn precedence_holds(dag: &Dag<Robot>, device: &Device) {
    let by_place: HashMap<(u64, usize), Ran> =
        device.ran.values().map(|ran| ((ran.job, ran.node), *ran)).collect();
    for ran in device.ran.values() {
        for after in dag.successors(NodeId::new(ran.node as u8)).iter() {
            if let Some(later) = by_place.get(&(ran.job, after)) {
                assert!(later.begin >= ran.end, "{later:?} begins before the end of {ran:?}");
            }
        }
    }
    for lane in 0..2 {
        let mut of_lane: Vec<Ran> = device.ran.values().filter(|ran| ran.lane == lane).copied().collect();
        of_lane.sort_by_key(|ran| ran.begin);
        assert!(of_lane.windows(2).all(|pair| pair[0].end <= pair[1].begin));
    }
}

fn usual(work: &Work) -> Option<u64> {
    Some(work.wcet_ns / 4)
}

#[test]
fn units_wait_on_the_device_for_what_runs_there() {
    let dag = mimonet();
    let (ends, report, device) = go(usual, true, 600, &dag);
    assert_eq!((ends.on_time, ends.faults, report.failed), (30, 0, 0));
    precedence_holds(&dag, &device);
    assert_eq!(device.ran.len(), 30 * 5);
    // A decoder behind the encoder and one on the other stream, of each job; and what comes after them, where no
    // decoder was left when they ran.
    assert!(report.ahead >= 60 && device.waits >= 25, "{} ahead, {} waits", report.ahead, device.waits);
    assert_eq!((report.lanes_lost, report.allocations), (0, 0));
    // The lanes were busy with what ran, and not with what waited.
    let ran: u64 = device.ran.values().map(|ran| ran.end - ran.begin).sum();
    let busy = report.busy_ns[0] + report.busy_ns[1];
    assert!(busy >= ran / 2, "{busy} of {ran}");
}

#[test]
fn without_it_every_unit_waits_for_the_host() {
    let dag = mimonet();
    let (ends, report, device) = go(usual, false, 200, &dag);
    assert_eq!((ends.on_time, report.ahead, device.waits), (10, 0, 0));
    precedence_holds(&dag, &device);
}

fn hangs_once(work: &Work) -> Option<u64> {
    // The widest decoder of the third job.
    if work.job == 2 && work.node.index() == 2 { None } else { usual(work) }
}

#[test]
fn a_stream_that_hangs_is_left_and_the_others_go_on() {
    let dag = mimonet();
    let (ends, report, device) = go(hangs_once, true, 600, &dag);
    assert_eq!(ends.faults, 1);
    assert_eq!(ends.on_time, 29);
    assert_eq!((report.lanes_lost, report.hung, report.gave_up), (1, 1, None));
    precedence_holds(&dag, &device);
}

fn always_hangs(work: &Work) -> Option<u64> {
    if work.node.index() == 1 { None } else { usual(work) }
}

#[test]
fn a_run_whose_streams_all_hang_keeps_its_other_lanes() {
    let dag = mimonet();
    let (ends, report, _) = go(always_hangs, true, 300, &dag);
    assert_eq!((ends.on_time, report.lanes_lost), (0, 2));
    assert_ne!(report.gave_up, Some(Surrender::NoLane), "the lane of the host is left");
    // The other stream waits for the one that hangs, or hangs itself.
    assert!(ends.faults >= 1);
}

#[test]
fn a_unit_that_the_stream_does_not_take_fails_its_job() {
    let mut dag = Dag::new();
    let mut last = dag.add_node(Node::new(Wcet::from_millis(1))).expect("room");
    for _ in 1..10 {
        let next = dag.add_node(Node::new(Wcet::from_millis(1))).expect("room");
        dag.add_edge(last, next).expect("no cycle");
        last = next;
    }
    let (ends, report, device) = go(|_| Some(1000), true, 100, &dag);
    assert_eq!((ends.on_time, ends.faults), (0, 5));
    assert!(report.failed >= 5);
    precedence_holds(&dag, &device);
}
