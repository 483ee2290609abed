//! A runtime: being set up, running, ended.
//!
//! Releases, errands and stops go to the running lanes without a lock of ours, so that a body may make them; the mutex is
//! for threads that set up, start, wait and close.

use super::bodies::{Bodies, Calls, is_in_body};
use super::called;
use super::lanes::Lanes;
use super::notes::{Notes, Teller};
use super::on_device::OnDevice;
use super::open::OF_A_RUNTIME;
use super::prepared::SetUp;
use super::report::red_report;
use super::text;
use super::values::{red_mode, red_runtime_config};
use crate::room::room;
use crate::status::red_status;
use core::time::Duration;
use red_core::{Instant, Scheduler};
use red_record::class::Large;
use red_record::{Recorder, Writer};
use red_rt::control::{AskError, Control, Errand};
use red_rt::cuda::{Cuda, Handlers};
use red_rt::held_cpus::{Choosing, choose_free_cpus};
use red_rt::report::RunReport;
use red_rt::runtime::{Mode, Setup, run};
use red_rt::setup::{SetupError, has_room_for_threads};
use red_rt::stop::StopBy;
use red_rt::utilisation::Observer;
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread;

/// Until somebody stops it.
const FOR_EVER_NS: u64 = 1 << 62;
/// Between two looks of who closes.
const MOMENT: Duration = Duration::from_millis(2);

/// The scheduler is moved to where lanes share it, and by an unoptimised build over the stack.
const STACK: usize = if cfg!(debug_assertions) { 32 << 20 } else { 8 << 20 };
/// A thread of a lane or of the watchdog: its stack, and what it measures.
const OF_A_THREAD: usize = 3 << 20;

pub(crate) enum State {
    SetUp(Box<SetUp>),
    Running,
    Ended(Box<red_report>),
    Failed(red_status),
}

impl State {
    /// What is being set up.
    fn set_up(&mut self) -> Result<&mut SetUp, red_status> {
        match self {
            Self::SetUp(set_up) => Ok(set_up),
            Self::Running | Self::Ended(_) => Err(red_status::Started),
            Self::Failed(status) => Err(*status),
        }
    }
}

/// What a thread of the run leaves.
struct Shared {
    /// There before any of them calls a body, which may release and stop.
    lanes: Lanes<Large>,
    state: Mutex<State>,
    ended: Condvar,
    /// Why what was asked for last did not come to be, and what to do.
    said: Mutex<String>,
}

impl Shared {
    fn said(&self) -> MutexGuard<'_, String> {
        self.said.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The number of what is missing, whose words are kept.
    fn failed(&self, error: &SetupError) -> State {
        *self.said() = text::for_this_program(&error.to_string());
        State::Failed(match error {
            SetupError::NotPermitted { .. } => red_status::NotPermitted,
            SetupError::MoreLanesThanCpus { .. } | SetupError::NotACpuEach { .. } => red_status::Cpus,
            SetupError::CpuNotUsable { .. } | SetupError::CpusHeld { .. } => red_status::Cpus,
            SetupError::Preempts => red_status::Preempts,
            _ => red_status::System,
        })
    }
}

/// A runtime.
pub(crate) struct Engine {
    pub(crate) config: red_runtime_config,
    pub(crate) notes: Arc<Notes>,
    pub(crate) bodies: Arc<Bodies>,
    shared: Arc<Shared>,
}

impl Engine {
    /// Opens a runtime; its handle.
    pub(crate) fn open(
        config: red_runtime_config,
        scheduler: Box<Scheduler<Large>>,
    ) -> Result<u64, red_status> {
        let set_up = SetUp {
            scheduler,
            tape: None,
            writer: None,
            is_begun: false,
            releases: Vec::new(),
            cpus: Vec::new(),
            device: None,
        };
        called::open(Self {
            config,
            notes: Notes::new(),
            bodies: Bodies::new(),
            shared: Arc::new(Shared {
                lanes: Lanes::new(),
                state: Mutex::new(State::SetUp(Box::new(set_up))),
                ended: Condvar::new(),
                said: Mutex::default(),
            }),
        })
    }

    /// Stops the runtime, waits for its end and for calls that go on, and frees it.
    pub(crate) fn close(bits: u64) -> Result<(), red_status> {
        let called = called::engine(bits)?;
        if is_in_body() {
            return Err(red_status::Busy);
        }
        called.shut()?;
        loop {
            // Before the end is looked at: who was inside may have started it, and nobody else can.
            let is_alone = called.is_alone();
            let _idle = called.stop();
            if called.wait(Some(MOMENT)) != Err(red_status::Timeout) && is_alone {
                break;
            }
            if !is_alone {
                thread::sleep(MOMENT);
            }
        }
        *called.state() = State::Failed(red_status::Closed);
        called.free()
    }

