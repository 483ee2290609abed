//! The platforms: one set of parameters each, and the reason for each number. Nothing is tuned per cell of a table.
//!
//! The paper publishes deadlines, and neither execution times nor deadlines' budgets of its second evaluation. What is
//! missing is inferred from its own tables:
//!
//! - *Latency from scores.* Table "variant lambda" gives the quality of experience at five values of lambda. From
//!   1 / (1 + e^lambda x) follows x, the tardiness in seconds, the same for each lambda, and the mean latency under EDF
//!   with it: 12.72, 9.78, 6.84 and 2.43 s.
//! - *Relative costs.* The EDF column of Table "extended" on AGX Orin gives C = 4.65 s, O = 5.97 s, L + S = 11.31 s: with
//!   L = S = 1 these are C = 0.82, O = 1.055. (The FLOPs of Table "models" say otherwise; they do not predict time.)
//! - *Encoder.* Half of an L task. Table "models" has 6.7 of 7.5 GFLOPs left in the multi-task network, which would be 0.27
//!   GFLOPs of encoder and 11 % of the work; the extended evaluation's -49 % needs more than all of it. A half is between.
//! - *Barrier.* The baselines synchronise periodically, at an interval that is not told. A twelfth of the tight deadline
//!   puts their latency where it is. Its cost is the runtime of Table "overhead" over six barriers a pipeline.
//! - *Execution times.* Uniform in 0.75 to 1 of the WCET, 3 % of them 0.15 longer: a WCET that was measured is exceeded.

use red_sim::Execution;

/// Execution times of all experiments that do not say otherwise.
pub const EXECUTION: Execution =
    Execution::Tailed { low_ppm: 750_000, high_ppm: 1_000_000, tail_ppm: 30_000, longer_ppm: 150_000 };

/// Encoder of every call, in thousandths of an L task.
pub const ENCODER_PER_MILLE: u64 = 500;

/// Barriers of a tight deadline.
const BARRIERS_PER_DEADLINE: u64 = 12;
/// Barriers that Table "overhead" is taken to have counted in a pipeline.
const BARRIERS_PER_PIPELINE: u64 = 6;

/// L + S + O + C in thousandths of an L task.
const FOUR_TASKS_PER_MILLE: u64 = 1_000 + 1_000 + 1_055 + 820;

/// A platform. Times are in nanoseconds.
#[derive(Clone, Copy, Debug)]
pub struct Platform {
    /// Name, as in the paper.
    pub name: &'static str,
    /// Effective parallelism rho: "small for Nano/TX2, larger for AGX Orin" is all that the paper says.
    pub lanes: u32,
    /// WCET of an L task.
    pub unit_ns: u64,
    /// Tight deadline (section 5.1).
    pub tight_ns: u64,
    /// Loose deadline (section 5.1).
    pub loose_ns: u64,
    /// Cost of one barrier.
    pub barrier_ns: u64,
    /// Mean latency of EDF at tight deadlines, in seconds, inferred from Table "variant lambda": what `unit_ns` is fitted to.
    pub edf_latency_s: f64,
}

const MS: u64 = 1_000_000;
const US: u64 = 1_000;

impl Platform {
    const fn new(
        name: &'static str,
        lanes: u32,
        (tight_ms, loose_ms): (u64, u64),
        overhead_us: u64,
        scale_per_mille: u64,
        edf_latency_s: f64,
    ) -> Self {
        Self {
            name,
            lanes,
            // The four tasks' WCETs together, as a multiple of the tight deadline.
            unit_ns: tight_ms * MS * scale_per_mille / FOUR_TASKS_PER_MILLE,
            tight_ns: tight_ms * MS,
            loose_ns: loose_ms * MS,
            barrier_ns: overhead_us * US / BARRIERS_PER_PIPELINE,
            edf_latency_s,
        }
    }

    /// Interval of the baselines' barriers.
    #[must_use]
    pub const fn grid_ns(&self) -> u64 {
        self.tight_ns / BARRIERS_PER_DEADLINE
    }
}

/// The four platforms of section 5. The scales are fitted to `edf_latency_s`, one number each, and to nothing else.
pub const PLATFORMS: [Platform; 4] = [
    Platform::new("Nano", 1, (9_815, 11_325), 27_300, 1_497, 12.72),
    Platform::new("TX2", 1, (8_400, 10_080), 26_900, 1_358, 9.78),
    Platform::new("Xavier", 1, (6_500, 7_315), 17_400, 1_156, 6.84),
    Platform::new("Orin", 2, (2_400, 3_600), 1_200, 1_381, 2.43),
];

/// A platform of the extended evaluation. Neither its deadlines nor execution times are published.
#[derive(Clone, Copy, Debug)]
pub struct Extended {
    /// Name, as in the paper.
    pub name: &'static str,
    /// WCET of an L task, in nanoseconds: fitted to the mean of EDF's latencies in urban, emergency and night.
    pub unit_ns: u64,
    /// End-to-end budgets, in nanoseconds, of urban and of every other scenario: EDF's latency less the tardiness that its
    /// score at lambda .05 gives, where that score is not 1.
    pub budgets_ns: [u64; 2],
    /// Cost of one barrier, in nanoseconds: that of Orin for all.
    pub barrier_ns: u64,
}

impl Extended {
    const fn new(name: &'static str, unit_ms: u64, budgets_ms: [u64; 2]) -> Self {
        let budgets_ns = [budgets_ms[0] * MS, budgets_ms[1] * MS];
        Self { name, unit_ns: unit_ms * MS, budgets_ns, barrier_ns: PLATFORMS[3].barrier_ns }
    }

    /// Interval of the baselines' barriers.
    #[must_use]
    pub const fn grid_ns(&self) -> u64 {
        self.budgets_ns[0] / BARRIERS_PER_DEADLINE
    }
}

/// rho of all three: EDF's latencies of scenarios are sums of the same task costs, so stages do not overlap.
pub const EXTENDED_LANES: u32 = 1;

/// The three platforms of the extended evaluation.
pub const EXTENDED: [Extended; 3] = [
    Extended::new("Nano Orin", 6_450, [17_300, 17_200]),
    Extended::new("AGX Orin", 5_675, [16_960, 16_540]),
    Extended::new("MacBook Pro", 1_005, [5_990, 2_890]),
];
