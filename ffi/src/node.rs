//! A node of a graph.

use crate::boundary::{Growing, plain};
use crate::config::flag;
use crate::status::red_status;
use crate::values::RED_NONE;
use red_core::{Bytes, Contention, Duration, Frame, Node, PoolId, Role, SensorId, Wcet};

/// What a node is in a MIMONet.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum red_role {
    /// Anything else.
    Ordinary = 0,
    /// The shared encoder of a stage.
    SharedEncoder = 1,
    /// A decoder: a successor of its encoder that reads the encoder's result.
    Decoder = 2,
}

/// A node: what it costs, where it runs, what it is. Begin with RED_NODE_INIT.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct red_node {
    /// RED_NODE_INIT sets it.
    pub struct_size: u32,
    /// RED_NODE_INIT sets it.
    pub abi_version: u32,
    /// Worst-case execution time alone.
    pub wcet_ns: u64,
    /// Best-case execution time, at most wcet_ns, by which jobs are found hopeless; 0 if nothing is known.
    pub bcet_ns: u64,
    /// Of an atomic node: the delay that co-runners can add; else 0.
    pub contention_ns: u64,
    /// Footprint.
    pub memory_bytes: u64,
    /// Its pool; 0 is the first.
    pub pool: u32,
    /// 1: once started it keeps its lane. 0: not.
    pub atomic: u32,
    /// One of red_role.
    pub role: u32,
    /// Of an encoder: which weights it has, a number of the host's; up to 65,535.
    pub weights: u32,
    /// Of an encoder: which frame it reads, a number of the host's; up to 65,535.
    pub frame: u32,
    /// Of an encoder: the sensor that captures the frame, or RED_NONE: every job has its own capture.
    pub sensor: u32,
}
plain!(red_node {
    struct_size: u32,
    abi_version: u32,
    wcet_ns: u64,
    bcet_ns: u64,
    contention_ns: u64,
    memory_bytes: u64,
    pool: u32,
    atomic: u32,
    role: u32,
    weights: u32,
    frame: u32,
    sensor: u32,
});
impl Growing for red_node {
    const LEAST: usize = 64;
}

impl red_node {
    pub(crate) fn read(self) -> Result<Node, red_status> {
        let out_of_range = |_| red_status::OutOfRange;
        let wcet = Wcet::from_nanos(self.wcet_ns);
        let node = match self.role {
            0 => Node::new(wcet),
            1 => {
                let sensor = if self.sensor == RED_NONE { None } else { Some(sensor(self.sensor)?) };
                let weights = u16::try_from(self.weights).map_err(out_of_range)?;
                let frame = u16::try_from(self.frame).map_err(out_of_range)?;
                Node::shared_encoder(wcet, Frame { weights, frame, sensor })
            }
            2 => Node::decoder(wcet),
            _ => return Err(red_status::OutOfRange),
        };
        let node = node.best_case(Duration::from_nanos(self.bcet_ns)).memory(Bytes(self.memory_bytes));
        let node = match (flag(self.atomic)?, self.contention_ns) {
            (true, contention) => node.atomic(Contention::from_nanos(contention)),
            (false, 0) => node,
            // Contention is defined for atomic nodes only.
            (false, _) => return Err(red_status::OutOfRange),
        };
        Ok(node.in_pool(pool(self.pool)?))
    }

    pub(crate) fn of(node: &Node) -> Self {
        let (role, weights, frame, sensor) = match node.role() {
            Role::Ordinary => (red_role::Ordinary, 0, 0, None),
            Role::SharedEncoder(Frame { weights, frame, sensor }) => {
                (red_role::SharedEncoder, weights, frame, sensor)
            }
            Role::Decoder => (red_role::Decoder, 0, 0, None),
        };
        let wcet_ns = node.wcet().as_nanos();
        Self {
            struct_size: 0,
            abi_version: 0,
            wcet_ns,
            bcet_ns: node.best().as_nanos(),
            contention_ns: node.cost().saturating_sub(wcet_ns),
            memory_bytes: node.footprint().0,
            pool: node.pool().index() as u32,
            atomic: node.is_atomic().into(),
            role: role as u32,
            weights: weights.into(),
            frame: frame.into(),
            sensor: sensor.map_or(RED_NONE, |sensor| sensor.index() as u32),
        }
    }
}

/// A pool of this number; whether it exists is for the class and the scheduler to say.
pub(crate) fn pool(number: u32) -> Result<PoolId, red_status> {
    u8::try_from(number).map(PoolId::new).map_err(|_| red_status::UnknownPool)
}

fn sensor(number: u32) -> Result<SensorId, red_status> {
    u8::try_from(number).map(SensorId::new).map_err(|_| red_status::UnknownSensor)
}
