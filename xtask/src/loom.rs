//! Runs the models of `loom-tests`, each in a process of its own, and says how far each was explored.

use std::process::ExitCode;
use std::sync::Mutex;
use std::thread;

use crate::depth::Depth;
use crate::process::{Failure, Run};
use crate::report::Tally;
use crate::workspace::Workspace;

/// A model's own last word, which ends its process with success.
const EXPLORED: &str = "explored";
/// How the line of a model begins: see `loom-tests/src/model.rs`.
const LINE: &str = "model ";
/// All models together explore at least so much.
const EXECUTIONS: u64 = 100_000;

/// What is asked of `cargo xtask loom`.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Wish<'a> {
    pub(crate) mutants: bool,
    /// Three preemptions instead of two.
    pub(crate) deep: bool,
    /// Of models or, for mutants, of files; all where there is none.
    pub(crate) names: Vec<&'a str>,
}

impl<'a> Wish<'a> {
    /// # Errors
    /// What is not known, or does not go together.
    pub(crate) fn of(words: &[&'a str]) -> Result<Self, String> {
        let (depth, words) = Depth::of(words);
        let (flags, names): (Vec<&str>, Vec<&str>) = words.iter().partition(|word| word.starts_with('-'));
        if let Some(unknown) = flags.iter().find(|flag| **flag != "--mutants") {
            return Err(format!("loom knows --deep and --mutants, not {unknown}"));
        }
        let (mutants, deep) = (!flags.is_empty(), depth == Depth::Deep);
        if mutants && deep {
            return Err("loom: --mutants is never deep; leave --deep out".to_owned());
        }
        Ok(Self { mutants, deep, names })
    }
}

/// What is run.
pub(crate) struct Models<'a> {
    pub(crate) workspace: &'a Workspace,
    /// Where `loom-tests` lies: in this workspace, or in a copy of it.
    pub(crate) root: &'a std::path::Path,
    /// Three preemptions instead of two.
    pub(crate) deep: bool,
    /// After so long a model is not explored; `None`: as `loom-tests` has it.
    pub(crate) seconds: Option<u32>,
}

/// A test of a model: one that explores, or one with a planted fault, which the checker has to catch.
#[derive(Clone, Debug)]
pub(crate) struct Model {
    pub(crate) binary: String,
    pub(crate) family: String,
    pub(crate) name: String,
}

impl Model {
    /// Whether it has a planted fault, by its name.
    pub(crate) fn is_planted(&self) -> bool {
        self.name.ends_with("_is_caught")
    }
}

/// How it went.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    Explored,
    Caught,
    NotExplored,
    Failed,
}

/// A row of the table.
#[derive(Debug)]
pub(crate) struct Row {
    pub(crate) model: Model,
    pub(crate) verdict: Verdict,
    /// Threads, bound, executions, seconds, and how it ended, in the model's words.
    words: Vec<String>,
    pub(crate) output: String,
}

impl Row {
    /// Reads what a model printed.
    pub(crate) fn read(model: &Model, output: String, succeeded: bool) -> Self {
        let line = output.lines().rev().find_map(|line| line.strip_prefix(LINE));
        let words: Vec<String> = line
            .and_then(|line| line.split_once(": "))
            .map(|(_, words)| words.split(", ").map(str::to_owned).collect())
            .unwrap_or_default();
        let ran = output.contains("test result: ok. 1 passed");
        let verdict = match words.last() {
            // Also where the test expected a panic: this one is not that of the planted fault.
            Some(word) if word.starts_with("NOT EXPLORED") => Verdict::NotExplored,
            Some(word) if succeeded && ran && word == EXPLORED => Verdict::Explored,
            // No line: the planted fault ended the model, and the test expected that.
            None if succeeded && ran && model.is_planted() => Verdict::Caught,
            _ => Verdict::Failed,
        };
        Self { model: model.clone(), verdict, words, output }
    }

