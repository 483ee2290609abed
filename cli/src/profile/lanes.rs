//! Threads like the lanes of a run, one per CPU and one per stream, that execute nodes again and again and take the time.
//!
//! A drill is one measurement: its lanes start together, the first runs as often as asked, and the others keep their
//! CPUs busy until it is done. A watchdog ends it when a body does not return.

use super::machine::{Machine, PRIORITY};
use super::runner::Runner;
use red_bodies::BodyError;
use red_bodies::onnx::on_lane;
use red_core::{NodeId, TaskId};
use red_cuda::CudaError;
use red_rt::clock::now_ns;
use red_rt::handler::Work;
use red_rt::setup::{Fifo, SetupError, best_effort, pin, prefault_stack};
use red_rt::stop::StopSignals;
use red_rt::watchdog::{Bound, Slot, Watchdog};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Barrier, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// Runs of a measurement at least, also of a slow body.
const FEWEST: usize = 3;
/// Executions of a node before those that count; even, for a frame serves two calls.
const WARM_UP: usize = 2;
/// Stack in memory before the first run.
const STACK: usize = 256 * 1024;
/// A lane rests after so much work, for one part in `REST_SHARE` of it: the kernel takes 5 % of each second from
/// real-time threads that never rest, in one piece, which would be measured.
const WORK_NS: u64 = 8_000_000;
const REST_SHARE: u64 = 8;
/// Between two looks for a signal.
const LOOK: Duration = Duration::from_millis(100);

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
    /// Time for one run: a body that takes longer counts as hung.
    pub(super) timeout_ns: u64,
}

/// A measurement did not succeed.
#[derive(Debug)]
pub(super) enum Trouble {
    /// A signal asked for the end.
    Stopped,
    /// A body failed, and what the driver said of it.
    Body(Place, Option<CudaError>),
    /// A body did not return in time. Its thread goes on, and ends with the process.
    Hung(Place),
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

/// What did not run to its end, and what the driver said.
type Fault = (Place, Option<CudaError>);

/// Times of passes, without the rests between.
type Times = Vec<u64>;

/// What a lane tells: its number, and the times of its part.
type Answer = (usize, Result<Times, Trouble>);

/// The running lanes.
pub(super) struct Lanes<'a> {
    orders: Vec<Sender<Order>>,
    answers: Receiver<Answer>,
    stop: &'a StopSignals,
}

