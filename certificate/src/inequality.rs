//! The tests: which inequalities a proof has to hold by, and whether it does.

use crate::graph::Shape;
use crate::rivals::Rivals;
use crate::work::Load;
use crate::{Keys, Proof, Rejected, Set, Variant};

/// What the inequalities are about: the set, as it was computed anew, and the response times that are stated.
pub(crate) struct World<'a> {
    pub(crate) set: &'a Set,
    /// By task and version.
    pub(crate) shapes: &'a [Vec<Shape>],
    /// Lengths of chains by task, version and cluster.
    pub(crate) chains: &'a [Vec<Vec<Vec<i128>>>],
    /// By task and cluster.
    pub(crate) loads: &'a [Vec<Load>],
}

/// What is to be proved: no job of this task with this graph responds later.
pub(crate) struct Claim<'a> {
    pub(crate) place: String,
    pub(crate) task: usize,
    pub(crate) version: usize,
    pub(crate) response: i128,
    pub(crate) proof: &'a Proof,
}

impl World<'_> {
    /// Evaluates the inequalities of one proof. Responses are from the longest path to the deadline, which is within the
    /// range of the set.
    pub(crate) fn proves(&self, claim: &Claim<'_>) -> Result<(), Rejected> {
        let shape = &self.shapes[claim.task][claim.version];
        if let Proof::Several { keys, waits_ns } = claim.proof {
            return self.several(claim, *keys, waits_ns);
        }
        if let Proof::Pools = claim.proof {
            return self.pools(claim);
        }
        let Some(cluster) = shape.only_cluster() else {
            return claim.refuse("all nodes of the graph in one cluster");
        };
        match claim.proof {
            Proof::A0 { keys, variant } => self.a0(claim, cluster, *keys, *variant),
            Proof::Prefix { keys, variant, segments_ns } => {
                self.prefix(claim, cluster, *keys, *variant, segments_ns)
            }
            Proof::Paths { chains } => self.paths(claim, cluster, *chains),
            Proof::Several { .. } | Proof::Pools => Ok(()),
        }
    }

    fn a0(&self, claim: &Claim<'_>, cluster: usize, keys: Keys, variant: Variant) -> Result<(), Rejected> {
        let (wait, cap, own) = self.waiting(claim, cluster, variant);
        let rivals = self.rivals(claim, cluster);
        let others = rivals.after_release(keys, claim.response, cap, wait);
        claim.holds("A0", rivals.lanes * wait, own + others)
    }

    fn prefix(
        &self,
        claim: &Claim<'_>,
        cluster: usize,
        keys: Keys,
        variant: Variant,
        segments_ns: &[u64],
    ) -> Result<(), Rejected> {
        let of_cluster = |task: &usize| self.is_in(*task, cluster);
        for task in (0..self.set.tasks.len()).filter(of_cluster) {
            if self.shapes[task].iter().any(|shape| shape.only_cluster() != Some(cluster)) {
                return claim.refuse("that all tasks of the cluster are in it alone");
            }
            if !self.is_constrained(task) {
                return claim.refuse("deadlines within the periods of all tasks of the cluster");
            }
        }
        if segments_ns.first() != Some(&0) || !segments_ns.is_sorted_by(|a, b| a < b) {
            return claim.refuse("segments that begin with 0 and increase");
        }
        let (wait, cap, own) = self.waiting(claim, cluster, variant);
        let rivals = self.rivals(claim, cluster);
        for pair in segments_ns.windows(2) {
            let (begin, end) = (i128::from(pair[0]), i128::from(pair[1]) - 1);
            let others = rivals.before_release(keys, claim.response, (begin, end), end + cap, wait);
            claim.holds("a segment of PREFIX", rivals.lanes * (begin + wait), own + others)?;
        }
        let begin = segments_ns.last().map_or(0, |begin| i128::from(*begin));
        let (done, there_is) = rivals.closing(keys, claim.response, begin, own, wait);
        claim.holds("the closing inequality of PREFIX, in 2^-32", done, there_is)
    }

    fn paths(&self, claim: &Claim<'_>, cluster: usize, beside: usize) -> Result<(), Rejected> {
        self.is_alone(claim, cluster)?;
        let shape = &self.shapes[claim.task][claim.version];
        let lengths = &self.chains[claim.task][claim.version][cluster];
        let left = i128::from(self.set.clusters[cluster].lanes) - beside as i128;
        if beside >= lengths.len() || left < 1 {
            return claim.refuse("as many chains, and lanes, as it counts");
        }
        if lengths.first() != Some(&shape.longest) {
            return claim.refuse("a longest path as its first chain");
        }
        let rest = shape.work - lengths[..=beside].iter().sum::<i128>();
        claim.holds("chains alone", left * (claim.response - shape.longest) + 1, rest)
    }

    fn is_alone(&self, claim: &Claim<'_>, cluster: usize) -> Result<(), Rejected> {
        let mut others = (0..self.set.tasks.len()).filter(|task| *task != claim.task);
        if others.any(|task| self.is_in(task, cluster)) {
            return claim.refuse("that no other task is in the cluster");
        }
        // The task's own jobs are apart if each ends before the next one may be released.
        let own = &self.loads[claim.task][cluster];
        if own.response > own.period() {
            return claim.refuse("a response time of the task within its period");
        }
        Ok(())
    }

    fn pools(&self, claim: &Claim<'_>) -> Result<(), Rejected> {
        let shape = &self.shapes[claim.task][claim.version];
        let (mut widest, mut shares) = (1, 0);
        for cluster in (0..self.set.clusters.len()).filter(|cluster| self.is_in(claim.task, *cluster)) {
            self.is_alone(claim, cluster)?;
            let here = shape.nodes.iter().filter(|node| node.cluster == cluster);
            let work: i128 = here.map(|node| node.cost).sum();
            let lanes = i128::from(self.set.clusters[cluster].lanes);
            shares += (work + lanes - 1).div_euclid(lanes);
            // A cluster that only other graphs of the task use makes the bound no smaller.
            if work > 0 {
                widest = lanes.max(widest);
            }
        }
        let least = shape.longest * (widest - 1) / widest + 1 + shares;
        claim.holds("pools alone", claim.response + 1, least)
    }

    fn several(&self, claim: &Claim<'_>, keys: Keys, waits_ns: &[u64]) -> Result<(), Rejected> {
        let shape = &self.shapes[claim.task][claim.version];
        if !self.is_constrained(claim.task) {
            return claim.refuse("a deadline within the period");
        }
        if waits_ns.len() != self.set.clusters.len() {
            return claim.refuse("a wait for each cluster");
        }
        let waits = waits_ns.iter().map(|wait| i128::from(*wait));
        if shape.longest + waits.clone().sum::<i128>() != claim.response {
            return claim.refuse("waits that make up the response time with the longest path");
        }
        for (cluster, wait) in waits.enumerate() {
            let here = |node: usize| shape.nodes[node].cluster == cluster;
            if !(0..shape.nodes.len()).any(here) {
                if wait > 0 {
                    return claim.refuse("no wait for a cluster without a node");
                }
                continue;
            }
            let cost = |node: usize| if here(node) { shape.nodes[node].cost } else { 0 };
            let work: i128 = (0..shape.nodes.len()).map(cost).sum();
            let lengths = &self.chains[claim.task][claim.version][cluster];
            let more = wait + 1;
            let own = (work - shape.least(cost)).min(Load::beside(lengths, more));
            let rivals = self.rivals(claim, cluster);
            let others = rivals.on_entry(keys, cluster, claim.response, more);
            claim.holds("several clusters", rivals.lanes * more, own + others)?;
        }
        Ok(())
    }

    /// How long the critical chain of a job that responds later waits, in how much of that time others are counted, and what
    /// the job itself does in it.
    fn waiting(&self, claim: &Claim<'_>, cluster: usize, variant: Variant) -> (i128, i128, i128) {
        let Shape { work, longest, shortest, .. } = &self.shapes[claim.task][claim.version];
        let (rest, shorter) = (work - longest, longest - shortest);
        let wait = claim.response - longest + 1;
        match variant {
            Variant::A => (wait, wait + shorter, rest),
            Variant::B => {
                let average = if wait <= rest { rest } else { (rest + shorter) * wait / (wait + shorter) };
                let lengths = &self.chains[claim.task][claim.version][cluster];
                (wait, wait, average.min(Load::beside(lengths, wait)))
            }
        }
    }

    fn rivals(&self, claim: &Claim<'_>, cluster: usize) -> Rivals<'_> {
        let others = self.loads.iter().enumerate().filter(|(task, _)| *task != claim.task);
        Rivals {
            lanes: i128::from(self.set.clusters[cluster].lanes),
            others: others.map(|(_, loads)| &loads[cluster]).collect(),
            own: &self.loads[claim.task][cluster],
            shape: &self.shapes[claim.task][claim.version],
        }
    }

    fn is_in(&self, task: usize, cluster: usize) -> bool {
        self.shapes[task].iter().flat_map(|shape| &shape.nodes).any(|node| node.cluster == cluster)
    }

    fn is_constrained(&self, task: usize) -> bool {
        let task = &self.set.tasks[task];
        task.period_ns.is_none_or(|period| task.deadline_ns <= period)
    }
}

impl Claim<'_> {
    fn refuse(&self, needs: &'static str) -> Result<(), Rejected> {
        Err(Rejected::Test { place: self.place.clone(), test: self.proof.name(), needs })
    }

    fn holds(&self, inequality: &str, done: i128, there_is: i128) -> Result<(), Rejected> {
        let place = || format!("{}, {inequality}", self.place);
        if done > there_is { Ok(()) } else { Err(Rejected::Inequality { place: place(), done, there_is }) }
    }
}

#[cfg(test)]
mod tests;
