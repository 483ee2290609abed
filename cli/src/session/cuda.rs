//! Pools of kind `cuda`: their device, and the bodies of their nodes, each lane with memory of its own.
//!
//! Everything is loaded, allocated and run once before real time starts, because the first use of anything may make the
//! whole device wait.

mod load;
mod step;
mod warm_up;

use super::faults::{self, Fault, Said};
use super::{Robot, SessionError};
use red_bodies::Call;
use red_bodies::scene::Scene;
use red_core::PoolId;
use red_cuda::{Buffer, CudaError, Device, Kind, Stream};
use red_rt::clock::now_ns;
use red_rt::control::Control;
use red_rt::cuda::{self, Bodies, Cuda, CudaFigures, Handlers, NotSubmitted};
use red_rt::handler::{Handler, Work};
use red_rt::report::RunReport;
use red_rt::stop::StopSignals;
use red_rt::utilisation::{self, OWN_ACCOUNTING, Observer, Utilisation};
use red_workload::model::{PoolKind, Workload};
use serde::Serialize;
use std::fmt;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use step::Step;

/// The device of a workload's CUDA pools, and what its lanes run.
pub(crate) struct CudaPools {
    cuda: Cuda,
    /// The first of them.
    pool: String,
    /// All of them.
    pools: Vec<PoolId>,
    /// Their lanes over all pools, a bit each.
    lanes: u32,
    handlers: Option<Handlers>,
    said: Arc<Mutex<Vec<Said>>>,
    /// Of whoever wants an end while it is loaded.
    signals: StopSignals,
}

impl fmt::Debug for CudaPools {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("CudaPools").field("lanes", &self.lanes).finish_non_exhaustive()
    }
}

/// What the streams of a run did.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct CudaSummary {
    /// Waits of a stream for an event of another.
    pub(crate) event_waits_issued: u64,
    /// Predecessors on the device that needed no such wait.
    pub(crate) event_waits_avoided: u64,
    /// Units that were given to their streams while their predecessors ran.
    pub(crate) submissions_ahead: u64,
    /// Bytes of the device's memory that buffers took, at their highest.
    pub(crate) device_memory_bytes: u64,
    /// What was allocated or loaded on the device after the start.
    pub(crate) late_allocations: u64,
    /// How much less of its memory is free at the end than at the start, whoever took it.
    pub(crate) late_memory_bytes: u64,
    /// Who says how much the device is used, besides the scheduler's own accounting, and the most that it said, in parts per
    /// million.
    pub(crate) utilisation_source: &'static str,
    pub(crate) utilisation_max_ppm: Option<u32>,
    /// The error that ended the device's context.
    pub(crate) device_lost: Option<String>,
    /// Pools that are lost: their device is, or none of their streams comes to its end.
    pub(crate) pools_lost: Vec<String>,
    /// Lanes that left their streams.
    #[serde(skip)]
    pub(crate) lanes_left: u64,
    /// Whether the device itself is gone, and not only the context.
    #[serde(skip)]
    pub(crate) is_gone: bool,
}

/// Lanes that are streams, with their bodies.
pub(crate) type Streams = Vec<(usize, Box<dyn Bodies>)>;

/// Whether a pool's lanes are streams.
pub(crate) fn is_cuda(workload: &Workload, pool: usize) -> bool {
    workload.pools.get(pool).is_some_and(|pool| pool.kind == PoolKind::Cuda)
}

/// Lanes of a pool, over all pools.
fn lanes_of(workload: &Workload, pool: usize) -> impl Iterator<Item = usize> + use<> {
    let lanes = |pools: &[red_workload::model::Pool]| pools.iter().map(|pool| pool.lanes as usize).sum();
    let first: usize = lanes(&workload.pools[..pool]);
    first..first + workload.pools[pool].lanes as usize
}

impl CudaPools {
    /// Opens the device, if a pool needs one.
    ///
    /// # Errors
    /// [`SessionError::Cuda`].
    pub(crate) fn open(workload: &Workload) -> Result<Option<Self>, SessionError> {
        let pools = || (0..workload.pools.len()).filter(|pool| is_cuda(workload, *pool));
        let Some(first) = pools().next() else { return Ok(None) };
        let lanes = pools().flat_map(|pool| lanes_of(workload, pool)).fold(0, |set, lane| set | 1 << lane);
        let pool = workload.pools[first].name.clone();
        let cuda = cuda::open(0).and_then(|device| Ok(Cuda::new(device, lanes)?));
        let cuda = cuda.map_err(|why| SessionError::Cuda { pool: pool.clone(), why })?;
        let refused = |error: CudaError| SessionError::Cuda { pool: pool.clone(), why: error.into() };
        let (free, total) = cuda.device().memory().map_err(refused)?;
        for pool in pools().map(|pool| &workload.pools[pool]) {
            // Footprints are kept within it as the run goes on, which is worth nothing if it is not there.
            if let Some(budget) = pool.memory_bytes.filter(|budget| *budget > free as u64) {
                let bytes = [budget, free as u64, total as u64];
                return Err(SessionError::DeviceMemory { pool: pool.name.clone(), bytes });
            }
        }
        let said = Arc::new(Mutex::new(faults::table()));
        let signals = StopSignals::install()?;
        let pools = pools().map(|pool| PoolId::new(pool as u8)).collect();
        Ok(Some(Self { cuda, pool, pools, lanes, handlers: None, said, signals }))
    }

