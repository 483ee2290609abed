//! The targets, how far a step goes with each, and the bugs that it has to find in them.

/// A target, its longest input, where its first inputs are, and what planted bugs say.
pub(super) struct Target {
    pub(super) name: &'static str,
    pub(super) longest: u32,
    /// Folders; planted bugs begin with the first one alone.
    pub(super) seeds: &'static [&'static str],
    /// What libFuzzer is told besides.
    pub(super) options: &'static [&'static str],
    /// Executions of a step.
    pub(super) executions: u64,
    pub(super) planted: &'static [Planted],
}

/// A bug by the name that the target is told, and what is said when it is found.
pub(super) struct Planted {
    pub(super) name: &'static str,
    /// One of these: what goes wrong first is for the input to say.
    pub(super) says: &'static [&'static str],
    /// Executions in which it has to be found: ten times and more what the slowest of ten other seeds took, as far as it was
    /// measured. That was 2 for what any call shows, 24 for `refused`, 1,408 for `generation`, 2,565 for `lane`, 3,310 for
    /// `status`, 15,380 for `log`, 47,065 for `body`, 217 for `core_calls`, 2,991 for `replay_log`.
    pub(super) within: u64,
}

impl Planted {
    const fn new(name: &'static str, within: u64, says: &'static [&'static str]) -> Self {
        Self { name, says, within }
    }
}

/// Where the bytes only choose what is drawn, how often a branch was taken says nothing, and costs half of the time.
const DRAWN: &[&str] = &["-use_counters=0", "-entropic=0"];

/// As [`DRAWN`]; and what the target itself compares, by name, are no words of its inputs.
const CHOSEN: &[&str] = &["-use_counters=0", "-entropic=0", "-use_cmp=0"];

/// A closed handle reaches something: alone among what is wrong, or with more.
const CLOSED: &[&str] = &["wrong is {Closed", ", Closed"];

/// A lane that stays is restored, is given a unit, or has what is polled be another one.
const LANE: &[&str] = &[
    "the core itself says something else",
    "a unit on a lane that was retired",
    "not what its outputs are to be",
];

pub(super) const TARGETS: &[Target] = &[
    Target {
        name: "workload",
        longest: 2_048,
        seeds: &["fuzz/seeds/workload", "examples", "examples/scenarios"],
        options: &[],
        executions: 120_000,
        planted: &[Planted::new("bug", 100_000, &["a message of "])],
    },
    Target {
        name: "core_calls",
        longest: 512,
        seeds: &[],
        options: &[],
        executions: 300_000,
        planted: &[Planted::new("bug", 100_000, &["units that run, and those that the host has"])],
    },
    Target {
        name: "core_runs",
        longest: 6,
        seeds: &[],
        options: DRAWN,
        executions: 30_000,
        planted: &[Planted::new("bug", 100_000, &["panicked at fuzz_targets/core_runs.rs"])],
    },
    Target {
        name: "replay_log",
        longest: 1_024,
        seeds: &[],
        options: &[],
        executions: 100_000,
        planted: &[Planted::new("bug", 100_000, &["a planted bug"])],
    },
    Target {
        name: "abi_calls",
        longest: 1_024,
        seeds: &["fuzz/seeds/abi_calls"],
        options: CHOSEN,
        executions: 100_000,
        planted: &[
            Planted::new("generation", 20_000, CLOSED),
            Planted::new("output", 1_000, &["not what its outputs are to be"]),
            Planted::new("refused", 1_000, &["wrote to something open that it may not change"]),
            Planted::new("closed", 1_000, &["wrote to memory that is not lent"]),
            Planted::new("lane", 100_000, LANE),
            Planted::new("status", 100_000, &["the header does not list it"]),
            Planted::new("twice", 1_000, &["was given out before"]),
            Planted::new("log", 200_000, &["a log that does not replay"]),
            Planted::new("body", 500_000, &["the core itself says something else to red_runtime_"]),
        ],
    },
];