    pub(crate) fn state(&self) -> MutexGuard<'_, State> {
        self.shared.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Why what was asked for last did not come to be, and what to do; empty where nothing was refused.
    pub(crate) fn said(&self) -> MutexGuard<'_, String> {
        self.shared.said()
    }

    /// Makes a call on what is being set up.
    pub(crate) fn set_up<R>(
        &self,
        call: impl FnOnce(&mut SetUp) -> Result<R, red_status>,
    ) -> Result<R, red_status> {
        call(self.state().set_up()?)
    }

    /// The same, without waiting for the state where lanes run: a body may ask.
    fn set_up_unless_running<R>(
        &self,
        call: impl FnOnce(&mut SetUp) -> Result<R, red_status>,
    ) -> Result<R, red_status> {
        if self.shared.lanes.get().is_some() { Err(red_status::Started) } else { self.set_up(call) }
    }

    /// The running lanes.
    pub(crate) fn control(&self) -> Result<&dyn Control<Large>, red_status> {
        self.shared.lanes.get().ok_or(red_status::Idle)
    }

    /// Has something done by the next lane, under the scheduler's lock.
    pub(crate) fn ask<R: Send + Sync + 'static>(
        &self,
        mut what: impl FnMut(&mut Recorder<'_, Large>, Instant) -> R + Send + 'static,
    ) -> Result<R, red_status> {
        let control = self.control()?;
        if is_in_body() {
            return Err(red_status::Busy);
        }
        let found = Arc::new(OnceLock::new());
        let to = found.clone();
        let errand: Errand<Large> = Box::new(move |scheduler, now| {
            let _once = to.set(what(scheduler, now));
        });
        drop(control.ask(errand).map_err(|error| match error {
            AskError::OnLane => red_status::Busy,
            AskError::Over => red_status::Over,
            _ => red_status::Internal,
        })?);
        Arc::into_inner(found).and_then(OnceLock::into_inner).ok_or(red_status::Internal)
    }

    /// Changes what is being set up; or a lane does it if the runtime runs already.
    pub(crate) fn change<R: Send + Sync + 'static>(
        &self,
        mut what: impl FnMut(&mut Recorder<'_, Large>, Instant) -> Result<R, red_status> + Send + 'static,
    ) -> Result<R, red_status> {
        // Also where it is started meanwhile.
        match self.set_up_unless_running(|set_up| set_up.call(|scheduler| what(scheduler, Instant::ZERO))) {
            Err(red_status::Started) => self.ask(what)?,
            done => done,
        }
    }

    /// Looks at what is being set up; or a lane does it if the runtime runs already.
    pub(crate) fn look<R: Send + Sync + 'static>(
        &self,
        mut what: impl FnMut(&Scheduler<Large>) -> R + Send + 'static,
    ) -> Result<R, red_status> {
        match self.set_up_unless_running(|set_up| Ok(what(&set_up.scheduler))) {
            Err(red_status::Started) => self.ask(move |scheduler, _now| what(scheduler)),
            done => done,
        }
    }

    /// Starts the lanes; returns when they run.
    pub(crate) fn start(&self) -> Result<(), red_status> {
        if is_in_body() {
            return Err(red_status::Busy);
        }
        let mut state = self.state();
        // Each lane, the watchdog and a spare.
        let threads = state.set_up()?.scheduler.lanes() + 2;
        room(OF_A_RUNTIME)?;
        if !has_room_for_threads(STACK + threads * OF_A_THREAD) {
            return Err(red_status::NoMemory);
        }
        self.said().clear();
        self.shared.lanes.begin();
        *state = self.start_lanes(&mut state).unwrap_or_else(|error| self.shared.failed(&error));
        if let State::Failed(status) = *state {
            self.shared.lanes.fail();
            return Err(status);
        }
        Ok(())
    }

    /// Where it is then.
    fn start_lanes(&self, state: &mut State) -> Result<State, SetupError> {
        // Until lanes run: of two that start at once each is given what the other one left.
        let _choosing = (self.config.mode == red_mode::RealTime as u32).then(Choosing::begin);
        let State::SetUp(set_up) = core::mem::replace(state, State::Failed(red_status::Internal)) else {
            return Ok(State::Failed(red_status::Internal));
        };
        let mode = self.mode(&set_up)?;
        let streams = set_up.device.as_ref().map(|device| device.streams(&self.bodies)).transpose();
        let (cuda, handlers) = match streams {
            Ok(streams) => streams.unzip(),
            Err(why) => {
                *self.said() = why.to_string();
                return Ok(State::Failed(red_status::Cuda));
            }
        };
        let (tell, told) = channel();
        let device = set_up.device.clone();
        let (setup, writer) = self.setup(*set_up, mode, handlers);
        let (notes, shared) = (self.notes.clone(), self.shared.clone());
        let run = move || run_to_the_end(setup, writer, cuda.zip(device), notes, &shared, &tell);
        let thread = thread::Builder::new().name("red-run".to_owned()).stack_size(STACK).spawn(run);
        let thread = thread.map_err(|error| SetupError::no_thread("pthread_create(run)", &error))?;
        match told.recv() {
            Ok(Ok(())) => Ok(State::Running),
            Ok(Err(error)) => {
                let _ended = thread.join();
                Err(error)
            }
            Err(_) => Ok(State::Failed(red_status::Internal)),
        }
    }

    fn mode(&self, set_up: &SetUp) -> Result<Mode, SetupError> {
        if self.config.mode == red_mode::BestEffort as u32 {
            return Ok(Mode::BestEffort);
        }
        let cpus = if set_up.cpus.is_empty() {
            choose_free_cpus(set_up.scheduler.lanes())?
        } else {
            set_up.cpus.clone()
        };
        Ok(Mode::RealTime { priority: self.config.priority as u8, cpus })
    }

    fn setup(
        &self,
        set_up: SetUp,
        mode: Mode,
        on_device: Option<Handlers>,
    ) -> (Setup<Large>, Option<Writer>) {
        let bodies = self.bodies.clone();
        let duration_ns = if self.config.duration_ns == 0 { FOR_EVER_NS } else { self.config.duration_ns };
        let setup = Setup {
            lanes: set_up.scheduler.lanes(),
            streams: set_up.device.map_or(0, |device| device.lanes),
            scheduler: set_up.scheduler,
            mode,
            releases: set_up.releases,
            duration_ns: duration_ns.min(FOR_EVER_NS),
            drain_ns: self.config.drain_ns,
            stop: StopBy::Caller,
            tape: set_up.tape,
            handlers: Arc::new(move |lane| {
                let on_device = on_device.as_ref().and_then(|handlers| handlers.take(lane));
                on_device.unwrap_or_else(|| Box::new(Calls::new(bodies.clone())))
            }),
            enclose: Arc::new(|main| main()),
        };
        (setup, set_up.writer)
    }

    /// Asks the lanes to end; any thread, also a body or a signal handler.
    pub(crate) fn stop(&self) -> Result<(), red_status> {
        if self.shared.lanes.stop() { Ok(()) } else { Err(red_status::Idle) }
    }

    /// Waits for the end, at most so long.
    pub(crate) fn wait(&self, timeout: Option<Duration>) -> Result<(), red_status> {
        if is_in_body() {
            return Err(red_status::Busy);
        }
        let goes_on = |state: &mut State| matches!(state, State::Running);
        let state = self.state();
        if !matches!(*state, State::Running | State::Ended(_)) {
            return Err(red_status::Idle);
        }
        let state = match timeout {
            None => self.shared.ended.wait_while(state, goes_on).unwrap_or_else(PoisonError::into_inner),
            Some(timeout) => {
                let waited = self.shared.ended.wait_timeout_while(state, timeout, goes_on);
                waited.unwrap_or_else(PoisonError::into_inner).0
            }
        };
        match *state {
            State::Running => Err(red_status::Timeout),
            State::Failed(status) => Err(status),
            State::SetUp(_) | State::Ended(_) => Ok(()),
        }
    }
}

