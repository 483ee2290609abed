//! One run of a workload in real time: bodies, lanes, notes, figures. `run` and `demo` both drive it.

pub(crate) mod bodies;
pub(crate) mod cuda;
mod drift;
mod error;
mod faults;
pub(crate) mod host;
pub(crate) mod record;
mod sub_deadlines;
mod summary;
pub(crate) mod trace;

use crate::denied::Denied;
use crate::place::Place;
use bodies::Bodies;
use cuda::CudaPools;
use drift::Costs;
pub(crate) use error::SessionError;
use faults::Names;
use host::{Live, Notes};
use record::{ClosedLog, Recording};
use red_bodies::onnx::on_lane;
use red_bodies::plugin::Host as PluginHost;
use red_core::{Config, Empty, PoolId, Scheduler, TaskId};
use red_record::Recorder;
use red_rt::control::Control;
use red_rt::placement::{choose_cpus, usable_cpus};
use red_rt::runtime::{Handlers, Mode, Setup, run};
use red_rt::setup::SetupError;
use red_rt::stop::{StopBy, StopSignals};
use red_rt::timeline::Releases;
use red_workload::Source;
use red_workload::build::{self, Numbered};
use red_workload::model::{Arrival, Workload};
use red_workload::policy::Policy;
use std::sync::{Arc, OnceLock};
use sub_deadlines::SubDeadlines;
pub(crate) use summary::RunSummary;
use summary::summary;

/// Capacities of a run: the limits of a workload file.
pub(crate) type Robot = red_core::Caps<16, 256, 64, 32, 32, 4, 4096>;

/// Priority of the lanes: above the kernel's threaded interrupts at 50, below its watchdogs at 99.
pub(crate) const PRIORITY: u8 = 70;
/// Events that a trace keeps at most.
const TRACE_EVENTS: usize = 2_000_000;

/// What to run, and how.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Options<'a> {
    /// Policy.
    pub(crate) policy: Policy,
    /// Releases stop after this.
    pub(crate) duration_ns: u64,
    /// Go on without real-time rights.
    pub(crate) best_effort: bool,
    /// Whether to keep events for a trace.
    pub(crate) trace: bool,
    /// Where every input of the scheduler goes.
    pub(crate) record: Option<&'a Place>,
    /// While an obstacle is in sight of the generated camera: from, until.
    pub(crate) obstacle_ns: Option<(u64, u64)>,
}

/// A finished run: its figures, and what a trace is made from.
#[derive(Debug)]
pub(crate) struct Session {
    /// Figures.
    pub(crate) summary: RunSummary,
    /// Notes.
    pub(crate) notes: Notes,
    /// Numbered nodes of each task.
    pub(crate) nodes: Vec<Vec<Numbered>>,
    /// Edges of each task by node number.
    pub(crate) edges: Vec<Vec<(usize, usize)>>,
    /// Names of the tasks.
    pub(crate) tasks: Vec<String>,
    /// Graph edits of each task in words, in their order.
    pub(crate) edits: Vec<Vec<String>>,
    /// Row titles of the lanes.
    pub(crate) lanes: Vec<String>,
    /// Bodies that failed, in words.
    pub(crate) faults: Vec<String>,
    /// Bodies that did not return within their bounds.
    pub(crate) hung: u64,
    /// Units that did not come to their ends on their streams, in words.
    pub(crate) stream_hangs: Vec<String>,
    /// Sub-deadlines of what ran; empty where no trace was asked for.
    pub(crate) sub_deadlines: Arc<SubDeadlines>,
    /// The log, if the run was recorded.
    pub(crate) record: Option<ClosedLog>,
    /// When it ended.
    pub(crate) end_ns: u64,
    /// To the end of whoever has the run: no Ctrl-C costs its summary.
    _signals: StopSignals,
}

