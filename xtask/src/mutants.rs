//! Changes of the core that its tests should notice: a sample of what cargo-mutants can think of, in parts of which each
//! goes through all files. What a part gave is kept, so that a run that was stopped goes on.

use std::collections::hash_map::DefaultHasher;
use std::fs;
use std::hash::{Hash, Hasher};
use std::path::Path;

use crate::process::{Failure, Run};
use crate::report::Tally;
use crate::tools;
use crate::workspace::Workspace;

const CARGO_MUTANTS: &str = "27.1.0";

/// The least share of mutants that has to be caught, in percent: its lower bound at 95 % confidence.
const NEEDED: f64 = 85.0;

/// Mutants of one part.
const PART: usize = 40;

/// What is run on each: what catches most in least time, and few cases of it.
const QUICK: &[&str] = &["--test", "golden", "--test", "properties", "--test", "differential"];

/// What is run on those that are left.
const ALL: &[&str] = &["--lib", "--tests"];

/// What is asked of `cargo xtask mutants`.
pub(crate) struct Wish {
    sample: usize,
    seed: u64,
}

impl Wish {
    /// # Errors
    /// What is not known.
    pub(crate) fn of(words: &[&str]) -> Result<Self, String> {
        let mut wish = Self { sample: 400, seed: 1 };
        for pair in words.chunks(2) {
            let number = pair.get(1).and_then(|number| number.parse::<u64>().ok());
            let number = number.ok_or_else(|| format!("{} takes a number", pair[0]));
            match pair[0] {
                "--sample" => wish.sample = number? as usize,
                "--seed" => wish.seed = number?,
                other => return Err(format!("mutants knows --sample N and --seed S, not {other}")),
            }
        }
        Ok(wish)
    }
}

/// What became of some mutants.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Found {
    noticed: usize,
    unviable: usize,
    /// What was changed, of those that no test noticed.
    missed: Vec<String>,
}

/// # Errors
/// Too few are noticed.
pub(crate) fn run(workspace: &Workspace, wish: &Wish) -> Result<Tally, Failure> {
    tools::built(workspace, "cargo-mutants", CARGO_MUTANTS, &["mutants", "--version"])?;
    let list = command(workspace, &["--list"]).output()?;
    let mut names = DefaultHasher::new();
    list.hash(&mut names);
    // Lines move with every change of the core, and then nothing that is kept is about it.
    let folder = workspace.target.join("mutants").join(format!("{:016x}", names.finish()));
    let (of, parts) = (list.lines().count().div_ceil(PART), wish.sample.div_ceil(PART));
    // Tests that fail by themselves would notice everything.
    quick(workspace.cargo(&["test", "--package", "red-core", "--package", "red-tests"]).args(QUICK))
        .stream()?;
    let mut all = Found::default();
    for part in 0..parts.min(of) {
        let shard = (wish.seed as usize + part * of / parts.min(of)) % of;
        let found = judge(workspace, &folder.join(format!("{shard}-of-{of}")), &format!("{shard}/{of}"))?;
        let Found { noticed, unviable, missed } = &found;
        println!(
            "part {} of {parts}: {noticed} noticed, {} not, {unviable} do not compile",
            part + 1,
            missed.len()
        );
        all.noticed += noticed;
        all.unviable += unviable;
        all.missed.extend(found.missed);
    }
    let missed = all.missed.len();
    let bound = 100.0 * lower_bound(all.noticed, all.noticed + missed);
    println!("\n{}", all.missed.join("\n"));
    println!("{} noticed, {missed} not, {} do not compile", all.noticed, all.unviable);
    println!("at least {bound:.1} % are noticed, at 95 % confidence; needed are {NEEDED} %");
    if bound >= NEEDED {
        Ok(Tally::default())
    } else {
        Err(Failure::Wrong("too few mutants are noticed".to_owned()))
    }
}

fn command(workspace: &Workspace, arguments: &[&str]) -> Run {
    let program = workspace.target.join("tools/bin/cargo-mutants");
    workspace.command(&program).args(&["mutants", "--package", "red-core"]).args(arguments)
}

/// One part, or what is kept of it.
fn judge(workspace: &Workspace, folder: &Path, shard: &str) -> Result<Found, Failure> {
    let kept = folder.join("found.txt");
    if let Some(found) = Found::read(&read(&kept)) {
        return Ok(found);
    }
    if folder.exists() {
        fs::remove_dir_all(folder).map_err(|reason| file(folder, reason))?;
    }
    fs::create_dir_all(folder).map_err(|reason| file(folder, reason))?;
    let count = |what: &str| read(&folder.join(format!("mutants.out/{what}.txt"))).lines().count();
    let mutants = |more: &[&str], tests: &[&str]| {
        let packages = ["--test-package", "red-core,red-tests", "--baseline", "skip", "--timeout", "120"];
        let part = ["--jobs", "1", "--shard", shard, "--sharding", "round-robin", "--output"];
        let run =
            command(workspace, &packages).args(&part).args(&[folder]).args(more).args(&["--"]).args(tests);
        run.env("CARGO_TARGET_DIR", workspace.target.join("mutants/target"))
    };
    ended(quick(mutants(&[], QUICK)))?;
    let (all, unviable) = (count("caught") + count("missed") + count("timeout"), count("unviable"));
    if count("missed") + count("timeout") > 0 {
        ended(mutants(&["--iterate"], ALL))?;
    }
    // One that never ends is noticed too.
    let missed: Vec<String> =
        read(&folder.join("mutants.out/missed.txt")).lines().map(str::to_owned).collect();
    let found = Found { noticed: all - missed.len(), unviable, missed };
    fs::write(&kept, found.text()).map_err(|reason| file(&kept, reason))?;
    Ok(found)
}

/// Few cases, and no optimization: most of the time goes into what changes, which is the build.
fn quick(run: Run) -> Run {
    let run = run.env("SEEDS", "4").env("PROPTEST_CASES", "30");
    run.env("CARGO_PROFILE_TEST_OPT_LEVEL", "0").env("CARGO_PROFILE_TEST_DEBUG", "0")
}

/// Runs it to its end; that mutants were missed, or never ended, is a status too.
fn ended(run: Run) -> Result<(), Failure> {
    match run.stream() {
        Err(Failure::Status { status, .. }) if matches!(status.code(), Some(2 | 3)) => Ok(()),
        other => other.map(drop),
    }
}

impl Found {
    fn text(&self) -> String {
        let missed: String = self.missed.iter().map(|line| format!("{line}\n")).collect();
        format!("{} {}\n{missed}", self.noticed, self.unviable)
    }

    fn read(text: &str) -> Option<Self> {
        let (numbers, missed) = text.split_once('\n')?;
        let (noticed, unviable) = numbers.split_once(' ')?;
        let missed = missed.lines().map(str::to_owned).collect();
        Some(Self { noticed: noticed.parse().ok()?, unviable: unviable.parse().ok()?, missed })
    }
}

/// Wilson's lower bound of a share at one-sided 95 %.
fn lower_bound(hits: usize, of: usize) -> f64 {
    const Z: f64 = 1.645;
    let (n, p) = (of as f64, hits as f64 / (of as f64).max(1.0));
    let (middle, spread) = (p + Z * Z / (2.0 * n), Z * (p * (1.0 - p) / n + Z * Z / (4.0 * n * n)).sqrt());
    if of == 0 { 0.0 } else { (middle - spread) / (1.0 + Z * Z / n) }
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_default()
}

fn file(path: &Path, reason: std::io::Error) -> Failure {
    Failure::File { path: path.display().to_string(), reason }
}

#[cfg(test)]
mod tests;
