//! Schedulers that are not the product's: dynamic keys, and level shares without costs. Preemptive, global, at events.

use super::drive::{Case, Ends};
use super::sets::Graph;

/// What a ready node is ordered by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Key {
    /// Equal shares of D for all levels: the alternative that the paper rejects (section 4.2).
    LevelEqual,
    /// Least laxity first, looked at when something is released or ends.
    LeastLaxity,
    /// Job-level EDF; whoever has no laxity left goes first (Lee 1994).
    ZeroLaxity,
}

struct Node {
    /// What it will still execute, which nobody knows, and what it may.
    left: u64,
    wcet_left: u64,
    waits_for: usize,
}

struct Job<'a> {
    deadline: u64,
    nodes: Vec<Node>,
    shape: &'a Shape,
}

struct Shape {
    graph: Graph,
    tails: Vec<u64>,
    indegree: Vec<usize>,
    /// End of each node's level, for [`Key::LevelEqual`].
    level_end: Vec<u64>,
}

/// Runs a case on so many lanes.
#[must_use]
pub(crate) fn drive(case: &Case<'_>, key: Key, lanes: usize) -> Ends {
    let shapes: Vec<Shape> = case.tasks.iter().map(|task| Shape::of(&task.graph, task.deadline_ns)).collect();
    let mut pending: Vec<(u64, usize, u64)> = Vec::new();
    for (task, releases) in case.world.releases.iter().enumerate() {
        pending.extend(releases.iter().enumerate().map(|(index, at)| (*at, task, index as u64)));
    }
    pending.sort_unstable();
    let mut pending = pending.into_iter().peekable();
    let (mut jobs, mut now, mut ends): (Vec<Job<'_>>, u64, Ends) = (Vec::new(), 0, Ends::default());
    loop {
        while let Some((at, task, index)) = pending.next_if(|(at, _, _)| *at <= now) {
            ends.jobs += 1;
            jobs.push(Job::released(case, &shapes[task], task, index, at));
        }
        // The lanes' nodes from now on, by (key, job, node).
        let mut ready: Vec<(i128, usize, usize)> = Vec::new();
        for (j, job) in jobs.iter().enumerate() {
            for n in 0..job.nodes.len() {
                if job.nodes[n].waits_for == 0 && job.nodes[n].left > 0 {
                    ready.push((job.key(key, n, now), j, n));
                }
            }
        }
        ready.sort_unstable();
        let next_release = pending.peek().map(|(at, _, _)| *at);
        let (running, waiting) = ready.split_at(lanes.min(ready.len()));
        let first_end = running.iter().map(|(_, j, n)| now + jobs[*j].nodes[*n].left).min();
        // Somebody who waits loses the last of its laxity at an instant that is no event otherwise.
        let zero = (key == Key::ZeroLaxity).then(|| {
            let at = waiting.iter().map(|(_, j, n)| jobs[*j].laxity(*n, now));
            at.filter(|laxity| *laxity > 0).min().map(|laxity| now.saturating_add(laxity as u64))
        });
        let next = [first_end, next_release, zero.flatten()].into_iter().flatten().min();
        let Some(next) = next else { return ends };
        for &(_, j, n) in running {
            jobs[j].executed(n, next - now);
        }
        now = next;
        jobs.retain(|job| {
            let is_done = job.nodes.iter().all(|node| node.left == 0);
            if is_done {
                ends.missed += u64::from(now > job.deadline);
                ends.last_end = now;
            }
            !is_done
        });
        if case.world.until_miss && (ends.missed > 0 || jobs.iter().any(|job| job.deadline < now)) {
            ends.missed = ends.missed.max(1);
            return ends;
        }
    }
}

impl Shape {
    fn of(graph: &Graph, deadline: u64) -> Self {
        let mut indegree = vec![0; graph.costs.len()];
        let mut height = vec![0_u64; graph.costs.len()];
        for (from, successors) in graph.successors.iter().enumerate() {
            for to in successors {
                indegree[*to] += 1;
                height[*to] = height[*to].max(height[from] + 1);
            }
        }
        let levels = height.iter().max().map_or(1, |height| height + 1);
        let level_end = height.iter().map(|height| deadline * (height + 1) / levels).collect();
        Self { graph: graph.clone(), tails: graph.tails(), indegree, level_end }
    }
}

impl<'a> Job<'a> {
    fn released(case: &Case<'_>, shape: &'a Shape, task: usize, index: u64, at: u64) -> Self {
        // A node that takes no time would never be ready to end: it takes a nanosecond here.
        let node = |n: usize| {
            let (left, waits_for) = ((case.world.time)(task, index, n).max(1), shape.indegree[n]);
            Node { left, wcet_left: shape.graph.costs[n].max(left), waits_for }
        };
        let nodes = (0..shape.graph.costs.len()).map(node).collect();
        Job { deadline: at + case.tasks[task].deadline_ns, nodes, shape }
    }

    /// Time until the node has to run for the job to be in time at WCET.
    fn laxity(&self, node: usize, now: u64) -> i128 {
        let after = i128::from(self.shape.tails[node]) + i128::from(self.nodes[node].wcet_left);
        i128::from(self.deadline) - after - i128::from(now)
    }

    fn key(&self, key: Key, node: usize, now: u64) -> i128 {
        match key {
            Key::LevelEqual => {
                let release = self.deadline - self.shape.level_end.iter().max().copied().unwrap_or(0);
                i128::from(release + self.shape.level_end[node])
            }
            Key::LeastLaxity => self.laxity(node, now),
            Key::ZeroLaxity if self.laxity(node, now) <= 0 => -1,
            Key::ZeroLaxity => i128::from(self.deadline),
        }
    }

    fn executed(&mut self, node: usize, time: u64) {
        self.nodes[node].left -= time;
        self.nodes[node].wcet_left -= time;
        if self.nodes[node].left == 0 {
            let shape = self.shape;
            for successor in &shape.graph.successors[node] {
                self.nodes[*successor].waits_for -= 1;
            }
        }
    }
}
