//! Interleaved rounds: every contestant in turn, A B C A B C ..., so that a disturbance of the machine meets all
//! of them and a ratio compares neighbours in time.

use std::thread;
use std::time::Instant;

use crate::not_run::NotRun;

/// Does its work `runs` times for each slot and stores the nanoseconds that took.
pub(crate) type Runner = Box<dyn FnMut(usize, &mut [u64]) -> Result<(), NotRun>>;

/// A runner of work that is timed here and cannot fail.
pub(crate) fn timed(mut work: impl FnMut(usize) + 'static) -> Runner {
    Box::new(move |runs, samples| {
        fill(samples, || work(runs));
        Ok(())
    })
}

/// Times `work` once per slot.
pub(crate) fn fill(samples: &mut [u64], mut work: impl FnMut()) {
    for sample in samples {
        let start = Instant::now();
        work();
        *sample = start.elapsed().as_nanos() as u64;
    }
}

/// How much is measured.
pub(crate) struct Plan {
    pub(crate) rounds: usize,
    /// Samples per contestant and round; the figure of the round is their median.
    pub(crate) samples: usize,
    /// Runs per sample.
    pub(crate) runs: usize,
    /// What one run counts as: nodes, operations, hand-offs.
    pub(crate) units: usize,
}

/// A contestant at the start line.
pub(crate) struct Entry {
    pub(crate) name: String,
    /// Whether the section's bound is about this one.
    pub(crate) ours: bool,
    pub(crate) runner: Result<Runner, NotRun>,
}

/// A contestant after the last round.
pub(crate) struct Row {
    pub(crate) name: String,
    pub(crate) ours: bool,
    /// One figure per round.
    pub(crate) rounds: Result<Vec<f64>, NotRun>,
}

/// Measures all entries in turn. The first round warms up and is not kept.
pub(crate) fn interleave(entries: Vec<Entry>, plan: &Plan) -> Vec<Row> {
    let mut samples = vec![0; plan.samples];
    let mut field: Vec<_> = entries
        .into_iter()
        .map(|entry| {
            let figures = entry.runner.as_ref().map(|_| Vec::new()).map_err(Clone::clone);
            (Row { name: entry.name, ours: entry.ours, rounds: figures }, entry.runner.ok())
        })
        .collect();
    for round in 0..=plan.rounds {
        let start = Instant::now();
        for (row, runner) in &mut field {
            let (Some(runner), Ok(figures)) = (runner, &mut row.rounds) else { continue };
            match runner(plan.runs, &mut samples) {
                Ok(()) if round == 0 => {}
                Ok(()) => figures.push(middle(&mut samples) as f64 / (plan.runs * plan.units) as f64),
                Err(reason) => row.rounds = Err(reason),
            }
        }
        // Leaves the CPUs to others for a tenth of the time: well below the kernel's throttling of real-time
        // threads, which would otherwise show as an outlier of 50 ms.
        thread::sleep(start.elapsed() / 10);
    }
    field.into_iter().map(|(row, _)| row).collect()
}

fn middle(samples: &mut [u64]) -> u64 {
    samples.sort_unstable();
    samples.get(samples.len() / 2).copied().unwrap_or(0)
}

/// Median; of an even number, the upper one. `None` without figures.
pub(crate) fn median(mut figures: Vec<f64>) -> Option<f64> {
    figures.sort_by(f64::total_cmp);
    figures.get(figures.len() / 2).copied()
}

/// Median over the rounds of `row / reference`, each round divided by its own.
pub(crate) fn ratio(row: &Row, reference: &Row) -> Option<f64> {
    compare(row, reference, |figure, base| figure / base)
}

/// Median over the rounds of `row - reference`, each round less its own.
pub(crate) fn difference(row: &Row, reference: &Row) -> Option<f64> {
    compare(row, reference, |figure, base| figure - base)
}

fn compare(row: &Row, reference: &Row, how: impl Fn(f64, f64) -> f64) -> Option<f64> {
    let (Ok(row), Ok(reference)) = (&row.rounds, &reference.rounds) else { return None };
    median(row.iter().zip(reference).map(|(figure, base)| how(*figure, *base)).collect())
}

#[cfg(test)]
mod tests;
