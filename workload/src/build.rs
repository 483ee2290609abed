//! From a workload to what the executive takes: graphs with numbered nodes, and graph changes with the numbers
//! that their nodes will have.
//!
//! Numbers follow the file: nodes of a task in order, refined stages expanded in place, nodes of events after
//! all others. They are never reused, so a number means the same node in every version of the graph.

pub use crate::change::{Change, Step, apply};
use crate::model::{Arrival, Node as FileNode, Part, Stage, Task, Work, Workload};
use red_core::{
    AddTaskError, Bytes, Capacity, Config, Contention, Dag, Duration, EdgeError, Frame, Instant, Node,
    NodeError, NodeId, PoolId, Scheduler, SensorId, TaskId, Timing, Wcet, refine,
};
use std::collections::{BTreeMap, HashMap};
use std::fmt;

/// What a numbered node does.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Role {
    /// One part: an ordinary node.
    Plain(Part),
    /// The encoder of a refined stage.
    Encoder {
        /// What it does.
        part: Part,
        /// Name of its weights. With the frame's it says which encoders have one result.
        weights: String,
        /// Name of the frame that it reads.
        frame: String,
    },
    /// A decoder of a refined stage; `encoder` is the number of its encoder.
    Decoder {
        /// What it does.
        part: Part,
        /// Its encoder's number.
        encoder: usize,
    },
    /// A whole stage as one node, as policy `edf` has it.
    Coarse(Stage),
}

/// A numbered node.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Numbered {
    /// Row name: `camera`, `perception.lane`; `perception` where the stage is one node.
    pub name: String,
    /// What it does.
    pub role: Role,
}

impl Numbered {
    /// Its WCET without contention, in nanoseconds.
    #[must_use]
    pub fn wcet_ns(&self) -> u64 {
        match &self.role {
            Role::Plain(part) | Role::Encoder { part, .. } | Role::Decoder { part, .. } => part.wcet_ns,
            Role::Coarse(stage) => {
                let add = |sum: u64, (_, part): &(String, Part)| sum.saturating_add(part.wcet_ns);
                stage.decoders.iter().fold(stage.encoder.wcet_ns, add)
            }
        }
    }
}

/// A workload as the executive takes it.
#[derive(Debug)]
pub struct Plan<C: Capacity> {
    /// First graph of each task.
    pub dags: Vec<Dag<C>>,
    /// Timing of each task.
    pub timings: Vec<Timing>,
    /// Numbered nodes of each task, those of events included.
    pub nodes: Vec<Vec<Numbered>>,
    /// Graph changes in the order of their instants, ties in file order.
    pub changes: Vec<Change>,
}

/// A workload does not fit the executive. Files that were read by this crate do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum BuildError {
    /// The period of this sensor is one more than the executive has room for: one for each node of a task.
    Sensor(String),
    /// A node of this task was refused.
    Node(String, NodeError),
    /// An edge of this task was refused.
    Edge(String, EdgeError),
    /// A task was refused.
    Task(String, AddTaskError),
    /// The pools were refused.
    Pools,
}

impl fmt::Display for BuildError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sensor(name) => {
                write!(f, "sensor `{name}`: too many distinct periods; give sensors of one clock one period")
            }
            Self::Node(task, e) => write!(f, "task `{task}`: {e}"),
            Self::Edge(task, e) => write!(f, "task `{task}`: {e}"),
            Self::Task(task, e) => write!(f, "task `{task}`: {e}"),
            Self::Pools => f.write_str("more pools or lanes than the executive has"),
        }
    }
}

impl std::error::Error for BuildError {}

