//! What a node took: the last 8 executions alone. Samples are kept in 32 bits: exact below 4.29 s; for nodes with a
//! longer WCET the low bits are dropped, so that the whole WCET fits (below one part in 10^9).

use crate::capacity::Empty;
use crate::graph::Node;
use crate::time::{CostEstimate, Duration};

/// Length of the window: the paper's k = 8 (section 4.3, re-assignment).
pub(crate) const WINDOW: usize = 8;

crate::capacity::stored! {
    /// Mean, minimum and maximum of the last 8 executions of one node.
    ///
    /// ```
    /// use red_core::{CostEstimate, Duration, Estimator, Node, Wcet};
    /// let mut window = Estimator::new(&Node::new(Wcet::from_millis(10)));
    /// assert_eq!(window.mean(), None); // before the first sample the WCET stands in
    /// [4, 8].map(|ms| window.push(Duration::from_millis(ms)));
    /// assert_eq!(window.mean(), Some(CostEstimate::from_millis(6)));
    /// assert_eq!(window.maximum(), Some(Duration::from_millis(8)));
    /// ```
    #[derive(Clone, Copy, Debug)]
    #[repr(Rust, packed(2))] // Tasks hold many of these: 4-byte alignment would pad each.
    pub struct Estimator {
        samples: [u32; WINDOW],
        /// Samples taken; from 8 on, 8 plus the place of the oldest.
        taken: u8,
        shift: u8,
    }
}

impl Estimator {
    /// No sample yet; `node` says how long samples may be.
    pub const fn new(node: &Node) -> Self {
        let bits = u64::BITS - node.wcet.as_nanos().leading_zeros();
        Self { shift: bits.saturating_sub(u32::BITS) as u8, ..Self::EMPTY }
    }

    /// Takes a sample; the oldest of 8 goes. Time bound: O(1).
    #[inline]
    pub fn push(&mut self, executed: Duration) {
        let scaled = (executed.as_nanos() >> self.shift).min(u32::MAX.into());
        self.samples[usize::from(self.taken) % WINDOW] = scaled as u32;
        // From 8 on the bit of 8 stays: 15 is followed by 8.
        self.taken = ((self.taken + 1) | (self.taken & WINDOW as u8)) % (2 * WINDOW as u8);
    }

    /// Mean, rounded down.
    pub fn mean(&self) -> Option<CostEstimate> {
        let sum: u64 = self.taken().map(u64::from).sum();
        let mean = sum.checked_div(self.taken().len() as u64)?;
        Some(CostEstimate::from_nanos(mean << self.shift))
    }

    /// Shortest.
    pub fn minimum(&self) -> Option<Duration> {
        self.taken().min().map(|least| self.unscaled(least))
    }

    /// Shortest of a whole window; fewer samples prove nothing.
    pub(crate) fn best_case(&self) -> Option<Duration> {
        self.minimum().filter(|_| usize::from(self.taken) >= WINDOW)
    }

    /// Longest.
    pub fn maximum(&self) -> Option<Duration> {
        self.taken().max().map(|most| self.unscaled(most))
    }

    fn taken(&self) -> impl ExactSizeIterator<Item = u32> {
        let samples = self.samples;
        samples.into_iter().take(self.taken.into())
    }

    fn unscaled(&self, sample: u32) -> Duration {
        Duration::from_nanos(u64::from(sample) << self.shift)
    }
}
