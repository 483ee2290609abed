//! One hand-off from lane to lane, between two pinned threads that pass a word, or a unit, back and forth.

use std::hint;
use std::sync::Arc;

use red_core::UnitId;
use red_rt::bell::Woken;
use red_rt::clock::now_ns;
use red_rt::handler::Work;
use red_rt::seat::Seat;
use red_rt::sleeper::Sleeper;

use crate::companion::Companion;
use crate::line::Line;
use crate::machine::Machine;
use crate::measure::{Entry, Runner, fill};
use crate::not_run::NotRun;
use crate::ours;

/// Hand-offs of one run: there and back, half of them each.
pub(crate) const HOPS: usize = 64;

/// A way to hand over. A run is [`HOPS`] hand-offs.
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

/// Ways to hand over that are measured. The last one contains what two lanes do besides: the lock, the completion
/// and the choice of the next unit.
pub(crate) const CONTESTANTS: &[Contestant] = &[
    Contestant { name: BARE_FLAG, ours: false, build: bare_flag },
    Contestant { name: "RED, a lane's seat", ours: true, build: seat },
    Contestant { name: "RED, with lock and scheduling", ours: false, build: ours::hand_off },
];

/// Longest wait of a lane that answers. It spins, as lanes between two units do, and then sleeps.
const SPIN_NS: u64 = 30_000;
const ANSWER_NS: u64 = 100_000;
/// Longest wait for the answer.
const GONE_NS: u64 = 1_000_000_000;

/// `step` on lane 1 answers what `round_trip` sends and waits for on this one. It tells whether an answer came.
fn back_and_forth(
    machine: &'static Machine,
    step: impl FnMut() + Send + 'static,
    mut round_trip: impl FnMut() -> bool + 'static,
) -> Result<Runner, NotRun> {
    let companion = Companion::spawn(machine, step)?;
    let mut answered = true;
    Ok(Box::new(move |runs, samples| {
        companion.beside(|| {
            fill(samples, || {
                for _ in 0..runs * HOPS / 2 {
                    answered = answered && round_trip();
                }
            });
        })?;
        if answered { Ok(()) } else { Err(NotRun::lane_gone()) }
    }))
}

/// One line per direction.
#[derive(Default)]
struct Lines {
    there: Line,
    back: Line,
}

fn bare_flag(machine: &'static Machine) -> Result<Runner, NotRun> {
    let lines = Arc::new(Lines::default());
    let step = {
        let (lines, mut seen) = (Arc::clone(&lines), 0);
        move || {
            if let Some(turn) = lines.there.news(&mut seen) {
                lines.back.store(turn);
            }
            hint::spin_loop();
        }
    };
    let (mut turn, mut seen) = (0, 0);
    back_and_forth(machine, step, move || {
        turn += 1;
        lines.there.store(turn);
        lines.back.wait(&mut seen).is_some()
    })
}

/// A seat per lane, waited at as the lanes of the runtime do: with a time, after which they would look around.
#[derive(Default)]
struct Seats {
    there: Seat,
    back: Seat,
}

fn seat(machine: &'static Machine) -> Result<Runner, NotRun> {
    let seats = Arc::new(Seats::default());
    let step = {
        let (seats, mut sleeper) = (Arc::clone(&seats), Sleeper::spinning());
        move || {
            if let Some(work) = await_unit(&seats.there, &mut sleeper, ANSWER_NS) {
                seats.back.hand(&work);
            }
        }
    };
    let (mut turn, mut sleeper) = (0, Sleeper::spinning());
    back_and_forth(machine, step, move || {
        turn += 1;
        seats.there.hand(&Work { unit: UnitId::from_bits(turn), ..Work::default() });
        await_unit(&seats.back, &mut sleeper, GONE_NS).is_some()
    })
}

/// What comes within `patience_ns`.
fn await_unit(seat: &Seat, sleeper: &mut Sleeper, patience_ns: u64) -> Option<Work> {
    let until = Some(now_ns() + patience_ns);
    loop {
        if let Some(handed) = seat.take() {
            return Some(handed);
        }
        if seat.sleep(sleeper, until, SPIN_NS) == Woken::TimedOut {
            return None;
        }
    }
}
