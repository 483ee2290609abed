//! m-of-k floors: at least m of any k consecutive jobs of a task are to be on time.
//!
//! *Background.* (m, k)-firm deadlines, Hamdaoui and Ramanathan 1995. *Rule.* A job is lost if it was given up,
//! refused or late, for whatever reason. A floor can spare a job if every window of k consecutive job indices that
//! contains it has at most k - m lost jobs, itself included.

/// Longest window that is remembered, in jobs.
pub(crate) const MEMORY: u32 = 128;

/// How many of a task's last jobs tell how it fared.
pub(crate) const RECENT: u32 = 16;

crate::capacity::stored! {
    /// A task's floor, and which of its last 128 jobs were lost.
    ///
    /// ```
    /// let mut floor = red_core::Floor::new(3, 4);
    /// floor.ended(7, true);
    /// assert!(!floor.spares(8)); // jobs 5 to 8 would have lost two
    /// assert!(floor.spares(11));
    /// ```
    #[derive(Clone, Copy, Debug)]
    #[repr(Rust, packed(8))] // Tasks hold many of these: 16-byte alignment would pad each.
    pub struct Floor {
        /// Lost jobs; bit 0 is job `newest`.
        lost: u128,
        /// The largest index of a job that ended.
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
        Self { lost: 0, newest: 0, window: window as u8, allowed: allowed as u8 }
    }

    /// Whether it needs any job.
    pub(crate) const fn needs_some(&self) -> bool {
        self.window > self.allowed
    }

    /// How many of how many jobs it needs.
    pub(crate) const fn part(&self) -> [u8; 2] {
        [self.window.saturating_sub(self.allowed), self.window]
    }

    /// Whether the floor is kept without job `index`; without a floor, always. Time bound: O(k), at most 128.
    pub fn spares(&self, index: u64) -> bool {
        let window = u64::from(self.window);
        if window > 0 && self.newest.saturating_sub(index) + window > u64::from(MEMORY) {
            return false; // What was lost so far back is forgotten, so that the job is kept.
        }
        let mut without = *self;
        without.ended(index, true);
        without.windows_of(index).all(|lost| lost <= u32::from(self.allowed))
    }

    /// The most jobs that were lost in a window that contains job `index`. Time bound: O(k), at most 128.
    pub fn most_lost_around(&self, index: u64) -> u32 {
        self.windows_of(index).max().unwrap_or(0)
    }

    /// Lost jobs of each window that contains a job: it ends between the job itself and the last that could contain it.
    fn windows_of(&self, index: u64) -> impl Iterator<Item = u32> {
        (index..index + u64::from(self.window)).map(|last| self.lost_up_to(last))
    }

    /// Remembers how job `index` ended.
    pub fn ended(&mut self, index: u64, is_lost: bool) {
        self.lost = self.lost.unbounded_shl(jobs_between(self.newest, index));
        self.newest = self.newest.max(index);
        self.lost |= u128::from(is_lost).unbounded_shl(jobs_between(index, self.newest));
    }

    /// How many of the last 16 jobs, up to the newest that ended, were lost. Time bound: O(1).
    pub(crate) fn recently_lost(&self) -> u32 {
        (self.lost as u16).count_ones()
    }

    /// How many of the last jobs were lost in a row, up to the newest that ended, as far as they are remembered. Time bound: O(1).
    pub(crate) fn lost_in_row(&self) -> u32 {
        let lost = self.lost;
        lost.trailing_ones()
    }

    /// How the task fared of late, the least the worst: how many of the last 16 were not lost, then how many of those that are
    /// remembered were before the last that was not. Time bound: O(1).
    pub(crate) fn fortune(&self) -> u8 {
        ((RECENT - self.recently_lost()) * 8 + (MEMORY - self.lost_in_row()) / RECENT) as u8
    }

    /// Lost jobs in the window that ends at `last`.
    fn lost_up_to(&self, last: u64) -> u32 {
        // What is newer than the window is shifted out; of its jobs, those newer than `newest` were not lost.
        let newer = jobs_between(last, self.newest);
        let known = u32::from(self.window).saturating_sub(jobs_between(self.newest, last));
        (self.lost.unbounded_shr(newer) & !u128::MAX.unbounded_shl(known)).count_ones()
    }
}

/// By how many jobs `last` is after `first`, at least 0; all that are forgotten count alike.
fn jobs_between(first: u64, last: u64) -> u32 {
    last.saturating_sub(first).min(MEMORY.into()) as u32
}
