//! What a workload file says, checked: plain data, names resolved where that is possible without a graph.
//!
//! All times are nanoseconds, all memory is bytes, as written in the file (exact integers).

use std::collections::HashSet;

/// Body of a node: what `redrt run` executes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Body {
    /// No body: the node exists for `plan` and `sim` only.
    None,
    /// Burns CPU for this long.
    Spin {
        /// Nanoseconds to burn.
        duration_ns: u64,
    },
    /// Runs an ONNX model on the CPU. Paths are relative to the workload file.
    Onnx {
        /// Path of the model.
        path: String,
    },
    /// Calls a C function of a shared object.
    Plugin {
        /// Shared object.
        path: String,
        /// Symbol of the step function.
        symbol: String,
        /// Whether what it submits is captured once, and launched as a graph from then on.
        graph: bool,
    },
    /// Launches a CUDA kernel.
    Cuda {
        /// PTX or cubin file.
        module: String,
        /// Kernel name.
        kernel: String,
        /// Grid dimensions.
        grid: [u32; 3],
        /// Block dimensions.
        block: [u32; 3],
        /// What its parameters are given, in their order.
        args: Vec<Argument>,
        /// Whether it is captured once with its copies, and launched as a graph from then on.
        graph: bool,
    },
}

/// What a parameter of a CUDA kernel is given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Argument {
    /// The bits of a number; a parameter shorter than 64 bits takes the low ones.
    Number(u64),
    /// The address of so many bytes of the device, filled from the host before the kernel runs.
    Input(u64),
    /// The address of so many bytes of the device, copied to the host after the kernel ran.
    Output(u64),
    /// The address of so many bytes of the device that stay what they are from run to run of one lane.
    Scratch(u64),
    /// The address of so many bytes of the device that an encoder writes and its decoders read.
    Result(u64),
}

/// Lanes of all pools together: the scheduler's capacity.
pub const MAX_LANES: u32 = 32;

/// Longest time that is an instant or a distance of instants: 146 years. A difference of two fits `i64`, and a sum
/// of three fits `u64`.
pub const MAX_INSTANT_NS: u64 = 1 << 62;

/// Where a pool's bodies run under `run`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PoolKind {
    /// CPU threads.
    Cpu,
    /// CUDA streams.
    Cuda,
}

/// A pool of execution resources.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pool {
    /// Name. A pool that the file divides is as many as it has clusters, each called `pool.cluster`.
    pub name: String,
    /// What executes.
    pub kind: PoolKind,
    /// Lanes: the paper's rho.
    pub lanes: u32,
    /// Memory budget in bytes; `None` is unlimited.
    pub memory_bytes: Option<u64>,
    /// CPUs for the lanes' threads; empty lets the runtime choose.
    pub cpus: Vec<u32>,
}

impl Pool {
    /// The pool's name in the file; of a cluster that of the pool which it is a part of.
    #[must_use]
    pub fn undivided(&self) -> &str {
        self.name.split('.').next().unwrap_or(&self.name)
    }

    /// The cluster's name in the file; of an undivided pool its own.
    #[must_use]
    pub fn cluster(&self) -> &str {
        self.name.rsplit('.').next().unwrap_or(&self.name)
    }
}

/// A sensor whose captures may be shared between jobs of different tasks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sensor {
    /// Name: the frame name that stages refer to.
    pub name: String,
    /// Capture instants are multiples of this.
    pub period_ns: u64,
}

/// When a task releases jobs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arrival {
    /// At offset + j * period.
    Periodic {
        /// Period.
        period_ns: u64,
    },
    /// At least this far apart; released from outside under `run`, like `Periodic` in `sim`.
    Sporadic {
        /// Minimum inter-arrival time.
        min_interarrival_ns: u64,
    },
    /// One release, at the offset.
    Once,
}

/// What one node, or one part of a stage, costs and executes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// Worst-case execution time.
    pub wcet_ns: u64,
    /// Best-case execution time.
    pub bcet_ns: u64,
    /// What runs.
    pub body: Body,
    /// Index of the pool.
    pub pool: usize,
    /// Footprint.
    pub memory_bytes: u64,
    /// Indivisible.
    pub atomic: bool,
    /// Contention delay; zero unless atomic.
    pub contention_ns: u64,
}

/// A node is one part, or a MIMONet stage.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Work {
    /// An ordinary node.
    Plain(Part),
    /// A multi-task network: one encoder and its decoders.
    Stage(Stage),
}

/// A MIMONet stage.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stage {
    /// Name of the encoder's weights.
    pub weights: String,
    /// Name of the frame that it reads.
    pub frame: String,
    /// The shared encoder, called `<stage>.encoder`.
    pub encoder: Part,
    /// The decoders, called `<stage>.<name>`.
    pub decoders: Vec<(String, Part)>,
}

/// A node of a task as written: a stage is one of these.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Node {
    /// Name, without dots.
    pub name: String,
    /// Predecessors: `name` or `stage.part`.
    pub after: Vec<String>,
    /// Successors, in events only: `name` or `stage.part`.
    pub before: Vec<String>,
    /// What it does.
    pub work: Work,
}

impl Node {
    /// Its parts in the order of execution, with the names of their rows.
    #[must_use]
    pub fn parts(&self) -> Vec<(String, &Part)> {
        match &self.work {
            Work::Plain(part) => vec![(self.name.clone(), part)],
            Work::Stage(Stage { encoder, decoders, .. }) => {
                let named = |(name, part)| (format!("{}.{name}", self.name), part);
                let decoders = decoders.iter().map(|(name, part)| (name.as_str(), part));
                std::iter::once(("encoder", encoder)).chain(decoders).map(named).collect()
            }
        }
    }
}

/// A task: one DAG with an end-to-end deadline.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Task {
    /// Name.
    pub name: String,
    /// End-to-end deadline, relative to the release.
    pub deadline_ns: u64,
    /// Release pattern.
    pub arrival: Arrival,
    /// First release.
    pub offset_ns: u64,
    /// Declared value for shedding.
    pub value: u32,
    /// At least m of any k consecutive jobs are never shed by choice.
    pub floor: Option<(u32, u32)>,
    /// Nodes in file order.
    pub nodes: Vec<Node>,
}

/// A change of a task's graph while it runs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Event {
    /// Holds for jobs released at or after this instant.
    pub at_ns: u64,
    /// Index of the task.
    pub task: usize,
    /// Nodes that appear.
    pub add: Vec<Node>,
    /// Nodes that disappear.
    pub remove: Vec<String>,
}

/// The periodic barrier of the paper's baselines, in `sim`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SyncGrid {
    /// A dispatch waits for the next multiple of this.
    pub grid_ns: u64,
    /// And then this long.
    pub cost_ns: u64,
}

/// A whole workload file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Workload {
    /// Pools; the first is the default pool.
    pub pools: Vec<Pool>,
    /// Sensors.
    pub sensors: Vec<Sensor>,
    /// Tasks in file order.
    pub tasks: Vec<Task>,
    /// Events sorted by instant, ties in file order.
    pub events: Vec<Event>,
    /// Barrier grid.
    pub sync: Option<SyncGrid>,
}

impl Workload {
    /// Names of the frames that stages read, those of events included.
    #[must_use]
    pub fn frames(&self) -> HashSet<&str> {
        let of_tasks = self.tasks.iter().flat_map(|task| &task.nodes);
        let of_events = self.events.iter().flat_map(|event| &event.add);
        of_tasks
            .chain(of_events)
            .filter_map(|node| match &node.work {
                Work::Stage(stage) => Some(stage.frame.as_str()),
                Work::Plain(_) => None,
            })
            .collect()
    }
}
