//! m-of-k floors: at least m of any k consecutive jobs of a task are never shed by choice.
//!
//! *Background.* (m, k)-firm deadlines, Hamdaoui and Ramanathan 1995. *Rule.* A job may be dropped only if
//! every window of k consecutive job indices that contains it has at most k - m dropped jobs, itself included.
//! Jobs that are provably dead are not dropped by choice and do not count.

/// Longest window that is remembered, in jobs.
const MEMORY: u32 = 128;

crate::capacity::stored! {
    /// A task's floor and what was dropped among its last 128 jobs.
    ///
    /// ```
    /// let mut floor = red_core::Floor::new(3, 4);
    /// floor.dropped(7);
    /// assert!(!floor.permits(8)); // jobs 5 to 8 would have lost two
    /// assert!(floor.permits(11));
    /// ```
    #[derive(Clone, Copy, Debug)]
    #[repr(Rust, packed(8))] // Tasks hold many of these: 16-byte alignment would pad each.
    pub struct Floor {
        /// Dropped jobs; bit 0 is job `newest`.
        history: u128,
        newest: u64,
        pub(crate) window: u8,
        pub(crate) allowed: u8,
    }
}

impl Floor {
    /// At least `m` of any `k`. Windows above 128 jobs are kept by a stricter rule over 128: the allowance is
    /// divided among the 128-job windows that cover k.
    pub const fn new(m: u32, k: u32) -> Self {
        let spare = k.saturating_sub(m);
        let (window, allowed) = if k <= MEMORY { (k, spare) } else { (MEMORY, spare / k.div_ceil(MEMORY)) };
        Self { history: 0, newest: 0, window: window as u8, allowed: allowed as u8 }
    }

    /// Whether job `index` may be dropped by choice. Time bound: O(k), at most 128.
    pub fn permits(&self, index: u64) -> bool {
        let window = u64::from(self.window);
        if window > 0 && self.newest.saturating_sub(index) + window > u64::from(MEMORY) {
            return false; // What was dropped so far back is forgotten, so that the job is kept.
        }
        // A window ends at `last`, between the job itself and the last that could contain it.
        (index..index + window).all(|last| self.dropped_up_to(last) < u32::from(self.allowed))
    }

    /// Remembers that job `index` was dropped by choice.
    pub fn dropped(&mut self, index: u64) {
        self.history = self.history.unbounded_shl(jobs_between(self.newest, index));
        self.newest = self.newest.max(index);
        self.history |= 1u128.unbounded_shl(jobs_between(index, self.newest));
    }

    /// Dropped jobs in the window that ends at `last`.
    fn dropped_up_to(&self, last: u64) -> u32 {
        // What is newer than the window is shifted out; of its jobs, those newer than `newest` were not dropped.
        let newer = jobs_between(last, self.newest);
        let known = u32::from(self.window).saturating_sub(jobs_between(self.newest, last));
        (self.history.unbounded_shr(newer) & !u128::MAX.unbounded_shl(known)).count_ones()
    }
}

/// By how many jobs `last` is after `first`, at least 0; all that are forgotten count alike.
fn jobs_between(first: u64, last: u64) -> u32 {
    last.saturating_sub(first).min(MEMORY.into()) as u32
}
