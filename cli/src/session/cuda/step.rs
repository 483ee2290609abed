//! A body as one lane submits it to its stream.

use crate::session::faults::Fault;
use red_bodies::Call;
use red_bodies::plugin::PluginBody;
use red_cuda::{Arguments, Buffer, CudaError, Graph, Kernel, Pinned, Stream};
use std::sync::Arc;

/// More than a stream has under way.
pub(super) const STAGES: usize = 4;

/// A body as one lane submits it.
pub(super) enum Step {
    Kernel(Box<KernelStep>),
    Plugin(PluginBody),
    /// Captured of the step, which has the memory that it uses: for each result that it may write or read, or one.
    Graphs(Box<Self>, Vec<Graph>),
}

pub(super) struct KernelStep {
    pub(super) kernel: Kernel,
    pub(super) arguments: Arguments,
    /// The image is copied from these in turns: what was submitted before may not have been copied yet.
    pub(super) inputs: Vec<([Pinned; STAGES], Buffer)>,
    pub(super) turn: usize,
    pub(super) outputs: Vec<(Buffer, Pinned)>,
    /// Kept for the kernel.
    pub(super) scratch: Vec<Buffer>,
    /// Which arguments are the address of a result.
    pub(super) results: Vec<usize>,
    /// Of a whole stage: the result that its parts hand on.
    pub(super) own_result: Option<Arc<Buffer>>,
}

impl Step {
    /// Whether it reads the camera's image.
    pub(super) fn wants_image(&self) -> bool {
        match self {
            Self::Kernel(step) => !step.inputs.is_empty(),
            Self::Plugin(_) => false,
            Self::Graphs(step, _) => step.wants_image(),
        }
    }

    /// Of a whole stage: the result that its parts hand on.
    pub(super) fn own_result(&self) -> Option<Arc<Buffer>> {
        match self {
            Self::Kernel(step) => step.own_result.clone(),
            Self::Plugin(_) => None,
            Self::Graphs(step, _) => step.own_result(),
        }
    }

    /// Submits it. `result` is the number and the address of the encoder's result that it writes or reads.
    pub(super) fn submit(
        &mut self,
        call: &Call,
        result: Option<(usize, u64)>,
        image: &[f32],
        stream: &Stream,
    ) -> Result<(), Fault> {
        match self {
            Self::Plugin(plugin) => Ok(plugin.submit(call, stream.as_ptr())?),
            Self::Kernel(step) => {
                step.upload(image, stream)?;
                Ok(step.run(result.map(|(_, address)| address), stream)?)
            }
            Self::Graphs(step, graphs) => {
                if let Self::Kernel(step) = &mut **step {
                    step.upload(image, stream)?;
                }
                let number = result.map_or(0, |(number, _)| number);
                Ok(stream.launch_graph(graphs.get(number).unwrap_or(&graphs[0]))?)
            }
        }
    }

    /// Has what it submits captured, for each of the results that it may be given.
    pub(super) fn captured(mut self, results: &[Buffer], stream: &Stream) -> Result<Self, Fault> {
        let numbers = match &self {
            Self::Kernel(step) if step.own_result.is_none() && !step.results.is_empty() => results.len(),
            _ => 1,
        };
        let mut graphs = Vec::new();
        for number in 0..numbers {
            let result = results.get(number).map(|result| (number, result.address()));
            graphs.push(stream.capture(|stream| match &mut self {
                // The image comes from another place each time.
                Self::Kernel(step) => Ok(step.run(result.map(|(_, address)| address), stream)?),
                other => other.submit(&Call::default(), result, &[], stream),
            })?);
        }
        Ok(Self::Graphs(Box::new(self), graphs))
    }
}

impl KernelStep {
    /// Copies the image to the device.
    fn upload(&mut self, image: &[f32], stream: &Stream) -> Result<(), CudaError> {
        self.turn = (self.turn + 1) % STAGES;
        for (stages, there) in &mut self.inputs {
            let here = &mut stages[self.turn];
            for (bytes, value) in here.bytes_mut().chunks_exact_mut(4).zip(image) {
                bytes.copy_from_slice(&value.to_le_bytes());
            }
            stream.upload(here, there)?;
        }
        Ok(())
    }

    /// Runs the kernel, and copies what it gives to the host.
    fn run(&mut self, result: Option<u64>, stream: &Stream) -> Result<(), CudaError> {
        let own = self.own_result.as_deref().map(Buffer::address);
        for at in &self.results {
            self.arguments.set(*at, own.or(result).unwrap_or(0));
        }
        stream.launch(&self.kernel, &mut self.arguments)?;
        for (there, here) in &mut self.outputs {
            stream.download(there, here)?;
        }
        Ok(())
    }
}
