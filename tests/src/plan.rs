//! The integers of `plan --json`, by the formulas of the specification, one task at a time.

use red_workload::model::{Arrival, Task, Workload};

use crate::graph::Graph;

/// One level of a task's refined base graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Level {
    /// Sum of the costs of its nodes.
    pub cost_ns: u64,
    /// Its share of the deadline under the paper's rule.
    pub share_ns: u64,
    /// Graham's bound for the level alone on its lanes.
    pub graham_ns: u64,
}

/// One node of a task's refined base graph; every sub-deadline is relative to the release.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlanNode {
    /// `node`, or `stage.part`.
    pub name: String,
    /// Height.
    pub height: usize,
    /// Cost c', contention included.
    pub cost_ns: u64,
    /// Sub-deadline of the paper's rule.
    pub level_sum_ns: u64,
    /// Sub-deadline with Graham's weights.
    pub level_graham_ns: u64,
    /// D * head / (head + tail); D at sinks.
    pub path_proportional_ns: u64,
    /// D - tail; negative when D is too short.
    pub latest_finish_ns: i128,
    /// D - tail - c'; negative when D is too short.
    pub latest_start_ns: i128,
}

/// What `plan` says about one task.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TaskPlan {
    /// Sum of all costs.
    pub work_ns: u64,
    /// Longest path.
    pub critical_path_ns: u64,
    /// Levels from the sources on.
    pub levels: Vec<Level>,
    /// Nodes in file order.
    pub nodes: Vec<PlanNode>,
    /// Bound of the response of one job alone.
    pub graham_ns: u64,
    /// The same by peeled paths; only where all nodes share a pool.
    pub long_path_ns: Option<u64>,
    /// Smaller of deadline and period, which the bounds are held against.
    pub limit_ns: u64,
    /// Whether Graham's bound of every level fits its share.
    pub levels_fit: bool,
}

/// Plans the base graph of `task`, a task of `workload`.
pub fn plan(workload: &Workload, task: &Task) -> TaskPlan {
    let graph = Graph::of(&task.nodes, true);
    let costs = graph.costs();
    let (heads, tails) = (graph.heads(&costs), graph.tails(&costs));
    let heights = graph.heights(|_| true);
    let sums = level_sums(&heights, &costs);
    let due = level_offsets(&sums, task.deadline_ns);
    let (grahams, graham_due) = level_graham(workload, &graph, &heights, task.deadline_ns);

    let level = |h: usize| Level {
        cost_ns: sums[h],
        share_ns: due[h] - if h == 0 { 0 } else { due[h - 1] },
        graham_ns: grahams[h],
    };
    let levels: Vec<Level> = (0..sums.len()).map(level).collect();
    let deadline = i128::from(task.deadline_ns);
    let node = |v: usize| PlanNode {
        name: graph.nodes[v].name.clone(),
        height: heights[v],
        cost_ns: costs[v],
        level_sum_ns: due[heights[v]],
        level_graham_ns: graham_due[heights[v]],
        path_proportional_ns: if graph.nodes[v].succs.is_empty() {
            task.deadline_ns
        } else {
            portion(task.deadline_ns, heads[v], heads[v] + tails[v]).unwrap_or(task.deadline_ns)
        },
        latest_finish_ns: deadline - i128::from(tails[v]),
        latest_start_ns: deadline - i128::from(tails[v]) - i128::from(costs[v]),
    };
    TaskPlan {
        work_ns: costs.iter().sum(),
        critical_path_ns: graph.longest_path(&costs),
        levels_fit: levels.iter().all(|level| level.graham_ns <= level.share_ns),
        levels,
        nodes: (0..costs.len()).map(node).collect(),
        graham_ns: graham_bound(workload, &graph),
        long_path_ns: long_path_bound(workload, &graph),
        limit_ns: match task.arrival {
            Arrival::Periodic { period_ns: gap } | Arrival::Sporadic { min_interarrival_ns: gap } => {
                gap.min(task.deadline_ns)
            }
            Arrival::Once => task.deadline_ns,
        },
    }
}

/// Cost of each level.
pub fn level_sums(heights: &[usize], costs: &[u64]) -> Vec<u64> {
    let mut sums = vec![0; heights.iter().max().map_or(0, |highest| highest + 1)];
    for (&height, &cost) in heights.iter().zip(costs) {
        sums[height] += cost;
    }
    sums
}

/// End of each level when `budget` is split in proportion to `weights`: floor(budget * prefix / total), so
/// that the last is the budget itself. All weights zero count as one each.
pub fn level_offsets(weights: &[u64], budget: u64) -> Vec<u64> {
    let weights = one_each_if_zero(weights);
    let total: u64 = weights.iter().sum();
    prefixes(&weights).into_iter().map(|prefix| portion(budget, prefix, total).unwrap_or(budget)).collect()
}

