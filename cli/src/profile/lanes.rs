//! Threads like the lanes of a run, one per CPU, that execute nodes again and again and take the time.
//!
//! A drill is one measurement: its lanes start together, the first runs as often as asked, and the others keep their
//! CPUs busy until it is done.

use super::machine::{Machine, PRIORITY};
use crate::session::bodies::Bodies;
use red_bodies::BodyError;
use red_bodies::onnx::on_lane;
use red_core::NodeId;
use red_rt::clock::now_ns;
use red_rt::handler::{Handler, Work};
use red_rt::setup::{Fifo, SetupError, best_effort, pin, prefault_stack};
use red_rt::stop::StopSignals;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Barrier};
use std::thread::{self, Scope};
use std::time::Duration;

/// Runs of a measurement at least, also of a slow body.
const FEWEST: usize = 3;
/// Stack in memory before the first run.
const STACK: usize = 256 * 1024;
/// A lane rests after so much work, for one part in `REST_SHARE` of it: the kernel takes 5 % of each second from
/// real-time threads that never rest, in one piece, which would be measured.
const WORK_NS: u64 = 8_000_000;
const REST_SHARE: u64 = 8;

/// A node to execute.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// Task, in the order of the file.
    pub(super) task: usize,
    /// Node.
    pub(super) node: NodeId,
    /// The encoder whose result it reads.
    pub(super) encoder: Option<NodeId>,
    /// The task's deadline, which bodies are told.
    pub(super) deadline_ns: u64,
}

/// When a measurement ends: after so many runs or so much time, whichever comes first.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    /// Runs.
    pub(super) runs: usize,
    /// Time.
    pub(super) budget_ns: u64,
}

/// A measurement did not succeed.
#[derive(Debug)]
pub(super) enum Trouble {
    /// A signal asked for the end.
    Stopped,
    /// A body failed.
    Body(Place),
    /// A lane did not get what it needs of the system.
    Setup(SetupError),
    /// A lane did not start.
    Thread(BodyError),
}

/// What a lane does in a drill.
pub(super) struct Part {
    /// The lane.
    pub(super) lane: usize,
    /// The nodes of one pass, in their order.
    pub(super) pass: Vec<Place>,
}

/// One part of a drill, on its way to a lane.
struct Order {
    pass: Vec<Place>,
    leads: bool,
    drill: Arc<Drill>,
}

/// What the lanes of a measurement share.
struct Drill {
    start: Barrier,
    over: AtomicBool,
}

/// Times of passes, without the rests between.
type Times = Vec<u64>;

/// What the measuring thread has of a lane.
struct Line {
    orders: Sender<Order>,
    answers: Receiver<Result<Times, Trouble>>,
}

/// The running lanes.
pub(super) struct Lanes<'a> {
    lanes: Vec<Line>,
    stop: &'a StopSignals,
}

impl Lanes<'_> {
    /// Starts a lane on each CPU of `machine`, does `work`, and ends them.
    ///
    /// # Errors
    /// Those of `work`, and of lanes that cannot be what they have to be.
    pub(super) fn with<R>(
        bodies: &Arc<Bodies>,
        machine: &Machine,
        stop: &StopSignals,
        bounds: Bounds,
        work: impl FnOnce(&Lanes<'_>) -> Result<R, Trouble>,
    ) -> Result<R, Trouble> {
        thread::scope(|scope| {
            let start = |(number, cpu): (usize, &usize)| {
                let handler = bodies.handler(number);
                let lane = Lane { number, cpu: *cpu, handler, bounds, stop, calls: 0, unrested_ns: 0 };
                lane.start(scope, machine.realtime())
            };
            let lanes = Lanes { lanes: machine.cpus.iter().enumerate().map(start).collect(), stop };
            for lane in 0..lanes.lanes.len() {
                lanes.answer(lane)?;
            }
            work(&lanes)
        })
    }

    /// One measurement: the times of each part's passes. The first part leads.
    ///
    /// # Errors
    /// A body failed, or a signal came.
    pub(super) fn drill(&self, parts: Vec<Part>) -> Result<Vec<Times>, Trouble> {
        let drill = Arc::new(Drill { start: Barrier::new(parts.len()), over: AtomicBool::new(false) });
        let lanes: Vec<usize> = parts.iter().map(|part| part.lane).collect();
        for (i, part) in parts.into_iter().enumerate() {
            let order = Order { pass: part.pass, leads: i == 0, drill: drill.clone() };
            self.lanes[part.lane].orders.send(order).map_err(|_| Trouble::Thread(BodyError::Thread))?;
        }
        // Every lane has ended when one's trouble is told.
        let answers: Vec<Result<Times, Trouble>> = lanes.iter().map(|lane| self.answer(*lane)).collect();
        if self.stop.requested().is_some() {
            return Err(Trouble::Stopped);
        }
        answers.into_iter().collect()
    }

    fn answer(&self, lane: usize) -> Result<Times, Trouble> {
        self.lanes[lane].answers.recv().unwrap_or(Err(Trouble::Thread(BodyError::Thread)))
    }
}

