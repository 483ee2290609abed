//! What executes a node and says what it took: a handler of the CPU by the clock, a stream by the events around it.

use red_cuda::{CudaError, Device, Stream, TimedEvent};
use red_rt::clock::now_ns;
use red_rt::cuda::{Bodies, NotSubmitted};
use red_rt::handler::{Failed, Handler, Work};
use std::thread;
use std::time::Duration;

/// Between two looks at a stream: what it takes is the device's to say, and other lanes need the CPUs.
const LOOK: Duration = Duration::from_micros(50);

/// Who runs the nodes of a lane.
pub(super) enum Runner {
    Host(Box<dyn Handler>),
    Stream(OnStream),
}

/// A stream with events that know when they were reached.
pub(super) struct OnStream {
    device: Device,
    stream: Stream,
    bodies: Box<dyn Bodies>,
    begin: TimedEvent,
    end: TimedEvent,
}

impl OnStream {
    /// For these bodies.
    ///
    /// # Errors
    /// The driver's.
    pub(super) fn new(device: &Device, stream: Stream, bodies: Box<dyn Bodies>) -> Result<Self, CudaError> {
        let (begin, end) = (device.timed_event()?, device.timed_event()?);
        Ok(Self { device: device.clone(), stream, bodies, begin, end })
    }

    fn run(&mut self, work: &Work) -> Result<u64, NotSubmitted> {
        self.stream.record_time(&self.begin)?;
        self.bodies.submit(work, &self.stream)?;
        self.stream.record_time(&self.end)?;
        while !self.end.is_done()? {
            thread::sleep(LOOK);
        }
        let took = self.end.since(&self.begin)?;
        Ok(u64::try_from(took.as_nanos()).unwrap_or(u64::MAX))
    }
}

impl Runner {
    /// On the lane's thread, before the first run.
    pub(super) fn prepare(&mut self) {
        match self {
            Self::Host(handler) => handler.prepare(),
            // What fails here fails at the first run as well.
            Self::Stream(on) => drop(on.device.enter()),
        }
    }

    /// Whether the thread itself computes.
    pub(super) const fn is_host(&self) -> bool {
        matches!(self, Self::Host(_))
    }

    /// Runs a node once; what it took, in nanoseconds. Errors: it failed, and what the driver said of it.
    pub(super) fn run(&mut self, work: &Work) -> Result<u64, Option<CudaError>> {
        match self {
            Self::Host(handler) => {
                let start = now_ns();
                handler.run(work).map(|()| now_ns() - start).map_err(|Failed| None)
            }
            Self::Stream(on) => on.run(work).map_err(|why| match why {
                NotSubmitted::Driver(error) => Some(error),
                NotSubmitted::Body => None,
            }),
        }
    }
}
