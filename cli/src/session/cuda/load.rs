//! Loading: modules once, and for each lane the memory of each node, which everything runs in once.

use super::step::{KernelStep, Step};
use super::{CudaPools, LaneBodies, Results, Streams, is_cuda, lanes_of};
use crate::session::SessionError;
use crate::session::bodies::{BodiesError, FRAME, Why};
use red_bodies::plugin::{Host as PluginHost, Plugin};
use red_bodies::scene::Scene;
use red_bodies::{SPIN_PTX, contents, within};
use red_cuda::{Arguments, Buffer, CudaError, Device, Kernel, Kind, Module};
use red_rt::cuda::Bodies;
use red_workload::Source;
use red_workload::build::{Numbered, Role};
use red_workload::model::{Argument, Arrival, Body, Part};
use std::collections::HashMap;
use std::ffi::CString;
use std::path::PathBuf;
use std::sync::Arc;

/// Largest module, in bytes.
const MOST_MODULE_BYTES: u64 = 256 << 20;
/// Results that may be kept at a time, at most.
const MOST_RESULTS: u64 = 256;

/// A body, before it is a lane's.
enum Loaded {
    Kernel {
        module: Module,
        kernel: CString,
        grid: [u32; 3],
        block: [u32; 3],
        args: Vec<Argument>,
        graph: bool,
    },
    Plugin {
        plugin: Plugin,
        graph: bool,
    },
}

/// What is loaded so far, and where.
pub(super) struct Loader<'a> {
    pub(super) pools: &'a CudaPools,
    source: &'a Source,
    host: &'a Arc<PluginHost>,
    modules: HashMap<PathBuf, Module>,
    spin: Option<Module>,
    pub(super) results: Results,
    task: usize,
    part: usize,
}

impl CudaPools {
    /// Loads the bodies of all nodes in CUDA pools, for each of their lanes, and runs the kernels once. The lanes that are
    /// streams, with their bodies.
    ///
    /// # Errors
    /// [`BodiesError`], for the first node that cannot run.
    pub(crate) fn load(
        &self,
        source: &Source,
        nodes: &[Vec<Numbered>],
        host: &Arc<PluginHost>,
        obstacle_ns: Option<(u64, u64)>,
    ) -> Result<Streams, SessionError> {
        let workload = &source.workload;
        let results = Results::new(results(self, source, nodes).map_err(|error| self.refused(error))?);
        let lanes: usize = workload.pools.iter().map(|pool| pool.lanes as usize).sum();
        let mut of_lanes: Vec<Vec<Vec<Vec<Step>>>> = (0..lanes)
            .map(|_| nodes.iter().map(|nodes| nodes.iter().map(|_| Vec::new()).collect()).collect())
            .collect();
        let (modules, results) = (HashMap::new(), results);
        let mut loader = Loader { pools: self, source, host, modules, spin: None, results, task: 0, part: 0 };
        for (task, of_task) in nodes.iter().enumerate() {
            (loader.task, loader.part) = (task, 0);
            for (node, numbered) in of_task.iter().enumerate() {
                for (name, part, pool) in parts(numbered) {
                    if is_cuda(workload, pool) {
                        loader.fits(part, pool, &name)?;
                        loader.agrees(part, encoder_of(numbered, of_task), &name)?;
                        let loaded = loader.load(part, &name)?;
                        let is_whole = matches!(numbered.role, Role::Coarse(_));
                        for lane in lanes_of(workload, pool) {
                            let steps = &mut of_lanes[lane][task][node];
                            let own = if is_whole { loader.own_result(steps, part, &name)? } else { None };
                            steps.push(loader.instance(&loaded, lane, own, &name)?);
                        }
                    }
                    loader.part += 1;
                }
            }
        }
        let of_streams = of_lanes.into_iter().enumerate().filter(|(lane, _)| self.lanes >> lane & 1 != 0);
        let bodies = of_streams.map(|(lane, steps)| {
            let scene = Scene::new(FRAME.0, FRAME.1);
            let image = vec![0.0; scene.len()];
            let said = self.said.clone();
            let bodies = LaneBodies {
                lane,
                origin_ns: 0,
                steps,
                results: loader.results.clone(),
                said,
                obstacle_ns,
                scene,
                image,
                seen: None,
            };
            (lane, Box::new(bodies) as Box<dyn Bodies>)
        });
        Ok(bodies.collect())
    }

