//! Random configurations, pools, graphs and edits, built without allocation.

use red_core::{
    BestCase, Bytes, Config, Contention, Dag, Duration, Frame, Late, Node, NodeId, PoolId, Role, SensorId,
    Timing, Wcet, refine,
};

use crate::rng::Rng;
use crate::{Board, POLICIES};

const MIB: u64 = 1 << 20;
/// What a pool with a budget has at least: an encoder and a decoder fit together.
const LEAST_BUDGET: u64 = 40 * MIB;
const LARGEST_FOOTPRINT: u64 = 20 * MIB;

/// A pool after the first: its lanes and its memory budget.
pub type Pool = (u8, Option<Bytes>);

/// What the tasks of one workload share.
#[derive(Debug)]
pub struct Common {
    /// Pools after the first.
    pub pools: [Option<Pool>; 2],
    /// How often the one sensor captures a frame, if there is one.
    pub sensor: Option<Duration>,
    /// One encoder for each of the weights.
    encoders: [Node; 2],
    refined: bool,
}

/// When the jobs of a task come.
#[derive(Clone, Copy, Debug)]
pub struct Arrival {
    /// The first one.
    pub offset_ns: u64,
    /// From one to the next.
    pub period_ns: u64,
}

/// What a task asks for.
#[derive(Clone, Copy, Debug)]
pub struct Terms {
    /// End to end.
    pub deadline: Duration,
    /// As declared.
    pub period: Duration,
    /// What a job is worth.
    pub value: u32,
    /// So many of so many are kept.
    pub floor: (u32, u32),
}

impl Terms {
    /// For the core.
    pub const fn timing(&self) -> Timing {
        Timing::new(self.deadline).every(self.period).value(self.value).floor(self.floor.0, self.floor.1)
    }
}

/// How a graph was made.
#[derive(Clone, Copy, Debug)]
pub enum Step<'a> {
    /// A node.
    Node(Node),
    /// An edge.
    Edge(NodeId, NodeId),
    /// A stage became an encoder and its decoders.
    Refine(NodeId, Node, &'a [Node]),
    /// A node became another.
    Replace(NodeId, Node),
}

/// One of the five policies by turns, with the choices that a host has.
pub fn config(seed: u64, rng: &mut Rng) -> Config {
    let (_, mut config) = POLICIES[(seed % POLICIES.len() as u64) as usize];
    config.late = if rng.chance(20) { Late::AbortJob } else { config.late };
    config.best_case = if rng.chance(50) { BestCase::Declared } else { BestCase::Observed };
    config.preempt = rng.chance(25);
    // Short, so that a short run sees overload last.
    config.overload.tick = Duration::from_micros(500);
    config.lanes = rng.within(1, 3) as u8;
    config.memory = budget(rng);
    config
}

/// Further pools, a sensor, and encoders.
pub fn common(config: &Config, rng: &mut Rng) -> Common {
    let more = rng.within(0, 2) as usize;
    let mut pools = [None; 2];
    for pool in &mut pools[..more] {
        *pool = Some((rng.within(1, 2) as u8, budget(rng)));
    }
    let period = Duration::from_micros(rng.within(1, 20) * 500);
    let sensor = rng.chance(70).then_some(period);
    let mut common = Common { pools, sensor, encoders: [Node::new(Wcet::ZERO); 2], refined: config.refine };
    for weights in 0..2 {
        let plain = plain(&common, rng);
        let frame = Frame { weights, frame: 0, sensor: None };
        common.encoders[usize::from(weights)] =
            Node::shared_encoder(Wcet::from_nanos(plain.wcet().as_nanos() * 2), frame)
                .in_pool(plain.pool())
                .memory(plain.footprint());
    }
    common
}

