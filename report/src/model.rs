//! A run as plain data. Instants are nanoseconds since the start of the run; tasks, lanes and graphs are named by their
//! place in [`Run`].

use std::collections::BTreeMap;

/// A sub-job: task, job, node.
pub type SubJob = (usize, u64, usize);

/// A run.
#[derive(Clone, Debug, Default)]
pub struct Run {
    /// Policy.
    pub policy: String,
    /// What else is to be known of it: a title and a value each.
    pub facts: Vec<(String, String)>,
    /// Tasks.
    pub tasks: Vec<Task>,
    /// Lanes over all pools.
    pub lanes: Vec<Lane>,
    /// Pools.
    pub pools: Vec<Pool>,
    /// Graphs that jobs were released with.
    pub graphs: Vec<Graph>,
    /// Whether a node waits for the whole level before it.
    pub level_gate: bool,
    /// Jobs by task and number.
    pub jobs: Vec<Vec<Job>>,
    /// Executions, by start.
    pub slices: Vec<Slice>,
    /// Encoders that took a result instead of running.
    pub hits: Vec<Hit>,
    /// Graph changes, in words.
    pub edits: Vec<(u64, String)>,
    /// When nothing ran: from, until.
    pub standstills: Vec<(u64, u64)>,
    /// When the run ended.
    pub end_ns: u64,
    /// Sub-jobs that ended after their sub-deadlines.
    pub nodes_missed: u64,
    /// Units that got a lane.
    pub units: u64,
    /// Encoder runs saved.
    pub saved: u64,
    /// What admission says of the workload, in lines; empty where nobody asked.
    pub certificate: Vec<String>,
    /// Jobs that missed, with what they spent their time on.
    pub misses: Vec<Miss>,
    /// Misses of one cause.
    pub groups: Vec<Group>,
    /// What was tried in virtual time.
    pub tried: Vec<Tried>,
    /// What has to be known to read `tried`; empty where nothing has.
    pub tried_note: String,
}

/// A task.
#[derive(Clone, Debug, Default)]
pub struct Task {
    /// Name.
    pub name: String,
    /// Relative deadline.
    pub deadline_ns: u64,
    /// Names of nodes by number; one that has none goes by its number.
    pub nodes: Vec<String>,
    /// How its jobs ended.
    pub figures: Figures,
}

/// How the jobs of a task ended.
#[derive(Clone, Debug, Default)]
pub struct Figures {
    /// Released.
    pub released: u64,
    /// On time.
    pub on_time: u64,
    /// Late, given up, or never ended.
    pub missed: u64,
    /// Given up.
    pub shed: u64,
    /// Why, with how many each.
    pub reasons: Vec<(String, u64)>,
    /// Of a task with a floor: at least so many of so many consecutive jobs on time, and the fewest that were.
    pub floor: Option<(u32, u32, u32)>,
    /// Value of the jobs on time, and of all released.
    pub value: [u64; 2],
    /// Median, 99th percentile and maximum.
    pub response_ns: [Option<u64>; 3],
    /// Response times of completed jobs, in any order.
    pub responses_ns: Vec<u64>,
}

/// A lane.
#[derive(Clone, Debug, Default)]
pub struct Lane {
    /// Name.
    pub name: String,
    /// Its pool.
    pub pool: usize,
}

/// A pool.
#[derive(Clone, Debug, Default)]
pub struct Pool {
    /// Name.
    pub name: String,
    /// Whether it has a memory budget.
    pub is_limited: bool,
    /// Time that its lanes worked.
    pub busy_ns: u64,
}

/// A version of a task's graph.
#[derive(Clone, Debug, Default)]
pub struct Graph {
    /// Nodes by number.
    pub nodes: BTreeMap<usize, Node>,
}

/// A node of a graph.
#[derive(Clone, Debug, Default)]
pub struct Node {
    /// Worst-case execution time.
    pub wcet_ns: u64,
    /// Pool.
    pub pool: usize,
    /// Longest number of edges from a source.
    pub height: usize,
    /// Longest path from its start to the end of the job.
    pub rest_ns: u64,
    /// Predecessors.
    pub after: Vec<usize>,
    /// Whether its result may be shared.
    pub is_encoder: bool,
}

/// A job.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Job {
    /// When it was due to be released.
    pub release_ns: u64,
    /// When the scheduler heard of it.
    pub recorded_ns: u64,
    /// When it was due.
    pub deadline_ns: u64,
    /// When it ended.
    pub end_ns: Option<u64>,
    /// Why it was given up, if it was.
    pub shed: Option<String>,
    /// Its graph.
    pub graph: usize,
    /// Whether it was released before the end of releases, and so counts.
    pub counts: bool,
}

