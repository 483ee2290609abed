//! The bodies of a workload, loaded once and instantiated per lane.
//!
//! Encoder results travel in numbered buffers: the scheduler says which one a unit writes or reads, and keeps a
//! number for one result as long as somebody in flight needs it. The locks around the buffers never wait then;
//! a body that would have to fails its job.

use red_bodies::onnx::{Engine, Instance, Network, Rten};
use red_bodies::plugin::{Host as PluginHost, Plugin, PluginBody};
use red_bodies::scene::Scene;
use red_bodies::spin::Spin;
use red_bodies::{Body as _, BodyError, Call};
use red_rt::handler::{Failed, Handler, Work};
use red_workload::build::{Numbered, Role};
use red_workload::model::{Body, Part};
use std::collections::HashMap;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::{Arc, RwLock};

/// Size of the generated road frames.
const FRAME: (usize, usize) = (160, 96);
/// Warm-up calls of every network on every lane, so that its memory is there before real time starts.
const WARM_UP: usize = 3;
/// Results that may be kept at a time.
const RESULTS: usize = 256;

/// A body could not be made ready.
#[derive(Debug)]
pub(crate) enum BodiesError {
    /// A node that `run` has to execute has no body.
    NoBody {
        /// Task and node.
        node: String,
    },
    /// CUDA bodies need a driver and a build with CUDA lanes.
    Cuda {
        /// Task and node.
        node: String,
    },
    /// Its file could not be used.
    Load {
        /// Task and node.
        node: String,
        /// Why.
        reason: BodyError,
    },
    /// A decoder reads another size than its encoder writes.
    Shape {
        /// Task and node.
        node: String,
        /// What it reads and what there is, in numbers of f32.
        reads: usize,
        /// What the encoder writes.
        written: usize,
    },
}

impl fmt::Display for BodiesError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoBody { node } => {
                write!(
                    f,
                    "node `{node}` has no body, so it can be planned and simulated but not run; give it one: body = {{ spin = \"1ms\" }}"
                )
            }
            Self::Cuda { node } => {
                write!(
                    f,
                    "node `{node}` has a cuda body, and this build has no CUDA lanes; run it on the CPU: pool kind = \"cpu\", body = {{ onnx = \"...\" }}"
                )
            }
            Self::Load { node, reason } => write!(f, "node `{node}`: {reason}"),
            Self::Shape { node, reads, written } => {
                write!(
                    f,
                    "node `{node}` reads {reads} numbers, but its encoder writes {written}; give it the decoder of that encoder"
                )
            }
        }
    }
}

impl std::error::Error for BodiesError {}

/// A loaded body, shared by the lanes.
enum Loaded {
    Spin(u64),
    Network(Arc<dyn Network>),
    Plugin(Plugin),
}

/// What a node does, with everything loaded.
enum Node {
    Plain(Loaded),
    Encoder(Loaded),
    Decoder(Loaded),
    /// A whole stage, one after the other.
    Coarse(Loaded, Vec<Loaded>),
}

/// All bodies of a workload.
pub(crate) struct Bodies {
    tasks: Vec<Vec<Node>>,
    results: Vec<RwLock<Vec<f32>>>,
    /// While an obstacle is in sight, by instants of the run: from, until.
    obstacle_ns: Option<(u64, u64)>,
}

impl fmt::Debug for Bodies {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Bodies").field("tasks", &self.tasks.len()).finish_non_exhaustive()
    }
}