    pub(crate) fn name(&self) -> String {
        format!("{}: {}", self.model.family, self.model.name)
    }

    fn seconds(&self) -> &str {
        self.words.get(3).map_or("", |word| word.trim_end_matches(" s"))
    }

    /// Tenths of a second that it took.
    pub(crate) fn tenths(&self) -> u64 {
        self.seconds().replace('.', "").parse().unwrap_or(0)
    }

    fn executions(&self) -> u64 {
        self.words.get(2).and_then(|word| word.split(' ').next()?.parse().ok()).unwrap_or(0)
    }

    fn line(&self) -> String {
        let word = |i: usize| self.words.get(i).map_or("", |word| word.split(' ').next_back().unwrap_or(""));
        let (threads, bound) =
            (self.words.first().map_or("", |w| w.split(' ').next().unwrap_or("")), word(1));
        let seconds = self.seconds();
        let verdict = match self.verdict {
            Verdict::Explored => EXPLORED.to_owned(),
            Verdict::Caught => "caught".to_owned(),
            Verdict::NotExplored => self.words.last().cloned().unwrap_or_default(),
            Verdict::Failed => "FAILED".to_owned(),
        };
        let executions = Some(self.executions()).filter(|n| *n > 0).map_or(String::new(), |n| n.to_string());
        format!("{:<66} {threads:>7} {bound:>5} {executions:>10} {seconds:>7}  {verdict}", self.name())
    }
}

/// The step of `cargo xtask test`: lints of what the checker builds, and all models.
pub(crate) fn step(workspace: &Workspace, depth: Depth) -> Result<Tally, Failure> {
    let lints = ["clippy", "--package", "red-loom-tests", "--all-targets", "--profile", "loom", "--"];
    let models = Models { workspace, root: &workspace.root, deep: depth == Depth::Deep, seconds: None };
    models.cargo(&lints).args(&["--deny", "warnings"]).stream()?;
    let rows = models.run(&models.build(&[])?);
    let explored: u64 = tell(&rows);
    let failed = rows.iter().filter(|row| !row.verdict.is_good()).count();
    if explored < EXECUTIONS {
        return Err(Failure::Wrong(format!("{explored} executions in all; {EXECUTIONS} are wanted")));
    }
    Ok(Tally { passed: (rows.len() - failed) as u32, failed: failed as u32, ignored: 0 })
}

