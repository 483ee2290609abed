//! An independent judge of schedules: what every valid schedule has in common, checked on the rows alone,
//! without simulating.
//!
//! A schedule that passes need not be the one the rules prescribe; a schedule that fails breaks one of them.
//! Left out, because the rows do not show them: re-assigned keys, the choice of the overload monitor, what
//! memory pressure allows to overtake or evict. Every run is compared with every other, so that some thousand
//! rows are the most that is quick.

mod cache;
mod jobs;
mod lanes;
mod order;
mod sheds;

use red_workload::model::Workload;

use crate::oracle::{Policy, Row, ShedRow};
use jobs::Facts;

/// Judges `rows` and `sheds`, the whole schedule of `workload` over [0, `horizon_ns`) under `policy`, every
/// node executing for its WCET, without preemption.
///
/// # Errors
///
/// The first broken rule, with the row or job that breaks it.
pub fn validate(
    workload: &Workload,
    policy: Policy,
    horizon_ns: u64,
    rows: &[Row],
    sheds: &[ShedRow],
) -> Result<(), String> {
    sorted(rows, sheds)?;
    let facts = Facts::gather(workload, policy, horizon_ns, rows, sheds)?;
    lanes::check(&facts)?;
    jobs::check(&facts)?;
    sheds::check(&facts)?;
    if policy.caches() {
        cache::check(&facts)?;
    }
    order::check(&facts)
}

fn sorted(rows: &[Row], sheds: &[ShedRow]) -> Result<(), String> {
    if let Some(pair) = rows.windows(2).find(|pair| pair[0] >= pair[1]) {
        return Err(format!("rows are not sorted, or twice there: {:?}, {:?}", pair[0], pair[1]));
    }
    if let Some(pair) = sheds.windows(2).find(|pair| pair[0] >= pair[1]) {
        return Err(format!("sheds are not sorted, or twice there: {:?}, {:?}", pair[0], pair[1]));
    }
    Ok(())
}

/// `Ok` if `holds`, else the message.
fn ensure(holds: bool, message: impl FnOnce() -> String) -> Result<(), String> {
    if holds { Ok(()) } else { Err(message()) }
}

#[cfg(test)]
mod tests;