impl Bodies {
    /// Loads every body. Paths are relative to `folder`.
    ///
    /// # Errors
    /// [`BodiesError`], for the first node that cannot run.
    pub(crate) fn load(
        nodes: &[Vec<Numbered>],
        tasks: &[String],
        folder: &Path,
        host: &Arc<PluginHost>,
        obstacle_ns: Option<(u64, u64)>,
    ) -> Result<Self, BodiesError> {
        let mut loader = Loader { folder, host, networks: HashMap::new() };
        let mut loaded = Vec::new();
        let mut largest = 0;
        for (task, nodes) in tasks.iter().zip(nodes) {
            let mut of_task: Vec<Node> = Vec::new();
            for node in nodes {
                let name = format!("{task}.{}", node.name);
                of_task.push(match &node.role {
                    Role::Plain(part) => Node::Plain(loader.load(part, &name)?),
                    Role::Encoder(part) => Node::Encoder(loader.load(part, &name)?),
                    Role::Decoder { part, encoder } => {
                        let decoder = loader.load(part, &name)?;
                        if let Some(Node::Encoder(encoder)) = of_task.get(*encoder) {
                            fit(encoder, &decoder, &name)?;
                        }
                        Node::Decoder(decoder)
                    }
                    Role::Coarse(stage) => {
                        let encoder = loader.load(&stage.encoder, &format!("{name}.encoder"))?;
                        let mut decoders = Vec::new();
                        for (decoder, part) in &stage.decoders {
                            let name = format!("{name}.{decoder}");
                            let decoder = loader.load(part, &name)?;
                            fit(&encoder, &decoder, &name)?;
                            decoders.push(decoder);
                        }
                        Node::Coarse(encoder, decoders)
                    }
                });
                if let Some(Node::Encoder(Loaded::Network(network))) = of_task.last() {
                    largest = largest.max(network.output_len());
                }
            }
            loaded.push(of_task);
        }
        let results = (0..RESULTS).map(|_| RwLock::new(vec![0.0; largest])).collect();
        Ok(Self { tasks: loaded, results, obstacle_ns })
    }

    /// The handler of one lane.
    #[must_use]
    pub(crate) fn handler(self: &Arc<Self>, lane: usize) -> Box<dyn Handler> {
        let scene = Scene::new(FRAME.0, FRAME.1);
        let image = vec![0.0; scene.len()];
        Box::new(LaneBodies { bodies: self.clone(), lane, runs: Vec::new(), scene, image, seen: None })
    }
}

/// Whether a decoder reads what its encoder writes.
fn fit(encoder: &Loaded, decoder: &Loaded, node: &str) -> Result<(), BodiesError> {
    match (encoder, decoder) {
        (Loaded::Network(e), Loaded::Network(d)) if e.output_len() != d.input_len() => {
            Err(BodiesError::Shape { node: node.to_owned(), reads: d.input_len(), written: e.output_len() })
        }
        _ => Ok(()),
    }
}

struct Loader<'a> {
    folder: &'a Path,
    host: &'a Arc<PluginHost>,
    networks: HashMap<PathBuf, Arc<dyn Network>>,
}

impl Loader<'_> {
    fn load(&mut self, part: &Part, node: &str) -> Result<Loaded, BodiesError> {
        let failed = |reason| BodiesError::Load { node: node.to_owned(), reason };
        match &part.body {
            Body::None => Err(BodiesError::NoBody { node: node.to_owned() }),
            Body::Cuda { .. } => Err(BodiesError::Cuda { node: node.to_owned() }),
            Body::Spin { duration_ns } => Ok(Loaded::Spin(*duration_ns)),
            Body::Onnx { path } => {
                let path = self.folder.join(path);
                if let Some(network) = self.networks.get(&path) {
                    return Ok(Loaded::Network(network.clone()));
                }
                let network: Arc<dyn Network> = Arc::from(Rten.load(&path).map_err(failed)?);
                self.networks.insert(path, network.clone());
                Ok(Loaded::Network(network))
            }
            Body::Plugin { path, symbol } => {
                Plugin::load(&self.folder.join(path), symbol, self.host).map(Loaded::Plugin).map_err(failed)
            }
        }
    }
}

/// An instance of a body, for one lane.
enum Run {
    Spin(Spin),
    Network {
        instance: Box<dyn Instance>,
        input: Vec<f32>,
        output: Vec<f32>,
    },
    Plugin(PluginBody),
    /// Could not be instantiated, which was said: its jobs fail.
    Broken,
}

/// One lane's instances: of a node, or of the encoder and then the decoders of a whole stage.
struct LaneBodies {
    bodies: Arc<Bodies>,
    lane: usize,
    runs: Vec<Vec<Vec<Run>>>,
    scene: Scene,
    image: Vec<f32>,
    /// The frame in `image`: its number, and whether the obstacle is in it.
    seen: Option<(u64, bool)>,
}