/// CPUs for the lanes, or why they cannot be real-time lanes.
fn place(workload: &Workload, lanes: usize) -> Result<Vec<usize>, SetupError> {
    let usable = usable_cpus()?;
    let wanted: Vec<usize> = workload.pools.iter().flat_map(|p| p.cpus.iter().map(|c| *c as usize)).collect();
    if wanted.is_empty() {
        return choose_cpus(lanes, &usable);
    }
    let missing = wanted.iter().find(|cpu| !usable.contains(cpu));
    if let Some(cpu) = missing {
        return Err(SetupError::CpuNotUsable { cpu: *cpu, usable });
    }
    let mut cpus = Vec::new();
    for pool in &workload.pools {
        let free = |cpu: &&usize| !wanted.contains(cpu);
        let rest: Vec<usize> = usable.iter().filter(free).copied().collect();
        let own = pool.cpus.iter().map(|c| *c as usize).chain(rest).filter(|c| !cpus.contains(c));
        let own: Vec<usize> = own.take(pool.lanes as usize).collect();
        cpus.extend(own);
    }
    if cpus.len() < lanes { Err(SetupError::MoreLanesThanCpus { lanes, usable }) } else { Ok(cpus) }
}

/// Whether a run goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Progress {
    /// It does.
    Running,
    /// Its lanes have ended.
    Ended,
}

