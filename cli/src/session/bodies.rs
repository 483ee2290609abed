//! The bodies of a workload, loaded once and instantiated per lane.
//!
//! Encoder results travel in numbered buffers: the scheduler says which one a unit writes or reads, and keeps a
//! number for one result as long as somebody in flight needs it. The locks around the buffers never wait then;
//! a body that would have to fails its job.

mod error;
mod load;

use super::cuda::is_cuda;
use super::faults::{self, Said};
pub(crate) use error::{BodiesError, Why};
use load::Loader;
use red_bodies::onnx::{Instance, Network};
use red_bodies::plugin::{Host as PluginHost, Plugin, PluginBody};
use red_bodies::scene::Scene;
use red_bodies::spin::Spin;
use red_bodies::{Body as _, BodyError, Call};
use red_rt::clock::now_ns;
use red_rt::handler::{Failed, Handler, Work};
use red_workload::build::{Numbered, Role};
use red_workload::model::{self, Body, Workload};
use red_workload::{Source, shown, shown_path};
use std::collections::HashMap;
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError, RwLock, TryLockError, TryLockResult};

/// Size of the generated road frames.
pub(super) const FRAME: (usize, usize) = (160, 96);
/// Warm-up calls of every network on every lane, so that its memory is there before real time starts.
const WARM_UP: usize = 3;
/// Heap that every lane touches and gives back: run by turns instead of alone, networks leave gaps in it and need more
/// than the warm-up did.
const HEAP_RESERVE: usize = 4 << 20;
/// Results that may be kept at a time.
const RESULTS: usize = 256;

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
    /// What a CUDA device executes.
    Device,
}

/// All bodies of a workload.
pub(crate) struct Bodies {
    tasks: Vec<Vec<Node>>,
    results: Vec<RwLock<Vec<f32>>>,
    /// While an obstacle is in sight, by instants of the run: from, until.
    obstacle_ns: Option<(u64, u64)>,
    said: Mutex<Vec<Said>>,
    /// The first that could not be instantiated.
    broken: Mutex<Option<String>>,
}

impl fmt::Debug for Bodies {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Bodies").field("tasks", &self.tasks.len()).finish_non_exhaustive()
    }
}

