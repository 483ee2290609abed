//! Changes of the core that its tests should notice: a sample of what cargo-mutants can think of, in parts of which each
//! goes through all files. What a part gave is kept, so that a run that was stopped goes on.

use std::collections::hash_map::DefaultHasher;
use std::fs;
use std::hash::{Hash, Hasher};
use std::path::{Path, PathBuf};
use std::time::Instant;

use crate::copy;
use crate::process::{Failure, Run};
use crate::report::Tally;
use crate::tools;
use crate::workspace::{Workspace, entries};

const CARGO_MUTANTS: &str = "27.1.0";

/// The least share of mutants that has to be caught, in percent: its lower bound at 95 % confidence.
const NEEDED: f64 = 85.0;

/// Mutants of one part.
const PART: usize = 40;

/// Which tests are run, and how.
struct Stage {
    targets: &'static [&'static str],
    skipped: &'static [&'static str],
    environment: &'static [(&'static str, &'static str)],
}

/// What catches most in least time: few cases, and no optimization, since most of the time goes into the build. Left
/// out are tests of the tests' own tools, and those that cost most beside `differential`, which sees the same.
const QUICK: Stage = Stage {
    targets: &["--lib", "--test=suite", "--test=differential"],
    skipped: &[
        "oracle::",
        "check::",
        "rng::",
        "runs::",
        "equal_options_",
        "every_overload_history::",
        "every_queue_sequence::",
        "every_small_graph::",
        "layering::",
        "counterexamples::",
        "manual::",
        "papers::",
        "paper_schedulability::",
        "paper_tables::",
        "paper_worked_example::",
        "plan_json::",
        "purpose::",
        "sources::",
    ],
    // Without optimization stacks are deep.
    environment: &[
        ("SEEDS", "2"),
        ("PROPTEST_CASES", "100"),
        ("CARGO_PROFILE_TEST_OPT_LEVEL", "0"),
        ("RUST_MIN_STACK", "33554432"),
    ],
};

/// What is run on those that are left. How many lines the sources have is no behaviour.
const ALL: Stage = Stage {
    targets: &["--lib", "--tests"],
    skipped: &["no_file_is_longer_than", "the_core_is_not_longer_than"],
    environment: &[],
};

/// What is asked of `cargo xtask mutants`.
pub(crate) struct Wish {
    sample: usize,
    seed: u64,
    /// Parts of paths: only what is changed in such files. All where there is none.
    files: Vec<String>,
}

