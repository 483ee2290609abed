//! The first run of everything, before real time starts: loading and allocating on first use makes the whole device wait.

use super::load::Loader;
use super::step::{KernelStep, Step};
use crate::session::bodies::Why;
use crate::session::faults::Fault;
use red_cuda::{Buffer, CudaError, Stream};
use std::thread;
use std::time::{Duration, Instant};

/// How long a kernel may take in its first run, before the start; once somebody wants the run to stop, no longer than that.
const PATIENCE: Duration = Duration::from_secs(10);
const PATIENCE_AFTER_SIGNAL: Duration = Duration::from_secs(1);
/// Between two looks at it.
const LOOK: Duration = Duration::from_micros(50);
impl Loader<'_> {
    /// Runs it once, and clears what it works in before that.
    pub(super) fn warm_up(&self, mut step: Box<KernelStep>) -> Result<Box<KernelStep>, Why> {
        let stream = self.pools.cuda.stream().map_err(|error| self.why(&error))?;
        self.submit_first(&mut step, &stream).map_err(|error| self.why(&error))?;
        self.settle(&stream)?;
        Ok(step)
    }

    fn submit_first(&self, step: &mut KernelStep, stream: &Stream) -> Result<(), CudaError> {
        let there =
            step.inputs.iter().map(|(_, there)| there).chain(step.outputs.iter().map(|(there, _)| there));
        let own = step.own_result.as_deref();
        there.chain(&step.scratch).chain(own).try_for_each(|buffer| stream.clear(buffer))?;
        let result = step.own_result.as_deref().or(self.results.first()).map_or(0, Buffer::address);
        for at in &step.results {
            step.arguments.set(*at, result);
        }
        stream.launch(&step.kernel, &mut step.arguments)
    }

    /// Waits for the end of what was submitted, for a while.
    fn settle(&self, stream: &Stream) -> Result<(), Why> {
        let device = self.pools.cuda.device();
        let end = device.event().and_then(|end| stream.record(&end).map(|()| end));
        let end = end.map_err(|error| self.why(&error))?;
        let begin = Instant::now();
        while !end.is_done().map_err(|error| self.why(&error))? {
            let bound =
                if self.pools.signals.requested().is_some() { PATIENCE_AFTER_SIGNAL } else { PATIENCE };
            if begin.elapsed() > bound {
                device.leave();
                return Err(Why::Endless { waited_s: bound.as_secs() });
            }
            thread::sleep(LOOK);
        }
        Ok(())
    }

    /// As graphs, which ran once.
    pub(super) fn graphs(&self, step: Step) -> Result<Step, Why> {
        let device = |error: CudaError| self.why(&error);
        let stream = self.pools.cuda.stream().map_err(device)?;
        let step = step.captured(&self.results, &stream).map_err(|fault| match fault {
            Fault::Device(error) => device(error),
            Fault::Body(error) => Why::Load(error),
        })?;
        if let Step::Graphs(_, graphs) = &step {
            graphs.iter().try_for_each(|graph| stream.launch_graph(graph)).map_err(device)?;
        }
        self.settle(&stream)?;
        Ok(step)
    }
}