/// Builds the scheduler of a workload under `config`, its pools, sensors and tasks admitted.
///
/// # Errors
/// [`BuildError`].
pub fn admit<C: Capacity>(
    scheduler: &mut Scheduler<C>,
    workload: &Workload,
    config: Config,
) -> Result<(Plan<C>, Vec<TaskId>), BuildError> {
    let first = workload.pools.first().ok_or(BuildError::Pools)?;
    let lanes = |n: u32| u8::try_from(n).map_err(|_| BuildError::Pools);
    let memory = first.memory_bytes.map(Bytes);
    scheduler.configure(Config { lanes: lanes(first.lanes)?, memory, ..config });
    for pool in workload.pools.iter().skip(1) {
        let added = scheduler.add_pool(lanes(pool.lanes)?, pool.memory_bytes.map(Bytes));
        added.map_err(|_| BuildError::Pools)?;
    }
    let mut sensors = HashMap::new();
    let frames = workload.frames();
    for sensor in workload.sensors.iter().filter(|sensor| frames.contains(&*sensor.name)) {
        let id = scheduler.add_sensor(Duration::from_nanos(sensor.period_ns));
        sensors.insert(sensor.name.clone(), id.map_err(|_| BuildError::Sensor(sensor.name.clone()))?);
    }
    let plan =
        Builder { refined: config.refine, sensors, frames: Names::default(), weights: Names::default() }
            .plan(workload)?;
    let mut tasks = Vec::new();
    for ((dag, timing), task) in plan.dags.iter().zip(&plan.timings).zip(&workload.tasks) {
        let id = scheduler.add_task(dag, *timing);
        tasks.push(id.map_err(|e| BuildError::Task(task.name.clone(), e))?);
    }
    Ok((plan, tasks))
}

/// Sub-jobs that an event's node may be named by: a node, a stage, or a part of one.
#[derive(Clone, Debug)]
struct Place {
    /// Where edges into it lead.
    entry: Vec<usize>,
    /// Where edges out of it leave.
    exit: Vec<usize>,
}

/// Numbers for names, in order of appearance.
#[derive(Debug, Default)]
struct Names(BTreeMap<String, u16>);

impl Names {
    fn number(&mut self, name: &str) -> u16 {
        let next = u16::try_from(self.0.len()).unwrap_or(u16::MAX);
        *self.0.entry(name.to_owned()).or_insert(next)
    }
}

struct Builder {
    refined: bool,
    sensors: HashMap<String, SensorId>,
    frames: Names,
    weights: Names,
}

impl Builder {
    fn plan<C: Capacity>(mut self, workload: &Workload) -> Result<Plan<C>, BuildError> {
        let mut plan = Plan { dags: Vec::new(), timings: Vec::new(), nodes: Vec::new(), changes: Vec::new() };
        let mut places = Vec::new();
        for task in &workload.tasks {
            let mut names = HashMap::new();
            let mut numbered = Vec::new();
            let dag = self.base(task, &mut names, &mut numbered)?;
            plan.dags.push(dag);
            plan.timings.push(timing(task));
            plan.nodes.push(numbered);
            places.push(names);
        }
        for event in &workload.events {
            let (names, numbered) = (&mut places[event.task], &mut plan.nodes[event.task]);
            let mut change = Step::default();
            for name in &event.remove {
                let parts = self.parts_of(name, names);
                change.removed.extend(parts.iter().map(|n| number(*n)));
            }
            for node in &event.add {
                self.add(node, names, numbered, &mut change);
            }
            let mut edges = Vec::new();
            for node in &event.add {
                for other in &node.after {
                    edges.extend(pairs(&self.place(names, other).exit, &names[&node.name].entry));
                }
                for other in &node.before {
                    edges.extend(pairs(&names[&node.name].exit, &self.place(names, other).entry));
                }
            }
            change.edges.extend(edges.into_iter().map(|(a, b)| (number(a), number(b))));
            change.edges.sort_unstable();
            change.edges.dedup();
            let at = Instant::from_nanos(event.at_ns);
            match plan.changes.iter_mut().rev().find(|c| c.task == event.task && c.at == at) {
                Some(same) => same.steps.push(change),
                None => plan.changes.push(Change { at, task: event.task, steps: vec![change] }),
            }
        }
        Ok(plan)
    }

