//! What would make a workload fit: of each kind of change the smallest that a judge says yes to.
//!
//! *Background.* The tests of admission are necessary, and cheap. What they say yes to may still miss, so a change that they
//! ask for is a place to begin at, and no answer.
//! *Rule.* A kind of change is a number: how far. By bisection the least is found that passes the tests and the judge's quick
//! look. The judge looks at that in full; as long as it says no, steps double, and what lies between the last no and the
//! first yes is bisected again.
//! *Why it holds.* Whatever is given was applied to a copy of the workload, and the judge said yes to that copy. A smaller
//! change may help too: misses do not always become fewer as a change grows.

use super::cure::{Cure, Rounding, Stretch, WHOLE, printed_above, printed_below, scale};
use super::{Plan, admission, built, period_ns};
use crate::model::{MAX_INSTANT_NS, MAX_LANES, Workload};
use red_core::Capacity;
use std::marker::PhantomData;

/// Longest periods of all tasks that are suggested, in thousandths of those in the file.
const LONGEST_PERIODS: u32 = 100_000;
/// Slowest pace of all tasks that is suggested, likewise.
const SLOWEST: u32 = 10_000_000;
/// Longest deadline or period of a single task that is suggested, in thousandths of what it has or needs.
const LONGEST: u32 = 10_000;

/// Says whether a changed workload fits.
pub trait Judge {
    /// A quick look: a no is final, a yes is not.
    fn may_fit(&mut self, workload: &Workload) -> bool;
    /// What a user is told who plans this workload.
    fn fits(&mut self, workload: &Workload) -> bool;
}

/// What makes a workload fit.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Cures {
    /// Each of them does by itself.
    pub single: Vec<Cure>,
    /// Where none does: all tasks slower, and later due.
    pub together: Option<Cure>,
}

/// The changes that make `workload` fit, each said yes to by `judge`; `plan` is its plan. Time bound: for each kind of change
/// and task some 20 quick looks and some 30 full ones.
#[must_use]
pub fn cures<C: Capacity>(workload: &Workload, plan: &Plan, judge: &mut impl Judge) -> Cures {
    if plan.admission.fits {
        return Cures::default();
    }
    let bounds = at_their_bounds(workload, plan);
    let mut search = Search::<C, _> { workload, judge, capacity: PhantomData };
    let times = search.times(&bounds);
    // Beside deadlines at the bounds, a period is asked for only where these alone are not enough.
    let period = if times.is_none() || bounds.is_empty() { search.period(&bounds) } else { None };
    let single: Vec<Cure> = times
        .into_iter()
        .chain(period)
        .chain(search.share(WHOLE + 1..=LONGEST_PERIODS, Cure::Periods))
        .chain((0..workload.pools.len()).filter_map(|pool| search.lanes(pool)).collect::<Vec<_>>())
        .chain(search.node(plan))
        .chain(search.share(1..=WHOLE - 1, |drop| Cure::Costs(WHOLE - drop)))
        .collect();
    let together = if single.is_empty() { search.share(WHOLE + 1..=SLOWEST, Cure::Pace) } else { None };
    Cures { single, together }
}

/// Deadlines and periods that are below the bound of a job alone, put to it.
fn at_their_bounds(workload: &Workload, plan: &Plan) -> Vec<Stretch> {
    let of = |(task, planned): (&crate::model::Task, &super::TaskPlan)| {
        let needed = planned.certificate.largest_response_ns();
        let above = |ns: u64| (ns < needed).then(|| printed_above(needed));
        let (deadline_ns, period_ns) = (above(task.deadline_ns), period_ns(task).and_then(above));
        let stretch = Stretch { task: task.name.clone(), deadline_ns, period_ns };
        (deadline_ns.is_some() || period_ns.is_some()).then_some(stretch)
    };
    workload.tasks.iter().zip(&plan.tasks).filter_map(of).collect()
}

struct Search<'a, C, J> {
    workload: &'a Workload,
    judge: &'a mut J,
    capacity: PhantomData<C>,
}

