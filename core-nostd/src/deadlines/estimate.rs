//! What a node took: the last 8 executions alone. Samples are kept in 32 bits: exact below 4.29 s; for nodes with a
//! longer WCET the low bits are dropped, so that the whole WCET fits (below one part in 10^9).

use crate::capacity::Empty;
use crate::graph::Node;
use crate::time::{CostEstimate, Duration};

/// Length of the window: the paper's k = 8 (section 4.3, re-assignment).
pub(crate) const WINDOW: usize = 8;

crate::capacity::stored! {
    /// The last 8 executions of a node, the newest last: one more than each took in the node's unit, 0 where none was.
    #[derive(Clone, Copy, Debug)]
    pub(crate) struct Window {
        samples: [u32; WINDOW],
    }
}

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
pub struct Estimator {
    window: Window,
    shift: u8,
}

/// By how many bits the samples of a node are shifted, for its whole WCET to fit.
pub(crate) const fn shift(node: &Node) -> u8 {
    let bits = u64::BITS - node.wcet.as_nanos().leading_zeros();
    bits.saturating_sub(u32::BITS) as u8
}

impl Window {
    /// Whether there is no sample yet.
    pub(crate) const fn is_empty(&self) -> bool {
        self.samples[WINDOW - 1] == 0
    }

    /// Whether there are 8 samples; fewer prove nothing.
    pub(crate) const fn is_whole(&self) -> bool {
        self.samples[0] > 0
    }

    /// Whether the newest sample is no shorter than a time, in whole units of the node's shift.
    pub(crate) const fn ends_with(&self, shift: u8, time: Duration) -> bool {
        self.samples[WINDOW - 1] as u64 > time.as_nanos() >> shift
    }

    /// Takes a sample of a node with this shift; the oldest of 8 goes. Time bound: O(1).
    #[inline]
    pub(crate) fn push(&mut self, shift: u8, executed: Duration) {
        let scaled = (executed.as_nanos() >> shift).min(u64::from(u32::MAX) - 1);
        self.samples.copy_within(1.., 0);
        self.samples[WINDOW - 1] = scaled as u32 + 1;
    }

    /// Forgets all but the newest sample. Time bound: O(1).
    pub(crate) fn keep_newest(&mut self) {
        let newest = self.samples[WINDOW - 1];
        *self = Self::EMPTY;
        self.samples[WINDOW - 1] = newest;
    }
}

impl Estimator {
    /// No sample yet; `node` says how long samples may be.
    pub const fn new(node: &Node) -> Self {
        Self::of(shift(node), &Window::EMPTY)
    }

    /// Of a node with its samples.
    pub(crate) const fn of(shift: u8, window: &Window) -> Self {
        Self { window: *window, shift }
    }

    /// Takes a sample; the oldest of 8 goes. Time bound: O(1).
    pub fn push(&mut self, executed: Duration) {
        self.window.push(self.shift, executed);
    }

    /// Mean, rounded down.
    pub fn mean(&self) -> Option<CostEstimate> {
        let sum: u64 = self.taken().sum();
        let mean = sum.checked_div(self.taken().count() as u64)?;
        Some(CostEstimate::from_nanos(mean << self.shift))
    }

    /// Shortest.
    pub fn minimum(&self) -> Option<Duration> {
        self.taken().min().map(|least| self.unscaled(least))
    }

    /// Shortest of a whole window.
    pub(crate) fn best_case(&self) -> Option<Duration> {
        self.minimum().filter(|_| self.window.is_whole())
    }

    /// Longest.
    pub fn maximum(&self) -> Option<Duration> {
        self.taken().max().map(|most| self.unscaled(most))
    }

    fn taken(&self) -> impl Iterator<Item = u64> {
        self.window.samples.into_iter().filter_map(|sample| u64::from(sample).checked_sub(1))
    }

    fn unscaled(&self, sample: u64) -> Duration {
        Duration::from_nanos(sample << self.shift)
    }
}