/// Graham's bound of each level, and the end of each level under LevelGraham.
fn level_graham(
    workload: &Workload,
    graph: &Graph,
    heights: &[usize],
    deadline: u64,
) -> (Vec<u64>, Vec<u64>) {
    let pools = pools_of(graph);
    let of_level = |height: usize, pool: usize| {
        let here = (0..graph.nodes.len()).filter(|&v| heights[v] == height && graph.nodes[v].pool == pool);
        let costs: Vec<u64> = here.map(|v| graph.nodes[v].cost_ns).collect();
        let longest = costs.iter().copied().max().unwrap_or(0);
        (longest, costs.iter().sum::<u64>() - longest, u64::from(workload.pools[pool].lanes))
    };
    let count = level_sums(heights, &graph.costs()).len();
    let grahams: Vec<u64> = (0..count)
        .map(|height| {
            let bound = |&pool: &usize| {
                let (longest, rest, lanes) = of_level(height, pool);
                longest + rest.div_ceil(lanes)
            };
            pools.iter().map(bound).max().unwrap_or(0)
        })
        .collect();
    // The exact weight is m times Graham's bound before rounding; between pools only the bound compares.
    let weights: Vec<u64> = match pools[..] {
        [pool] => (0..count)
            .map(|height| {
                let (longest, rest, lanes) = of_level(height, pool);
                lanes * longest + rest
            })
            .collect(),
        _ => grahams.clone(),
    };
    let needed: u64 = grahams.iter().sum();
    let due = if needed <= deadline {
        let spare = level_offsets(&weights, deadline - needed);
        prefixes(&grahams).into_iter().zip(spare).map(|(bound, extra)| bound + extra).collect()
    } else {
        level_offsets(&weights, deadline)
    };
    (grahams, due)
}

/// Bound on the response of one job alone: Graham's on one pool, its extension to several.
fn graham_bound(workload: &Workload, graph: &Graph) -> u64 {
    let costs = graph.costs();
    let longest = graph.longest_path(&costs);
    let lanes = |pool: usize| u64::from(workload.pools[pool].lanes);
    let work = |pool: usize| -> u64 {
        graph.nodes.iter().filter(|node| node.pool == pool).map(|node| node.cost_ns).sum()
    };
    let pools = pools_of(graph);
    match pools[..] {
        [pool] => longest + (work(pool) - longest).div_ceil(lanes(pool)),
        _ => {
            let most = pools.iter().map(|&pool| lanes(pool)).max().unwrap_or(1);
            let scaled = u128::from(longest) * u128::from(most - 1) / u128::from(most);
            let spread: u64 = pools.iter().map(|&pool| work(pool).div_ceil(lanes(pool))).sum();
            u64::try_from(scaled).expect("not above the longest path") + 1 + spread
        }
    }
}

/// min over j < m of L + ceil((W - len_0 - ... - len_j) / (m - j)), paths peeled longest first.
fn long_path_bound(workload: &Workload, graph: &Graph) -> Option<u64> {
    let [pool] = pools_of(graph)[..] else { return None };
    let mut costs = graph.costs();
    let longest = graph.longest_path(&costs);
    let mut rest: u64 = costs.iter().sum();
    let lanes = u64::from(workload.pools[pool].lanes);
    let mut best = u64::MAX;
    for j in 0..lanes {
        rest -= peel(graph, &mut costs);
        best = best.min(longest + rest.div_ceil(lanes - j));
    }
    Some(best)
}

/// Zeroes the costs of one longest path, found from its end by lowest index, and returns its length.
fn peel(graph: &Graph, costs: &mut [u64]) -> u64 {
    let heads = graph.heads(costs);
    let length = heads.iter().copied().max().unwrap_or(0);
    let mut at = heads.iter().position(|&head| head == length);
    while let Some(v) = at {
        let before = heads[v] - costs[v];
        costs[v] = 0;
        at = graph.nodes[v].preds.iter().copied().find(|&u| heads[u] == before);
    }
    length
}

fn pools_of(graph: &Graph) -> Vec<usize> {
    let mut pools: Vec<usize> = graph.nodes.iter().map(|node| node.pool).collect();
    pools.sort_unstable();
    pools.dedup();
    pools
}

fn one_each_if_zero(weights: &[u64]) -> Vec<u64> {
    if weights.iter().all(|&weight| weight == 0) { vec![1; weights.len()] } else { weights.to_vec() }
}

fn prefixes(values: &[u64]) -> Vec<u64> {
    let sum_to = |end: usize| values[..=end].iter().sum();
    (0..values.len()).map(sum_to).collect()
}

/// floor(budget * part / whole), or nothing of nothing.
pub fn portion(budget: u64, part: u64, whole: u64) -> Option<u64> {
    let exact = (u128::from(budget) * u128::from(part)).checked_div(u128::from(whole))?;
    Some(u64::try_from(exact).expect("a part is not above the whole"))
}

#[cfg(test)]
mod tests;