impl Wish {
    /// # Errors
    /// What is not known.
    pub(crate) fn of(words: &[&str]) -> Result<Self, String> {
        let mut wish = Self { sample: 400, seed: 1, files: Vec::new() };
        for pair in words.chunks(2) {
            let number = pair.get(1).and_then(|number| number.parse::<u64>().ok());
            let number = number.ok_or_else(|| format!("{} takes a number", pair[0]));
            match pair[0] {
                "--file" => {
                    let part = pair.get(1).ok_or("--file takes a part of a path")?;
                    wish.files.push((*part).to_owned());
                }
                "--sample" => wish.sample = number? as usize,
                "--seed" => wish.seed = number?,
                other => {
                    return Err(format!("mutants knows --sample N, --seed S and --file PART, not {other}"));
                }
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
    /// Which tests did not notice those that were missed.
    tests: u64,
    /// What was changed, of those that no test noticed.
    missed: Vec<String>,
}

/// # Errors
/// Too few are noticed.
pub(crate) fn run(workspace: &Workspace, wish: &Wish) -> Result<Tally, Failure> {
    tools::built(workspace, "cargo-mutants", CARGO_MUTANTS, &["mutants", "--version"])?;
    let mut bench = Bench::new(workspace, &wish.files)?;
    let (of, parts) = (bench.chosen.len().div_ceil(PART), wish.sample.div_ceil(PART));
    let mut all = Found::default();
    for part in 0..parts.min(of) {
        let shard = (wish.seed as usize + part * of / parts.min(of)) % of;
        let Found { noticed, unviable, missed, .. } = bench.judge(shard, of)?;
        let left = missed.len();
        say!("part {} of {parts}: {noticed} noticed, {left} not, {unviable} do not compile", part + 1);
        all.noticed += noticed;
        all.unviable += unviable;
        all.missed.extend(missed);
    }
    let missed = all.missed.len();
    let bound = 100.0 * lower_bound(all.noticed, all.noticed + missed);
    say!("\nnot noticed:\n{}\n", all.missed.join("\n"));
    say!("{} noticed, {missed} not, {} do not compile", all.noticed, all.unviable);
    say!("at least {bound:.1} % are noticed, at 95 % confidence; needed are {NEEDED} %");
    if bound >= NEEDED {
        Ok(Tally::default())
    } else {
        Err(Failure::Wrong("too few mutants are noticed".to_owned()))
    }
}

/// A copy of the workspace in which mutants are tried.
struct Bench<'a> {
    workspace: &'a Workspace,
    tree: PathBuf,
    /// Of all mutants that there are.
    names: Vec<String>,
    /// Of these, those that the sample is of.
    chosen: Vec<String>,
    /// Of the core without its tests: what is kept about another is about nothing.
    core: u64,
    tests: u64,
    /// For how long tests may run that end by themselves, in seconds; known once they passed.
    limits: Option<[u64; 2]>,
}

impl<'a> Bench<'a> {
    fn new(workspace: &'a Workspace, files: &[String]) -> Result<Self, Failure> {
        let tree = copy::of(workspace, "mutants")?;
        let is_test = |path: &Path| path.ends_with("tests.rs");
        let (mut core, mut tests) = (DefaultHasher::new(), DefaultHasher::new());
        hash_files(&tree.join("core-nostd"), &mut |path, bytes| {
            (path, bytes).hash(if is_test(path) { &mut tests } else { &mut core });
        })?;
        hash_files(&tree.join("tests"), &mut |path, bytes| (path, bytes).hash(&mut tests))?;
        let names = mutants(workspace, &tree).args(&["--list"]).output()?;
        let names: Vec<String> = names.lines().map(str::to_owned).collect();
        let path = |name: &str| name.split(':').next().unwrap_or_default().to_owned();
        let is_chosen =
            |name: &&String| files.is_empty() || files.iter().any(|file| path(name).contains(file));
        let chosen: Vec<String> = names.iter().filter(is_chosen).cloned().collect();
        if chosen.is_empty() {
            return Err(Failure::Wrong(format!("no mutant of the core is in {}", files.join(" or "))));
        }
        if !files.is_empty() {
            files.hash(&mut core);
        }
        Ok(Self { workspace, tree, names, chosen, core: core.finish(), tests: tests.finish(), limits: None })
    }

    /// One part, or what is kept of it: what was noticed is not tried again, and the rest only by other tests.
    fn judge(&mut self, shard: usize, of: usize) -> Result<Found, Failure> {
        let folder = self.workspace.target.join(format!("mutants/{:016x}/{shard}-of-{of}", self.core));
        let kept = folder.join("found.txt");
        let mut found = match Found::read(&read(&kept)) {
            Some(found) if found.tests == self.tests || found.missed.is_empty() => return Ok(found),
            Some(found) => found,
            None => {
                let missed = self.chosen.iter().skip(shard).step_by(of).cloned().collect();
                Found { missed, ..Found::default() }
            }
        };
        for stage in [&QUICK, &ALL] {
            if !found.missed.is_empty() {
                let again = self.try_on(stage, &folder, &found.missed)?;
                found.noticed += again.noticed;
                found.unviable += again.unviable;
                found.missed = again.missed;
            }
        }
        found.tests = self.tests;
        fs::write(&kept, found.text()).map_err(Failure::of_file(&kept))?;
        Ok(found)
    }

    /// Runs the tests of a stage on the mutants of these names. The tool has no choice by names that holds for all kinds,
    /// but leaves out what it is told to have tried before.
    fn try_on(&mut self, stage: &Stage, folder: &Path, wanted: &[String]) -> Result<Found, Failure> {
        let [quick, all] = self.limits()?;
        let limit = if stage.targets == QUICK.targets { quick } else { all };
        let out = folder.join("mutants.out");
        if out.exists() {
            fs::remove_dir_all(&out).map_err(Failure::of_file(&out))?;
        }
        fs::create_dir_all(&out).map_err(Failure::of_file(&out))?;
        let rest: String =
            self.names.iter().filter(|name| !wanted.contains(name)).map(|name| format!("{name}\n")).collect();
        let before = out.join("previously_caught.txt");
        fs::write(&before, rest).map_err(Failure::of_file(&before))?;

        let how =
            ["--iterate", "--in-place", "--baseline=skip", "--test-package=red-core,red-tests", "--output"];
        let run = mutants(self.workspace, &self.tree).args(&how).args(&[folder]);
        let run = run.args(&[format!("--timeout={limit}")]);
        let targets: Vec<String> =
            stage.targets.iter().map(|target| format!("--cargo-arg={target}")).collect();
        ended(stage.prepare(self.workspace, run.args(&targets).args(&["--", "--"])))?;
        let names = |what: &str| -> Vec<String> {
            read(&out.join(format!("{what}.txt"))).lines().map(str::to_owned).collect()
        };
        let [noticed, endless, unviable, missed] = ["caught", "timeout", "unviable", "missed"].map(names);
        let mut tried = [&noticed[..], &endless, &unviable, &missed].concat();
        tried.sort();
        let mut wanted = wanted.to_vec();
        wanted.sort();
        if tried != wanted {
            let (tried, wanted) = (tried.len(), wanted.len());
            return Err(Failure::Wrong(format!(
                "{tried} mutants were tried, and not the {wanted} of this part"
            )));
        }
        // One that never ends is noticed too.
        let noticed = noticed.len() + endless.len();
        Ok(Found { noticed, unviable: unviable.len(), tests: self.tests, missed })
    }

    /// The tests have to pass where nothing is changed, or they would notice everything. How long they take tells when
    /// others never end.
    fn limits(&mut self) -> Result<[u64; 2], Failure> {
        if let Some(limits) = self.limits {
            return Ok(limits);
        }
        let mut limits = [0; 2];
        for (stage, limit) in [QUICK, ALL].iter().zip(&mut limits) {
            let cargo = |more: &[&str]| {
                let test = ["test", "--quiet", "--package", "red-core", "--package", "red-tests"];
                let run = self.workspace.cargo(&test).at(&self.tree).args(stage.targets).args(more);
                stage.prepare(self.workspace, run)
            };
            cargo(&["--no-run", "--"]).stream()?;
            let begin = Instant::now();
            cargo(&["--"]).stream()?;
            *limit = 20 + 5 * begin.elapsed().as_secs();
        }
        self.limits = Some(limits);
        Ok(limits)
    }
}

impl Stage {
    /// Sets what all programs of this stage are given, whose arguments are those of the tests by now.
    fn prepare(&self, workspace: &Workspace, run: Run) -> Run {
        let skips: Vec<&str> = self.skipped.iter().flat_map(|name| ["--skip", name]).collect();
        let run = run.args(&skips).env("CARGO_TARGET_DIR", workspace.target.join("mutants/target"));
        // Nobody debugs a mutant.
        let run = run.env("CARGO_PROFILE_DEV_DEBUG", "0").env("CARGO_PROFILE_TEST_DEBUG", "0");
        self.environment.iter().fold(run, |run, (name, value)| run.env(name, value))
    }
}

/// All files below a folder, in their order, by their place in it.
fn hash_files(folder: &Path, add: &mut dyn FnMut(&Path, &[u8])) -> Result<(), Failure> {
    let mut paths = entries(folder)?;
    paths.sort();
    for path in paths {
        if path.is_dir() {
            hash_files(&path, add)?;
        } else {
            add(&path, &fs::read(&path).map_err(Failure::of_file(&path))?);
        }
    }
    Ok(())
}

/// The tool, on the core of a copy of the workspace.
fn mutants(workspace: &Workspace, tree: &Path) -> Run {
    let program = workspace.target.join("tools/bin/cargo-mutants");
    workspace.command(program).args(&["mutants", "--package", "red-core", "--dir"]).args(&[tree])
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
        format!("{} {} {}\n{missed}", self.noticed, self.unviable, self.tests)
    }

    fn read(text: &str) -> Option<Self> {
        let (numbers, missed) = text.split_once('\n')?;
        let mut numbers = numbers.split(' ');
        let missed = missed.lines().map(str::to_owned).collect();
        Some(Self {
            noticed: numbers.next()?.parse().ok()?,
            unviable: numbers.next()?.parse().ok()?,
            tests: numbers.next()?.parse().ok()?,
            missed,
        })
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

#[cfg(test)]
mod tests;
