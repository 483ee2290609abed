//! One lane of a device: its stream, the bodies of its nodes, and what it has under way.

use super::Shared;
use super::order::{LANES, Own, Waits};
use crate::handler::{Failed, Handler, Work};
use crate::stream::{Progress, Stream as OnStream, Submitted};
use crate::stream_seat::StreamSeat;
use core::sync::atomic::Ordering;
use red_core::UnitId;
use red_cuda::{CudaError, Stream};
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

/// Units under way in a stream, at most.
const UNDER_WAY: usize = 4;

/// The bodies of all nodes, as the lane of one stream submits them.
pub trait Bodies: Send {
    /// Submits a node's work to the stream, and returns: it must not wait for it. A panic fails the job as well.
    ///
    /// # Errors
    /// [`NotSubmitted`]: the job is given up with the reason `fault`.
    fn submit(&mut self, work: &Work, stream: &Stream) -> Result<(), NotSubmitted>;

    /// Called once on the lane's thread when the run starts. The times of [`Work`] count from `origin_ns`, nanoseconds of
    /// `CLOCK_MONOTONIC`.
    fn begin(&mut self, origin_ns: u64) {
        let _unused = origin_ns;
    }
}

/// A node's work was not submitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotSubmitted {
    /// The driver refused, or answered with what an earlier kernel did.
    Driver(CudaError),
    /// The body did; what went wrong is its own to tell.
    Body,
}

impl From<CudaError> for NotSubmitted {
    fn from(error: CudaError) -> Self {
        Self::Driver(error)
    }
}

/// A unit that the stream has, or what it waits for.
#[derive(Clone, Copy, Debug)]
struct UnderWay {
    turn: u64,
    waits: Waits,
}

pub(super) struct OnDevice {
    cuda: Arc<Shared>,
    own: Own,
    lane: usize,
    /// There until it is dropped.
    bodies: Option<Box<dyn Bodies>>,
    stream: Stream,
    /// Where the driver's thread is asked to ring: in the stream itself, what comes next would wait for that.
    calls: Stream,
    under_way: VecDeque<UnderWay>,
}

/// Bodies that would give something back to a device that takes nothing back any more: there until the process ends.
static LEFT: Mutex<Vec<Box<dyn Bodies>>> = Mutex::new(Vec::new());

impl OnDevice {
    pub(super) fn new(
        cuda: Arc<Shared>,
        lane: usize,
        stream: Stream,
        calls: Stream,
        bodies: Box<dyn Bodies>,
    ) -> Self {
        let under_way = VecDeque::with_capacity(UNDER_WAY);
        Self { cuda, own: Own::of(lane), lane, bodies: Some(bodies), stream, calls, under_way }
    }

    /// Keeps an error that ends the context.
    fn note(&self, error: CudaError) {
        if error.is_sticky() {
            // The first one is the cause.
            let _later = self.cuda.lost.set(error);
            self.cuda.device.leave();
        }
    }

    fn noted<T>(&self, result: Result<T, CudaError>) -> Option<T> {
        result.inspect_err(|error| self.note(*error)).ok()
    }

    /// Whether all that a unit waits for on other streams has ended.
    fn has_begun(&self, waits: &Waits) -> Result<bool, CudaError> {
        for lane in 0..LANES {
            let turn = waits.turns[lane];
            if turn > 0
                && let Some(event) = self.cuda.order.event(lane, turn)
                && !event.is_done()?
            {
                return Ok(false);
            }
        }
        Ok(true)
    }
}

impl Handler for OnDevice {
    fn run(&mut self, _: &Work) -> Result<(), Failed> {
        // Not called: there is a stream.
        Err(Failed)
    }

    fn stream(&mut self) -> Option<&mut dyn OnStream> {
        Some(self)
    }

    fn begin(&mut self, origin_ns: u64) {
        self.noted(self.cuda.device.enter());
        let free = self.noted(self.cuda.device.memory()).map(|(free, _)| free);
        // Before the lanes' own first units, by whichever lane comes first.
        free.map(|free| self.cuda.free_bytes.set(free));
        self.cuda.device.seal();
        if let Some(bodies) = &mut self.bodies {
            bodies.begin(origin_ns);
        }
    }
}

impl OnStream for OnDevice {
    fn submit(&mut self, work: &Work, after: &[UnitId]) -> Submitted {
        if self.is_lost() {
            return Submitted::Failed;
        }
        let Self { cuda, own, bodies: Some(bodies), stream, .. } = self else { return Submitted::Failed };
        let waited = cuda.order.wait_for(own, after, |event| stream.wait_for(event));
        let waits = match waited {
            Ok(Some(waits)) => Ok(waits),
            Ok(None) => return Submitted::NotYet,
            Err(error) => Err(NotSubmitted::Driver(error)),
        };
        let submitted = waits.and_then(|waits| bodies.submit(work, stream).map(|()| waits));
        // Also where nothing was submitted, for others may wait for it.
        let marked = cuda.order.mark(own, work.unit, |event| stream.record(event));
        let given = submitted.and_then(|waits| Ok((waits, marked?)));
        match given {
            Ok((waits, turn)) => {
                self.cuda.issued.fetch_add(waits.issued, Ordering::Relaxed);
                // What is under way in the stream is a predecessor, by which a unit was sent ahead.
                let behind = u64::from(!self.under_way.is_empty());
                self.cuda.avoided.fetch_add(waits.avoided + behind, Ordering::Relaxed);
                self.under_way.push_back(UnderWay { turn, waits });
                Submitted::Given
            }
            Err(NotSubmitted::Driver(error)) => {
                self.note(error);
                Submitted::Failed
            }
            Err(NotSubmitted::Body) => Submitted::Failed,
        }
    }

    fn look(&mut self) -> Progress {
        let Some(UnderWay { turn, waits }) = self.under_way.front().copied() else {
            return Progress::Done(Err(Failed));
        };
        let event = self.cuda.order.event(self.lane, turn);
        let progress = match event.map_or(Ok(true), red_cuda::Event::is_done) {
            Ok(true) => Ok(Progress::Done(Ok(()))),
            Ok(false) => {
                self.has_begun(&waits).map(|begun| if begun { Progress::Runs } else { Progress::Waits })
            }
            Err(error) => Err(error),
        };
        let progress = progress.unwrap_or_else(|error| {
            self.note(error);
            Progress::Done(Err(Failed))
        });
        if let Progress::Done(_) = progress {
            self.under_way.pop_front();
        }
        progress
    }

    fn call(&mut self, seat: &Arc<StreamSeat>) -> Result<(), Failed> {
        let turn = self.under_way.front().ok_or(Failed)?.turn;
        let event = self.cuda.order.event(self.lane, turn).ok_or(Failed)?;
        let called = self.calls.wait_for(event).and_then(|()| self.calls.call(seat.clone()));
        self.noted(called).ok_or(Failed)
    }

    fn quarantine(&mut self) {
        self.cuda.device.leave();
    }

    fn is_lost(&mut self) -> bool {
        self.cuda.lost.get().is_some()
    }
}

impl Drop for OnDevice {
    fn drop(&mut self) {
        if self.cuda.device.is_left() {
            LEFT.lock().unwrap_or_else(PoisonError::into_inner).extend(self.bodies.take());
        }
    }
}
