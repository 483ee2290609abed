#![allow(unsafe_code, reason = "names of C")]
//! What the scheduler does, as numbers.

use crate::boundary::{Growing, OutGrowing, plain};
use crate::status::{flat, red_status};
use crate::values::RED_NONE_64;
use red_core::{
    Admission, BestCase, Bytes, Config, DeadlineRule, Duration, Gate, Late, Overload, Ppm, Reassign, Shed,
};

/// The named configurations.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum red_preset {
    /// The paper's baseline: unrefined graphs, one deadline per job, and nothing else.
    Edf = 0,
    /// The paper's RED-FG: refined, level shares, level barrier.
    RedFg = 1,
    /// The paper's RED-IDA: RED-FG with re-assignment at each dispatch.
    RedIda = 2,
    /// The paper's RED: RED-IDA with merging, on-demand synchronisation and ProactiveDrop.
    Red = 3,
    /// Ours, and the default: latest-start keys, precedence gating, merging, frame cache, hopeless-first shedding.
    Redrt = 4,
    /// Ours, with lanes that wait for what is soon ready where nothing is preempted.
    RedrtLookahead = 5,
}

/// How a node's sub-deadline follows from the end-to-end deadline D.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum red_rule {
    /// D for every node: job-level EDF.
    EndToEnd = 0,
    /// Level shares in proportion to the level's cost (paper Def. 4).
    LevelSum = 1,
    /// Level shares that cover Graham's bound of each level first.
    LevelGraham = 2,
    /// D * head / (head + tail), for progress reports.
    PathProportional = 3,
    /// D - tail.
    LatestFinish = 4,
    /// D - tail, dispatched by the latest start that can still meet D.
    LatestStart = 5,
}

/// What must be done before a node may start.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum red_gate {
    /// Its predecessors.
    Precedence = 0,
    /// Every node of a lower height, as the paper's level barrier has it.
    Level = 1,
    /// Its predecessors, and a more pressing node that is ready so soon that it would be late behind this one.
    Lookahead = 2,
}

/// When sub-deadlines of jobs in flight are computed again.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum red_reassign {
    /// Only when the graph changes.
    Never = 0,
    /// Level rules: of every job at each dispatch (paper section 4.3).
    OnDispatch = 1,
    /// Level rules: of a job when one of its nodes ended.
    OnChange = 2,
}

/// Which jobs are given up.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum red_shedding {
    /// None.
    Never = 0,
    /// The paper's ProactiveDrop: lowest urgency first, while the overload lasts.
    LowestUrgency = 1,
    /// Jobs that no schedule can end in time, at once; and the least of those that would make others late.
    Hopeless = 2,
}

/// What happens to a job that is past its deadline.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum red_late {
    /// It runs on.
    Continue = 0,
    /// It is given up.
    AbortJob = 1,
}

/// Where best-case execution times come from.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum red_best_case {
    /// The shortest of the last 8 executions, the declared one before the first.
    Observed = 0,
    /// The declared one, always.
    Declared = 1,
}

/// What happens to a task, or an edit, whose certificate does not fit.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum red_admission {
    /// It is accepted.
    Report = 0,
    /// It is refused: RED_STATUS_UNSCHEDULABLE.
    Enforce = 1,
}

/// Configuration of a scheduler. Begin with RED_CONFIG_INIT and red_config_preset.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct red_config {
    /// RED_CONFIG_INIT sets it.
    pub struct_size: u32,
    /// RED_CONFIG_INIT sets it.
    pub abi_version: u32,
    /// Lanes of the first pool; 1 up to the lanes of the capacity class.
    pub lanes: u32,
    /// One of red_rule.
    pub rule: u32,
    /// One of red_gate.
    pub gate: u32,
    /// One of red_reassign.
    pub reassign: u32,
    /// 1: stages are to be refined into encoder and decoders; the host builds its graphs by it. 0: not.
    pub refine: u32,
    /// 1: encoder results are shared beyond their unit. 0: not.
    pub frame_cache: u32,
    /// One of red_shedding.
    pub shed: u32,
    /// One of red_late.
    pub late: u32,
    /// One of red_best_case.
    pub best_case: u32,
    /// One of red_admission.
    pub admission: u32,
    /// 1: a waiting node takes the lane of a running one with a larger key. 0: not.
    pub preempt: u32,
    /// theta_u: busy share of all lanes in one tick that is overload, in millionths.
    pub overload_utilisation_ppm: u32,
    /// Q_max: ready sub-jobs above which it is overload; up to 65,535.
    pub overload_queue: u32,
    /// W: consecutive ticks until it is lasting; up to 255.
    pub overload_ticks: u32,
    /// Length of a tick; at least 1.
    pub overload_tick_ns: u64,
    /// Memory budget of the first pool; RED_NONE_64: unlimited.
    pub memory_bytes: u64,
    /// gamma of DynamicMerge; RED_NONE_64: no merging.
    pub merge_skew_ns: u64,
}
plain!(red_config {
    struct_size: u32,
    abi_version: u32,
    lanes: u32,
    rule: u32,
    gate: u32,
    reassign: u32,
    refine: u32,
    frame_cache: u32,
    shed: u32,
    late: u32,
    best_case: u32,
    admission: u32,
    preempt: u32,
    overload_utilisation_ppm: u32,
    overload_queue: u32,
    overload_ticks: u32,
    overload_tick_ns: u64,
    memory_bytes: u64,
    merge_skew_ns: u64,
});
impl Growing for red_config {
    const LEAST: usize = 88;
}

