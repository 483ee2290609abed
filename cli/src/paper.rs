//! `redrt paper`: the paper's experiments, our numbers beside the paper's.

mod page;
pub(crate) mod real;

use crate::options;
use crate::outcome::{Answer, Failure};
use crate::output;
use crate::place::{self, Folder, Force, Place, Places};
use crate::table::Table as Text;
use crate::terminal;
use red_paper::table::{Claim, Table, Verdict};
use red_paper::{EXPERIMENTS, Experiment, Group, PaperError, Run, SEEDS, markdown};
use red_rt::stop::StopSignals;
use red_workload::shown_path;
use serde::Serialize;
use std::io;
use std::path::{Path, PathBuf};

/// Name of all tables that are not the paper's.
const SCOREBOARD: &str = "scoreboard";

/// Asks for the names of all tables.
const LIST: &str = "list";

/// Runs the paper's experiments in virtual time, and prints our numbers beside the paper's.
#[derive(clap::Args)]
#[command(after_help = "\
Each table has the paper's values, ours as means over seeds with 95 % confidence intervals, and verdicts: reproduced
(direction and size), shape only (direction), not reproducible (with the reason), calibrated (what the model was fitted
to, no evidence); ours (nothing to compare with), holds and fails (what this project promises), not kept (a promise of
overload, with what was measured), loses (where a rule of ours is worse than another). Same arguments, same output, to
the byte. Exit status 1 if it was stopped, or if a claim fails.

Example:
  redrt paper effectiveness --json")]
pub(crate) struct Args {
    /// Table, or `scoreboard` for those that are not the paper's, or `real` for runs on this machine; all but `real` unless
    /// told. `list` names them.
    #[arg(value_name = "TABLE")]
    table: Option<String>,
    /// How many seeds to run, from 2 on.
    #[arg(long, value_name = "N", default_value_t = SEEDS, value_parser = clap::value_parser!(u64).range(2..=10_000))]
    seeds: u64,
    /// Time of each of the 125 runs of `real`.
    #[arg(long, value_name = "TIME", default_value = "2500ms", allow_hyphen_values = true, value_parser = options::duration_ns)]
    duration: u64,
    /// Folder for the workloads and networks of `real`; they are written anew each time where the folder is not told, and
    /// under `--force`.
    #[arg(long, value_name = "FOLDER", default_value = place::OWN)]
    out: PathBuf,
    /// Write the tables as one HTML page, with bars; without a TABLE they go to redrt-paper.html unless told, but with
    /// `--json` or `--markdown` only where told.
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
    /// Print Markdown.
    #[arg(long, conflicts_with = "json")]
    markdown: bool,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// Where a run of all tables leaves its page.
const PAGE: &str = "redrt-paper.html";

#[derive(Serialize)]
struct Tables<'a> {
    /// `None` of runs on this machine, which have rounds.
    #[serde(skip_serializing_if = "Option::is_none")]
    seeds: Option<u64>,
    tables: &'a [Table],
}

impl<'a> Tables<'a> {
    fn of(tables: &'a [Table], seeds: u64) -> Self {
        let is_real = tables.iter().any(|table| table.name == real::NAME);
        Self { seeds: (!is_real).then_some(seeds), tables }
    }
}

/// Runs the experiments and prints their tables.
pub(crate) fn main(args: &Args) -> Result<Answer, Failure> {
    if args.table.as_deref() == Some(LIST) {
        if args.json {
            output::json(&Names { tables: names() })?;
        } else {
            output::line(&list())?;
        }
        return Ok(Answer::Yes);
    }
    let signals = StopSignals::install().map_err(|e| Failure::Machine(e.to_string()))?;
    if args.table.as_deref() == Some(real::NAME) {
        let mut folder = Folder::open(&args.out, &args.force)?;
        let files = real::Files::of(&mut folder)?;
        let page = page_in(args, &mut folder.places)?;
        let (table, left) = real::run(&args.out, &files, args.duration, &signals)?;
        let tables: Vec<Table> = table.into_iter().collect();
        tables.iter().try_for_each(|table| tell(args, table))?;
        return print(args, &tables, left.as_deref(), page.as_ref());
    }
    let chosen = choose(args.table.as_deref())?;
    let page = page_in(args, &mut Places::new(&args.force, Failure::Machine))?;
    let is_stopped = || signals.requested().is_some();
    let mut tables = Vec::new();
    for (nth, experiment) in chosen.iter().enumerate() {
        let bar = Bar { name: experiment.name, nth, of: chosen.len() };
        let progress = |done, all| bar.show(done, all);
        let run = Run { seeds: args.seeds, progress: &progress, is_stopped: &is_stopped };
        let table = (experiment.run)(&run);
        bar.clear();
        match table {
            Ok(table) => {
                tell(args, &table)?;
                tables.push(table);
            }
            Err(PaperError::Stopped) => break,
            Err(error) => return Err(Failure::input(error)),
        }
    }
    let left = (tables.len() < chosen.len())
        .then(|| format!("stopped after {} of {} tables", tables.len(), chosen.len()));
    print(args, &tables, left.as_deref(), page.as_ref())
}

