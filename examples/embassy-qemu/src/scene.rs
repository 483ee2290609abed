//! What the robot sees: a camera, a network with a shared encoder, and control; as in `examples/cruise.toml`.

use red_core::{
    Contention, Dag, Duration, EdgeError, Frame, Node, NodeId, PoolId, Scheduler, SensorId, TaskId, Timing,
    Wcet,
};

use crate::firmware::Robot;

/// A frame every so often.
pub(crate) const PERIOD: Duration = Duration::from_micros(100_000);
const DEADLINE: Duration = Duration::from_micros(120_000);

/// Where networks run: two streams of an accelerator. Their bodies wait for it.
const ACCELERATOR: PoolId = PoolId::new(0);
/// Where camera and control run: on this processor.
const CPU: PoolId = PoolId::new(1);

/// What a node does.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Work {
    /// Waits for the accelerator.
    Infer,
    /// Computes here.
    Compute,
}

/// A node: its name, what it does and for how long, in microseconds; what it may take.
pub(crate) struct Step {
    pub(crate) name: &'static str,
    pub(crate) work: Work,
    pub(crate) micros: u64,
    wcet: Wcet,
}

const fn step(name: &'static str, work: Work, micros: u64, wcet_ms: u64) -> Step {
    Step { name, work, micros, wcet: Wcet::from_millis(wcet_ms) }
}

/// The first task; nodes are numbered as they stand here.
pub(crate) const CRUISE: [Step; 6] = [
    step("camera", Work::Compute, 1_500, 2),
    step("encoder", Work::Infer, 9_000, 12),
    step("lane", Work::Infer, 3_000, 4),
    step("segment", Work::Infer, 4_500, 6),
    step("objects", Work::Infer, 7_000, 9),
    step("control", Work::Compute, 2_000, 3),
];

/// The second task, which reads the same frames with the same encoder.
pub(crate) const WATCH: [Step; 2] =
    [step("encoder", Work::Infer, 9_000, 12), step("people", Work::Infer, 5_000, 7)];

/// Adds pools, sensor and tasks. With another frame for the second task nothing can be shared.
pub(crate) fn add(scheduler: &mut Scheduler<Robot>, other_frame: bool) -> Option<[TaskId; 2]> {
    scheduler.add_pool(1, None).ok()?;
    let front = scheduler.add_sensor(PERIOD).ok()?;
    let timing = Timing::new(DEADLINE).every(PERIOD).value(10);
    let cruise = scheduler.add_task(&cruise(front).ok()?, timing).ok()?;
    let watch = scheduler.add_task(&watch(front, other_frame.into()).ok()?, timing).ok()?;
    Some([cruise, watch])
}

fn cruise(front: SensorId) -> Result<Dag<Robot>, EdgeError> {
    let [camera, encoder, lane, segment, objects, control] =
        CRUISE.each_ref().map(|step| Node::new(step.wcet));
    let mut dag = Dag::new();
    let nodes = [
        camera.in_pool(CPU),
        shared(encoder, front, 0),
        decoder(lane),
        decoder(segment),
        decoder(objects),
        control.in_pool(CPU).atomic(Contention::from_millis(1)),
    ];
    // There is room for all of them.
    let [camera, encoder, decoders @ .., control] = nodes.map(|node| dag.add_node(node).unwrap_or_default());
    dag.add_edge(camera, encoder)?;
    for decoder in decoders {
        dag.add_edge(encoder, decoder)?;
        dag.add_edge(decoder, control)?;
    }
    Ok(dag)
}

fn watch(front: SensorId, frame: u16) -> Result<Dag<Robot>, EdgeError> {
    let [encoder, people] = WATCH.each_ref().map(|step| Node::new(step.wcet));
    let mut dag = Dag::new();
    let nodes = [shared(encoder, front, frame), decoder(people)];
    let [encoder, people]: [NodeId; 2] = nodes.map(|node| dag.add_node(node).unwrap_or_default());
    dag.add_edge(encoder, people)?;
    Ok(dag)
}

fn shared(node: Node, sensor: SensorId, frame: u16) -> Node {
    let frame = Frame { weights: 0, frame, sensor: Some(sensor) };
    Node::shared_encoder(node.wcet(), frame).in_pool(ACCELERATOR)
}

fn decoder(node: Node) -> Node {
    Node::decoder(node.wcet()).in_pool(ACCELERATOR)
}
