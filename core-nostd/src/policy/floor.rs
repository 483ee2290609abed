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
    /// use red_core::Floor;
    /// let mut floor = Floor::new(3, 4);
    /// assert!(floor.permits(7));
    /// floor.dropped(7);
    /// assert!(!floor.permits(8)); // jobs 5 to 8 would have lost two
    /// assert!(!floor.permits(10));
    /// assert!(floor.permits(11));
    /// ```
    #[derive(Clone, Copy, Debug)]
    #[repr(Rust, packed(8))] // Tasks hold many of these: 16-byte alignment would pad each.
    pub struct Floor {
        /// Dropped jobs; bit 0 is job `newest`.
        history: u128,
        newest: u64,
        window: u8,
        allowed: u8,
    }
}

impl Floor {
    /// At least `m` of any `k`. Windows above 128 jobs are kept by a stricter rule over 128: the allowance is
    /// divided among the 128-job windows that cover k.
    pub const fn new(m: u32, k: u32) -> Self {
        let spare = k.saturating_sub(m);
        let (window, allowed) = if k <= MEMORY { (k, spare) } else { (MEMORY, spare / k.div_ceil(MEMORY)) };
        Self {
            history: 0,
            newest: 0,
            window: window as u8,
            allowed: if allowed > 255 { 255 } else { allowed as u8 },
        }
    }

    /// Whether job `index` may be dropped by choice. Time bound: O(k), at most 128.
    pub fn permits(&self, index: u64) -> bool {
        if self.window == 0 {
            return true;
        }
        let window = u64::from(self.window);
        if self.newest.saturating_sub(index) + window > u64::from(MEMORY) {
            return false; // What was dropped so far back is forgotten, so that the job is kept.
        }
        // A window ends at `last`, between the job itself and the last that could contain it.
        (index..index + window).all(|last| self.in_window(last, window) < u32::from(self.allowed))
    }

    /// Remembers that job `index` was dropped by choice.
    pub fn dropped(&mut self, index: u64) {
        if index > self.newest {
            let by = index - self.newest;
            self.history = if by < u64::from(MEMORY) { self.history << by } else { 0 };
            self.newest = index;
        }
        let age = self.newest - index;
        if age < u64::from(MEMORY) {
            self.history |= 1 << age;
        }
    }

    /// Dropped jobs with an index in `last - window + 1 ..= last`.
    fn in_window(&self, last: u64, window: u64) -> u32 {
        let ones = |n: u64| if n >= 128 { u128::MAX } else { (1u128 << n) - 1 };
        // In ages: from newest - last (could be below 0) to that plus window - 1.
        if last >= self.newest {
            let beyond = last - self.newest;
            if beyond >= window { 0 } else { (self.history & ones(window - beyond)).count_ones() }
        } else {
            let age = self.newest - last;
            if age >= 128 { 0 } else { (self.history >> age & ones(window)).count_ones() }
        }
    }
}
