//! Names of things: small integers, with a generation where a place is reused. A late message about an old job
//! finds the generation changed and is refused as stale; it never reaches another job.

macro_rules! generational {
    ($($(#[$doc:meta])* $t:ident)*) => { $(
        crate::capacity::values! {
            $(#[$doc])*
            #[derive(Default, PartialOrd, Ord, Hash)]
            pub struct $t { index: u16, generation: u16, }
        }

        impl $t {
            pub(crate) const fn new(index: usize, generation: u16) -> Self {
                Self { index: index as u16, generation }
            }

            /// The place, counted from 0.
            pub const fn index(self) -> usize {
                self.index as usize
            }

            /// One integer, for a C ABI.
            pub const fn to_bits(self) -> u32 {
                (self.generation as u32) << 16 | self.index as u32
            }

            /// Back from [`Self::to_bits`].
            pub const fn from_bits(bits: u32) -> Self {
                Self { index: bits as u16, generation: (bits >> 16) as u16 }
            }
        }
    )* };
}

generational! {
    /// An admitted task.
    TaskId
    /// One release of a task, in flight.
    JobId
}

macro_rules! plain {
    ($($(#[$doc:meta])* $t:ident)*) => { $(
        crate::capacity::numbers! { $(#[$doc])* pub struct $t(u8); }

        impl $t {
            /// The `index`-th, counted from 0.
            pub const fn new(index: u8) -> Self {
                Self(index)
            }

            /// Counted from 0.
            pub const fn index(self) -> usize {
                self.0 as usize
            }
        }
    )* };
}

plain! {
    /// A node of one task.
    NodeId
    /// A lane, counted over all pools in their order.
    LaneId
    /// A pool of lanes.
    PoolId
    /// A sensor whose captures jobs may share.
    SensorId
}

crate::capacity::numbers! {
    /// A dispatched unit: which lane, which sub-job, and the how-manieth unit of that lane.
    ///
    /// Bits 0..8 lane, 8..16 node, 16..64 sequence number: a handle is used once.
    pub struct UnitId(u64);
}

impl UnitId {
    pub(crate) const fn new(sequence: u64, node: u8, lane: usize) -> Self {
        Self(sequence << 16 | (node as u64) << 8 | lane as u64)
    }

    /// The lane that runs it.
    pub const fn lane(self) -> LaneId {
        LaneId(self.0 as u8)
    }

    /// The node, of its first member.
    pub const fn node(self) -> NodeId {
        NodeId((self.0 >> 8) as u8)
    }

    /// One integer, for a C ABI.
    pub const fn to_bits(self) -> u64 {
        self.0
    }

    /// Back from [`UnitId::to_bits`].
    pub const fn from_bits(bits: u64) -> Self {
        Self(bits)
    }
}
