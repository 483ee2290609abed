//! What the executive does: a plain struct of integers, and the six named configurations.

use crate::capacity::Empty;
use crate::deadlines::DeadlineRule;
use crate::policy::Overload;
use crate::time::{Bytes, Duration};

crate::capacity::values! {
    /// What must be done before a node may start.
    pub enum Gate {
        /// Its predecessors.
        Precedence,
        /// Every node of a lower height, as the paper's level barrier has it.
        Level,
        /// Its predecessors, and a more pressing node that is ready so soon that it would be late behind this one.
        Lookahead,
    }

    /// When sub-deadlines of jobs in flight are computed again.
    pub enum Reassign {
        /// Only when the graph changes.
        Never,
        /// Level rules: the residual graph of every job, at each dispatch (paper section 4.3).
        OnDispatch,
        /// Level rules: the residual graph of a job when one of its nodes ended. Path rules keep their keys.
        OnChange,
    }

    /// Which jobs are given up.
    pub enum Shed {
        /// None.
        Never,
        /// The paper's ProactiveDrop: lowest urgency first, while the overload lasts.
        LowestUrgency,
        /// Jobs that no schedule can end in time, at once; and of those that the forward schedule has late, the least,
        /// so that the others are in time.
        Hopeless,
    }

    /// What happens to a job that is past its deadline.
    pub enum Late {
        /// It runs on; every remaining node is due at the deadline.
        Continue,
        /// It is given up.
        AbortJob,
    }

    /// Where best-case execution times come from.
    pub enum BestCase {
        /// The shortest of the last 8 executions once there are 8, the declared one if that is longer.
        Observed,
        /// The declared one, always.
        Declared,
    }

    /// What `add_task` and `commit` do with a task that does not fit.
    pub enum Admission {
        /// Accept it and return the certificate.
        Report,
        /// Refuse it.
        Enforce,
    }

    /// Configuration of a scheduler.
    ///
    /// ```
    /// use red_core::{Config, DeadlineRule};
    /// let ours = Config::REDRT.with_lanes(2);
    /// assert_eq!(ours.rule, DeadlineRule::LatestStart);
    /// ```
    pub struct Config {
        /// Lanes of the first pool.
        pub lanes: u8,
        /// Memory budget of the first pool; `None` is unlimited.
        pub memory: Option<Bytes>,
        /// How sub-deadlines are assigned.
        pub rule: DeadlineRule,
        /// What a node waits for.
        pub gate: Gate,
        /// When sub-deadlines are assigned again.
        pub reassign: Reassign,
        /// Whether stages are refined into encoder and decoders; the host builds its graphs by it.
        pub refine: bool,
        /// gamma of DynamicMerge; `None` is no merging. Paper: 100 ms.
        pub merge_skew: Option<Duration>,
        /// Whether encoder results are shared beyond their unit.
        pub frame_cache: bool,
        /// Which jobs are given up.
        pub shed: Shed,
        /// What happens to late jobs.
        pub late: Late,
        /// Where best cases come from.
        pub best_case: BestCase,
        /// When the monitor speaks of overload.
        pub overload: Overload,
        /// Whether a task that does not fit is refused.
        pub admission: Admission,
        /// Whether a waiting node takes the lane of a running one with a larger key, which the host gives back.
        pub preempt: bool,
    }
}

/// gamma: paper section 4.3.
const PAPER_SKEW: Duration = Duration::from_millis(100);

impl Config {
    /// The paper's baseline: unrefined graphs, one deadline per job, and nothing else.
    pub const EDF: Self = Self { lanes: 1, overload: Overload::PAPER, ..Self::EMPTY };

    /// The paper's RED-FG: refined, level shares, level barrier.
    pub const RED_FG: Self =
        Self { rule: DeadlineRule::LevelSum, gate: Gate::Level, refine: true, ..Self::EDF };

    /// The paper's RED-IDA: RED-FG with re-assignment at each dispatch.
    pub const RED_IDA: Self = Self { reassign: Reassign::OnDispatch, ..Self::RED_FG };

    /// The paper's RED: RED-IDA with merging, on-demand synchronisation and ProactiveDrop.
    pub const RED: Self = Self {
        gate: Gate::Precedence,
        merge_skew: Some(PAPER_SKEW),
        shed: Shed::LowestUrgency,
        ..Self::RED_IDA
    };

    /// Ours: latest-start keys, precedence gating, merging, frame cache, and who is given up by the forward schedule.
    pub const REDRT: Self = Self {
        rule: DeadlineRule::LatestStart,
        reassign: Reassign::OnChange,
        frame_cache: true,
        shed: Shed::Hopeless,
        ..Self::RED
    };

    /// Ours, with lanes that wait for what is soon ready where nothing is preempted.
    pub const REDRT_LOOKAHEAD: Self = Self { gate: Gate::Lookahead, ..Self::REDRT };

    /// With this many lanes in the first pool.
    #[must_use]
    pub const fn with_lanes(self, lanes: u8) -> Self {
        Self { lanes, ..self }
    }

    /// With a memory budget for the first pool.
    #[must_use]
    pub const fn with_memory(self, memory: Bytes) -> Self {
        Self { memory: Some(memory), ..self }
    }

    /// Whether keys of jobs in flight follow the residual graph.
    pub(crate) const fn residual(&self) -> bool {
        self.rule.is_level() && !matches!(self.reassign, Reassign::Never)
    }

    /// Whether anything reads the estimator.
    pub(crate) const fn observes(&self) -> bool {
        self.residual() || matches!(self.shed, Shed::Hopeless)
    }
}
