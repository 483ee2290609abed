//! Loading: files once, each refusal with its place.

use super::{BodiesError, Loaded, Node, Why};
use red_bodies::onnx::{Engine, Network, Rten};
use red_bodies::plugin::{Host as PluginHost, Plugin};
use red_bodies::{BodyError, within};
use red_workload::Source;
use red_workload::model::{Body, Part};
use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

/// What is loaded so far, and where.
pub(super) struct Loader<'a> {
    pub(super) source: &'a Source,
    pub(super) host: &'a Arc<PluginHost>,
    pub(super) networks: HashMap<PathBuf, Arc<dyn Network>>,
    /// Which task is being loaded, and how many of its parts are.
    pub(super) task: usize,
    pub(super) part: usize,
}

impl Loader<'_> {
    /// Parts that a CUDA device executes.
    pub(super) fn pass(&mut self, parts: usize) -> Node {
        self.part += parts;
        Node::Device
    }

    pub(super) fn decoder(
        &mut self,
        part: &Part,
        encoder: Option<&Node>,
        name: &str,
    ) -> Result<Node, BodiesError> {
        let decoder = self.load(part, name)?;
        if let Some(Node::Encoder(encoder)) = encoder {
            self.fit(encoder, &decoder, name)?;
        }
        Ok(Node::Decoder(decoder))
    }

    /// Loads the next part.
    pub(super) fn load(&mut self, part: &Part, node: &str) -> Result<Loaded, BodiesError> {
        let loaded = match &part.body {
            Body::None => Err(Why::NoBody),
            Body::Cuda { .. } => Err(Why::OfDevice),
            Body::Spin { duration_ns } => Ok(Loaded::Spin(*duration_ns)),
            Body::Onnx { path } => self.network(path).map(Loaded::Network).map_err(Why::Load),
            Body::Plugin { path, symbol, .. } => within(self.source.folder(), path.as_ref())
                .and_then(|path| Plugin::load(&path, symbol, self.host))
                .map(Loaded::Plugin)
                .map_err(Why::Load),
        };
        self.part += 1;
        loaded.map_err(|why| self.refused(node, why))
    }

    fn network(&mut self, path: &str) -> Result<Arc<dyn Network>, BodyError> {
        let path = within(self.source.folder(), path.as_ref())?;
        if let Some(network) = self.networks.get(&path) {
            return Ok(network.clone());
        }
        let network: Arc<dyn Network> = Arc::from(Rten.load(&path)?);
        self.networks.insert(path, network.clone());
        Ok(network)
    }

    /// Whether the decoder that was loaded last reads what its encoder writes.
    pub(super) fn fit(&self, encoder: &Loaded, decoder: &Loaded, node: &str) -> Result<(), BodiesError> {
        match (encoder, decoder) {
            (Loaded::Network(e), Loaded::Network(d)) if e.output_len() != d.input_len() => {
                Err(self.refused(node, Why::Shape { reads: d.input_len(), written: e.output_len() }))
            }
            _ => Ok(()),
        }
    }

    /// A refusal of the part that was loaded last.
    pub(super) fn refused(&self, node: &str, why: Why) -> BodiesError {
        BodiesError::of(self.source, self.task, self.part - 1, node, why)
    }
}