impl Lanes<'_> {
    /// Starts a lane for each runner, does `work`, and ends them: the first on the CPUs of `machine`, one each, and the others
    /// on whatever CPU is free, as they only wait. Lanes that may wait for a hung body are left behind.
    ///
    /// # Errors
    /// Those of `work`, and of lanes that cannot be what they have to be.
    pub(super) fn with<R>(
        runners: Vec<Runner>,
        machine: &Machine,
        stop: &StopSignals,
        bounds: Bounds,
        work: impl FnOnce(&Lanes<'_>) -> Result<R, Trouble>,
    ) -> Result<R, Trouble> {
        let count = runners.len();
        let slots: Arc<[Slot]> = (0..count).map(|_| Slot::new()).collect();
        let runs: Arc<[Mutex<Option<Place>>]> = (0..count).map(|_| Mutex::new(None)).collect();
        let (answer, answers) = channel();
        let (hung, watched) = (answer.clone(), runs.clone());
        let above = machine.realtime().then(|| Fifo { priority: PRIORITY + 1, cpu: machine.cpus[0] });
        let watchdog = Watchdog::start(slots.clone(), above, move |lane: usize, _expiry| {
            if let Some(place) = *watched[lane].lock().unwrap_or_else(PoisonError::into_inner) {
                let _told = hung.send((lane, Err(Trouble::Hung(place))));
            }
        });
        let _watchdog = watchdog.map_err(Trouble::Setup)?;
        let mut lanes = Lanes { orders: Vec::new(), answers, stop };
        let mut threads = Vec::new();
        for (number, runner) in runners.into_iter().enumerate() {
            let (orders, ordered) = channel();
            let cpu = machine.cpus.get(number).copied();
            let lane = Lane {
                number,
                cpu,
                output: number.checked_sub(machine.cpus.len()).unwrap_or(number),
                runner,
                bounds,
                slots: slots.clone(),
                runs: runs.clone(),
                calls: 0,
                unrested_ns: 0,
            };
            lanes.orders.push(orders);
            threads.push(lane.start(machine.realtime(), ordered, answer.clone())?);
        }
        let ready = lanes.answers(count, || {});
        let ready = ready.and_then(|all| all.into_iter().try_for_each(|(_, answer)| answer.map(drop)));
        let result = ready.and_then(|()| work(&lanes));
        drop(lanes);
        if !matches!(result, Err(Trouble::Hung(_))) {
            // A panic of a lane was printed and is an answer that never came.
            threads.into_iter().for_each(|thread| drop(thread.join()));
        }
        result
    }

    /// One measurement: the times of each part's passes. The first part leads.
    ///
    /// # Errors
    /// A body failed or hung, or a signal came.
    pub(super) fn drill(&self, parts: Vec<Part>) -> Result<Vec<Times>, Trouble> {
        let drill = Arc::new(Drill { start: Barrier::new(parts.len()), over: AtomicBool::new(false) });
        let lanes: Vec<usize> = parts.iter().map(|part| part.lane).collect();
        for (i, part) in parts.into_iter().enumerate() {
            let order = Order { pass: part.pass, leads: i == 0, drill: drill.clone() };
            self.orders[part.lane].send(order).map_err(|_| Trouble::Thread(BodyError::Thread))?;
        }
        let mut answers = self.answers(lanes.len(), || drill.over.store(true, Ordering::Relaxed))?;
        answers.sort_by_key(|(lane, _)| lanes.iter().position(|of| of == lane));
        if self.stop.requested().is_some() {
            return Err(Trouble::Stopped);
        }
        answers.into_iter().map(|(_, answer)| answer).collect()
    }

    /// What so many lanes tell, each once; `stop` is called when a signal asks for the end.
    ///
    /// # Errors
    /// A body hung, and others may wait for it; or a lane is gone.
    fn answers(&self, count: usize, stop: impl Fn()) -> Result<Vec<Answer>, Trouble> {
        let mut answers = Vec::new();
        while answers.len() < count {
            match self.answers.recv_timeout(LOOK) {
                Ok((_, Err(trouble @ (Trouble::Hung(_) | Trouble::Thread(_))))) => return Err(trouble),
                Ok(answer) => answers.push(answer),
                Err(RecvTimeoutError::Timeout) if self.stop.requested().is_some() => stop(),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Err(Trouble::Thread(BodyError::Thread)),
            }
        }
        Ok(answers)
    }
}

/// A lane, as its thread sees it.
struct Lane {
    number: usize,
    /// `None`: any.
    cpu: Option<usize>,
    /// The number of its results, which it shares with no other lane of its kind.
    output: usize,
    runner: Runner,
    bounds: Bounds,
    /// For the watchdog, by lane: until when, and what runs.
    slots: Arc<[Slot]>,
    runs: Arc<[Mutex<Option<Place>>]>,
    calls: u64,
    /// Work since the last rest.
    unrested_ns: u64,
}