impl<C: Capacity, J: Judge> Search<'_, C, J> {
    /// The tasks that need it later due and slower, and all of these deadlines a little later; or that of one task more.
    fn times(&mut self, bounds: &[Stretch]) -> Option<Cure> {
        if !bounds.is_empty() {
            let all = |share| {
                let later = bounds.iter().map(|stretch| {
                    let deadline_ns = stretch.deadline_ns.map(|ns| stretched(ns, share));
                    Stretch { deadline_ns, ..stretch.clone() }
                });
                Cure::Times(later.collect())
            };
            if let Some((_, cure)) = self.smallest(WHOLE..=LONGEST, all) {
                return Some(cure);
            }
        }
        self.of_one_task(|workload, task, share| {
            let task = &workload.tasks[task];
            let planned = bounds.iter().find(|stretch| stretch.task == task.name);
            let needed = planned.and_then(|stretch| stretch.deadline_ns).unwrap_or(task.deadline_ns);
            Some(with(bounds, &task.name, |stretch| stretch.deadline_ns = Some(stretched(needed, share))))
        })
    }

    /// A longer period of one task.
    fn period(&mut self, bounds: &[Stretch]) -> Option<Cure> {
        self.of_one_task(|workload, task, share| {
            let task = &workload.tasks[task];
            let planned = bounds.iter().find(|stretch| stretch.task == task.name);
            let needed = planned.and_then(|stretch| stretch.period_ns).or_else(|| period_ns(task))?;
            Some(with(bounds, &task.name, |stretch| stretch.period_ns = Some(stretched(needed, share))))
        })
    }

    /// Of the changes of one task each the smallest.
    fn of_one_task(&mut self, make: impl Fn(&Workload, usize, u32) -> Option<Cure>) -> Option<Cure> {
        let (workload, mut best, mut found) = (self.workload, LONGEST, None);
        for task in 0..workload.tasks.len() {
            if make(workload, task, best).is_none() {
                continue;
            }
            let of_task = |share| make(workload, task, share).unwrap_or(Cure::Periods(share));
            if let Some((share, cure)) = self.smallest(WHOLE + 1..=best, of_task) {
                (best, found) = (share - 1, Some(cure));
            }
        }
        found
    }

    fn lanes(&mut self, pool: usize) -> Option<Cure> {
        let pools = &self.workload.pools;
        let (now, name) = (pools[pool].lanes, &pools[pool].name);
        let all: u32 = pools.iter().map(|pool| pool.lanes).sum();
        let same = pools.iter().filter(|other| other.undivided() == pools[pool].undivided());
        let undivided: u32 = same.map(|pool| pool.lanes).sum();
        let wider = |lanes| Cure::Lanes { pool: name.clone(), lanes, of: undivided - now + lanes };
        self.smallest(now + 1..=(now + MAX_LANES).saturating_sub(all), wider).map(|(_, cure)| cure)
    }

    /// A smaller cost of the costliest node of one task.
    fn node(&mut self, plan: &Plan) -> Option<Cure> {
        let (mut best, mut found) = (WHOLE - 1, None);
        for planned in &plan.tasks {
            let Some((node, wcet_ns)) = costliest(self.workload, &planned.name) else { continue };
            let smaller = |drop| Cure::Node {
                task: planned.name.clone(),
                node: node.clone(),
                wcet_ns: printed_below(scale(wcet_ns, WHOLE - drop, Rounding::Down)),
            };
            if let Some((drop, cure)) = self.smallest(1..=best, smaller) {
                (best, found) = (drop - 1, Some(cure));
            }
        }
        found
    }

    fn share(&mut self, range: std::ops::RangeInclusive<u32>, make: impl Fn(u32) -> Cure) -> Option<Cure> {
        self.smallest(range, make).map(|(_, cure)| cure)
    }

    /// The least number for which the judge says yes, as far as bisection finds it, and the change.
    fn smallest(
        &mut self,
        range: std::ops::RangeInclusive<u32>,
        make: impl Fn(u32) -> Cure,
    ) -> Option<(u32, Cure)> {
        let (low, most) = range.into_inner();
        if low > most || !self.may_fit(&make(most)) {
            return None;
        }
        let mut yes = first(low, most, |n| self.may_fit(&make(n)));
        let (mut no, mut step) = (None, 1);
        while !self.fits(&make(yes)) {
            if yes == most {
                return None;
            }
            no = Some(yes);
            yes = most.min(yes + step);
            step *= 2;
        }
        if let Some(no) = no {
            yes = first(no + 1, yes, |n| self.fits(&make(n)));
        }
        Some((yes, make(yes)))
    }

    fn may_fit(&mut self, cure: &Cure) -> bool {
        let changed = cure.applied(self.workload, Rounding::Up);
        is_valid(&changed) && passes::<C>(&changed) && self.judge.may_fit(&changed)
    }

    /// However a share is rounded in the file.
    fn fits(&mut self, cure: &Cure) -> bool {
        let [down, up] = [Rounding::Down, Rounding::Up].map(|rounding| cure.applied(self.workload, rounding));
        self.may_fit(cure) && self.judge.fits(&up) && (down == up || self.judge.fits(&down))
    }
}

/// The first number from `low` on for which `holds`, which does for `high`, if it holds for all after the first.
fn first(mut low: u32, mut high: u32, mut holds: impl FnMut(u32) -> bool) -> u32 {
    while low < high {
        let middle = low + (high - low) / 2;
        if holds(middle) { high = middle } else { low = middle + 1 }
    }
    high
}

fn stretched(ns: u64, share: u32) -> u64 {
    printed_above(scale(ns, share, Rounding::Up))
}

/// These changes, and one more of a task.
fn with(bounds: &[Stretch], task: &str, change: impl FnOnce(&mut Stretch)) -> Cure {
    let mut stretches = bounds.to_vec();
    let at = stretches.iter().position(|stretch| stretch.task == task).unwrap_or_else(|| {
        stretches.push(Stretch { task: task.to_owned(), deadline_ns: None, period_ns: None });
        stretches.len() - 1
    });
    change(&mut stretches[at]);
    Cure::Times(stretches)
}

/// The part of a task that costs most, that of events included.
fn costliest(workload: &Workload, task: &str) -> Option<(String, u64)> {
    let of_task = workload.tasks.iter().filter(|other| other.name == task).flat_map(|task| &task.nodes);
    let events = workload.events.iter().filter(|event| workload.tasks[event.task].name == task);
    let nodes = of_task.chain(events.flat_map(|event| &event.add));
    let parts = nodes.flat_map(|node| node.parts()).map(|(name, part)| (name, part.wcet_ns));
    parts.max_by_key(|(_, wcet_ns)| *wcet_ns)
}

/// Whether a file may say so.
fn is_valid(workload: &Workload) -> bool {
    workload.tasks.iter().all(|task| task.deadline_ns.max(period_ns(task).unwrap_or(0)) <= MAX_INSTANT_NS)
}

/// Whether every test of admission says yes. No proof is looked for.
#[must_use]
pub fn passes<C: Capacity>(workload: &Workload) -> bool {
    let pools = admission::Pools::of(workload);
    let versions = built::<C>(workload).and_then(|built| admission::versions(workload, &built, &pools));
    versions.is_ok_and(|versions| admission::fits(workload, &pools, &versions))
}

#[cfg(test)]
mod tests;
