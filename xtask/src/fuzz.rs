//! Random inputs: libFuzzer's targets in `fuzz`.
//!
//! Without AddressSanitizer: what is tried has no unsafe code of ours but the C ABI's, and goes four times as far in the same time.
//!
//! A step's run is the same on every machine: it begins with the committed seeds and an empty folder, draws the same
//! numbers, and ends after so many executions. By hand, a run begins with what the last one found interesting, and draws
//! others. An input that fails stays in `fuzz/artifacts`.

mod stop;
mod targets;

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::depth::Depth;
use crate::nightly::{HOST, Nightly, Said, hear_with};
use crate::process::{Failure, Run};
use crate::report::Tally;
use crate::tools;
use crate::workspace::{Workspace, entries};
use stop::Stop;
use targets::{Planted, TARGETS, Target};

const CARGO_FUZZ: &str = "0.13.2";

/// A step's numbers are drawn from it.
const SEED: &str = "-seed=1";

/// The other one of the two that libFuzzer goes by is the clock.
const NO_CLOCK: &str = "-reload=0";

/// `--deep` executes so many times as much.
const DEEP: u64 = 30;

/// The time of a run that would take half a minute, in case that it never ends. The count is what ends it.
const LAST_RESORT: Duration = Duration::from_secs(900);

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
    /// An input to run alone, and the bug that is planted meanwhile.
    input: Option<&'a str>,
    planted: Option<&'a str>,
}