impl Bodies {
    /// Loads the bodies of all nodes of `source`.
    ///
    /// # Errors
    /// [`BodiesError`], for the first node that cannot run. No plugin was loaded if it has no body that could.
    pub(crate) fn load(
        source: &Source,
        nodes: &[Vec<Numbered>],
        host: &Arc<PluginHost>,
        obstacle_ns: Option<(u64, u64)>,
    ) -> Result<Self, BodiesError> {
        check(source)?;
        let workload = &source.workload;
        let mut loader = Loader { source, host, networks: HashMap::new(), task: 0, part: 0 };
        let mut loaded = Vec::new();
        let mut largest = 0;
        for (task, nodes) in nodes.iter().enumerate() {
            (loader.task, loader.part) = (task, 0);
            let mut of_task: Vec<Node> = Vec::new();
            for node in nodes {
                let name = &node.name;
                of_task.push(match &node.role {
                    Role::Plain(part) | Role::Encoder { part, .. } if is_cuda(workload, part.pool) => {
                        loader.pass(1)
                    }
                    Role::Decoder { part, encoder } => {
                        let is_apart = matches!(of_task.get(*encoder), Some(Node::Device))
                            != is_cuda(workload, part.pool);
                        if is_apart {
                            loader.part += 1;
                            return Err(loader.refused(name, Why::Apart));
                        }
                        if is_cuda(workload, part.pool) {
                            loader.pass(1)
                        } else {
                            loader.decoder(part, of_task.get(*encoder), name)?
                        }
                    }
                    Role::Coarse(stage) if is_cuda(workload, stage.encoder.pool) => {
                        loader.pass(1 + stage.decoders.len())
                    }
                    Role::Plain(part) => Node::Plain(loader.load(part, name)?),
                    Role::Encoder { part, .. } => Node::Encoder(loader.load(part, name)?),
                    Role::Coarse(stage) => {
                        let encoder = loader.load(&stage.encoder, &format!("{name}.encoder"))?;
                        let mut decoders = Vec::new();
                        for (decoder, part) in &stage.decoders {
                            let name = format!("{name}.{decoder}");
                            let decoder = loader.load(part, &name)?;
                            loader.fit(&encoder, &decoder, &name)?;
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
        Ok(Self {
            tasks: loaded,
            results,
            obstacle_ns,
            said: Mutex::new(faults::table()),
            broken: Mutex::new(None),
        })
    }

    /// The first body that could not be instantiated since this was asked last, in words.
    pub(crate) fn broken(&self) -> Option<String> {
        self.broken.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    /// What bodies said of their failures.
    pub(crate) fn said(&self) -> Vec<Said> {
        std::mem::take(&mut *self.said.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// The handler of one lane.
    #[must_use]
    pub(crate) fn handler(self: &Arc<Self>, lane: usize) -> Box<dyn Handler> {
        let scene = Scene::new(FRAME.0, FRAME.1);
        let image = vec![0.0; scene.len()];
        Box::new(LaneBodies {
            bodies: self.clone(),
            lane,
            origin_ns: 0,
            runs: Vec::new(),
            scene,
            image,
            seen: None,
        })
    }
}

/// Refuses nodes without a body that could run, before anything is loaded.
fn check(source: &Source) -> Result<(), BodiesError> {
    let Workload { tasks, events, .. } = &source.workload;
    for (task, of) in tasks.iter().enumerate() {
        let added = events.iter().filter(|event| event.task == task).flat_map(|event| &event.add);
        let parts = of.nodes.iter().chain(added).flat_map(model::Node::parts);
        for (number, (name, part)) in parts.enumerate() {
            let why = match part.body {
                Body::None => Why::NoBody,
                Body::Cuda { .. } if !is_cuda(&source.workload, part.pool) => Why::OfDevice,
                Body::Plugin { graph: true, .. } if !is_cuda(&source.workload, part.pool) => Why::Captured,
                _ => continue,
            };
            return Err(BodiesError::of(source, task, number, &name, why));
        }
    }
    Ok(())
}

/// How a body ended; a failure without an error was told before.
type Ran = Result<(), Option<BodyError>>;

/// An instance of a body, for one lane.
enum Run {
    Spin(Spin),
    Network {
        instance: Box<dyn Instance>,
        input: Vec<f32>,
        output: Vec<f32>,
    },
    Plugin(PluginBody),
    /// Could not be instantiated: on a spare thread, for a run does not start so. Its jobs fail.
    Broken,
}

/// One lane's instances: of a node, or of the encoder and then the decoders of a whole stage.
struct LaneBodies {
    bodies: Arc<Bodies>,
    lane: usize,
    /// What the times of work count from, for bodies that are told times of the clock.
    origin_ns: u64,
    runs: Vec<Vec<Vec<Run>>>,
    scene: Scene,
    image: Vec<f32>,
    /// The frame in `image`: its number, and whether the obstacle is in it.
    seen: Option<(u64, bool)>,
}

impl Handler for LaneBodies {
    fn prepare(&mut self) {
        let make = |loaded: &Loaded| {
            Run::of(loaded, self.lane).unwrap_or_else(|error| {
                let words = format!("on lane {}: {}", self.lane, error.told(shown, shown_path));
                self.bodies.broken.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(words);
                Run::Broken
            })
        };
        let of_node = |node: &Node| match node {
            Node::Plain(one) | Node::Encoder(one) | Node::Decoder(one) => vec![make(one)],
            Node::Coarse(encoder, decoders) => std::iter::once(encoder).chain(decoders).map(make).collect(),
            Node::Device => Vec::new(),
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
        drop(std::hint::black_box(vec![1_u8; HEAP_RESERVE]));
    }

    fn begin(&mut self, origin_ns: u64) {
        self.origin_ns = origin_ns;
    }

    fn run(&mut self, work: &Work) -> Result<(), Failed> {
        self.execute(work).map_err(|error| {
            // Nobody waits here: of two lanes that fail at once, one is heard.
            if let (Some(error), Ok(mut said)) = (error, self.bodies.said.try_lock()) {
                faults::say(&mut said, (work.task.index(), work.job, work.node.index(), error.into()));
            }
            Failed
        })
    }
}

impl Run {
    fn of(loaded: &Loaded, lane: usize) -> Result<Self, BodyError> {
        match loaded {
            Loaded::Spin(duration_ns) => Ok(Self::Spin(Spin::new(*duration_ns))),
            Loaded::Network(network) => network.instance().map(|instance| Self::Network {
                instance,
                input: vec![0.5; network.input_len()],
                output: vec![0.0; network.output_len()],
            }),
            Loaded::Plugin(plugin) => {
                plugin.instance(u32::try_from(lane).unwrap_or(u32::MAX)).map(Self::Plugin)
            }
        }
    }

    /// Runs on `given`, or on an input of its own where that has another size.
    fn step(&mut self, given: Option<&[f32]>, into: Option<&mut [f32]>, call: &Call) -> Ran {
        match self {
            Self::Spin(spin) => spin.run(call).map_err(Some),
            Self::Plugin(plugin) => plugin.run(call).map_err(Some),
            Self::Network { instance, input, output } => {
                let len = input.len();
                let input = given.and_then(|g| g.get(..len)).unwrap_or(input);
                let own = output.len();
                let output = into.and_then(|o| o.get_mut(..own)).unwrap_or(output);
                instance.run(input, output).map_err(Some)
            }
            Self::Broken => Err(None),
        }
    }
}

/// A result, also one with which a body panicked: who writes it next writes all of it. A body beyond its bound may have
/// it still; then this one fails, because it must neither wait nor go on without.
fn held<G>(asked: Option<TryLockResult<G>>) -> Result<Option<G>, Option<BodyError>> {
    match asked {
        None => Ok(None),
        Some(Ok(result)) => Ok(Some(result)),
        Some(Err(TryLockError::Poisoned(result))) => Ok(Some(result.into_inner())),
        Some(Err(TryLockError::WouldBlock)) => Err(None),
    }
}

impl LaneBodies {
    fn execute(&mut self, work: &Work) -> Ran {
        let bodies = self.bodies.clone();
        let node =
            bodies.tasks.get(work.task.index()).and_then(|nodes| nodes.get(work.node.index())).ok_or(None)?;
        if matches!(node, Node::Plain(Loaded::Network(_)) | Node::Encoder(_) | Node::Coarse(..)) {
            self.look(work)?;
        }
        let call = Call {
            now_ns: now_ns(),
            release_ns: self.origin_ns.saturating_add(work.release_ns),
            deadline_ns: self.origin_ns.saturating_add(work.deadline_ns),
            job: work.job,
            task: work.task.index() as u32,
            lane: u32::try_from(self.lane).unwrap_or(u32::MAX),
        };
        let result = work.output.and_then(|number| bodies.results.get(usize::from(number)));
        let runs = self
            .runs
            .get_mut(work.task.index())
            .and_then(|nodes| nodes.get_mut(work.node.index()))
            .ok_or(None)?;
        let (first, rest) = runs.split_first_mut().ok_or(None)?;
        match node {
            Node::Plain(_) => first.step(Some(&self.image), None, &call),
            Node::Encoder(_) => {
                let mut result = held(result.map(RwLock::try_write))?;
                first.step(Some(&self.image), result.as_mut().map(|r| r.as_mut_slice()), &call)
            }
            Node::Decoder(_) => {
                let result = held(result.map(RwLock::try_read))?;
                first.step(result.as_ref().map(|r| r.as_slice()), None, &call)
            }
            Node::Coarse(..) => {
                first.step(Some(&self.image), None, &call)?;
                let features =
                    if let Run::Network { output, .. } = first { Some(output.as_slice()) } else { None };
                rest.iter_mut().try_for_each(|decoder| decoder.step(features, None, &call))
            }
            Node::Device => Err(None),
        }
    }

    /// The camera: draws the road as it is at the job's release, unless this lane has that frame already.
    fn look(&mut self, work: &Work) -> Ran {
        let obstacle =
            self.bodies.obstacle_ns.is_some_and(|(from, until)| (from..until).contains(&work.release_ns));
        let frame = (work.job, obstacle);
        if self.seen != Some(frame) {
            self.scene.draw(work.job, obstacle, &mut self.image).map_err(Some)?;
            self.seen = Some(frame);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