impl Handler for LaneBodies {
    fn prepare(&mut self) {
        let make = |loaded: &Loaded| Run::of(loaded, self.lane);
        let of_node = |node: &Node| match node {
            Node::Plain(one) | Node::Encoder(one) | Node::Decoder(one) => vec![make(one)],
            Node::Coarse(encoder, decoders) => std::iter::once(encoder).chain(decoders).map(make).collect(),
        };
        self.runs = self.bodies.tasks.iter().map(|nodes| nodes.iter().map(of_node).collect()).collect();
        for run in self.runs.iter_mut().flatten().flatten() {
            if let Run::Network { instance, input, output } = run {
                for _ in 0..WARM_UP {
                    // A network that fails here fails its jobs as well, and is counted there.
                    let _warm = instance.run(input, output);
                }
            }
        }
    }

    fn run(&mut self, work: &Work) -> Result<(), Failed> {
        self.execute(work).map_err(|()| Failed)
    }
}

impl Run {
    fn of(loaded: &Loaded, lane: usize) -> Self {
        let made = match loaded {
            Loaded::Spin(duration_ns) => return Self::Spin(Spin::new(*duration_ns)),
            Loaded::Network(network) => network.instance().map(|instance| Self::Network {
                instance,
                input: vec![0.5; network.input_len()],
                output: vec![0.0; network.output_len()],
            }),
            Loaded::Plugin(plugin) => {
                plugin.instance(u32::try_from(lane).unwrap_or(u32::MAX)).map(Self::Plugin)
            }
        };
        made.unwrap_or_else(|e| {
            eprintln!("redrt: lane {lane}: {e}");
            Self::Broken
        })
    }

    /// Runs on `given`, or on an input of its own where that has another size.
    fn step(&mut self, given: Option<&[f32]>, into: Option<&mut [f32]>, call: &Call) -> Result<(), ()> {
        match self {
            Self::Spin(spin) => spin.run(call).map_err(drop),
            Self::Plugin(plugin) => plugin.run(call).map_err(drop),
            Self::Network { instance, input, output } => {
                let len = input.len();
                let input = given.and_then(|g| g.get(..len)).unwrap_or(input);
                let own = output.len();
                let output = into.and_then(|o| o.get_mut(..own)).unwrap_or(output);
                instance.run(input, output).map_err(drop)
            }
            Self::Broken => Err(()),
        }
    }
}

impl LaneBodies {
    fn execute(&mut self, work: &Work) -> Result<(), ()> {
        let bodies = self.bodies.clone();
        let node = bodies.tasks.get(work.task).and_then(|nodes| nodes.get(work.node.index())).ok_or(())?;
        if matches!(node, Node::Plain(Loaded::Network(_)) | Node::Encoder(_) | Node::Coarse(..)) {
            self.look(work)?;
        }
        let call = Call {
            now_ns: work.since_ns,
            release_ns: work.release_ns,
            deadline_ns: work.deadline_ns,
            job: work.job,
            task: u32::try_from(work.task).unwrap_or(u32::MAX),
            lane: u32::try_from(self.lane).unwrap_or(u32::MAX),
        };
        let result = work.output.and_then(|number| bodies.results.get(usize::from(number)));
        let runs =
            self.runs.get_mut(work.task).and_then(|nodes| nodes.get_mut(work.node.index())).ok_or(())?;
        let (first, rest) = runs.split_first_mut().ok_or(())?;
        match node {
            Node::Plain(_) => first.step(Some(&self.image), None, &call),
            Node::Encoder(_) => {
                let mut result = result.and_then(|r| r.try_write().ok());
                first.step(Some(&self.image), result.as_mut().map(|r| r.as_mut_slice()), &call)
            }
            Node::Decoder(_) => {
                let result = result.and_then(|r| r.try_read().ok());
                first.step(result.as_ref().map(|r| r.as_slice()), None, &call)
            }
            Node::Coarse(..) => {
                first.step(Some(&self.image), None, &call)?;
                let features =
                    if let Run::Network { output, .. } = first { Some(output.as_slice()) } else { None };
                rest.iter_mut().try_for_each(|decoder| decoder.step(features, None, &call))
            }
        }
    }

    /// The camera: draws the road as it is at the job's release, unless this lane has that frame already.
    fn look(&mut self, work: &Work) -> Result<(), ()> {
        let obstacle =
            self.bodies.obstacle_ns.is_some_and(|(from, until)| (from..until).contains(&work.release_ns));
        let frame = (work.job, obstacle);
        if self.seen != Some(frame) {
            self.scene.draw(work.job, obstacle, &mut self.image).map_err(drop)?;
            self.seen = Some(frame);
        }
        Ok(())
    }
}
