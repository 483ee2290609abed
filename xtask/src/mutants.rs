//! Changes of the core that its tests should notice: every k-th of what cargo-mutants can think of, from a seed on, so
//! that each file has its part.

use std::fs;
use std::path::Path;

use crate::process::Failure;
use crate::report::Tally;
use crate::tools;
use crate::workspace::Workspace;

const CARGO_MUTANTS: &str = "27.1.0";

/// The least share of mutants that has to be caught, in percent: its lower bound at 95 % confidence.
const NEEDED: f64 = 85.0;

/// What is run on each: the tests that catch most in least time.
const TESTS: &[&str] =
    &["--lib", "--test", "golden", "--test", "properties", "--test", "hopeless", "--test", "differential"];

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

/// # Errors
/// Too few are caught.
pub(crate) fn run(workspace: &Workspace, wish: &Wish) -> Result<Tally, Failure> {
    tools::built(workspace, "cargo-mutants", CARGO_MUTANTS, &["mutants", "--version"])?;
    let program = workspace.target.join("tools/bin/cargo-mutants");
    let mutants = |arguments: &[&str]| {
        workspace.command(&program).args(&["mutants", "--package", "red-core"]).args(arguments)
    };
    let count = mutants(&["--list"]).output()?.lines().count();
    let every = (count / wish.sample.max(1)).max(1);
    let shard = format!("{}/{every}", wish.seed % every as u64);
    println!("every {every}. of {count} mutants: shard {shard}");
    let results = workspace.target.join("mutants");
    let folder = results.join("mutants.out");
    if folder.exists() {
        fs::remove_dir_all(&folder).map_err(|reason| file(&folder, reason))?;
    }
    fs::create_dir_all(&results).map_err(|reason| file(&results, reason))?;
    let packages = ["--test-package", "red-core,red-tests", "--baseline", "skip", "--timeout", "120"];
    let part = ["--jobs", "1", "--shard", &shard, "--sharding", "round-robin", "--output"];
    // Fewer workloads: what eight of them do not show, eighty seldom do.
    let command =
        mutants(&packages).args(&part).args(&[&results]).args(&["--"]).args(TESTS).env("SEEDS", "8");
    let ended = command.env("CARGO_TARGET_DIR", results.join("target")).stream();
    // A mutant that is missed is a status too.
    if !folder.join("outcomes.json").exists() {
        return ended;
    }
    let count = |what: &str| read(&folder.join(format!("{what}.txt"))).lines().count();
    let (caught, missed) = (count("caught"), count("missed"));
    let (unviable, timeouts) = (count("unviable"), count("timeout"));
    let bound = 100.0 * lower_bound(caught + timeouts, caught + timeouts + missed);
    println!("{}", read(&folder.join("missed.txt")));
    println!("{caught} caught, {timeouts} never ended, {missed} missed, {unviable} do not compile");
    println!("at least {bound:.1} % are noticed, at 95 % confidence; needed are {NEEDED} %");
    if bound >= NEEDED {
        Ok(Tally::default())
    } else {
        Err(Failure::Wrong("too few mutants are noticed".to_owned()))
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
