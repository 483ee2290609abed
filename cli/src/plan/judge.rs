//! Asks of a changed workload what `redrt plan` would say of it.

use super::evidence::{self, MOST_SUB_JOBS, Seen};
use red_sim::Lab;
use red_workload::model::Workload;
use red_workload::plan::{Judge, passes};

/// Sub-jobs of a quick look, and of the still quicker one before it: most of what misses does so at once.
const QUICK_SUB_JOBS: [u128; 2] = [2_000, 20_000];
/// Sub-jobs that may be simulated in all, counted and not timed: the answer is the same on every machine.
const ALL_SUB_JOBS: u128 = 6_000_000;

/// The verdict of `redrt plan`, as long as there is something left to spend on it.
pub(super) struct Verdict {
    left: u128,
    is_cut_short: bool,
}

impl Verdict {
    pub(super) const fn new() -> Self {
        Self { left: ALL_SUB_JOBS, is_cut_short: false }
    }

    /// Whether some question got no answer.
    pub(super) const fn is_cut_short(&self) -> bool {
        self.is_cut_short
    }

    fn spend(&mut self, workload: &Workload, most_sub_jobs: u128) -> bool {
        let horizon_ns = evidence::evidence_ns(workload, most_sub_jobs);
        match self.left.checked_sub(evidence::sub_jobs(workload, horizon_ns).min(most_sub_jobs)) {
            Some(left) => self.left = left,
            None => self.is_cut_short = true,
        }
        !self.is_cut_short
    }
}

impl Judge for Verdict {
    /// Misses at the begin are misses of the whole.
    fn may_fit(&mut self, workload: &Workload) -> bool {
        QUICK_SUB_JOBS.into_iter().all(|most| {
            self.spend(workload, most)
                && !matches!(evidence::seen(workload, most), Err(_) | Ok(Seen::Missed(_)))
        })
    }

    /// Tests and simulation. No proof is looked for: what is proved misses nothing in a simulation.
    fn fits(&mut self, workload: &Workload) -> bool {
        self.spend(workload, MOST_SUB_JOBS)
            && passes::<Lab>(workload)
            && !matches!(evidence::seen(workload, MOST_SUB_JOBS), Err(_) | Ok(Seen::Missed(_)))
    }
}
