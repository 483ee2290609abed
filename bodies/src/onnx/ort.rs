//! The engine for robots that have onnxruntime: about twice as fast as rten, from a shared library that is looked up
//! at run time.

use std::path::{Path, PathBuf};

use ort::environment::Environment;
use ort::session::{Session, SessionInputValue};
use ort::value::{Outlet, TensorElementType, TensorRef, ValueType};

use super::{Engine, Instance, Network, Port, read, tried};
use crate::BodyError;

/// The engine onnxruntime.
pub struct Ort {
    environment: Environment,
}

impl Ort {
    /// Loads onnxruntime from the shared library at `library`. The first library loaded serves the whole process.
    ///
    /// # Errors
    /// The library is missing, too old, or not onnxruntime.
    pub fn new(library: &Path) -> Result<Self, BodyError> {
        let refuse = |reason| BodyError::Library { path: library.into(), reason };
        let builder = ort::init_from(library).map_err(|error| refuse(error.to_string()))?;
        let environment = builder.build().map_err(|error| refuse(error.to_string()))?;
        Ok(Self { environment })
    }
}

impl Engine for Ort {
    fn load(&self, path: &Path) -> Result<Box<dyn Network>, BodyError> {
        let model = read(path)?;
        let session = open(&self.environment, path, &model)?;
        let network = OrtNetwork {
            inputs: ports(path, session.inputs())?,
            outputs: ports(path, session.outputs())?,
            environment: self.environment.clone(),
            path: path.into(),
            model,
        };
        tried(path, Box::new(network))
    }
}

/// Opens a session that computes on the calling thread alone.
fn open(environment: &Environment, path: &Path, model: &[u8]) -> Result<Session, BodyError> {
    let refuse = |reason| BodyError::Model { path: path.into(), reason };
    Session::builder(environment)
        .map_err(|error| refuse(error.to_string()))?
        .with_intra_threads(1)
        .map_err(|error| refuse(error.to_string()))?
        .with_inter_threads(1)
        .map_err(|error| refuse(error.to_string()))?
        .commit_from_memory(model)
        .map_err(|error| refuse(error.to_string()))
}

/// Names and sizes of `outlets`, which must all be `f32` of fixed size.
fn ports(path: &Path, outlets: &[Outlet]) -> Result<Vec<Port>, BodyError> {
    outlets
        .iter()
        .map(|outlet| {
            let ValueType::Tensor { ty: TensorElementType::Float32, shape, .. } = outlet.dtype() else {
                let reason = "is not of 32-bit floats";
                return Err(BodyError::Port { path: path.into(), port: outlet.name().into(), reason });
            };
            Port::new(path, outlet.name(), shape.iter().map(|&size| usize::try_from(size).ok()))
        })
        .collect()
}

struct OrtNetwork {
    environment: Environment,
    path: PathBuf,
    model: Vec<u8>,
    inputs: Vec<Port>,
    outputs: Vec<Port>,
}

impl Network for OrtNetwork {
    fn inputs(&self) -> &[Port] {
        &self.inputs
    }

    fn outputs(&self) -> &[Port] {
        &self.outputs
    }

    /// A session of its own, weights included: two lanes in one session would share its memory arena's lock.
    fn instance(&self) -> Result<Box<dyn Instance>, BodyError> {
        Ok(Box::new(OrtInstance {
            session: open(&self.environment, &self.path, &self.model)?,
            inputs: self.inputs.clone(),
            outputs: self.outputs.clone(),
            input_len: self.input_len(),
            output_len: self.output_len(),
        }))
    }
}

struct OrtInstance {
    session: Session,
    inputs: Vec<Port>,
    outputs: Vec<Port>,
    input_len: usize,
    output_len: usize,
}

impl Instance for OrtInstance {
    fn run(&mut self, input: &[f32], output: &mut [f32]) -> Result<(), BodyError> {
        BodyError::check_len("input", self.input_len, input.len())?;
        BodyError::check_len("output", self.output_len, output.len())?;
        let failed = |error: ort::Error| BodyError::Inference { reason: error.to_string() };
        let mut rest = input;
        let tensors = self
            .inputs
            .iter()
            .map(|port| {
                let values;
                (values, rest) = rest.split_at(port.len());
                TensorRef::from_array_view((&port.shape[..], values)).map(SessionInputValue::from)
            })
            .collect::<Result<Vec<_>, _>>()
            .map_err(failed)?;
        let results = self.session.run(&tensors[..]).map_err(failed)?;
        let mut rest = output;
        for (index, port) in self.outputs.iter().enumerate() {
            let values;
            (values, rest) = rest.split_at_mut(port.len());
            let (_, data) = results[index].try_extract_tensor::<f32>().map_err(failed)?;
            if data.len() != values.len() {
                return Err(port.changed());
            }
            values.copy_from_slice(data);
        }
        Ok(())
    }
}