/// A graph, and when its jobs come; `load` is its part of one lane in percent. `made` hears how the graph is made.
pub fn task(
    common: &Common,
    load: u64,
    rng: &mut Rng,
    made: &mut impl FnMut(Step<'_>),
) -> (Dag<Board>, Terms, Arrival) {
    let dag = graph(common, rng, made);
    let period_ns = (dag.work() * 100 / load).clamp(500_000, 20_000_000);
    let deadline = Duration::from_nanos(period_ns * rng.within(30, 200) / 100);
    let k = rng.within(1, 5);
    let floor = if rng.chance(30) { rng.within(0, k) } else { 0 };
    let value = rng.within(0, 3) as u32;
    let terms =
        Terms { deadline, period: Duration::from_nanos(period_ns), value, floor: (floor as u32, k as u32) };
    let offset_ns = if rng.chance(50) { 0 } else { rng.within(0, period_ns) };
    (dag, terms, Arrival { offset_ns, period_ns })
}

/// Changes a live graph: a node goes, or one comes between two that are there.
pub(crate) fn change(dag: &mut Dag<Board>, common: &Common, rng: &mut Rng) {
    let some = |dag: &Dag<Board>, rng: &mut Rng| dag.nodes().nth(rng.index(dag.len().max(1)));
    let Some(first) = some(dag, rng) else { return };
    // Decoders stay: their encoder's frame says that somebody reads it.
    let is_plain = dag.node(first).is_some_and(|node| node.role() == Role::Ordinary);
    if is_plain && dag.len() > 1 && rng.chance(50) {
        dag.remove_node(first);
    } else if let Ok(new) = dag.add_node(plain(common, rng)) {
        let second = some(dag, rng);
        // The edge into the new node closes no cycle; the one out of it may, and is then left out.
        let _added = dag.add_edge(first, new);
        let _added = second.map(|second| dag.add_edge(new, second));
    }
}

fn budget(rng: &mut Rng) -> Option<Bytes> {
    rng.chance(50).then(|| Bytes(LEAST_BUDGET + rng.within(0, 2) * 8 * MIB))
}

/// Up to six nodes or stages; edges lead from earlier to later ones.
fn graph(common: &Common, rng: &mut Rng, made: &mut impl FnMut(Step<'_>)) -> Dag<Board> {
    let mut dag = Dag::new();
    let count = rng.within(1, 6) as u8;
    let density = rng.within(10, 70);
    let mut stages = 0u8;
    for to in 0..count {
        let plain = plain(common, rng);
        made(Step::Node(plain));
        let node = dag.add_node(plain).expect("few nodes");
        stages |= u8::from(rng.chance(35)) << to;
        for from in 0..to {
            if rng.chance(density) {
                dag.add_edge(NodeId::new(from), node).expect("forwards");
                made(Step::Edge(NodeId::new(from), node));
            }
        }
    }
    // From the last, because a stage moves the nodes after it.
    let stages = (0..count).rev().filter(|stage| stages >> stage & 1 == 1);
    stages.fold(dag, |dag, stage| with_stage(&dag, NodeId::new(stage), common, rng, made))
}

/// A node made a stage: an encoder and its decoders, or one node that costs as much.
fn with_stage(
    dag: &Dag<Board>,
    node: NodeId,
    common: &Common,
    rng: &mut Rng,
    made: &mut impl FnMut(Step<'_>),
) -> Dag<Board> {
    let weights = rng.within(0, 1) as u16;
    let front = rng.chance(70);
    let sensor = common.sensor.filter(|_| front).map(|_| SensorId::new(0));
    let frame = Frame { weights, frame: u16::from(!front), sensor };
    let shared = common.encoders[usize::from(weights)];
    // Who shares an encoder may give it another cost.
    let wcet = if rng.chance(80) { shared.wcet() } else { cost(rng) };
    let encoder = Node::shared_encoder(wcet, frame)
        .in_pool(shared.pool())
        .memory(shared.footprint())
        .best_case(Duration::from_nanos(wcet.as_nanos() / 2));
    let decoders = [(); 3].map(|()| {
        let plain = plain(common, rng);
        let pool = if rng.chance(85) { shared.pool() } else { plain.pool() };
        Node::decoder(plain.wcet()).in_pool(pool).memory(plain.footprint())
    });
    let decoders = &decoders[..rng.within(1, 3) as usize];
    if common.refined {
        made(Step::Refine(node, encoder, decoders));
        return refine(dag, node, encoder, decoders).expect("few nodes").dag;
    }
    let sum = decoders.iter().map(Node::cost).sum::<u64>() + encoder.cost();
    let by = Node::new(Wcet::from_nanos(sum)).in_pool(shared.pool());
    made(Step::Replace(node, by));
    replaced(dag, node, by)
}

/// A graph with another node in one place.
fn replaced(dag: &Dag<Board>, place: NodeId, by: Node) -> Dag<Board> {
    let mut new = Dag::new();
    for node in dag.nodes() {
        let old = dag.node(node).copied().filter(|_| node != place);
        let _same_place = new.add_node(old.unwrap_or(by)).expect("as many as before");
    }
    for from in dag.nodes() {
        for to in dag.successors(from).iter() {
            new.add_edge(from, NodeId::new(to as u8)).expect("as before");
        }
    }
    new
}

/// An ordinary node.
pub fn plain(common: &Common, rng: &mut Rng) -> Node {
    let wcet = cost(rng);
    let best = Duration::from_nanos(wcet.as_nanos() / 2);
    let memory = if rng.chance(20) { 0 } else { rng.within(LARGEST_FOOTPRINT / 3, LARGEST_FOOTPRINT) };
    let node = Node::new(wcet)
        .best_case(best)
        .memory(Bytes(memory))
        .in_pool(PoolId::new(rng.within(0, common.pools.iter().flatten().count() as u64) as u8));
    if rng.chance(20) { node.atomic(Contention::from_nanos(rng.within(0, 200) * 1_000)) } else { node }
}

/// Round costs make completions coincide; some nodes take no time.
fn cost(rng: &mut Rng) -> Wcet {
    Wcet::from_nanos(match rng.within(0, 9) {
        0 => 0,
        1..=4 => rng.within(1, 4) * 250_000,
        _ => rng.within(20_000, 1_000_000),
    })
}
