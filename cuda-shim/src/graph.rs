//! Captured graphs: many submissions as one.

use crate::error::CudaError;
use crate::{Device, result};

/// What a stream captured ([`Stream::capture`](crate::Stream::capture)), ready to run.
#[derive(Debug)]
pub struct Graph {
    handle: result::GraphExec,
    _device: Device,
}

impl Graph {
    #[expect(clippy::needless_pass_by_value, reason = "what was captured ends")]
    pub(crate) fn new(device: Device, captured: result::Graph) -> Result<Self, CudaError> {
        Ok(Self { handle: result::graph_instantiate(&captured)?, _device: device })
    }

    pub(crate) const fn handle(&self) -> &result::GraphExec {
        &self.handle
    }
}