/// One execution of a sub-job.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Slice {
    /// Whose.
    pub of: SubJob,
    /// Where.
    pub lane: usize,
    /// From.
    pub start_ns: u64,
    /// Until.
    pub end_ns: u64,
    /// When it should have ended.
    pub due_ns: Option<u64>,
    /// Whether it ended by itself.
    pub completed: bool,
    /// Sub-jobs of one unit have one number.
    pub unit: u64,
}

/// An encoder that took a result.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Hit {
    /// Whose.
    pub of: SubJob,
    /// When.
    pub at_ns: u64,
    /// The encoder for whose end it waited; `None`: the result was there.
    pub by: Option<SubJob>,
}

/// What time was spent on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// On a lane, within the WCET.
    Execution,
    /// On a lane, beyond the WCET.
    Overrun,
    /// Ready, and the lane had something else.
    Lane,
    /// Ready, the lane was free, but the pool's memory was not.
    Memory,
    /// A node of the level before was not done.
    Gate,
    /// Another encoder computed the same result.
    Encoder,
    /// The scheduler heard of the release after it was due.
    Release,
    /// Ready, with a free lane: until the lane asked.
    Dispatch,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Execution,
        Self::Overrun,
        Self::Lane,
        Self::Memory,
        Self::Gate,
        Self::Encoder,
        Self::Release,
        Self::Dispatch,
    ];

    /// The word that programs read.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Execution => "execution",
            Self::Overrun => "overrun",
            Self::Lane => "lane",
            Self::Memory => "memory",
            Self::Gate => "gate",
            Self::Encoder => "encoder",
            Self::Release => "release",
            Self::Dispatch => "dispatch",
        }
    }

    /// In words.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::Execution => "own execution",
            Self::Overrun => "overrun beyond the WCET",
            Self::Lane => "waiting for a lane",
            Self::Memory => "waiting for memory",
            Self::Gate => "waiting for the level before",
            Self::Encoder => "waiting for a shared encoder",
            Self::Release => "late release",
            Self::Dispatch => "lane free, not asked yet",
        }
    }
}

/// A stretch of a job's critical chain; those of a chain have neither gaps nor overlaps.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// What.
    pub kind: Kind,
    /// The node of the job that executed or waited; `None` before the first.
    pub node: Option<usize>,
    /// From.
    pub from_ns: u64,
    /// Until.
    pub to_ns: u64,
    /// Who had what it waited for.
    pub by: Option<SubJob>,
}

impl Part {
    /// How long.
    #[must_use]
    pub const fn ns(&self) -> u64 {
        self.to_ns - self.from_ns
    }
}

/// A job that missed its deadline.
#[derive(Clone, Debug)]
pub struct Miss {
    /// Task.
    pub task: usize,
    /// Job.
    pub job: u64,
    /// When it ended, was given up, or the run ended.
    pub until_ns: u64,
    /// Its critical chain, from release to `until_ns`.
    pub parts: Vec<Part>,
    /// The first of [`Run::tried`] that saves it.
    pub saved_by: Option<usize>,
}

/// Misses of one cause.
#[derive(Clone, Debug)]
pub struct Group {
    /// The cause, in words.
    pub cause: String,
    /// Which of [`Run::misses`].
    pub misses: Vec<usize>,
    /// Of [`Run::tried`]: the first that saves most of them, and how many that are.
    pub best: Option<(usize, usize)>,
}

/// A change that was tried.
#[derive(Clone, Debug)]
pub struct Tried {
    /// What was otherwise.
    pub change: String,
    /// Jobs that were on time then, over all tasks.
    pub on_time: u64,
    /// Jobs that missed.
    pub missed: u64,
    /// How many of [`Run::misses`] were on time.
    pub saves: u64,
}

impl Run {
    /// The name of a node.
    #[must_use]
    pub fn node(&self, task: usize, node: usize) -> String {
        let name = self.tasks.get(task).and_then(|task| task.nodes.get(node)).filter(|name| !name.is_empty());
        name.cloned().unwrap_or_else(|| format!("node-{node}"))
    }

    /// The name of a task.
    #[must_use]
    pub fn task(&self, task: usize) -> &str {
        self.tasks.get(task).map_or("?", |task| &task.name)
    }

    /// The name of a sub-job.
    #[must_use]
    pub fn sub_job(&self, (task, job, node): SubJob) -> String {
        format!("{} #{job} {}", self.task(task), self.node(task, node))
    }

    /// A job.
    #[must_use]
    pub fn job(&self, task: usize, job: u64) -> Option<&Job> {
        self.jobs.get(task)?.get(usize::try_from(job).ok()?)
    }

    /// What became of a job.
    #[must_use]
    pub fn outcome(&self, job: &Job) -> &'static str {
        match (job.end_ns, &job.shed) {
            (_, Some(_)) => "given up",
            (Some(end), None) if end > job.deadline_ns => "late",
            (Some(_), None) => "on time",
            (None, None) => "unfinished",
        }
    }
}
