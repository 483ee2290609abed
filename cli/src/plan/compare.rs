//! Whether a changed workload is as good to every task as it was.

use super::evidence::{self, MOST_SUB_JOBS};
use super::judged;
use crate::outcome::Failure;
use red_sim::simulate;
use red_workload::model::Workload;
use red_workload::plan::{Guarantee, Plan};

/// Sub-jobs of each of the two simulations.
const SUB_JOBS: u128 = MOST_SUB_JOBS / 4;

/// Whether under `other`, of the same tasks, the verdict is no worse than `plan` of `workload`, and no task has a longer
/// bound or more misses.
pub(super) fn is_no_worse(workload: &Workload, plan: &Plan, other: &Workload) -> bool {
    judged(other).is_ok_and(|(after, _)| {
        let (was, is) = (&plan.admission, &after.admission);
        (is.fits || !was.fits)
            && worth(is.guarantee) >= worth(was.guarantee)
            && bounds_hold(plan, &after)
            && (is.guarantee == Guarantee::Analytic || loses_nothing(workload, other).unwrap_or(false))
    })
}

const fn worth(guarantee: Guarantee) -> u8 {
    match guarantee {
        Guarantee::Analytic => 2,
        Guarantee::Empirical => 1,
        Guarantee::BestEffort => 0,
    }
}

/// Of a task that is not proved among all, what a job alone takes is all that is known.
fn bounds_hold(before: &Plan, after: &Plan) -> bool {
    let proofs = after.certificate.tasks.iter();
    before.tasks.iter().zip(&after.tasks).zip(proofs).all(|((before, after), proof)| {
        proof.response_ns.is_some()
            || after.certificate.largest_response_ns() <= before.certificate.largest_response_ns()
    })
}

/// Whether no task misses more deadlines in a simulation. Jobs that are on time are no measure: the last ones may be
/// undecided in one of the two.
fn loses_nothing(workload: &Workload, other: &Workload) -> Result<bool, Failure> {
    let options = evidence::at_wcet(evidence::evidence_ns(workload, SUB_JOBS));
    let [before, after] = [simulate(workload, &options)?, simulate(other, &options)?];
    Ok(before.tasks.iter().zip(&after.tasks).all(|(before, after)| after.missed <= before.missed))
}