/// A lane, as its thread sees it.
struct Lane<'a> {
    number: usize,
    cpu: usize,
    handler: Box<dyn Handler>,
    bounds: Bounds,
    stop: &'a StopSignals,
    calls: u64,
    /// Work since the last rest.
    unrested_ns: u64,
}

impl<'scope> Lane<'scope> {
    /// Answers once when it is ready, and then each order.
    fn start(mut self, scope: &'scope Scope<'scope, '_>, realtime: bool) -> Line {
        let (orders, ordered) = channel::<Order>();
        let (answers, answered) = channel();
        let refused = answers.clone();
        let main = move || {
            let ready = self.prepare(realtime);
            let mut waiting = ready.is_ok();
            let _told = answers.send(ready.map(|()| Times::new()).map_err(Trouble::Setup));
            while waiting {
                let Ok(order) = ordered.recv() else { break };
                waiting = answers.send(self.serve(&order).map_err(Trouble::Body)).is_ok();
            }
        };
        let enclosed = move || {
            if let Err(e) = on_lane(main) {
                let _told = refused.send(Err(Trouble::Thread(e)));
            }
        };
        // A thread that does not start drops its channels, which is the answer.
        let _started = thread::Builder::new().spawn_scoped(scope, enclosed);
        Line { orders, answers: answered }
    }

    fn prepare(&mut self, realtime: bool) -> Result<(), SetupError> {
        self.handler.prepare();
        prefault_stack(STACK)?;
        if realtime {
            return Fifo { priority: PRIORITY, cpu: self.cpu }.apply();
        }
        pin(self.cpu)?;
        best_effort()
    }

    /// Runs passes until the drill is over, and ends it when it leads or fails.
    fn serve(&mut self, order: &Order) -> Result<Times, Place> {
        let fed = order.pass.iter().try_for_each(|place| self.feed(place));
        let mut times = Times::with_capacity(self.bounds.runs);
        order.drill.start.wait();
        let result = fed.and_then(|()| self.passes(order, &mut times));
        order.drill.over.store(true, Ordering::Relaxed);
        result.map(|()| times)
    }

    fn passes(&mut self, order: &Order, times: &mut Times) -> Result<(), Place> {
        let start_ns = now_ns();
        loop {
            let mut pass_ns = 0;
            for place in &order.pass {
                let took = self.execute(place, place.node)?;
                pass_ns += took;
                self.rest(took);
            }
            if times.len() < self.bounds.runs {
                times.push(pass_ns);
            }
            let spent = now_ns() - start_ns >= self.bounds.budget_ns;
            let enough = times.len() >= self.bounds.runs || (spent && times.len() >= FEWEST);
            let over = order.drill.over.load(Ordering::Relaxed) || self.stop.requested().is_some();
            if over || (order.leads && enough) {
                return Ok(());
            }
        }
    }

    /// Has a decoder's encoder write what the decoder reads.
    fn feed(&mut self, place: &Place) -> Result<(), Place> {
        place.encoder.map_or(Ok(()), |encoder| self.execute(place, encoder).map(drop))
    }

    /// Time of one execution, in nanoseconds. Every frame serves two calls: the first draws it, as the first node of
    /// a job on a lane does in a run, and the second finds it, as the others do.
    fn execute(&mut self, place: &Place, node: NodeId) -> Result<u64, Place> {
        let start_ns = now_ns();
        let work = Work {
            task: place.task,
            node,
            job: self.calls / 2,
            release_ns: start_ns,
            deadline_ns: start_ns.saturating_add(place.deadline_ns),
            since_ns: start_ns,
            output: u16::try_from(self.number).ok(),
            ..Work::default()
        };
        self.calls += 1;
        let result = catch_unwind(AssertUnwindSafe(|| self.handler.run(&work)));
        let took = now_ns() - start_ns;
        if matches!(result, Ok(Ok(()))) { Ok(took) } else { Err(*place) }
    }

    fn rest(&mut self, worked_ns: u64) {
        self.unrested_ns += worked_ns;
        if self.unrested_ns >= WORK_NS {
            thread::sleep(Duration::from_nanos(self.unrested_ns / REST_SHARE));
            self.unrested_ns = 0;
        }
    }
}
