//! Whether a changed workload is as good to every task as it was.

use super::between::Between;
use super::evidence::{self, MOST_SUB_JOBS};
use super::judged;
use crate::outcome::Failure;
use red_sim::{Execution, Options, Report, simulate};
use red_workload::model::Workload;
use red_workload::plan::{Guarantee, Plan};

/// Sub-jobs of each of the four simulations.
const SUB_JOBS: u128 = MOST_SUB_JOBS / 4;
/// Shares of the WCET, in millionths, where the file declares no best cases.
const HALF_TO_ALL: Execution = Execution::Uniform { low_ppm: 500_000, high_ppm: 1_000_000 };

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

/// Whether no task misses more deadlines in a simulation, at WCET and where times vary. Jobs that are on time are no measure:
/// the last ones may be undecided in one of the two.
fn loses_nothing(workload: &Workload, other: &Workload) -> Result<bool, Failure> {
    let options = evidence::at_wcet(evidence::evidence_ns(workload, SUB_JOBS));
    for run in [at_wcet, where_times_vary] {
        let [before, after] = [run(workload, &options)?, run(other, &options)?];
        if before.tasks.iter().zip(&after.tasks).any(|(before, after)| after.missed > before.missed) {
            return Ok(false);
        }
    }
    Ok(true)
}

fn at_wcet(workload: &Workload, options: &Options) -> Result<Report, Failure> {
    Ok(simulate(workload, options)?)
}

fn where_times_vary(workload: &Workload, options: &Options) -> Result<Report, Failure> {
    match Between::of(workload, options.seed) {
        Some(world) => world.simulate(options),
        None => at_wcet(workload, &Options { execution: HALF_TO_ALL, ..*options }),
    }
}
