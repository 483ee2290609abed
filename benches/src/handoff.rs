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
    Contestant { name: "RED", ours: true, build: ours::hand_off },
];

/// One flag per direction.
#[derive(Default)]
struct Flags {
    there: Line,
    back: Line,
}

impl Flags {
    fn round_trip(&self, turn: u64) -> Option<()> {
        self.there.store(turn);
        self.back.spin(|line| (line.load() == turn).then_some(()))
    }

    fn answer(&self) {
        let turn = self.there.load();
        if turn != self.back.load() {
            self.back.store(turn);
        }
        hint::spin_loop();
    }
}

fn bare_flag(machine: &'static Machine) -> Result<Runner, NotRun> {
    let flags = Arc::new(Flags::default());
    let companion = Companion::spawn(machine, {
        let flags = Arc::clone(&flags);
        move || flags.answer()
    })?;
    let mut turn = 0;
    Ok(Box::new(move |runs, samples| {
        let mut answered = Some(());
        companion.beside(|| {
            fill(samples, || {
                for _ in 0..runs {
                    turn += 1;
                    answered = answered.and_then(|()| flags.round_trip(turn));
                }
            });
        })?;
        answered.ok_or_else(NotRun::lane_gone)
    }))
}
