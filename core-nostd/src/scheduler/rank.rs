//! The key of the pools' queues: a total order of jobs by their most pressing ready nodes.

crate::capacity::stored! {
    /// Key of the scheduler's queues: absolute key, then release, then task order, then job index.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
    pub(crate) struct Rank {
        key: i64,
        release: u64,
        /// Task order in the high 8 bits, job index below.
        tie: u64,
    }
}

impl Rank {
    #[inline(always)]
    pub(crate) const fn new(key: i64, release: u64, task_order: usize, job_index: u64) -> Self {
        Self { key, release, tie: (task_order as u64) << 56 | (job_index & ((1 << 56) - 1)) }
    }
}

#[cfg(test)]
mod tests;
