//! Instructions per node, counted by callgrind: this executable runs a contestant under valgrind for two numbers
//! of runs, and the difference leaves out everything that happens once.

use std::env;
use std::io;
use std::process::Command;

use crate::graphs::{Body, Graph};
use crate::machine::Machine;
use crate::not_run::NotRun;
use crate::peers::{ONE_LANE, Setup, THROUGH_ABI};

/// First argument of the mode in which this executable is what callgrind counts.
pub(crate) const MODE: &str = "count";

/// The counted program: `contestant graph runs`.
///
/// # Errors
///
/// What is wrong with the arguments, or why the contestant did not run.
pub(crate) fn run(arguments: &[String]) -> Result<(), String> {
    let [name, graph, runs] = arguments else { return Err("expected: contestant graph runs".to_owned()) };
    let contestant = ONE_LANE.iter().chain(THROUGH_ABI).find(|contestant| contestant.name == name);
    let contestant = contestant.ok_or_else(|| format!("no contestant {name:?}"))?;
    let graph = Graph::named(graph).ok_or_else(|| format!("no graph {graph:?}"))?;
    let runs = runs.parse().map_err(|error| format!("runs {runs:?}: {error}"))?;
    let machine = Box::leak(Box::new(Machine::best_effort().map_err(|error| error.to_string())?));
    let setup = Setup { graph: &graph, lanes: 1, body: Body::EMPTY, machine };
    (contestant.build)(&setup).and_then(|mut runner| runner(runs, &mut [0])).map_err(|why| why.to_string())
}

/// Instructions per node of the contestant of that name: from `runs` runs to three times as many.
///
/// # Errors
///
/// valgrind is missing, or the counted program failed.
pub(crate) fn instructions(name: &str, graph: &Graph, runs: usize) -> Result<f64, NotRun> {
    let few = collect(name, graph, runs)?;
    let many = collect(name, graph, 3 * runs)?;
    let counted =
        many.checked_sub(few).ok_or_else(|| NotRun::Failed("fewer instructions for more runs".to_owned()))?;
    Ok(counted as f64 / (2 * runs * graph.nodes()) as f64)
}

fn collect(name: &str, graph: &Graph, runs: usize) -> Result<u64, NotRun> {
    let failed = |error: io::Error| NotRun::Failed(format!("callgrind: {error}"));
    let output = Command::new("valgrind")
        // Children, because the C++ contestants run in one.
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null", "--trace-children=yes"])
        .arg(env::current_exe().map_err(failed)?)
        .args([MODE, name, graph.name, &runs.to_string()])
        .output()
        .map_err(|error| match error.kind() {
            io::ErrorKind::NotFound => NotRun::Missing("valgrind"),
            _ => failed(error),
        })?;
    let said = String::from_utf8_lossy(&output.stderr);
    let count = collected(&said).filter(|_| output.status.success());
    count.ok_or_else(|| NotRun::Failed(format!("callgrind: {}", said.lines().last().unwrap_or("no output"))))
}

/// The sum of callgrind's `Collected` lines, one per process; `None` without any.
fn collected(text: &str) -> Option<u64> {
    let counts = text.lines().filter_map(|line| line.split_once("Collected :")?.1.trim().parse::<u64>().ok());
    counts.reduce(u64::saturating_add)
}

#[cfg(test)]
mod tests;