/// Runs a workload. `progress` is called about ten times a second, and once at the end, with the time since the start
/// and the live counters; `ready` once, with the mode that the lanes got, before time starts.
///
/// # Errors
/// [`SessionError`]; nothing ran then.
pub(crate) fn execute(
    source: &Source,
    options: &Options<'_>,
    ready: impl FnOnce(&Mode, &[Vec<Numbered>], Option<&Denied>),
    mut progress: impl FnMut(Progress, u64, &Live),
) -> Result<Session, SessionError> {
    let workload = &source.workload;
    // Before the bodies are loaded, which takes a while.
    let _signals = StopSignals::install()?;
    // What the machine lacks comes before what its bodies lack, which may not matter then.
    let mut cuda = CudaPools::open(workload)?;
    let mut scheduler: Box<Scheduler<Robot>> = Box::new(Scheduler::EMPTY);
    let config = Config { ..options.policy.config() };
    let (plan, tasks) = build::admit(&mut scheduler, workload, config).map_err(SessionError::Build)?;
    let names: Vec<String> = workload.tasks.iter().map(|t| t.name.clone()).collect();
    let control: Arc<OnceLock<Arc<dyn Control<Robot>>>> = Arc::new(OnceLock::new());
    let host = plugin_host(&control, &tasks);
    let bodies = Bodies::load(source, &plan.nodes, &host, options.obstacle_ns);
    let bodies = Arc::new(bodies.map_err(SessionError::Bodies)?);
    if let Some(cuda) = &mut cuda {
        cuda.give(cuda.load(source, &plan.nodes, &host, options.obstacle_ns)?)?;
    }
    let cuda = cuda.map(Arc::new);
    let utilisation = cuda.as_ref().and_then(|cuda| cuda.utilisation());
    let lanes: usize = workload.pools.iter().map(|p| p.lanes as usize).sum();
    let (mode, why) = mode(workload, lanes, options.best_effort).map_err(SessionError::Machine)?;
    ready(&mode, &plan.nodes, why.as_ref());

    let live = Live::new(lanes);
    let (edges, edits) = (all_edges(&plan), edits(&plan));
    let deadlines: Vec<u64> = workload.tasks.iter().map(|t| t.deadline_ns).collect();
    let drain_ns = deadlines.iter().copied().max().unwrap_or(0);
    let jobs: Vec<usize> = workload.tasks.iter().map(|t| jobs_of(&t.arrival, options.duration_ns)).collect();
    let events = if options.trace { TRACE_EVENTS } else { 0 };
    // A unit has two events at least.
    let sub_deadlines = SubDeadlines::new(lanes, events / 2);
    let costs = Costs::new(lanes, &plan.nodes);
    let notes = Notes::new(tasks.clone(), deadlines, plan.changes, &jobs, events, costs, live.clone());
    let (record, mut tape) = Recording::start(source, options, &mode)?.unzip();
    for pool in (0..workload.pools.len()).filter(|pool| cuda::is_cuda(workload, *pool)) {
        // Not where the policy opens graphs level by level: nothing is ahead there.
        Recorder::new(&mut scheduler, tape.as_mut()).dispatch_ahead(PoolId::new(pool as u8));
    }
    let setup = Setup {
        scheduler,
        lanes,
        streams: cuda.as_ref().map_or(0, |cuda| cuda.lanes()),
        mode,
        releases: releases(workload, &tasks),
        duration_ns: options.duration_ns,
        drain_ns,
        stop: StopBy::Signals,
        tape,
        handlers: handlers(bodies.clone(), cuda.clone(), options.trace.then(|| sub_deadlines.clone())),
        enclose: Arc::new(|main| {
            // What keeps a lane's thread from starting is told by the lanes that never report.
            if let Err(e) = on_lane(main) {
                eprintln!("redrt: {e}");
            }
        }),
    };
    let mut end_ns = 0;
    let mut observer = None;
    let mut broken = None;
    let started = |running: Arc<dyn Control<Robot>>| {
        // Lanes are there, and none does anything yet.
        broken = bodies.broken();
        if broken.is_some() {
            running.stop();
        }
        observer =
            cuda.as_ref().zip(utilisation).and_then(|(cuda, source)| cuda.observe(running.clone(), source));
        drop(control.set(running));
    };
    let finished = run(setup, notes, started, |now| {
        end_ns = now;
        progress(Progress::Running, now, &live);
    });
    let (notes, figures) = match finished {
        Ok(finished) => finished,
        Err(error) => {
            record.into_iter().for_each(Recording::give_up);
            return Err(error.into());
        }
    };
    let record = record.map(Recording::finish);
    if let Some(words) = broken {
        record.iter().for_each(ClosedLog::withdraw);
        return Err(SessionError::Instance(words));
    }
    progress(Progress::Ended, end_ns, &live);
    let mut summary =
        summary(workload, options, &notes, &figures, record.as_ref().map(ClosedLog::summary), end_ns);
    summary.cost_drift = notes.costs.drifted(&names, &plan.nodes);
    let mut said = bodies.said();
    if let Some(cuda) = &cuda {
        summary.cuda = Some(cuda.summary(workload, &figures, observer.as_ref()));
        said.extend(cuda.said());
    }
    let names_of = Names { tasks: &names, nodes: &plan.nodes };
    let mut faults = notes.faults.words(&names_of, &said, &(&figures).into());
    faults.extend(bodies.broken().map(|words| format!("a body could not be made ready {words}")));
    let titles = lane_titles(workload);
    let stream_hangs =
        figures.stream_hangs.iter().map(|hang| faults::of_stream(&names_of, &titles, hang)).collect();
    Ok(Session {
        summary,
        faults,
        hung: figures.hung - figures.stream_hangs.len() as u64,
        stream_hangs,
        notes,
        nodes: plan.nodes,
        edges,
        tasks: names,
        edits,
        lanes: titles,
        sub_deadlines,
        record,
        end_ns,
        _signals,
    })
}

/// Titles of the lanes, over all pools.
pub(crate) fn lane_titles(workload: &Workload) -> Vec<String> {
    let of_pool = |pool: &red_workload::model::Pool| {
        (0..pool.lanes).map(|lane| format!("{} lane {lane}", pool.name)).collect::<Vec<_>>()
    };
    workload.pools.iter().flat_map(of_pool).collect()
}

/// The bodies of each lane, with notes of their sub-deadlines where somebody reads them.
fn handlers(
    bodies: Arc<Bodies>,
    cuda: Option<Arc<CudaPools>>,
    notes: Option<Arc<SubDeadlines>>,
) -> Arc<Handlers> {
    Arc::new(move |lane| {
        let on_device = cuda.as_ref().and_then(|cuda| cuda.handler(lane));
        let handler = on_device.unwrap_or_else(|| bodies.handler(lane));
        match &notes {
            Some(notes) => notes.of(lane, handler),
            None => handler,
        }
    })
}