/// The value of a number, if it is one of those.
fn one_of<T: Copy>(number: u32, values: &[T]) -> Result<T, red_status> {
    values.get(number as usize).copied().ok_or(red_status::OutOfRange)
}

/// The value of a number that is 0 or 1.
pub(crate) fn flag(number: u32) -> Result<bool, red_status> {
    one_of(number, &[false, true])
}

pub(crate) fn rule(number: u32) -> Result<DeadlineRule, red_status> {
    const RULES: &[DeadlineRule] = &[
        DeadlineRule::EndToEnd,
        DeadlineRule::LevelSum,
        DeadlineRule::LevelGraham,
        DeadlineRule::PathProportional,
        DeadlineRule::LatestFinish,
        DeadlineRule::LatestStart,
    ];
    one_of(number, RULES)
}

pub(crate) fn bytes(number: u64) -> Option<Bytes> {
    (number != RED_NONE_64).then_some(Bytes(number))
}

impl red_config {
    pub(crate) fn read(self) -> Result<Config, red_status> {
        let narrow = |number: u32| u8::try_from(number).map_err(|_| red_status::OutOfRange);
        if self.overload_tick_ns == 0 {
            return Err(red_status::OutOfRange);
        }
        Ok(Config {
            lanes: u8::try_from(self.lanes).map_err(|_| red_status::PoolsFull)?,
            memory: bytes(self.memory_bytes),
            rule: rule(self.rule)?,
            gate: one_of(self.gate, &[Gate::Precedence, Gate::Level, Gate::Lookahead])?,
            reassign: one_of(self.reassign, &[Reassign::Never, Reassign::OnDispatch, Reassign::OnChange])?,
            refine: flag(self.refine)?,
            merge_skew: (self.merge_skew_ns != RED_NONE_64)
                .then_some(Duration::from_nanos(self.merge_skew_ns)),
            frame_cache: flag(self.frame_cache)?,
            shed: one_of(self.shed, &[Shed::Never, Shed::LowestUrgency, Shed::Hopeless])?,
            late: one_of(self.late, &[Late::Continue, Late::AbortJob])?,
            best_case: one_of(self.best_case, &[BestCase::Observed, BestCase::Declared])?,
            overload: Overload {
                utilisation: Ppm(self.overload_utilisation_ppm),
                queue: u16::try_from(self.overload_queue).map_err(|_| red_status::OutOfRange)?,
                ticks: narrow(self.overload_ticks)?,
                tick: Duration::from_nanos(self.overload_tick_ns),
            },
            admission: one_of(self.admission, &[Admission::Report, Admission::Enforce])?,
            preempt: flag(self.preempt)?,
        })
    }

    pub(crate) fn of(config: &Config) -> Self {
        Self {
            struct_size: 0,
            abi_version: 0,
            lanes: config.lanes.into(),
            rule: config.rule as u32,
            gate: config.gate as u32,
            reassign: config.reassign as u32,
            refine: config.refine.into(),
            frame_cache: config.frame_cache.into(),
            shed: config.shed as u32,
            late: config.late as u32,
            best_case: config.best_case as u32,
            admission: config.admission as u32,
            preempt: config.preempt.into(),
            overload_utilisation_ppm: config.overload.utilisation.0,
            overload_queue: config.overload.queue.into(),
            overload_ticks: config.overload.ticks.into(),
            overload_tick_ns: config.overload.tick.as_nanos(),
            memory_bytes: config.memory.map_or(RED_NONE_64, |memory| memory.0),
            merge_skew_ns: config.merge_skew.map_or(RED_NONE_64, Duration::as_nanos),
        }
    }
}

/// Fills a configuration with a named one of one lane and unlimited memory.
///
/// Threads: any, at once. Real time: yes. Time: O(1). Errors: RED_STATUS_OUT_OF_RANGE: `preset` is not one of red_preset.
#[unsafe(no_mangle)]
pub extern "C" fn red_config_preset(preset: u32, config: *mut red_config) -> red_status {
    const PRESETS: &[Config] =
        &[Config::EDF, Config::RED_FG, Config::RED_IDA, Config::RED, Config::REDRT, Config::REDRT_LOOKAHEAD];
    flat(OutGrowing::of(config).and_then(|config| {
        config.put(red_config::of(&one_of(preset, PRESETS)?));
        Ok(red_status::Ok)
    }))
}
