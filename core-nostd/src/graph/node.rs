//! A node: what it costs, where it runs, what it is.

use crate::capacity::Empty;
use crate::id::{PoolId, SensorId};
use crate::time::{Bytes, Contention, Duration, Wcet};

crate::capacity::values! {
    /// What an encoder's result may be shared for: (weights, frame name, capture), the last from the job.
    pub struct Frame {
        /// Which weights the encoder has; the host numbers them.
        pub weights: u16,
        /// Which frame it reads; the host numbers the names.
        pub frame: u16,
        /// The sensor that captures the frame. `None`: every job has its own capture.
        pub sensor: Option<SensorId>,
    }

    /// A node of a DAG.
    ///
    /// ```
    /// use red_core::{Contention, Node, PoolId, Wcet};
    /// let control = Node::new(Wcet::from_millis(3)).atomic(Contention::from_millis(1)).in_pool(PoolId::new(0));
    /// assert_eq!(control.cost(), 4_000_000);
    /// ```
    #[must_use]
    pub struct Node {
        pub(crate) wcet: Wcet,
        pub(crate) best: Duration,
        pub(crate) contention: Contention,
        pub(crate) memory: Bytes,
        pub(crate) role: Role,
        pub(crate) pool: PoolId,
        /// Once started it keeps its lane.
        pub(crate) atomic: bool,
    }
}

/// What a node is in a MIMONet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Role {
    /// Anything else.
    Ordinary,
    /// The shared encoder of a stage.
    SharedEncoder(Frame),
    /// A decoder: a successor of its encoder that reads the encoder's result.
    Decoder,
}

// The variants without a frame are told by bits that a frame cannot have, so this one is all zero. Nobody asks a place
// without a node what it is.
crate::capacity::empty!(Role = Self::SharedEncoder(Frame::EMPTY));

impl Node {
    /// An ordinary node of the first pool without memory.
    pub const fn new(wcet: Wcet) -> Self {
        Self { wcet, role: Role::Ordinary, ..Self::EMPTY }
    }

    /// A shared encoder.
    pub const fn shared_encoder(wcet: Wcet, frame: Frame) -> Self {
        Self { role: Role::SharedEncoder(frame), ..Self::new(wcet) }
    }

    /// A decoder.
    pub const fn decoder(wcet: Wcet) -> Self {
        Self { role: Role::Decoder, ..Self::new(wcet) }
    }

    /// With a best-case execution time; default 0.
    pub const fn best_case(self, best: Duration) -> Self {
        Self { best, ..self }
    }

    /// Indivisible, with the delay that co-runners can add.
    pub const fn atomic(self, contention: Contention) -> Self {
        Self { atomic: true, contention, ..self }
    }

    /// With a memory footprint.
    pub const fn memory(self, memory: Bytes) -> Self {
        Self { memory, ..self }
    }

    /// In another pool.
    pub const fn in_pool(self, pool: PoolId) -> Self {
        Self { pool, ..self }
    }

    /// c' = WCET + contention: the cost in every formula. Nanoseconds.
    pub const fn cost(&self) -> u64 {
        self.wcet.as_nanos().saturating_add(self.contention.as_nanos())
    }

    /// What it is in a MIMONet.
    pub const fn role(&self) -> Role {
        self.role
    }

    /// Its pool.
    pub const fn pool(&self) -> PoolId {
        self.pool
    }

    /// Its worst-case execution time alone.
    pub const fn wcet(&self) -> Wcet {
        self.wcet
    }

    /// Its best-case execution time.
    pub const fn best(&self) -> Duration {
        self.best
    }

    /// Whether it keeps its lane once it has started.
    pub const fn is_atomic(&self) -> bool {
        self.atomic
    }

    /// Its footprint.
    pub const fn footprint(&self) -> Bytes {
        self.memory
    }
}
