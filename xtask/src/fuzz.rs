//! Random inputs: libFuzzer's targets in `fuzz`.
//!
//! Without AddressSanitizer: what is tried has no unsafe code of ours but the C ABI's, and goes four times as far in the same time.
//!
//! What was found interesting stays in the target folder and is where the next run begins; an input that fails stays
//! in `fuzz/artifacts`.

use std::fs;
use std::time::{Duration, Instant};

use crate::depth::Depth;
use crate::nightly::{HOST, Nightly, Said, hear_with};
use crate::process::Failure;
use crate::report::Tally;
use crate::tools;
use crate::workspace::Workspace;

const CARGO_FUZZ: &str = "0.13.2";

/// A target, its longest input, where its first inputs are, and what planted bugs say.
struct Target {
    name: &'static str,
    longest: u32,
    seeds: &'static [&'static str],
    /// What libFuzzer is told besides.
    options: &'static [&'static str],
    planted: &'static [Planted],
}

/// A bug by the name that the target is told, and what is said when it is found.
struct Planted {
    name: &'static str,
    says: &'static str,
}

impl Planted {
    const fn new(name: &'static str, says: &'static str) -> Self {
        Self { name, says }
    }
}

/// Where the bytes only choose what is drawn, how often a branch was taken says nothing, and costs half of the time.
const DRAWN: &[&str] = &["-use_counters=0", "-entropic=0"];

/// As [`DRAWN`]; and what the target itself compares, by name, are no words of its inputs.
const CHOSEN: &[&str] = &["-use_counters=0", "-entropic=0", "-use_cmp=0"];

const TARGETS: &[Target] = &[
    Target {
        name: "workload",
        longest: 2_048,
        seeds: &["fuzz/seeds/workload", "examples", "examples/scenarios"],
        options: &[],
        planted: &[Planted::new("bug", "a message of ")],
    },
    Target {
        name: "core_calls",
        longest: 512,
        seeds: &[],
        options: &[],
        planted: &[Planted::new("bug", "units that run, and those that the host has")],
    },
    Target {
        name: "core_runs",
        longest: 6,
        seeds: &[],
        options: DRAWN,
        planted: &[Planted::new("bug", "panicked at fuzz_targets/core_runs.rs")],
    },
    Target {
        name: "replay_log",
        longest: 1_024,
        seeds: &[],
        options: &[],
        planted: &[Planted::new("bug", "a planted bug")],
    },
    Target {
        name: "abi_calls",
        longest: 1_024,
        seeds: &["fuzz/seeds/abi_calls"],
        options: CHOSEN,
        planted: &[
            Planted::new("generation", "wrong is {Closed"),
            Planted::new("output", "not what its outputs are to be"),
            Planted::new("refused", "wrote to something open that it may not change"),
            Planted::new("closed", "wrote to memory that is not lent"),
            Planted::new("lane", "the core itself says something else"),
            Planted::new("status", "the header does not list it"),
            Planted::new("twice", "was given out before"),
            Planted::new("log", "a log that does not replay"),
            Planted::new("body", "the core itself says something else to red_runtime_"),
        ],
    },
];

/// A run with fewer executions has shown nothing.
const FEWEST: u64 = 100;

/// Between two signs of life.
const PROGRESS: Duration = Duration::from_secs(30);

/// Executions of each target if nobody says how many.
const EXECUTIONS: u64 = 1_000_000;

/// What is asked of `cargo xtask fuzz`.
pub(crate) struct Wish<'a> {
    target: Option<&'a Target>,
    executions: u64,
}

impl Wish<'_> {
    /// # Errors
    /// What is not known.
    pub(crate) fn of(words: &[&str]) -> Result<Self, String> {
        let mut wish = Self { target: None, executions: EXECUTIONS };
        let mut words = words.iter();
        while let Some(word) = words.next() {
            if *word == "--executions" {
                let number = words.next().and_then(|number| number.parse().ok());
                let number = number.filter(|number| *number >= FEWEST);
                wish.executions =
                    number.ok_or_else(|| format!("--executions takes a number of at least {FEWEST}"))?;
            } else if wish.target.is_some() {
                return Err(format!("one target or all, not {word:?} too"));
            } else {
                let known = TARGETS.iter().find(|target| target.name == *word);
                let names = || TARGETS.iter().map(|target| target.name).collect::<Vec<_>>().join(", ");
                wish.target =
                    Some(known.ok_or_else(|| format!("no target {word:?}; there are {}", names()))?);
            }
        }
        Ok(wish)
    }
}

/// `cargo xtask fuzz`.
///
/// # Errors
/// A tool is missing, or an input fails.
pub(crate) fn run(workspace: &Workspace, wish: &Wish<'_>) -> Result<Tally, Failure> {
    let fuzzer = Fuzzer::new(workspace)?;
    let bound = format!("-runs={}", wish.executions);
    for target in TARGETS.iter().filter(|target| wish.target.is_none_or(|only| only.name == target.name)) {
        fuzzer.explore(target, &bound)?;
    }
    Ok(Tally::default())
}

