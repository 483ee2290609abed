//! The rules that are compared.

use super::drive::{self, Case, Ends};
use super::federated;
use super::reference::{self, Key};
use super::sets::Task;
use red_core::{BestCase, Config, DeadlineRule, Gate, Reassign, Shed};

/// A rule by its name in tables.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rule {
    /// Name.
    pub(crate) name: &'static str,
    /// Who dispatches.
    pub(crate) by: By,
}

/// Who dispatches.
#[derive(Clone, Copy, Debug)]
pub(crate) enum By {
    /// The scheduler, with this configuration.
    Scheduler(Config),
    /// One that is not ours.
    Reference(Key),
    /// Nobody: a proof that holds without a schedule.
    Proof(fn(&[Task], u64) -> bool),
}

pub(super) const JOB_EDF: Config = Config { best_case: BestCase::Declared, preempt: true, ..Config::EDF };

pub(super) const fn by_rule(rule: DeadlineRule) -> Config {
    Config { rule, ..JOB_EDF }
}

pub(super) const LEVEL_SUM: Config = by_rule(DeadlineRule::LevelSum);
pub(super) const LATEST_START: Config = by_rule(DeadlineRule::LatestStart);
pub(super) const REDRT: Config = Config { best_case: BestCase::Declared, preempt: true, ..Config::REDRT };

const fn ours(name: &'static str, config: Config) -> Rule {
    Rule { name, by: By::Scheduler(config) }
}

const fn theirs(name: &'static str, key: Key) -> Rule {
    Rule { name, by: By::Reference(key) }
}

/// Name of the rule that is the measure of all others.
pub(crate) const BASELINE: &str = "job-EDF";
/// Name of ours.
pub(crate) const OURS: &str = "REDRT";

/// All rules, preemptive unless their names say otherwise.
pub(crate) const RULES: [Rule; 19] = [
    ours("paper: level-sum, level gate", Config { gate: Gate::Level, ..LEVEL_SUM }),
    theirs("level-equal", Key::LevelEqual),
    ours("level-Graham", by_rule(DeadlineRule::LevelGraham)),
    ours("level-sum", LEVEL_SUM),
    ours("level-sum, re-assigned", Config { reassign: Reassign::OnChange, ..LEVEL_SUM }),
    ours("path-proportional", by_rule(DeadlineRule::PathProportional)),
    ours(BASELINE, JOB_EDF),
    ours("latest finish", by_rule(DeadlineRule::LatestFinish)),
    ours("latest start", LATEST_START),
    ours(OURS, REDRT),
    Rule { name: "federated: what is proved", by: By::Proof(federated::is_proved) },
    theirs("EDZL", Key::ZeroLaxity),
    theirs("LLF at events", Key::LeastLaxity),
    ours("latest start, level gate", Config { gate: Gate::Level, ..LATEST_START }),
    ours("latest start, lowest urgency shed", Config { shed: Shed::LowestUrgency, ..LATEST_START }),
    ours("job-EDF, non-preemptive", Config { preempt: false, ..JOB_EDF }),
    ours("REDRT, non-preemptive", Config { preempt: false, ..REDRT }),
    ours("REDRT lookahead, non-preemptive", Config { preempt: false, gate: Gate::Lookahead, ..REDRT }),
    ours("paper, non-preemptive", Config { gate: Gate::Level, preempt: false, ..LEVEL_SUM }),
];

impl Rule {
    /// Runs a case on so many lanes; a proof has no jobs, and misses one where it fails. `None` where it is too large for
    /// the scheduler.
    #[must_use]
    pub(crate) fn run(&self, case: &Case<'_>, lanes: u8) -> Option<Ends> {
        match self.by {
            By::Scheduler(config) => drive::drive(case, config.with_lanes(lanes)),
            By::Reference(key) => Some(reference::drive(case, key, lanes.into())),
            By::Proof(is_proved) => {
                Some(Ends { missed: u64::from(!is_proved(case.tasks, lanes.into())), ..Ends::default() })
            }
        }
    }
}