impl<'a> Wish<'a> {
    /// # Errors
    /// What is not known.
    pub(crate) fn of(words: &[&'a str]) -> Result<Self, String> {
        let mut wish = Self { target: None, executions: EXECUTIONS, input: None, planted: None };
        let mut words = words.iter().copied();
        while let Some(word) = words.next() {
            match word {
                "--executions" => {
                    let number = words.next().and_then(|number| number.parse().ok());
                    let number = number.filter(|number| *number >= FEWEST);
                    wish.executions =
                        number.ok_or_else(|| format!("--executions takes a number of at least {FEWEST}"))?;
                }
                "--input" => wish.input = Some(words.next().ok_or("--input takes a file")?),
                "--planted" => wish.planted = Some(words.next().ok_or("--planted takes the name of a bug")?),
                _ if wish.target.is_some() => return Err(format!("one target or all, not {word:?} too")),
                _ => {
                    let known = TARGETS.iter().find(|target| target.name == word);
                    let names = || TARGETS.iter().map(|target| target.name).collect::<Vec<_>>().join(", ");
                    wish.target =
                        Some(known.ok_or_else(|| format!("no target {word:?}; there are {}", names()))?);
                }
            }
        }
        if wish.target.is_none() && wish.input.is_some() {
            return Err("--input takes a target".to_owned());
        }
        if wish.planted.is_some_and(|name| wish.input.is_none() || !wish.has_planted(name)) {
            return Err("--planted takes an --input, and a bug of its target".to_owned());
        }
        Ok(wish)
    }

    fn has_planted(&self, name: &str) -> bool {
        self.target.is_some_and(|target| target.planted.iter().any(|planted| planted.name == name))
    }
}

/// `cargo xtask fuzz`.
///
/// # Errors
/// A tool is missing, or an input fails.
pub(crate) fn run(workspace: &Workspace, wish: &Wish<'_>) -> Result<Tally, Failure> {
    let fuzzer = Fuzzer::new(workspace)?;
    if let (Some(target), Some(input)) = (wish.target, wish.input) {
        let input = std::path::absolute(input).map_err(Failure::of_file(Path::new(input)))?;
        return fuzzer.command(target, wish.planted).args(&[input]).stream();
    }
    for target in TARGETS.iter().filter(|target| wish.target.is_none_or(|only| only.name == target.name)) {
        let folder = fuzzer.folder("corpus", target.name)?;
        fuzzer.explore(target, &folder, wish.executions, &[])?;
    }
    Ok(Tally::default())
}

/// # Errors
/// A tool is missing, an input fails, or a planted bug is not found.
pub(crate) fn step(workspace: &Workspace, depth: Depth) -> Result<Tally, Failure> {
    let fuzzer = Fuzzer::new(workspace)?;
    let times = match depth {
        Depth::Quick => 1,
        Depth::Deep => DEEP,
    };
    let time = format!("-max_total_time={}", LAST_RESORT.as_secs() * times);
    for target in TARGETS {
        let folder = fuzzer.empty("explored", target.name)?;
        fuzzer.explore(target, &folder, target.executions * times, &[SEED, NO_CLOCK, &time])?;
    }
    let mut found = 0;
    for target in TARGETS {
        for planted in target.planted {
            fuzzer.find(target, planted)?;
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
    fn explore(
        &self,
        target: &Target,
        folder: &Path,
        executions: u64,
        options: &[&str],
    ) -> Result<(), Failure> {
        let said = self.start(target, None, folder, executions, options)?;
        if !said.status.success() {
            return Err(Failure::Wrong(format!("{}: {}", target.name, self.stopped(target, None, &said))));
        }
        came_so_far(target.name, &said.text, executions)?;
        let number = |name: &str| number(&said.text, name).unwrap_or("?");
        let last = said.text.lines().rfind(|line| line.starts_with('#') && line.contains(" cov: "));
        let after = |word: &str| {
            last.unwrap_or("").split_whitespace().skip_while(|w| *w != word).nth(1).unwrap_or("?")
        };
        // `839/55Kb`
        let (inputs, bytes) = after("corp:").split_once('/').unwrap_or(("?", "?"));
        let bytes = bytes.replace("Kb", " thousand").replace('b', "");
        say!(
            "{}: {} executions, {} a second, {} edges of code covered, {} features, {} inputs kept ({} bytes)",
            target.name,
            number(EXECUTED),
            number("stat::average_exec_per_sec:"),
            after("cov:"),
            after("ft:"),
            inputs,
            bytes
        );
        Ok(())
    }

    /// Runs a target with a planted bug, which has to be what it stops on.
    fn find(&self, target: &Target, planted: &Planted) -> Result<(), Failure> {
        let (name, bug) = (target.name, planted.name);
        let folder = self.empty("planted", name)?;
        let time = format!("-max_total_time={}", LAST_RESORT.as_secs());
        let options = [SEED, NO_CLOCK, &time];
        let said = self.start(target, Some(bug), &folder, planted.within, &options)?;
        if said.status.success() {
            came_so_far(name, &said.text, planted.within)?;
            let why = format!("not found in {} executions, so this check finds nothing", planted.within);
            return Err(Failure::Wrong(format!("{name}: the planted bug {bug:?} is {why}")));
        }
        let stop = Stop::of(&said.text);
        let Some(line) = stop.line_with(planted.says) else {
            let stopped = self.stopped(target, Some(bug), &said);
            return Err(Failure::Wrong(format!("{name}: not on the planted bug {bug:?}: {stopped}")));
        };
        let executions = number(&said.text, EXECUTED).unwrap_or("?");
        say!("{name}: found, as it should be, in {executions} executions: {line}");
        // It is nobody's to mend.
        stop.input.map_or(Ok(()), |input| fs::remove_file(input).map_err(Failure::of_file(Path::new(input))))
    }

    /// What a run stopped on, and how to see it again.
    fn stopped(&self, target: &Target, planted: Option<&str>, said: &Said) -> String {
        let Stop { why, input } = Stop::of(&said.text);
        let Some(input) = input else {
            return format!("{}\n{}", said.status, said.last(60));
        };
        let input = Path::new(input);
        let input = input.strip_prefix(&self.workspace.root).unwrap_or(input).display();
        let planted = planted.map_or(String::new(), |bug| format!(" --planted {bug}"));
        format!(
            "the fuzzer stopped\n{}\nthe input is kept in {input}; it is run again by\n\
             cargo xtask fuzz {}{planted} --input {input}",
            why.join("\n"),
            target.name
        )
    }

    /// Where a kind of runs keeps what it finds interesting.
    fn folder(&self, kind: &str, target: &str) -> Result<PathBuf, Failure> {
        let folder = self.nightly.target("fuzz").join(kind).join(target);
        fs::create_dir_all(&folder).map_err(Failure::of_file(&folder))?;
        Ok(folder)
    }

    /// The same without what another run left.
    fn empty(&self, kind: &str, target: &str) -> Result<PathBuf, Failure> {
        let folder = self.folder(kind, target)?;
        fs::remove_dir_all(&folder).map_err(Failure::of_file(&folder))?;
        self.folder(kind, target)
    }

    /// A target, with a planted bug if one is named, that is told what to do yet.
    fn command(&self, target: &Target, planted: Option<&str>) -> Run {
        let run = ["fuzz", "run", "--fuzz-dir", "fuzz", "--sanitizer", "none", "--target", HOST];
        // Noting every comparison of numbers takes half of the time and more; names are compared as memory, and seen.
        let run = [&run[..], &["--no-trace-compares", "--target-dir"]].concat();
        let features: &[&str] = if planted.is_some() { &["--features", "planted"] } else { &[] };
        let run = self.nightly.cargo(&run).args(&[self.nightly.target("fuzz")]).args(features);
        run.args(&[target.name]).env("RED_PLANTED", planted.unwrap_or(""))
    }

    /// Runs a target from its seeds and what is in the folder.
    fn start(
        &self,
        target: &Target,
        planted: Option<&str>,
        folder: &Path,
        executions: u64,
        options: &[&str],
    ) -> Result<Said, Failure> {
        let artifacts = self.workspace.root.join("fuzz/artifacts").join(target.name);
        fs::create_dir_all(&artifacts).map_err(Failure::of_file(&artifacts))?;
        // Named after its bug: without that it does not fail.
        let prefix = planted.map_or(String::new(), |bug| format!("planted-{bug}-"));
        let few = if planted.is_none() { target.seeds.len() } else { 1 };
        let mut told = vec![
            format!("-max_len={}", target.longest),
            format!("-runs={executions}"),
            format!("-artifact_prefix={}/{prefix}", artifacts.display()),
            "-print_final_stats=1".to_owned(),
        ];
        let seeds = self.seeds(target.seeds.iter().take(few))?;
        if !seeds.is_empty() {
            told.push(format!("-seed_inputs={}", seeds.join(",")));
        }
        let run = self.command(target, planted).args(&[folder]).args(&["--"]).args(&told);
        hear_with(run.args(target.options).args(options), signs_of_life())
    }

    /// The files of these folders. Those of a folder that libFuzzer is given come as the file system has them.
    fn seeds(&self, folders: impl Iterator<Item = &'static &'static str>) -> Result<Vec<String>, Failure> {
        let mut seeds = Vec::new();
        for folder in folders {
            let mut files = entries(&self.workspace.root.join(folder))?;
            files.retain(|file| file.is_file());
            files.sort();
            seeds.extend(files.iter().map(|file| file.display().to_string()));
        }
        Ok(seeds)
    }
}

const EXECUTED: &str = "stat::number_of_executed_units:";

/// A number of libFuzzer's last words.
fn number<'t>(text: &'t str, name: &str) -> Option<&'t str> {
    text.lines().find_map(|line| line.strip_prefix(name)).map(str::trim)
}

/// # Errors
/// It ended earlier, and not by what it tried: no machine may show less than another one.
fn came_so_far(target: &str, text: &str, executions: u64) -> Result<(), Failure> {
    let came = number(text, EXECUTED).and_then(|number| number.parse().ok()).unwrap_or(0);
    if came >= executions {
        return Ok(());
    }
    let why = format!("after {came} of {executions} executions its time was over, and shows nothing");
    Err(Failure::Wrong(format!("{target}: {why}")))
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