    /// The task's first graph: coarse, then each stage refined in place, then edges that name a part.
    fn base<C: Capacity>(
        &mut self,
        task: &Task,
        names: &mut HashMap<String, Place>,
        numbered: &mut Vec<Numbered>,
    ) -> Result<Dag<C>, BuildError> {
        let mut dag = Dag::new();
        let node_error = |e| BuildError::Node(task.name.clone(), e);
        for node in &task.nodes {
            dag.add_node(self.coarse(node)).map_err(node_error)?;
        }
        let index: HashMap<&str, usize> =
            task.nodes.iter().enumerate().map(|(i, n)| (n.name.as_str(), i)).collect();
        for (i, node) in task.nodes.iter().enumerate() {
            for other in &node.after {
                let whole = other.split('.').next().unwrap_or(other);
                if whole.len() == other.len() || !self.refined {
                    link(&mut dag, task, index[whole], i)?;
                }
            }
        }
        for node in &task.nodes {
            let first = numbered.len();
            if let (Work::Stage(stage), true) = (&node.work, self.refined) {
                let (encoder, decoders) = self.stage(stage);
                let spliced = refine(&dag, number(first), encoder, &decoders);
                dag = spliced.map_err(|_| BuildError::Node(task.name.clone(), NodeError::Full))?.dag;
            }
            self.number(node, names, numbered);
        }
        if self.refined {
            for node in &task.nodes {
                for part in node.after.iter().filter(|other| other.contains('.')) {
                    for (from, to) in pairs(&names[part].exit, &names[&node.name].entry) {
                        link(&mut dag, task, from, to)?;
                    }
                }
            }
        }
        Ok(dag)
    }

    /// Nodes of an event, with the numbers that they will get.
    fn add(
        &mut self,
        node: &FileNode,
        names: &mut HashMap<String, Place>,
        numbered: &mut Vec<Numbered>,
        change: &mut Step,
    ) {
        let first = numbered.len();
        match &node.work {
            Work::Stage(stage) if self.refined => {
                let (encoder, decoders) = self.stage(stage);
                change.added.push((number(first), encoder));
                for (j, decoder) in decoders.into_iter().enumerate() {
                    change.added.push((number(first + 1 + j), decoder));
                    change.edges.push((number(first), number(first + 1 + j)));
                }
            }
            _ => change.added.push((number(first), self.coarse(node))),
        }
        self.number(node, names, numbered);
    }

    /// Gives a node's parts their names and numbers.
    fn number(&self, node: &FileNode, names: &mut HashMap<String, Place>, numbered: &mut Vec<Numbered>) {
        let first = numbered.len();
        let mut name =
            |name: String, entry: Vec<usize>, exit: Vec<usize>| names.insert(name, Place { entry, exit });
        match &node.work {
            Work::Plain(part) => {
                name(node.name.clone(), vec![first], vec![first]);
                numbered.push(Numbered { name: node.name.clone(), role: Role::Plain(part.clone()) });
            }
            Work::Stage(stage) if !self.refined => {
                name(node.name.clone(), vec![first], vec![first]);
                numbered.push(Numbered { name: node.name.clone(), role: Role::Coarse(stage.clone()) });
            }
            Work::Stage(stage) => {
                let all = first + 1..=first + stage.decoders.len();
                name(node.name.clone(), vec![first], all.clone().collect());
                let encoder = format!("{}.encoder", node.name);
                name(encoder.clone(), vec![first], vec![first]);
                let Stage { weights, frame, encoder: part, .. } = stage.clone();
                numbered.push(Numbered { name: encoder, role: Role::Encoder { part, weights, frame } });
                for ((decoder, part), at) in stage.decoders.iter().zip(all) {
                    let decoder = format!("{}.{decoder}", node.name);
                    name(decoder.clone(), vec![at], vec![at]);
                    numbered.push(Numbered {
                        name: decoder,
                        role: Role::Decoder { part: part.clone(), encoder: first },
                    });
                }
            }
        }
    }