/// Real time where the machine grants it; best effort where it does not and that was asked for.
fn mode(workload: &Workload, lanes: usize, best_effort: bool) -> Result<(Mode, Option<Denied>), Denied> {
    let granted = place(workload, lanes).and_then(|cpus| {
        let probe = red_rt::setup::Fifo { priority: PRIORITY, cpu: cpus.first().copied().unwrap_or(0) };
        // Asked for on a thread of its own, so that this one stays as it is.
        let asked = std::thread::spawn(move || probe.apply().and_then(|()| red_rt::setup::lock_memory()));
        asked.join().unwrap_or(Ok(())).map(|()| cpus)
    });
    match granted {
        Ok(cpus) => Ok((Mode::RealTime { priority: PRIORITY, cpus }, None)),
        Err(e) if best_effort => Ok((Mode::BestEffort, Some(e.into()))),
        Err(e) => Err(e.into()),
    }
}

fn plugin_host(control: &Arc<OnceLock<Arc<dyn Control<Robot>>>>, tasks: &[TaskId]) -> Arc<PluginHost> {
    let (control, tasks) = (control.clone(), tasks.to_vec());
    PluginHost::new(move |task| {
        let task = usize::try_from(task).ok().and_then(|t| tasks.get(t));
        matches!((control.get(), task), (Some(running), Some(task)) if running.release(*task, None).is_ok())
    })
}

fn releases(workload: &Workload, tasks: &[TaskId]) -> Vec<Releases> {
    let by_clock = workload.tasks.iter().zip(tasks).filter_map(|(task, id)| {
        let period_ns = match task.arrival {
            Arrival::Periodic { period_ns } => Some(period_ns),
            Arrival::Once => None,
            Arrival::Sporadic { .. } => return None,
        };
        Some(Releases { task: *id, first_ns: task.offset_ns, period_ns })
    });
    by_clock.collect()
}

/// Room for a task's jobs; sporadic ones that come more often than they said are counted as dropped notes.
fn jobs_of(arrival: &Arrival, duration_ns: u64) -> usize {
    const MOST: u64 = 4_000_000;
    let jobs = match arrival {
        Arrival::Periodic { period_ns: t } | Arrival::Sporadic { min_interarrival_ns: t } => {
            duration_ns / t.max(&1) + 2
        }
        Arrival::Once => 1,
    };
    usize::try_from(jobs.min(MOST)).unwrap_or(0)
}

fn all_edges(plan: &build::Plan<Robot>) -> Vec<Vec<(usize, usize)>> {
    let mut edges: Vec<Vec<(usize, usize)>> = Vec::new();
    for dag in &plan.dags {
        let of_node =
            |from: red_core::NodeId| dag.successors(from).iter().map(move |to| (from.index(), to)).collect();
        let of_task: Vec<Vec<(usize, usize)>> = dag.nodes().map(of_node).collect();
        edges.push(of_task.concat());
    }
    for change in &plan.changes {
        let added = change.steps.iter().flat_map(|step| &step.edges);
        edges[change.task].extend(added.map(|(from, to)| (from.index(), to.index())));
    }
    edges
}

/// Edits in words, by task: which nodes come and which go.
fn edits(plan: &build::Plan<Robot>) -> Vec<Vec<String>> {
    let mut edits = vec![Vec::new(); plan.nodes.len()];
    for change in &plan.changes {
        let name = |node: red_core::NodeId| plan.nodes[change.task][node.index()].name.as_str();
        let words = change.steps.iter().flat_map(|step| {
            let gone = step.removed.iter().map(|node| format!("-{}", name(*node)));
            gone.chain(step.added.iter().map(|(node, _)| format!("+{}", name(*node))))
        });
        edits[change.task].push(words.collect::<Vec<_>>().join(" "));
    }
    edits
}