/// `cargo xtask loom [--deep] [MODEL]...`
pub(crate) fn run(workspace: &Workspace, deep: bool, names: &[&str]) -> Result<ExitCode, Failure> {
    let models = Models { workspace, root: &workspace.root, deep, seconds: None };
    let all = models.build(&[])?;
    let is_meant = |model: &Model, name: &str| model.family == name || model.name.contains(name);
    if let Some(unknown) = names.iter().find(|name| !all.iter().any(|model| is_meant(model, name))) {
        let mut known: Vec<&str> = all.iter().map(|model| &*model.family).collect();
        known.dedup();
        let known = known.join(", ");
        return Err(Failure::Wrong(format!(
            "no model {unknown:?}; there are those of {known}, and each by a part of its name"
        )));
    }
    let is_chosen = |model: &Model| names.is_empty() || names.iter().any(|name| is_meant(model, name));
    let chosen: Vec<Model> = all.into_iter().filter(is_chosen).collect();
    let rows = models.run(&chosen);
    tell(&rows);
    let is_good = rows.iter().all(|row| row.verdict.is_good());
    Ok(if is_good { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

impl Verdict {
    pub(crate) fn is_good(self) -> bool {
        matches!(self, Self::Explored | Self::Caught)
    }
}

impl Models<'_> {
    /// Cargo with the checker's flags, and a folder of its own for what it builds: the flags would have everything
    /// built anew, and then again.
    fn cargo(&self, arguments: &[&str]) -> Run {
        let cargo = self.workspace.cargo(arguments).at(self.root);
        cargo.env("RUSTFLAGS", "--cfg loom").env("CARGO_TARGET_DIR", self.workspace.target.join("loom"))
    }

    /// Builds the models of these families, all where none is named, and lists them.
    ///
    /// # Errors
    /// They do not build.
    pub(crate) fn build(&self, families: &[String]) -> Result<Vec<Model>, Failure> {
        let arguments = ["test", "--package", "red-loom-tests", "--profile", "loom", "--no-run"];
        let only: Vec<String> = families.iter().flat_map(|name| ["--test".into(), name.clone()]).collect();
        let built = self.cargo(&arguments).args(&only).text()?;
        let mut models = Vec::new();
        for line in built.lines() {
            // `Executable tests/bell.rs (…/bell-0123456789abcdef)`
            let Some((_, rest)) = line.split_once("Executable tests/") else { continue };
            let Some((family, binary)) = rest.split_once(".rs (") else { continue };
            let binary = binary.trim_end_matches(')');
            let list = self.workspace.command(binary).args(&["--list", "--format", "terse"]).output()?;
            let names = list.lines().filter_map(|line| line.strip_suffix(": test"));
            models.extend(names.map(|name| Model {
                binary: binary.into(),
                family: family.into(),
                name: name.into(),
            }));
        }
        Ok(models)
    }

    /// Runs models, as many at a time as there are CPUs. Rows come in the order of `models`.
    pub(crate) fn run(&self, models: &[Model]) -> Vec<Row> {
        let next = Mutex::new(models.iter().enumerate());
        let rows = Mutex::new(Vec::new());
        let threads = thread::available_parallelism().map_or(1, usize::from);
        let work = || {
            while let Some((number, model)) = next.lock().ok().and_then(|mut next| next.next()) {
                let row = self.run_one(model);
                say!("{}", row.line());
                if let Ok(mut rows) = rows.lock() {
                    rows.push((number, row));
                }
            }
        };
        thread::scope(|scope| (0..threads).for_each(|_| drop(scope.spawn(work))));
        let mut rows = rows.into_inner().unwrap_or_default();
        rows.sort_by_key(|(number, _)| *number);
        rows.into_iter().map(|(_, row)| row).collect()
    }

    pub(crate) fn run_one(&self, model: &Model) -> Row {
        let run = self.workspace.command(&model.binary).args(&["--exact", &model.name, "--nocapture"]);
        let run = if self.deep { run.env("RED_LOOM_PREEMPTIONS", "3") } else { run };
        let run = self.seconds.iter().fold(run, |run, limit| run.env("RED_LOOM_SECONDS", limit.to_string()));
        match run.all_text() {
            Ok((output, succeeded)) => Row::read(model, output, succeeded),
            Err(failure) => Row::read(model, failure.to_string(), false),
        }
    }
}

/// Prints the table. Executions in all.
fn tell(rows: &[Row]) -> u64 {
    say!("\n{:<66} {:>7} {:>5} {:>10} {:>7}  verdict", "model", "threads", "bound", "executions", "seconds");
    rows.iter().for_each(|row| say!("{}", row.line()));
    for row in rows.iter().filter(|row| row.verdict == Verdict::Failed) {
        let why: Vec<&str> = row.output.lines().filter(|line| !line.starts_with("   ")).collect();
        say!("\n{}\n{}", row.name(), why.join("\n"));
    }
    let executions = rows.iter().filter(|row| row.verdict == Verdict::Explored).map(Row::executions).sum();
    let count = |verdict| rows.iter().filter(|row| row.verdict == verdict).count();
    say!(
        "\n{} explored, {} planted faults caught, {} not explored, {} failed; {executions} executions",
        count(Verdict::Explored),
        count(Verdict::Caught),
        count(Verdict::NotExplored),
        count(Verdict::Failed)
    );
    executions
}

#[cfg(test)]
mod tests;
