//! What is compared under overload.

use super::load::Set;
use super::others::{self, Other};
use crate::scoreboard::drive::{Ends, World, play};
use red_core::{Caps, Config, Empty, Scheduler, Shed, Timing};
use red_workload::policy::Policy;

/// Room for a set: tasks, nodes, jobs, lanes, pools.
type Room = Caps<5, 8, 64, 4, 1>;

/// Who decides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rule {
    /// The scheduler, as this policy has it.
    Ours(Policy),
    /// One of the literature.
    Theirs(Other),
}

impl Rule {
    /// All of them, that which is on trial first.
    pub(super) const ALL: [Self; 8] = [
        Self::Ours(Policy::Redrt),
        Self::Ours(Policy::RedrtLookahead),
        Self::Ours(Policy::Red),
        Self::Ours(Policy::Edf),
        Self::Theirs(Other::Value),
        Self::Theirs(Other::Density),
        Self::Theirs(Other::Robust),
        Self::Theirs(Other::DOver),
    ];

    /// Name in tables.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Ours(policy) => policy.name(),
            Self::Theirs(Other::Value) => "highest value",
            Self::Theirs(Other::Density) => "value density",
            Self::Theirs(Other::Robust) => "Robust EDF",
            Self::Theirs(Other::DOver) => "D-over",
        }
    }

    /// Runs a set; `None` where it is more than the scheduler has room for.
    pub(super) fn run(self, set: &Set) -> Option<Ends> {
        match self {
            Self::Ours(policy) => scheduled(set, policy.config()),
            Self::Theirs(other) => Some(others::drive(set, other)),
        }
    }
}

/// Runs a set by the keys of `redrt` alone: nobody is given up, and no lane waits. `None` as in [`Rule::run`].
pub(super) fn by_keys(set: &Set) -> Option<Ends> {
    scheduled(set, Config { shed: Shed::Never, ..Config::REDRT })
}

fn scheduled(set: &Set, config: Config) -> Option<Ends> {
    let mut scheduler: Box<Scheduler<Room>> = Box::new(Scheduler::EMPTY);
    scheduler.configure(config.with_lanes(set.lanes));
    let mut tasks = Vec::new();
    for ((task, value), floor) in set.tasks.iter().zip(&set.values).zip(&set.floors) {
        let timing = task.timing().value(*value);
        let timing = floor.map_or(timing, |(m, k)| Timing::floor(timing, m, k));
        tasks.push(scheduler.add_task(&task.graph.dag(set.times.best_percent())?, timing).ok()?);
    }
    let time = |task: usize, job: u64, node: usize| set.time(task, job, node);
    Some(play(World { releases: &set.releases, time: &time, until_miss: false }, scheduler, tasks))
}