impl Lane {
    /// Answers once when it is ready, and then each order.
    fn start(
        mut self,
        realtime: bool,
        ordered: Receiver<Order>,
        answers: Sender<Answer>,
    ) -> Result<JoinHandle<()>, Trouble> {
        let number = self.number;
        let refused = answers.clone();
        let main = move || {
            let ready = self.prepare(realtime);
            let mut waiting = ready.is_ok();
            let _told = answers.send((number, ready.map(|()| Times::new()).map_err(Trouble::Setup)));
            while waiting {
                let Ok(order) = ordered.recv() else { break };
                waiting = answers
                    .send((number, self.serve(&order).map_err(|(place, why)| Trouble::Body(place, why))))
                    .is_ok();
            }
        };
        let enclosed = move || {
            if let Err(e) = on_lane(main) {
                let _told = refused.send((number, Err(Trouble::Thread(e))));
            }
        };
        thread::Builder::new().spawn(enclosed).map_err(|_| Trouble::Thread(BodyError::Thread))
    }

    fn prepare(&mut self, realtime: bool) -> Result<(), SetupError> {
        self.runner.prepare();
        prefault_stack(STACK)?;
        self.slots[self.number].adopt();
        match self.cpu {
            Some(cpu) if realtime => Fifo { priority: PRIORITY, cpu }.apply(),
            Some(cpu) => pin(cpu).and_then(|()| best_effort()),
            None => best_effort(),
        }
    }

    /// Runs passes until the drill is over, and ends it when it leads or fails.
    fn serve(&mut self, order: &Order) -> Result<Times, Fault> {
        let fed = order.pass.iter().try_for_each(|place| self.feed(place).and_then(|()| self.warm_up(place)));
        let mut times = Times::with_capacity(self.bounds.runs);
        order.drill.start.wait();
        let result = fed.and_then(|()| self.passes(order, &mut times));
        order.drill.over.store(true, Ordering::Relaxed);
        result.map(|()| times)
    }

    fn passes(&mut self, order: &Order, times: &mut Times) -> Result<(), Fault> {
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
            let over = order.drill.over.load(Ordering::Relaxed);
            if over || (order.leads && enough) {
                return Ok(());
            }
        }
    }

    /// Has a decoder's encoder write what the decoder reads.
    fn feed(&mut self, place: &Place) -> Result<(), Fault> {
        place.encoder.map_or(Ok(()), |encoder| self.execute(place, encoder).map(drop))
    }

    /// Executions that are no samples: the first of a body may load and allocate what all later ones find.
    fn warm_up(&mut self, place: &Place) -> Result<(), Fault> {
        (0..WARM_UP).try_for_each(|_| self.execute(place, place.node).map(drop))
    }

    /// Time of one execution, in nanoseconds. Every frame serves two calls: the first draws it, as the first node of
    /// a job on a lane does in a run, and the second finds it, as the others do.
    fn execute(&mut self, place: &Place, node: NodeId) -> Result<u64, Fault> {
        *self.runs[self.number].lock().unwrap_or_else(PoisonError::into_inner) =
            Some(Place { node, ..*place });
        let slot = &self.slots[self.number];
        let armed = slot.arm(now_ns().saturating_add(self.bounds.timeout_ns));
        let start_ns = now_ns();
        let work = Work {
            task: TaskId::from_bits(place.task as u32),
            node,
            job: self.calls / 2,
            release_ns: start_ns,
            deadline_ns: start_ns.saturating_add(place.deadline_ns),
            since_ns: start_ns,
            output: u16::try_from(self.output).ok(),
            ..Work::default()
        };
        self.calls += 1;
        let result = catch_unwind(AssertUnwindSafe(|| self.runner.run(&work)));
        if slot.disarm(armed) == Bound::Passed {
            // Late, and the watchdog has told so.
            return Err((*place, None));
        }
        match result {
            Ok(Ok(took)) => Ok(took),
            Ok(Err(why)) => Err((*place, why)),
            Err(_) => Err((*place, None)),
        }
    }

    fn rest(&mut self, worked_ns: u64) {
        // A stream's lane has rested meanwhile.
        self.unrested_ns += if self.runner.is_host() { worked_ns } else { 0 };
        if self.unrested_ns >= WORK_NS {
            thread::sleep(Duration::from_nanos(self.unrested_ns / REST_SHARE));
            self.unrested_ns = 0;
        }
    }
}
