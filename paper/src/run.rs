//! Doing many simulations on all CPUs, and telling how far it is.

use crate::trial::{Sample, Samples, System, Trial};
use rayon::prelude::*;
use red_sim::SimError;
use std::sync::Mutex;

/// An experiment could not be run.
#[derive(Debug)]
pub enum PaperError {
    /// A workload of it does not fit the executive.
    Sim(SimError),
    /// A random set of tasks does not fit the executive.
    Capacity,
    /// Somebody asked it to stop.
    Stopped,
}

impl std::fmt::Display for PaperError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Sim(error) => error.fmt(f),
            Self::Capacity => f.write_str("a set of tasks is larger than the executive's capacity"),
            Self::Stopped => f.write_str("stopped before the last table was done"),
        }
    }
}

impl std::error::Error for PaperError {}

/// How experiments are run.
pub struct Run<'a> {
    /// Seeds 1 to this are run.
    pub seeds: u64,
    /// Told now and then: parts of the present table that are done, and all parts of it.
    pub progress: &'a (dyn Fn(usize, usize) + Sync),
    /// Whether it should come to its end.
    pub is_stopped: &'a (dyn Fn() -> bool + Sync),
}

impl Run<'_> {
    /// Does something for each item, in any order; results come in the order of the items, so that they are the same
    /// whatever the number of CPUs.
    ///
    /// # Errors
    /// The first [`PaperError`].
    pub fn each<T: Sync, R: Send>(
        &self,
        items: &[T],
        work: impl Fn(&T) -> Result<R, PaperError> + Sync,
    ) -> Result<Vec<R>, PaperError> {
        let done = Mutex::new(0);
        (self.progress)(0, items.len());
        let one = |item: &T| {
            if (self.is_stopped)() {
                return Err(PaperError::Stopped);
            }
            let result = work(item);
            // Told one after the other, so that a bar never goes back.
            if let Ok(mut done) = done.lock() {
                *done += 1;
                (self.progress)(*done, items.len());
            }
            result
        };
        items.par_iter().map(one).collect()
    }

    /// Runs each trial under its system, with every seed.
    ///
    /// # Errors
    /// The first [`PaperError`].
    pub fn trials(&self, trials: &[(Trial, System)]) -> Result<Vec<Samples>, PaperError> {
        self.each(trials, |(trial, system)| {
            let samples: Result<Vec<Sample>, SimError> =
                (1..=self.seeds).map(|seed| trial.run(*system, seed)).collect();
            samples.map(Samples).map_err(PaperError::Sim)
        })
    }
}