/// The place of the page, if one is made: where it was asked for, or of all tables for people.
fn page_in(args: &Args, places: &mut Places) -> Result<Option<Place>, Failure> {
    let all = args.table.is_none() && !args.json && !args.markdown;
    let path = args.report.as_deref().or(all.then_some(Path::new(PAGE)));
    path.map(|path| places.add("page", "--report", path)).transpose()
}

/// A table for people, as soon as it is there.
fn tell(args: &Args, table: &Table) -> Result<(), Failure> {
    if args.json || args.markdown { Ok(()) } else { output::line(&format!("{}\n\n", text(table))) }
}

/// What waits for all tables: JSON, Markdown, the page. `left`: what was not done.
fn print(args: &Args, tables: &[Table], left: Option<&str>, page: Option<&Place>) -> Result<Answer, Failure> {
    if args.json {
        output::json(&Tables::of(tables, args.seeds))?;
    } else if args.markdown {
        output::line(&markdown::document(tables, args.seeds))?;
    }
    // A page that was not asked for is one of all tables.
    if let Some(place) = page.filter(|_| args.report.is_some() || left.is_none()) {
        place.write_text(&page::of(tables, args.seeds, left)?)?;
        output::note(&format!("report: {}", shown_path(place.path())));
    }
    let is_kept = tables.iter().flat_map(|table| &table.claims).all(|claim| claim.verdict != Verdict::Fails);
    if !is_kept {
        output::note("a claim of this project fails");
    }
    if let Some(left) = left {
        output::note(left);
    }
    Ok(Answer::of(left.is_none() && is_kept))
}

/// A table that can be asked for.
#[derive(Serialize)]
struct Name {
    name: &'static str,
    what: &'static str,
}

#[derive(Serialize)]
struct Names {
    tables: Vec<Name>,
}

fn names() -> Vec<Name> {
    let name = |experiment: &Experiment| Name { name: experiment.name, what: experiment.what };
    let on_machine = [
        Name { name: SCOREBOARD, what: "all of those that are not the paper's" },
        Name { name: real::NAME, what: "the scenarios with real networks on this machine, about 6 minutes" },
    ];
    EXPERIMENTS.iter().map(name).chain(on_machine).collect()
}

fn list() -> String {
    let names = names();
    let width = names.iter().map(|Name { name, .. }| name.len()).max().unwrap_or(0);
    let line = |Name { name, what }: &Name| format!("  {name:<width$}  {what}");
    names.iter().map(line).collect::<Vec<_>>().join("\n")
}

fn choose(name: Option<&str>) -> Result<Vec<Experiment>, Failure> {
    let Some(name) = name else { return Ok(EXPERIMENTS.to_vec()) };
    let is_meant = |experiment: &&Experiment| match name {
        SCOREBOARD => experiment.group == Group::Scoreboard,
        _ => experiment.name == name,
    };
    let found: Vec<Experiment> = EXPERIMENTS.iter().filter(is_meant).copied().collect();
    (!found.is_empty()).then_some(found).ok_or_else(|| {
        let names: Vec<&str> = names().iter().map(|name| name.name).chain([LIST]).collect();
        Failure::Input(format!(
            "no table `{}`; expected one of {}",
            red_workload::shown(name),
            names.join(", ")
        ))
    })
}

fn text(table: &Table) -> String {
    let mut out = vec![format!("{} ({}; redrt paper {})", table.title, table.source, table.name)];
    out.extend(table.about.iter().map(|paragraph| terminal::wrap(paragraph, 0)));
    let heads: Vec<String> = table.columns.iter().map(markdown::head).collect();
    let mut rows = Text::new(&heads.iter().map(String::as_str).collect::<Vec<_>>());
    for row in &table.rows {
        rows.row(row.iter().zip(&table.columns).map(|(cell, column)| markdown::cell(cell, column)));
    }
    out.push(rows.to_string());
    if !table.claims.is_empty() {
        let mut claims = Text::new(&["claim", "paper", "here", "verdict"]);
        for Claim { claim, paper, ours, verdict, .. } in &table.claims {
            claims.row([claim.clone(), paper.clone(), ours.clone(), verdict.words().to_owned()]);
        }
        out.push(claims.to_string());
        let mut reasons: Vec<&str> =
            table.claims.iter().map(|claim| claim.why).filter(|why| !why.is_empty()).collect();
        reasons.dedup();
        let reasons: Vec<String> =
            reasons.iter().map(|why| terminal::wrap(&format!("why: {why}"), 5)).collect();
        out.extend((!reasons.is_empty()).then(|| reasons.join("\n")));
    }
    out.join("\n\n")
}

/// How far it is, on a terminal.
struct Bar<'a> {
    name: &'a str,
    nth: usize,
    of: usize,
}

impl Bar<'_> {
    const WIDTH: usize = 30;

    fn show(&self, done: usize, all: usize) {
        if terminal::moves(&io::stderr()) {
            let full = (done * Self::WIDTH).checked_div(all).unwrap_or(0);
            let bar: String = (0..Self::WIDTH).map(|i| if i < full { '#' } else { '.' }).collect();
            let Self { name, nth, of } = self;
            terminal::tell(&format!("\r\x1b[Ktable {} of {of}, {name} [{bar}] {done} of {all}", nth + 1));
        }
    }

    fn clear(&self) {
        if terminal::moves(&io::stderr()) {
            terminal::tell("\r\x1b[K");
        }
    }
}