    /// A place by its name; a part of a stage that is one node is the stage.
    fn place<'a>(&self, names: &'a HashMap<String, Place>, name: &str) -> &'a Place {
        let whole = name.split('.').next().unwrap_or(name);
        &names[if self.refined { name } else { whole }]
    }

    fn parts_of(&self, name: &str, names: &HashMap<String, Place>) -> Vec<usize> {
        let place = self.place(names, name);
        let mut parts = place.entry.clone();
        parts.extend(place.exit.iter().filter(|n| !place.entry.contains(n)));
        parts
    }

    /// A node as written; a stage as one node that costs its encoder and all of its decoders.
    fn coarse(&mut self, node: &FileNode) -> Node {
        match &node.work {
            Work::Plain(part) => plain(part),
            Work::Stage(stage) => {
                let decoders = || stage.decoders.iter().map(|(_, part)| part);
                let mut whole = stage.encoder.clone();
                for part in decoders() {
                    whole.wcet_ns = whole.wcet_ns.saturating_add(part.wcet_ns);
                    whole.bcet_ns = whole.bcet_ns.saturating_add(part.bcet_ns);
                    whole.atomic |= part.atomic;
                    whole.contention_ns = whole.contention_ns.max(part.contention_ns);
                }
                // The encoder's result stays while a decoder runs.
                let beside =
                    decoders().filter(|d| d.pool == whole.pool).map(|d| d.memory_bytes).max().unwrap_or(0);
                whole.memory_bytes = whole.memory_bytes.saturating_add(beside);
                plain(&whole)
            }
        }
    }

    fn stage(&mut self, stage: &Stage) -> (Node, Vec<Node>) {
        let frame = Frame {
            weights: self.weights.number(&stage.weights),
            frame: self.frames.number(&stage.frame),
            sensor: self.sensors.get(&stage.frame).copied(),
        };
        let base = plain(&stage.encoder);
        let encoder = with(Node::shared_encoder(base.wcet(), frame), &stage.encoder);
        let decoders = stage.decoders.iter().map(|(_, part)| with(Node::decoder(plain(part).wcet()), part));
        (encoder, decoders.collect())
    }
}

fn plain(part: &Part) -> Node {
    with(Node::new(Wcet::from_nanos(part.wcet_ns)), part)
}

fn with(node: Node, part: &Part) -> Node {
    let node = node
        .best_case(Duration::from_nanos(part.bcet_ns))
        .memory(Bytes(part.memory_bytes))
        .in_pool(PoolId::new(u8::try_from(part.pool).unwrap_or(u8::MAX)));
    if part.atomic { node.atomic(Contention::from_nanos(part.contention_ns)) } else { node }
}

fn timing(task: &Task) -> Timing {
    let timing = Timing::new(Duration::from_nanos(task.deadline_ns)).value(task.value);
    let timing = match task.floor {
        Some((m, k)) => timing.floor(m, k),
        None => timing,
    };
    match task.arrival {
        Arrival::Periodic { period_ns: t } | Arrival::Sporadic { min_interarrival_ns: t } => {
            timing.every(Duration::from_nanos(t))
        }
        Arrival::Once => timing,
    }
}

/// An edge; one that is there already (overlap through a stage) stays one.
fn link<C: Capacity>(dag: &mut Dag<C>, task: &Task, from: usize, to: usize) -> Result<(), BuildError> {
    match dag.add_edge(number(from), number(to)) {
        Ok(()) | Err(EdgeError::Duplicate) => Ok(()),
        Err(e) => Err(BuildError::Edge(task.name.clone(), e)),
    }
}

fn pairs(from: &[usize], to: &[usize]) -> Vec<(usize, usize)> {
    from.iter().flat_map(|a| to.iter().map(|b| (*a, *b))).collect()
}

fn number(n: usize) -> NodeId {
    NodeId::new(u8::try_from(n).unwrap_or(u8::MAX))
}
