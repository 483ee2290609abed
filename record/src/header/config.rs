//! A configuration as a header has it. A field or a variant that the core gets does not compile here until it has a
//! place, and one that this version does not know is refused.

use red_core::{
    Admission, BestCase, Bytes, Config, DeadlineRule, Duration, Gate, Late, Overload, Ppm, Reassign, Shed,
};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// `Config`, with plain integers; times in nanoseconds, memory in bytes.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    lanes: u8,
    memory: Option<u64>,
    #[serde(with = "WrittenRule")]
    rule: DeadlineRule,
    #[serde(with = "WrittenGate")]
    gate: Gate,
    #[serde(with = "WrittenReassign")]
    reassign: Reassign,
    refine: bool,
    merge_skew_ns: Option<u64>,
    frame_cache: bool,
    #[serde(with = "WrittenShed")]
    shed: Shed,
    #[serde(with = "WrittenLate")]
    late: Late,
    #[serde(with = "WrittenBestCase")]
    best_case: BestCase,
    overload: WrittenOverload,
    #[serde(with = "WrittenAdmission")]
    admission: Admission,
    preempt: bool,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenOverload {
    utilisation_ppm: u32,
    queue: u16,
    ticks: u8,
    tick_ns: u64,
}

macro_rules! variants {
    ($($written:ident of $of:literal: $($variant:ident)*;)*) => { $(
        #[derive(Serialize, Deserialize)]
        #[serde(remote = $of, rename_all = "kebab-case")]
        enum $written { $($variant,)* }
    )* };
}

variants! {
    WrittenRule of "DeadlineRule":
        EndToEnd LevelSum LevelGraham PathProportional LatestFinish LatestStart;
    WrittenGate of "Gate": Precedence Level Lookahead;
    WrittenReassign of "Reassign": Never OnDispatch OnChange;
    WrittenShed of "Shed": Never LowestUrgency Hopeless;
    WrittenLate of "Late": Continue AbortJob;
    WrittenBestCase of "BestCase": Observed Declared;
    WrittenAdmission of "Admission": Report Enforce;
}

impl From<&Config> for Written {
    fn from(config: &Config) -> Self {
        let Config { lanes, memory, rule, gate, reassign, refine, merge_skew, .. } = *config;
        let Config { frame_cache, shed, late, best_case, overload, admission, preempt, .. } = *config;
        let Overload { utilisation, queue, ticks, tick } = overload;
        let (memory, merge_skew_ns) = (memory.map(|bytes| bytes.0), merge_skew.map(Duration::as_nanos));
        let overload =
            WrittenOverload { utilisation_ppm: utilisation.0, queue, ticks, tick_ns: tick.as_nanos() };
        Self {
            lanes,
            memory,
            rule,
            gate,
            reassign,
            refine,
            merge_skew_ns,
            frame_cache,
            shed,
            late,
            best_case,
            overload,
            admission,
            preempt,
        }
    }
}

impl From<Written> for Config {
    fn from(written: Written) -> Self {
        let Written { lanes, rule, gate, reassign, refine, frame_cache, .. } = written;
        let Written { shed, late, best_case, overload, admission, preempt, .. } = written;
        let WrittenOverload { utilisation_ppm, queue, ticks, tick_ns } = overload;
        Self {
            lanes,
            memory: written.memory.map(Bytes),
            rule,
            gate,
            reassign,
            refine,
            merge_skew: written.merge_skew_ns.map(Duration::from_nanos),
            frame_cache,
            shed,
            late,
            best_case,
            overload: Overload {
                utilisation: Ppm(utilisation_ppm),
                queue,
                ticks,
                tick: Duration::from_nanos(tick_ns),
            },
            admission,
            preempt,
        }
    }
}

pub(super) fn serialize<S: Serializer>(config: &Option<Config>, to: S) -> Result<S::Ok, S::Error> {
    config.as_ref().map(Written::from).serialize(to)
}

pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Config>, D::Error> {
    Ok(Option::<Written>::deserialize(from)?.map(Config::from))
}