    /// The device, and a stream as its lanes have them.
    ///
    /// # Errors
    /// [`SessionError::Cuda`].
    pub(crate) fn stream(&self) -> Result<(&Device, Stream), SessionError> {
        let stream = self.cuda.stream().map_err(|error| self.refused(error))?;
        Ok((self.cuda.device(), stream))
    }

    /// The device's name.
    pub(crate) fn device_name(&self) -> &str {
        self.cuda.device().name()
    }

    /// Lanes whose handlers have streams, a bit each.
    pub(crate) const fn lanes(&self) -> u32 {
        self.lanes
    }

    /// The handler of a lane, if it has a stream.
    pub(crate) fn handler(&self, lane: usize) -> Option<Box<dyn Handler>> {
        self.handlers.as_ref()?.take(lane)
    }

    /// What knows how much the device is used, also by others. To be asked for before the run.
    pub(crate) fn utilisation(&self) -> Option<Box<dyn Utilisation>> {
        utilisation::of_device(self.cuda.device(), Path::new("/"))
    }

    /// Has the scheduler told of it.
    pub(crate) fn observe(
        &self,
        control: Arc<dyn Control<Robot>>,
        source: Box<dyn Utilisation>,
    ) -> Option<Observer> {
        Observer::start(control, self.pools.clone(), source)
    }

    /// What bodies said of their failures.
    pub(crate) fn said(&self) -> Vec<Said> {
        std::mem::take(&mut *self.said.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// What the streams did.
    pub(crate) fn summary(
        &self,
        workload: &Workload,
        run: &RunReport,
        used: Option<&Observer>,
    ) -> CudaSummary {
        let CudaFigures {
            event_waits_issued,
            event_waits_avoided,
            device_memory_bytes,
            late_allocations,
            late_memory_bytes,
        } = self.cuda.figures();
        let lost = self.cuda.lost();
        let pools_lost =
            workload.pools.iter().enumerate().filter(|(pool, _)| run.pools_lost >> pool & 1 != 0);
        CudaSummary {
            event_waits_issued,
            event_waits_avoided,
            submissions_ahead: run.ahead,
            device_memory_bytes,
            late_allocations,
            late_memory_bytes,
            utilisation_source: used.map_or(OWN_ACCOUNTING, Observer::source),
            utilisation_max_ppm: used.map(|used| used.highest().0),
            device_lost: lost.map(|error| error.to_string()),
            pools_lost: pools_lost.map(|(_, pool)| pool.name.clone()).collect(),
            lanes_left: run.streams_left,
            is_gone: lost.is_some_and(|error| error.kind() == Kind::Lost),
        }
    }
}

/// Results of encoders, by number, shared by the lanes: the streams order who writes and who reads.
type Results = Arc<Vec<Buffer>>;

/// One lane's bodies: of a node, or of the encoder and then the decoders of a whole stage.
struct LaneBodies {
    lane: usize,
    origin_ns: u64,
    /// By task and node.
    steps: Vec<Vec<Vec<Step>>>,
    results: Results,
    said: Arc<Mutex<Vec<Said>>>,
    obstacle_ns: Option<(u64, u64)>,
    scene: Scene,
    image: Vec<f32>,
    /// The frame in `image`: its number, and whether the obstacle is in it.
    seen: Option<(u64, bool)>,
}

impl Bodies for LaneBodies {
    fn begin(&mut self, origin_ns: u64) {
        self.origin_ns = origin_ns;
    }

    fn submit(&mut self, work: &Work, stream: &Stream) -> Result<(), NotSubmitted> {
        let (task, node) = (work.task.index(), work.node.index());
        let call = Call {
            now_ns: now_ns(),
            release_ns: self.origin_ns.saturating_add(work.release_ns),
            deadline_ns: self.origin_ns.saturating_add(work.deadline_ns),
            job: work.job,
            task: task as u32,
            lane: u32::try_from(self.lane).unwrap_or(u32::MAX),
        };
        let result = work.output.map(usize::from);
        let result = result.and_then(|number| Some((number, self.results.get(number)?.address())));
        let Self { steps, said, scene, image, seen, obstacle_ns, .. } = self;
        let steps = steps.get_mut(task).and_then(|nodes| nodes.get_mut(node)).ok_or(NotSubmitted::Body)?;
        for step in steps {
            if step.wants_image() {
                let obstacle =
                    obstacle_ns.is_some_and(|(from, until)| (from..until).contains(&work.release_ns));
                if *seen != Some((work.job, obstacle)) {
                    scene.draw(work.job, obstacle, image).map_err(|_| NotSubmitted::Body)?;
                    *seen = Some((work.job, obstacle));
                }
            }
            step.submit(&call, result, image, stream).map_err(|fault| {
                let answer = match &fault {
                    Fault::Device(error) => NotSubmitted::Driver(*error),
                    Fault::Body(_) => NotSubmitted::Body,
                };
                // Nobody waits here: of two lanes that fail at once, one is heard.
                if let Ok(mut said) = said.try_lock() {
                    faults::say(&mut said, (task, work.job, node, fault));
                }
                answer
            })?;
        }
        Ok(())
    }
}