/// # Errors
/// A tool is missing, an input fails, or a planted bug is not found.
pub(crate) fn step(workspace: &Workspace, depth: Depth) -> Result<Tally, Failure> {
    let fuzzer = Fuzzer::new(workspace)?;
    let bound = match depth {
        Depth::Quick => "-max_total_time=30",
        Depth::Deep => "-max_total_time=900",
    };
    for target in TARGETS {
        fuzzer.explore(target, bound)?;
    }
    let mut found = 0;
    for target in TARGETS {
        for Planted { name, says } in target.planted {
            let said = fuzzer.start(target, Some(name), &["-max_total_time=120"])?;
            said.found(target.name, says)?;
            found += 1;
        }
    }
    Ok(Tally { passed: TARGETS.len() as u32 + found, ..Tally::default() })
}

struct Fuzzer<'a> {
    workspace: &'a Workspace,
    nightly: Nightly<'a>,
}

impl<'a> Fuzzer<'a> {
    fn new(workspace: &'a Workspace) -> Result<Self, Failure> {
        let nightly = Nightly::with(workspace, &["rust-src"])?;
        // libFuzzer is built with each target.
        tools::present(workspace, "c++", &["g++"])?;
        tools::built(workspace, "cargo-fuzz", CARGO_FUZZ, &["--version"])?;
        Ok(Self { workspace, nightly })
    }

    /// Runs a target and says how far it came.
    fn explore(&self, target: &Target, bound: &str) -> Result<(), Failure> {
        let text = self.start(target, None, &[bound])?.well(target.name)?;
        let number =
            |name: &str| text.lines().find_map(|line| line.strip_prefix(name)).map_or("?", str::trim);
        let executions = number("stat::number_of_executed_units:");
        if executions.parse::<u64>().map_or(true, |executions| executions < FEWEST) {
            let (name, wanted) = (target.name, format!("at least {FEWEST} are wanted"));
            return Err(Failure::Wrong(format!("{name}: {executions} executions show nothing; {wanted}")));
        }
        let last = text.lines().rfind(|line| line.starts_with('#') && line.contains(" cov: ")).unwrap_or("");
        let after = |word: &str| last.split_whitespace().skip_while(|w| *w != word).nth(1).unwrap_or("?");
        // `839/55Kb`
        let (inputs, bytes) = after("corp:").split_once('/').unwrap_or(("?", "?"));
        let bytes = bytes.replace("Kb", " thousand").replace('b', "");
        say!(
            "{}: {} executions, {} a second, {} edges of code covered, {} features, {} inputs kept ({} bytes)",
            target.name,
            executions,
            number("stat::average_exec_per_sec:"),
            after("cov:"),
            after("ft:"),
            inputs,
            bytes
        );
        Ok(())
    }

    /// Runs a target, with a planted bug if one is named.
    fn start(&self, target: &Target, planted: Option<&str>, bounds: &[&str]) -> Result<Said, Failure> {
        let folder = self.nightly.target("fuzz");
        // Planted bugs begin from the smallest seeds, so that none is found by what another run left.
        let kept = folder.join(if planted.is_none() { "corpus" } else { "planted" }).join(target.name);
        if planted.is_some() && kept.exists() {
            fs::remove_dir_all(&kept).map_err(Failure::of_file(&kept))?;
        }
        fs::create_dir_all(&kept).map_err(Failure::of_file(&kept))?;
        let longest = format!("-max_len={}", target.longest);
        let run = ["fuzz", "run", "--fuzz-dir", "fuzz", "--sanitizer", "none", "--target", HOST];
        // Noting every comparison of numbers takes half of the time and more; names are compared as memory, and seen.
        let run = [&run[..], &["--no-trace-compares", "--target-dir"]].concat();
        let features: &[&str] = if planted.is_some() { &["--features", "planted"] } else { &[] };
        let run =
            self.nightly.cargo(&run).args(&[&folder]).args(features).args(&[target.name]).args(&[&kept]);
        let run = run.env("RED_PLANTED", planted.unwrap_or(""));
        let few = if planted.is_none() { target.seeds.len() } else { 1 };
        let seeds = target.seeds.iter().take(few).map(|seed| self.workspace.root.join(seed));
        let run = run.args(&seeds.collect::<Vec<_>>()).args(&["--", &longest, "-print_final_stats=1"]);
        let run = run.args(target.options);
        // A planted bug leaves nothing in the sources' folder.
        let found = planted.is_some().then(|| format!("-artifact_prefix={}/", kept.display()));
        hear_with(run.args(found.as_slice()).args(bounds), signs_of_life())
    }
}

/// Shows a line of libFuzzer's progress now and then.
fn signs_of_life() -> impl FnMut(&str) {
    let mut told = Instant::now();
    move |line| {
        if line.starts_with('#') && told.elapsed() >= PROGRESS {
            say!("{line}");
            told = Instant::now();
        }
    }
}

#[cfg(test)]
mod tests;
