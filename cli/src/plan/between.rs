//! A world in which nodes take anything from their best case to their WCET.

use crate::outcome::Failure;
use red_sim::{Drawn, Execution, Options, Report, World, simulate_in};
use red_workload::build::{Numbered, Role};
use red_workload::model::{Part, Workload};

/// Every time between the two is as likely.
pub(super) struct Between<'a> {
    /// Releases, and a share of each WCET.
    drawn: Drawn<'a>,
}

impl<'a> Between<'a> {
    /// Of a workload that declares best cases; nothing of another.
    pub(super) fn of(workload: &'a Workload, seed: u64) -> Option<Self> {
        let nodes = workload.tasks.iter().flat_map(|task| &task.nodes);
        let added = workload.events.iter().flat_map(|event| &event.add);
        let is_declared = nodes.chain(added).flat_map(|node| node.parts()).any(|(_, part)| part.bcet_ns > 0);
        let execution = Execution::Uniform { low_ppm: 0, high_ppm: 1_000_000 };
        is_declared.then_some(Self { drawn: Drawn { workload, execution, seed } })
    }

    /// Simulates. The file has no `[sync]` grid under the default policy, and best cases are those that it declares.
    pub(super) fn simulate(&self, options: &Options) -> Result<Report, Failure> {
        Ok(simulate_in(self, self.drawn.workload, options.policy.config(), options)?)
    }
}

impl World for Between<'_> {
    fn release(&self, task: usize, job: usize) -> Option<u64> {
        self.drawn.release(task, job)
    }

    fn time(&self, task: usize, job: u64, node: &Numbered) -> (u64, bool) {
        let (share_ns, is_known) = self.drawn.time(task, job, node);
        let time_ns = match &node.role {
            Role::Plain(part) | Role::Encoder { part, .. } | Role::Decoder { part, .. } => {
                between(part, share_ns)
            }
            // Only `edf` has stages as one node.
            Role::Coarse(_) => share_ns,
        };
        (time_ns, is_known)
    }
}

/// What `share_ns` of the WCET is of the room between best case and WCET, above the best case.
fn between(part: &Part, share_ns: u64) -> u64 {
    let room = u128::from(part.wcet_ns - part.bcet_ns);
    let above = room * u128::from(share_ns) / u128::from(part.wcet_ns.max(1));
    part.bcet_ns + u64::try_from(above).unwrap_or(0)
}

#[cfg(test)]
mod tests;
