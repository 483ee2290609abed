//! The default engine: rten, pure Rust.

use std::path::Path;
use std::sync::Arc;

use rten::{DataType, Dimension, Model, ModelOptions, NodeId, RunOptions, ValueType, ValueView};
use rten_tensor::TensorView;
use rten_tensor::prelude::*;

use super::{Engine, Instance, Network, Port, lane, read, tried, wire};
use crate::BodyError;

/// The engine rten.
#[derive(Clone, Copy, Debug, Default)]
pub struct Rten;

impl Engine for Rten {
    fn load(&self, path: &Path) -> Result<Box<dyn Network>, BodyError> {
        let data = read(path)?;
        wire::check(&data).map_err(|reason| BodyError::Model { path: path.into(), reason: reason.into() })?;
        let model = ModelOptions::with_all_ops()
            .prepack_weights(true)
            .load(data)
            .map_err(|error| BodyError::Model { path: path.into(), reason: error.to_string() })?;
        let inputs = ports(path, &model, model.input_ids())?;
        let outputs = ports(path, &model, model.output_ids())?;
        tried(path, Box::new(RtenNetwork { shared: Arc::new(Shared { model, inputs, outputs }) }))
    }
}

/// Names and sizes of `ids`, which must all be `f32` of fixed size.
fn ports(path: &Path, model: &Model, ids: &[NodeId]) -> Result<Vec<Port>, BodyError> {
    ids.iter()
        .map(|&id| {
            let info = model.node_info(id);
            let name = info.as_ref().and_then(|info| info.name()).unwrap_or_default();
            let refuse = |reason| BodyError::Port { path: path.into(), port: name.into(), reason };
            let info = info.as_ref().ok_or_else(|| refuse("is not in the graph"))?;
            if info.dtype() != Some(ValueType::Tensor(DataType::Float)) {
                return Err(refuse("is not of 32-bit floats"));
            }
            let shape = info.shape().ok_or_else(|| refuse("has no shape"))?;
            let fixed = |size| match size {
                Dimension::Fixed(size) => Some(size),
                Dimension::Symbolic(_) => None,
            };
            Port::new(path, name, shape.into_iter().map(fixed))
        })
        .collect()
}

struct Shared {
    model: Model,
    inputs: Vec<Port>,
    outputs: Vec<Port>,
}

struct RtenNetwork {
    shared: Arc<Shared>,
}

impl Network for RtenNetwork {
    fn inputs(&self) -> &[Port] {
        &self.shared.inputs
    }

    fn outputs(&self) -> &[Port] {
        &self.shared.outputs
    }

    /// The lanes share the weights. What rten writes in a run is that run's own, but for its mutex around the cached
    /// order of operators, which it holds for one comparison.
    fn instance(&self) -> Result<Box<dyn Instance>, BodyError> {
        Ok(Box::new(RtenInstance {
            shared: Arc::clone(&self.shared),
            input_len: self.input_len(),
            output_len: self.output_len(),
        }))
    }
}

struct RtenInstance {
    shared: Arc<Shared>,
    input_len: usize,
    output_len: usize,
}

impl Instance for RtenInstance {
    fn run(&mut self, input: &[f32], output: &mut [f32]) -> Result<(), BodyError> {
        BodyError::check_len("input", self.input_len, input.len())?;
        BodyError::check_len("output", self.output_len, output.len())?;
        let Shared { model, inputs, outputs } = &*self.shared;
        let options = RunOptions::default().with_thread_pool(Some(lane::pool()?));
        let mut rest = input;
        let views = model
            .input_ids()
            .iter()
            .zip(inputs)
            .map(|(&id, port)| {
                let values;
                (values, rest) = rest.split_at(port.len());
                (id, ValueView::from(TensorView::from_data(&port.shape[..], values)).into())
            })
            .collect();
        let results = model
            .run(views, model.output_ids(), Some(options))
            .map_err(|error| BodyError::Inference { reason: error.to_string() })?;
        let mut rest = output;
        for (value, port) in results.into_iter().zip(outputs) {
            let values;
            (values, rest) = rest.split_at_mut(port.len());
            let tensor = value.as_tensor_view::<f32>().filter(|tensor| tensor.len() == values.len());
            let tensor = tensor.ok_or_else(|| port.changed())?;
            match tensor.data() {
                Some(data) => values.copy_from_slice(data),
                None => values.iter_mut().zip(tensor.iter()).for_each(|(to, from)| *to = *from),
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