    /// Has lanes run these bodies.
    ///
    /// # Errors
    /// [`SessionError::Cuda`].
    pub(crate) fn give(&mut self, bodies: Streams) -> Result<(), SessionError> {
        let handlers = self.cuda.handlers(bodies.into_iter()).map_err(|error| self.refused(error))?;
        self.handlers = Some(handlers);
        Ok(())
    }

    pub(crate) fn refused(&self, error: CudaError) -> SessionError {
        SessionError::Cuda { pool: self.pool.clone(), why: error.into() }
    }
}

/// The parts that a node executes in their order, with their names and where they run: a whole stage runs in the pool of
/// its encoder.
fn parts(numbered: &Numbered) -> Vec<(String, &Part, usize)> {
    match &numbered.role {
        Role::Plain(part) | Role::Encoder { part, .. } | Role::Decoder { part, .. } => {
            vec![(numbered.name.clone(), part, part.pool)]
        }
        Role::Coarse(stage) => {
            let named = |name: &str| format!("{}.{name}", numbered.name);
            let decoders = stage.decoders.iter().map(|(name, part)| (named(name), part, stage.encoder.pool));
            std::iter::once((named("encoder"), &stage.encoder, stage.encoder.pool)).chain(decoders).collect()
        }
    }
}

/// The encoder whose result a node may have: of a decoder that of another node, of all others their own, if they have one.
fn encoder_of<'n>(numbered: &'n Numbered, of_task: &'n [Numbered]) -> Option<&'n Part> {
    match &numbered.role {
        Role::Plain(_) => None,
        Role::Encoder { part, .. } => Some(part),
        Role::Decoder { encoder, .. } => {
            of_task.get(*encoder).and_then(|encoder| encoder_of(encoder, of_task))
        }
        Role::Coarse(stage) => Some(&stage.encoder),
    }
}

/// Bytes of the results that a body writes or reads.
fn result_bytes(part: &Part) -> Option<u64> {
    let Body::Cuda { args, .. } = &part.body else { return None };
    args.iter().filter_map(|arg| if let Argument::Result(bytes) = arg { Some(*bytes) } else { None }).max()
}

/// Memory for as many results as there may be at a time, if bodies have any: of each encoder one for each of its task's
/// jobs in flight, and one more for each lane.
fn results(pools: &CudaPools, source: &Source, nodes: &[Vec<Numbered>]) -> Result<Vec<Buffer>, CudaError> {
    let (mut largest, mut count) = (0, u64::from(pools.lanes.count_ones()));
    for (task, nodes) in source.workload.tasks.iter().zip(nodes) {
        let period = match task.arrival {
            Arrival::Periodic { period_ns: t } | Arrival::Sporadic { min_interarrival_ns: t } => t.max(1),
            Arrival::Once => u64::MAX,
        };
        let encoders = nodes.iter().filter(|node| matches!(node.role, Role::Encoder { .. })).count() as u64;
        count = count.saturating_add(encoders.saturating_mul((task.deadline_ns / period).saturating_add(2)));
        let of_node =
            |node: &Numbered| parts(node).iter().filter_map(|(_, part, _)| result_bytes(part)).max();
        largest = largest.max(nodes.iter().filter_map(of_node).max().unwrap_or(0));
    }
    let count = if largest == 0 { 0 } else { count.min(MOST_RESULTS) };
    (0..count).map(|_| buffer(pools.cuda.device(), largest)).collect()
}