/// The thread of a run: tells who started it whether lanes run, and leaves the report.
fn run_to_the_end(
    setup: Setup<Large>,
    writer: Option<Writer>,
    cuda: Option<(Cuda, OnDevice)>,
    notes: Arc<Notes>,
    shared: &Shared,
    tell: &Sender<Result<(), SetupError>>,
) {
    let origin = notes.clone();
    let (cuda, device) = cuda.unzip();
    let used = device.and_then(OnDevice::utilisation);
    let mut observer = None;
    let started = |control: Arc<dyn Control<Large>>| {
        observer = used.and_then(|(pools, source)| Observer::start(control.clone(), pools, source));
        origin.origin_ns.store(control.origin_ns(), core::sync::atomic::Ordering::Relaxed);
        shared.lanes.come(control);
        let _told = tell.send(Ok(()));
    };
    let ran: Result<RunReport, SetupError> =
        run(setup, Teller::new(notes), started, |_now_ns| ()).map(|(_host, report)| report);
    drop(observer);
    let log_dropped = writer.map_or(0, |writer| {
        let (totals, why) = writer.finish();
        if let Some(why) = why {
            *shared.said() = format!("the log is not whole: {why}; fix: give it room, or another place");
        }
        // A log that could not be closed is not whole either.
        totals.dropped.max(totals.cut.is_some().into())
    });
    let ran = match ran {
        // Who started it listens until lanes run.
        Err(error) if shared.lanes.get().is_none() => {
            let _told = tell.send(Err(error));
            return;
        }
        ran => ran,
    };
    // Who started it sets the state to running before this one gets it.
    let mut state = shared.state.lock().unwrap_or_else(PoisonError::into_inner);
    match ran {
        Ok(report) => {
            let report = red_report { log_dropped, ..red_report::of(&report) };
            *state = State::Ended(Box::new(cuda.map_or(report, |cuda| report.on(&cuda))));
        }
        Err(error) => *state = shared.failed(&error),
    }
    shared.ended.notify_all();
}
