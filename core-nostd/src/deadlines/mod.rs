//! Layer 2: sub-deadlines. Rules are data; each assigns every node an offset from the release.

pub(crate) mod estimate;
pub(crate) mod exact;
pub(crate) mod level;
pub(crate) mod path;

use crate::capacity::{Capacity, Empty};
use crate::graph::Levels;
use crate::id::NodeId;
use crate::time::Duration;
pub use estimate::Estimator;
pub(crate) use estimate::{Window, shift};
pub use level::{LevelShare, shares};

crate::capacity::values! {
    /// How a node's sub-deadline follows from the end-to-end deadline D. `c` is WCET plus contention.
    pub enum DeadlineRule {
        /// d = D for every node: job-level EDF.
        EndToEnd,
        /// Level shares in proportion to the level's cost (paper Def. 4).
        LevelSum,
        /// Level shares that cover Graham's bound of each level first.
        LevelGraham,
        /// d = floor(D * head / (head + tail)), for progress reports.
        PathProportional,
        /// d = D - tail.
        LatestFinish,
        /// d = D - tail, dispatched by d - c: the latest start that can still meet D.
        LatestStart,
    }
}

impl DeadlineRule {
    /// Whether the rule divides D among levels, so that re-assignment over the residual graph applies.
    pub const fn is_level(self) -> bool {
        matches!(self, Self::LevelSum | Self::LevelGraham)
    }
}

/// A graph's offsets under one rule: nanoseconds after the release, negative where D is below the critical path.
///
/// ```
/// use red_core::{Caps, Dag, DeadlineRule, Duration, Levels, Node, SubDeadlines, Wcet};
/// let mut dag = Dag::<Caps<1, 8, 1>>::new();
/// let chain = [20, 20, 40].map(|ms| dag.add_node(Node::new(Wcet::from_millis(ms))).unwrap());
/// dag.add_edge(chain[0], chain[1])?;
/// dag.add_edge(chain[1], chain[2])?;
/// let due = SubDeadlines::assign(&Levels::of(&dag), DeadlineRule::LevelSum, Duration::from_millis(120), &[1]);
/// assert_eq!(chain.map(|v| due.sub_deadline(v) / 1_000_000), [30, 60, 120]); // the paper's worked example
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct SubDeadlines<C: Capacity> {
    pub(crate) due: C::Nodes<i64>,
    pub(crate) key: C::Nodes<i64>,
}

impl<C: Capacity> SubDeadlines<C> {
    /// Applies `rule`. `lanes` is the number of lanes of each pool. Time bound: O(nodes + edges + nodes * pools).
    pub fn assign(levels: &Levels<'_, C>, rule: DeadlineRule, deadline: Duration, lanes: &[u8]) -> Self {
        let d = deadline.as_nanos();
        let mut new = Self { due: Empty::EMPTY, key: Empty::EMPTY };
        let due = &mut new.due;
        match rule {
            DeadlineRule::EndToEnd => levels.places().for_each(|i| due[i] = d.cast_signed()),
            DeadlineRule::LevelSum | DeadlineRule::LevelGraham => {
                let shares = shares(levels, rule, deadline, lanes);
                levels.places().for_each(|i| due[i] = shares[levels.height[i].into()].end.cast_signed());
            }
            DeadlineRule::PathProportional => path::proportional(levels, d, due),
            DeadlineRule::LatestFinish | DeadlineRule::LatestStart => path::latest_finish(levels, d, due),
        }
        let early = |i: usize| if rule == DeadlineRule::LatestStart { levels.dag.at(i).cost() } else { 0 };
        levels.places().for_each(|i| new.key[i] = new.due[i].saturating_sub_unsigned(early(i)));
        new
    }

    /// When the node should have ended.
    pub fn sub_deadline(&self, node: NodeId) -> i64 {
        if node.index() < C::NODES { self.due[node.index()] } else { 0 }
    }

    /// What the ready queue orders by: the sub-deadline, under `LatestStart` less the node's cost.
    pub fn key(&self, node: NodeId) -> i64 {
        if node.index() < C::NODES { self.key[node.index()] } else { 0 }
    }
}
