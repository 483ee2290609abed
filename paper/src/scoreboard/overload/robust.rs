//! Robust EDF: a guarantee at arrival, rejection by least value, and rejected jobs that come back when there is time.
//!
//! *Rule.* Jobs run by deadlines. With every release, and whenever a node ended, it is reckoned when each job ends if they run
//! in that order: the mean work of all up to it over the lanes, or its own longest path where that is longer. While a job
//! ends late, the least valuable of those up to the first such is rejected. A rejected job does not run. It comes back, the
//! most valuable first, once all are in time with it.
//!
//! *On several lanes* the original says nothing: work over lanes is a bound from below.

use super::others::{Answer, Job, Look, Rule};

#[derive(Default)]
pub(super) struct Robust {
    /// Names of the jobs that are rejected.
    rejected: Vec<usize>,
}

impl Rule for Robust {
    fn look(&mut self, look: &Look<'_>) -> Answer {
        self.rejected.retain(|id| look.jobs.iter().any(|job| job.id == *id));
        let is_accepted = |job: &&Job| !self.rejected.contains(&job.id);
        let mut accepted: Vec<&Job> = look.jobs.iter().filter(is_accepted).collect();
        let mut rejected: Vec<&Job> = look.jobs.iter().filter(|job| !is_accepted(job)).collect();
        accepted.sort_by_key(|job| (job.deadline, job.id));
        while let Some(late) = first_late(&accepted, look) {
            let least = |(_, a): &(usize, &&Job), (_, b): &(usize, &&Job)| {
                a.value.total_cmp(&b.value).then((b.deadline, b.id).cmp(&(a.deadline, a.id)))
            };
            let Some((at, _)) = accepted[..=late].iter().enumerate().min_by(least) else { break };
            rejected.push(accepted.remove(at));
        }
        rejected
            .sort_by(|a, b| b.value.total_cmp(&a.value).then((a.deadline, a.id).cmp(&(b.deadline, b.id))));
        self.rejected.clear();
        for job in rejected {
            let at = accepted.partition_point(|other| (other.deadline, other.id) < (job.deadline, job.id));
            accepted.insert(at, job);
            if first_late(&accepted, look).is_some() {
                accepted.remove(at);
                self.rejected.push(job.id);
            }
        }
        Answer { order: accepted.iter().map(|job| job.id).collect(), given_up: Vec::new() }
    }
}

/// The first that ends late of jobs that run in this order.
fn first_late(jobs: &[&Job], look: &Look<'_>) -> Option<usize> {
    // A node of somebody who was rejected or given up keeps its lane all the same.
    let is_apart = |(id, _): &&(usize, u64)| !jobs.iter().any(|job| job.id == *id);
    let mut work: u64 = look.held.iter().filter(is_apart).map(|(_, left)| left).sum();
    jobs.iter().position(|job| {
        work += job.work;
        look.now + job.left.max(work.div_ceil(look.lanes)) > job.deadline
    })
}
