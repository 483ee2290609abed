//! What is told of a workload in which something is wrong: how it went, where its log is, and what repeats it.

use crate::workload::Drawn;
use std::path::PathBuf;

pub(crate) struct Repeat {
    how: String,
    log: PathBuf,
    again: String,
}

impl Repeat {
    /// Of a workload whose log is kept at `log`. `words`: the arguments that repeat it.
    pub(crate) fn of(drawn: &Drawn, log: PathBuf, words: &[String]) -> Self {
        let lanes: u32 = drawn.workload.pools.iter().map(|pool| pool.lanes).sum();
        let mode = if drawn.realtime { "real time" } else { "best effort" };
        let how = format!("seed {} (policy {}, lanes: {lanes}, {mode})", drawn.seed, drawn.policy);
        Self { how, log, again: format!("cargo xtask soak {}", words.join(" ")) }
    }

    pub(crate) fn told(&self, wrong: &str) -> String {
        let Self { how, log, again } = self;
        // What is wrong may be that there is none.
        let replay = log.exists().then(|| format!("\nits log: redrt replay {}", log.display()));
        format!("{how}: {wrong}{}\nagain: {again}", replay.unwrap_or_default())
    }
}
