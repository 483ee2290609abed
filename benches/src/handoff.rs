//! One hand-off from lane to lane: half of a round trip between two pinned threads.

use std::hint;
use std::sync::Arc;

use crate::companion::Companion;
use crate::line::Line;
use crate::machine::Machine;
use crate::measure::{Entry, Runner, fill};
use crate::not_run::NotRun;
use crate::ours;

/// A way to hand over. A run is one round trip: two hand-offs.
#[derive(Clone, Copy)]
pub(crate) struct Contestant {
    pub(crate) name: &'static str,
    pub(crate) ours: bool,
    pub(crate) build: fn(&'static Machine) -> Result<Runner, NotRun>,
}

impl Contestant {
    /// This contestant at the start line.
    pub(crate) fn enter(&self, machine: &'static Machine) -> Entry {
        Entry { name: self.name.to_owned(), ours: self.ours, runner: (self.build)(machine) }
    }
}

/// The reference: nothing but a flag.
pub(crate) const BARE_FLAG: &str = "bare flag";

/// Ways to hand over that are measured.
pub(crate) const CONTESTANTS: &[Contestant] = &[
    Contestant { name: BARE_FLAG, ours: false, build: bare_flag },
    Contestant { name: "RED, complete and poll", ours: true, build: ours::hand_off },
];

/// One line per direction.
#[derive(Default)]
struct Lines {
    there: Line,
    back: Line,
}

fn bare_flag(machine: &'static Machine) -> Result<Runner, NotRun> {
    let lines = Arc::new(Lines::default());
    let companion = Companion::spawn(machine, {
        let (lines, mut seen) = (Arc::clone(&lines), 0);
        move || {
            if let Some(turn) = lines.there.news(&mut seen) {
                lines.back.store(turn);
            }
            hint::spin_loop();
        }
    })?;
    let (mut turn, mut seen) = (0, 0);
    Ok(Box::new(move |runs, samples| {
        let mut answered = true;
        companion.beside(|| {
            fill(samples, || {
                for _ in 0..runs {
                    if answered {
                        turn += 1;
                        lines.there.store(turn);
                        answered = lines.back.wait(&mut seen).is_some();
                    }
                }
            });
        })?;
        if answered { Ok(()) } else { Err(NotRun::lane_gone()) }
    }))
}