fn buffer(device: &Device, bytes: u64) -> Result<Buffer, CudaError> {
    // More than an address has is more than the device has.
    device.buffer(usize::try_from(bytes).unwrap_or(usize::MAX))
}

impl Loader<'_> {
    /// Refuses a part that takes more of the device than it says, where that counts.
    fn fits(&self, part: &Part, pool: usize, name: &str) -> Result<(), BodiesError> {
        let Body::Cuda { args, .. } = &part.body else { return Ok(()) };
        let bytes = args.iter().map(|arg| match arg {
            Argument::Number(_) => 0,
            Argument::Input(bytes)
            | Argument::Output(bytes)
            | Argument::Scratch(bytes)
            | Argument::Result(bytes) => *bytes,
        });
        let (takes, says) = (bytes.fold(0, u64::saturating_add), part.memory_bytes);
        let has_budget = self.source.workload.pools[pool].memory_bytes.is_some();
        if has_budget && takes > says {
            return Err(self.refused(name, Why::Footprint { takes, says }));
        }
        Ok(())
    }

    /// Refuses a part that has a result of another size than its encoder writes.
    fn agrees(&self, part: &Part, encoder: Option<&Part>, name: &str) -> Result<(), BodiesError> {
        let Some(reads) = result_bytes(part) else { return Ok(()) };
        match encoder.map(result_bytes) {
            None => Err(self.refused(name, Why::NoStage)),
            Some(writes) if writes != Some(reads) => Err(self.refused(name, Why::Result { reads, writes })),
            Some(_) => Ok(()),
        }
    }

    /// Loads a part's body.
    fn load(&mut self, part: &Part, name: &str) -> Result<Loaded, BodiesError> {
        let loaded = match &part.body {
            Body::None => Err(Why::NoBody),
            Body::Onnx { .. } => Err(Why::OfHost),
            Body::Spin { duration_ns } => self.spin(*duration_ns),
            Body::Plugin { path, symbol, graph } => within(self.source.folder(), path.as_ref())
                .and_then(|path| Plugin::load(&path, symbol, self.host))
                .map(|plugin| Loaded::Plugin { plugin, graph: *graph })
                .map_err(Why::Load),
            Body::Cuda { module, kernel, grid, block, args, graph } => {
                self.module(module).map(|module| Loaded::Kernel {
                    module,
                    kernel: CString::new(kernel.as_str()).unwrap_or_default(),
                    grid: *grid,
                    block: *block,
                    args: args.clone(),
                    graph: *graph,
                })
            }
        };
        loaded.map_err(|why| self.refused(name, why))
    }

    fn spin(&mut self, duration_ns: u64) -> Result<Loaded, Why> {
        let module = match &self.spin {
            Some(module) => module.clone(),
            None => self
                .pools
                .cuda
                .device()
                .module(SPIN_PTX.as_bytes())
                .map_err(|e| Why::Module(e.to_string()))?,
        };
        self.spin = Some(module.clone());
        let args = vec![Argument::Number(duration_ns)];
        let kernel = c"red_spin".to_owned();
        Ok(Loaded::Kernel { module, kernel, grid: [1; 3], block: [1; 3], args, graph: false })
    }

    fn module(&mut self, path: &str) -> Result<Module, Why> {
        let path = within(self.source.folder(), path.as_ref()).map_err(Why::Load)?;
        if let Some(module) = self.modules.get(&path) {
            return Ok(module.clone());
        }
        let image = contents(&path, MOST_MODULE_BYTES).map_err(Why::Load)?;
        let module =
            self.pools.cuda.device().module(&image).map_err(|error| Why::Module(error.to_string()))?;
        self.modules.insert(path, module.clone());
        Ok(module)
    }

    /// The result that parts of a whole stage hand on: what the first of them has, which is the encoder.
    fn own_result(
        &self,
        before: &[Step],
        part: &Part,
        name: &str,
    ) -> Result<Option<Arc<Buffer>>, BodiesError> {
        let of_encoder = before.first().and_then(Step::own_result);
        let Some(bytes) = result_bytes(part).filter(|_| of_encoder.is_none()) else { return Ok(of_encoder) };
        let made = buffer(self.pools.cuda.device(), bytes);
        made.map(|made| Some(Arc::new(made))).map_err(|error| self.refused(name, self.why(&error)))
    }

    /// A lane's own, which ran once if it is a kernel.
    fn instance(
        &self,
        loaded: &Loaded,
        lane: usize,
        own_result: Option<Arc<Buffer>>,
        name: &str,
    ) -> Result<Step, BodiesError> {
        let refused = |why| self.refused(name, why);
        let (step, graph) = match loaded {
            Loaded::Plugin { plugin, graph } => {
                let made = plugin.instance(u32::try_from(lane).unwrap_or(u32::MAX));
                (made.map(Step::Plugin).map_err(|error| refused(Why::Load(error)))?, *graph)
            }
            Loaded::Kernel { module, kernel, grid, block, args, graph } => {
                let found = module.kernel(kernel, *grid, *block);
                let kernel =
                    found.map_err(|_| refused(Why::Kernel(kernel.to_string_lossy().into_owned())))?;
                let step = self.kernel(kernel, args, own_result);
                let step = step.map_err(|error| self.why(&error)).and_then(|step| self.warm_up(step));
                (step.map(Step::Kernel).map_err(refused)?, *graph)
            }
        };
        if graph { self.graphs(step).map_err(refused) } else { Ok(step) }
    }

    fn kernel(
        &self,
        kernel: Kernel,
        args: &[Argument],
        own_result: Option<Arc<Buffer>>,
    ) -> Result<Box<KernelStep>, CudaError> {
        let device = self.pools.cuda.device();
        let pinned = |bytes: u64| device.pinned(usize::try_from(bytes).unwrap_or(usize::MAX));
        let mut step = KernelStep {
            kernel,
            arguments: Arguments::new(args.len()),
            inputs: Vec::new(),
            turn: 0,
            outputs: Vec::new(),
            scratch: Vec::new(),
            results: Vec::new(),
            own_result,
        };
        for (at, arg) in args.iter().enumerate() {
            let bits = match *arg {
                Argument::Number(bits) => bits,
                Argument::Input(bytes) => {
                    let stages = [pinned(bytes)?, pinned(bytes)?, pinned(bytes)?, pinned(bytes)?];
                    step.inputs.push((stages, buffer(device, bytes)?));
                    step.inputs.last().map_or(0, |(_, there)| there.address())
                }
                Argument::Output(bytes) => {
                    step.outputs.push((buffer(device, bytes)?, pinned(bytes)?));
                    step.outputs.last().map_or(0, |(there, _)| there.address())
                }
                Argument::Scratch(bytes) => {
                    step.scratch.push(buffer(device, bytes)?);
                    step.scratch.last().map_or(0, Buffer::address)
                }
                Argument::Result(_) => {
                    step.results.push(at);
                    0
                }
            };
            step.arguments.set(at, bits);
        }
        Ok(Box::new(step))
    }

    /// What an error of the driver means for a body.
    pub(super) fn why(&self, error: &CudaError) -> Why {
        let free = self.pools.cuda.device().memory().ok();
        let cure = match error.kind() {
            Kind::OutOfMemory => "end what else uses the device",
            Kind::Poisoned => "mend the kernel, or what its arguments say of the memory that it uses",
            Kind::Lost => "look at `nvidia-smi`",
            _ => "look at grid, block and args: what the device can is told by `nvidia-smi -q`, deviceQuery",
        };
        Why::Device {
            error: error.to_string(),
            cure,
            memory: free.filter(|_| error.kind() == Kind::OutOfMemory),
        }
    }

    /// A refusal of the part that is being loaded.
    fn refused(&self, name: &str, why: Why) -> BodiesError {
        BodiesError::of(self.source, self.task, self.part, name, why)
    }
}
