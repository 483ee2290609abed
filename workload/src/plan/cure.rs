//! Changes that a user can make in a workload file, in words and applied.

use crate::model::{Arrival, Part, Work, Workload};
use red_core::Duration;
use std::fmt;

/// A share of this many thousandths leaves a number as it is.
pub(super) const WHOLE: u32 = 1_000;

/// A change of a workload, as somebody makes it in the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Cure {
    /// New deadlines and periods of some tasks.
    Times(Vec<Stretch>),
    /// All periods at this many thousandths of what they are.
    Periods(u32),
    /// More lanes in one pool.
    Lanes {
        /// Pool, or `pool.cluster`.
        pool: String,
        /// Its lanes then.
        lanes: u32,
        /// Lanes of the whole pool then; the same where it is undivided.
        of: u32,
    },
    /// A smaller cost of one node.
    Node {
        /// Task.
        task: String,
        /// Node, `stage.part` in a stage.
        node: String,
        /// Its WCET then.
        wcet_ns: u64,
    },
    /// All costs at this many thousandths of what they are.
    Costs(u32),
    /// All deadlines and all periods at this many thousandths of what they are.
    Pace(u32),
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

/// What becomes of a share that is no whole number of nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rounding {
    Down,
    Up,
}

impl Cure {
    /// The workload with this change.
    pub(super) fn applied(&self, workload: &Workload, rounding: Rounding) -> Workload {
        let mut changed = workload.clone();
        let scaled = |ns: u64, share: u32| scale(ns, share, rounding);
        match self {
            Self::Times(stretches) => {
                for stretch in stretches {
                    let named = changed.tasks.iter_mut().filter(|task| task.name == stretch.task);
                    for task in named {
                        task.deadline_ns = stretch.deadline_ns.unwrap_or(task.deadline_ns);
                        set_period(&mut task.arrival, |period| stretch.period_ns.unwrap_or(period));
                    }
                }
            }
            Self::Periods(share) => {
                let tasks = changed.tasks.iter_mut();
                tasks.for_each(|task| set_period(&mut task.arrival, |period| scaled(period, *share)));
            }
            Self::Pace(share) => {
                for task in &mut changed.tasks {
                    task.deadline_ns = scaled(task.deadline_ns, *share);
                    set_period(&mut task.arrival, |period| scaled(period, *share));
                }
            }
            Self::Lanes { pool, lanes, .. } => {
                let named = changed.pools.iter_mut().filter(|other| other.name == *pool);
                named.for_each(|pool| pool.lanes = *lanes);
            }
            Self::Node { task, node, wcet_ns } => {
                each_part(&mut changed, |of, name, part| {
                    if workload.tasks[of].name == *task && name == node {
                        part.wcet_ns = *wcet_ns;
                        part.bcet_ns = part.bcet_ns.min(*wcet_ns);
                    }
                });
            }
            Self::Costs(share) => each_part(&mut changed, |_, _, part| {
                part.wcet_ns = scaled(part.wcet_ns, *share);
                part.bcet_ns = scaled(part.bcet_ns, *share);
                part.contention_ns = scaled(part.contention_ns, *share);
            }),
        }
        changed
    }
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
                        write!(f, " {name} {}", Duration::from_nanos(ns))?;
                    }
                    for (name, ns) in times {
                        write!(f, " and {name} {}", Duration::from_nanos(ns))?;
                    }
                }
                Ok(())
            }
            Self::Periods(share) => write!(f, "all periods at {} of what they are", percent(*share)),
            Self::Lanes { pool, lanes, of } => match pool.split_once('.') {
                None => write!(f, "pool `{pool}`: {lanes} lanes"),
                Some((pool, cluster)) => {
                    write!(f, "pool `{pool}`: {of} lanes, {lanes} of them in cluster `{cluster}`")
                }
            },
            Self::Node { task, node, wcet_ns } => {
                write!(f, "task `{task}`, node `{node}`: wcet {}", Duration::from_nanos(*wcet_ns))
            }
            Self::Costs(share) => write!(f, "all costs at {} of what they are", percent(*share)),
            Self::Pace(share) => {
                write!(f, "all deadlines and periods at {} of what they are", percent(*share))
            }
        }
    }
}

fn percent(thousandths: u32) -> String {
    format!("{}.{} %", thousandths / 10, thousandths % 10)
}

/// The digit that [`Duration`] shows last, in nanoseconds.
const fn last_digit(ns: u64) -> u64 {
    match ns {
        1_000_000_000.. => 1_000_000,
        1_000_000.. => 1_000,
        _ => 1,
    }
}

/// The next longer time that is printed whole.
pub(super) const fn printed_above(ns: u64) -> u64 {
    let digit = last_digit(ns);
    ns.div_ceil(digit).saturating_mul(digit)
}

/// The next shorter time that is printed whole.
pub(super) const fn printed_below(ns: u64) -> u64 {
    ns - ns % last_digit(ns)
}

pub(super) fn scale(ns: u64, thousandths: u32, rounding: Rounding) -> u64 {
    let product = u128::from(ns) * u128::from(thousandths);
    let whole = u128::from(WHOLE);
    let scaled = if rounding == Rounding::Up { product.div_ceil(whole) } else { product / whole };
    u64::try_from(scaled).unwrap_or(u64::MAX)
}

fn set_period(arrival: &mut Arrival, new: impl FnOnce(u64) -> u64) {
    match arrival {
        Arrival::Periodic { period_ns: t } | Arrival::Sporadic { min_interarrival_ns: t } => *t = new(*t),
        Arrival::Once => {}
    }
}

/// Every part of every node with the index of its task and its name, those of events included.
pub(super) fn each_part(workload: &mut Workload, mut change: impl FnMut(usize, &str, &mut Part)) {
    let of_tasks = workload.tasks.iter_mut().enumerate().map(|(i, task)| (i, &mut task.nodes));
    let of_events = workload.events.iter_mut().map(|event| (event.task, &mut event.add));
    for (i, nodes) in of_tasks.chain(of_events) {
        for node in nodes {
            match &mut node.work {
                Work::Plain(part) => change(i, &node.name, part),
                Work::Stage(stage) => {
                    change(i, &format!("{}.encoder", node.name), &mut stage.encoder);
                    for (decoder, part) in &mut stage.decoders {
                        change(i, &format!("{}.{decoder}", node.name), part);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
