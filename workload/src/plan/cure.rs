//! What would make a workload fit: the smallest change of one kind, found by asking the tests again.

use super::{Plan, admission, built, period_ns};
use crate::model::{Arrival, Part, Work, Workload};
use red_core::{Capacity, Duration};
use std::fmt;

/// Lanes over all pools that a workload may have.
const MOST_LANES: u32 = 32;
/// Longest periods that are suggested, in thousandths of those in the file.
const LONGEST_PERIODS: u32 = 100_000;
const WHOLE: u32 = 1_000;

/// A change that alone makes a workload fit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Cure {
    /// Longer deadlines, and periods where these are shorter than the bound.
    Times(Vec<Stretch>),
    /// All periods at this many thousandths of what they are.
    Periods(u32),
    /// More lanes in one pool.
    Lanes {
        /// Pool.
        pool: String,
        /// Its lanes then.
        lanes: u32,
    },
    /// All costs at this many thousandths of what they are.
    Costs(u32),
}

/// The times that a task needs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stretch {
    /// Task.
    pub task: String,
    /// New deadline, if it has to change.
    pub deadline_ns: Option<u64>,
    /// New period or minimum inter-arrival time, if it has to change.
    pub period_ns: Option<u64>,
}

impl fmt::Display for Cure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Times(stretches) => {
                for (i, Stretch { task, deadline_ns, period_ns }) in stretches.iter().enumerate() {
                    write!(f, "{}task `{task}`:", if i == 0 { "" } else { "; " })?;
                    let times = [("deadline", deadline_ns), ("period", period_ns)];
                    let mut times = times.iter().filter_map(|(name, ns)| ns.map(|ns| (name, ns)));
                    if let Some((name, ns)) = times.next() {
                        write!(f, " {name} {}", ceiling(ns))?;
                    }
                    for (name, ns) in times {
                        write!(f, " and {name} {}", ceiling(ns))?;
                    }
                }
                Ok(())
            }
            Self::Periods(share) => write!(f, "all periods at {} of what they are", percent(*share)),
            Self::Lanes { pool, lanes } => write!(f, "pool `{pool}`: {lanes} lanes"),
            Self::Costs(share) => write!(f, "all costs at {} of what they are", percent(*share)),
        }
    }
}

fn percent(thousandths: u32) -> String {
    format!("{}.{} %", thousandths / 10, thousandths % 10)
}

/// Rounded up to what `Display` shows, so that the number as printed is enough.
fn ceiling(ns: u64) -> Duration {
    let step = match ns {
        1_000_000_000.. => 1_000_000,
        1_000_000.. => 1_000,
        _ => 1,
    };
    Duration::from_nanos(ns.div_ceil(step).saturating_mul(step))
}

/// The smallest change of each kind that alone makes `workload` fit, as far as there is one; `plan` is its plan.
#[must_use]
pub fn cures<C: Capacity>(workload: &Workload, plan: &Plan) -> Vec<Cure> {
    if plan.admission.fits {
        return Vec::new();
    }
    let times = stretched::<C>(workload, plan);
    let lanes = (0..workload.pools.len()).filter_map(|pool| widened::<C>(workload, pool));
    let costs = smallest(1..=WHOLE - 1, |drop| fits::<C>(&with_costs(workload, WHOLE - drop)));
    let costs = costs.map(|drop| Cure::Costs(WHOLE - drop));
    times.into_iter().chain(lanes).chain(costs).collect()
}

/// Deadlines and periods at the bounds; where the pools stay too busy, longer periods.
fn stretched<C: Capacity>(workload: &Workload, plan: &Plan) -> Option<Cure> {
    let mut longer = workload.clone();
    let mut stretches = Vec::new();
    for (task, planned) in longer.tasks.iter_mut().zip(&plan.tasks) {
        let needed = planned.certificate.largest_response_ns();
        let deadline_ns = (task.deadline_ns < needed).then_some(needed);
        let period_ns = period_ns(task).filter(|period| *period < needed).map(|_| needed);
        task.deadline_ns = task.deadline_ns.max(needed);
        set_period(&mut task.arrival, |period| period.max(needed));
        if deadline_ns.is_some() || period_ns.is_some() {
            stretches.push(Stretch { task: task.name.clone(), deadline_ns, period_ns });
        }
    }
    if !stretches.is_empty() && fits::<C>(&longer) {
        return Some(Cure::Times(stretches));
    }
    let slower = |thousandths| fits::<C>(&with_periods(workload, thousandths));
    smallest(WHOLE + 1..=LONGEST_PERIODS, slower).map(Cure::Periods)
}

fn widened<C: Capacity>(workload: &Workload, pool: usize) -> Option<Cure> {
    let (now, name) = (workload.pools[pool].lanes, workload.pools[pool].name.clone());
    let others: u32 = workload.pools.iter().map(|pool| pool.lanes).sum::<u32>() - now;
    let with_lanes = |lanes| {
        let mut wider = workload.clone();
        wider.pools[pool].lanes = lanes;
        fits::<C>(&wider)
    };
    smallest(now + 1..=MOST_LANES.saturating_sub(others), with_lanes)
        .map(|lanes| Cure::Lanes { pool: name, lanes })
}

fn with_periods(workload: &Workload, thousandths: u32) -> Workload {
    let mut slower = workload.clone();
    for task in &mut slower.tasks {
        set_period(&mut task.arrival, |period| scale(period, thousandths));
    }
    slower
}

fn set_period(arrival: &mut Arrival, new: impl FnOnce(u64) -> u64) {
    match arrival {
        Arrival::Periodic { period_ns: t } | Arrival::Sporadic { min_interarrival_ns: t } => *t = new(*t),
        Arrival::Once => {}
    }
}

fn with_costs(workload: &Workload, thousandths: u32) -> Workload {
    let mut faster = workload.clone();
    let shrink = |part: &mut Part| {
        part.wcet_ns = scale(part.wcet_ns, thousandths);
        part.contention_ns = scale(part.contention_ns, thousandths);
    };
    let of_tasks = faster.tasks.iter_mut().flat_map(|task| &mut task.nodes);
    let of_events = faster.events.iter_mut().flat_map(|event| &mut event.add);
    for node in of_tasks.chain(of_events) {
        match &mut node.work {
            Work::Plain(part) => shrink(part),
            Work::Stage(stage) => {
                shrink(&mut stage.encoder);
                stage.decoders.iter_mut().for_each(|(_, part)| shrink(part));
            }
        }
    }
    faster
}

fn scale(ns: u64, thousandths: u32) -> u64 {
    u64::try_from(u128::from(ns) * u128::from(thousandths) / u128::from(WHOLE)).unwrap_or(u64::MAX)
}

fn fits<C: Capacity>(workload: &Workload) -> bool {
    let pools = admission::Pools::of(workload);
    let versions = built::<C>(workload).and_then(|built| admission::versions(workload, &built, &pools));
    versions.is_ok_and(|versions| admission::fits(workload, &pools, &versions))
}

/// The smallest number for which `holds`, by bisection; what it returns does hold.
fn smallest(range: std::ops::RangeInclusive<u32>, holds: impl Fn(u32) -> bool) -> Option<u32> {
    let (mut low, mut high) = range.into_inner();
    if low > high || !holds(high) {
        return None;
    }
    while low < high {
        let middle = low + (high - low) / 2;
        if holds(middle) { high = middle } else { low = middle + 1 }
    }
    Some(high)
}

#[cfg(test)]
mod tests;
