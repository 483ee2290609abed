//! A network as an ordinary node.

use super::{Instance, Network};
use crate::{Body, BodyError, Call};

/// A network with tensors of its own: for a node that shares no frame with others, and for measuring.
pub struct Inference {
    instance: Box<dyn Instance>,
    input: Box<[f32]>,
    output: Box<[f32]>,
}

impl Inference {
    /// Makes an instance of `network` with an input of zeros.
    ///
    /// # Errors
    /// As [`Network::instance`].
    pub fn new(network: &dyn Network) -> Result<Self, BodyError> {
        Ok(Self {
            instance: network.instance()?,
            input: vec![0.0; network.input_len()].into(),
            output: vec![0.0; network.output_len()].into(),
        })
    }

    /// The input of the next call.
    pub fn input_mut(&mut self) -> &mut [f32] {
        &mut self.input
    }

    /// The output of the last call.
    #[must_use]
    pub fn output(&self) -> &[f32] {
        &self.output
    }
}

impl Body for Inference {
    fn run(&mut self, _call: &Call) -> Result<(), BodyError> {
        self.instance.run(&self.input, &mut self.output)
    }
}
