//! The executors, ours and those that it is measured against. Each is a function from a [`Setup`] to a runner that executes
//! the graph so many times; another executor joins by adding one such function to a list of contestants.

pub(crate) mod cpp;
pub(crate) mod edf;
pub(crate) mod edf_spin;
pub(crate) mod embassy;
pub(crate) mod mutex_heap;
pub(crate) mod rayon;

use crate::graphs::{Body, Graph};
use crate::machine::Machine;
use crate::measure::{Entry, Runner, timed};
use crate::not_run::NotRun;
use crate::ours;

/// What an executor is built for.
#[derive(Clone, Copy)]
pub(crate) struct Setup<'a> {
    pub(crate) graph: &'a Graph,
    pub(crate) lanes: usize,
    pub(crate) body: Body,
    pub(crate) machine: &'static Machine,
}

/// An executor that takes part in a section.
#[derive(Clone, Copy)]
pub(crate) struct Contestant {
    pub(crate) name: &'static str,
    /// Whether the section's bound is about this one.
    pub(crate) ours: bool,
    pub(crate) build: fn(&Setup<'_>) -> Result<Runner, NotRun>,
}

impl Contestant {
    const fn peer(name: &'static str, build: fn(&Setup<'_>) -> Result<Runner, NotRun>) -> Self {
        Self { name, ours: false, build }
    }

    const fn ours(name: &'static str, build: fn(&Setup<'_>) -> Result<Runner, NotRun>) -> Self {
        Self { name, ours: true, build }
    }

    /// This contestant at the start line.
    pub(crate) fn enter(&self, setup: &Setup<'_>) -> Entry {
        let runner = setup.machine.has_lanes(setup.lanes).and_then(|()| (self.build)(setup));
        Entry { name: self.name.to_owned(), ours: self.ours, runner }
    }
}

/// The reference of the dispatch cost: embassy's executor in deadline order.
pub(crate) const EMBASSY: &str = "embassy EDF";
/// The reference of two lanes: the bodies of the best schedule, run back to back on one thread.
pub(crate) const IDEAL: &str = "ideal";

/// Executors of one lane, for the cost per node in time and in instructions. Ours comes bare, and with every
/// execution observed and every event recorded and taken.
pub(crate) const ONE_LANE: &[Contestant] = &[
    Contestant::peer(EMBASSY, embassy::build),
    Contestant::peer("40-line EDF", edf::build),
    Contestant::peer("mutex and heap", mutex_heap::build),
    Contestant::peer("oneTBB lightweight", cpp::tbb),
    Contestant::peer("Taskflow", cpp::taskflow),
    Contestant::ours("RED", ours::bare),
    Contestant::ours("RED, estimator and record", ours::observed),
];

/// Executors of two lanes.
pub(crate) const TWO_LANES: &[Contestant] = &[
    Contestant::peer(IDEAL, ideal),
    Contestant::peer("40-line EDF, spin lock", edf_spin::build),
    Contestant::peer("rayon", rayon::build),
    Contestant::peer("Taskflow", cpp::taskflow),
    Contestant::ours("RED", ours::two_lanes),
];

/// Executors whose lane is another thread than the one that releases the frame.
pub(crate) const RELEASED_FROM_OUTSIDE: &[Contestant] = &[
    Contestant::peer("mutex and heap", mutex_heap::build),
    Contestant::peer("Taskflow", cpp::taskflow),
    Contestant::ours("RED", ours::from_outside),
];

/// The reference of what recording costs.
pub(crate) const NOT_RECORDED: &str = "not recorded";

/// One lane with every input recorded, and without.
pub(crate) const RECORDED: &[Contestant] =
    &[Contestant::peer(NOT_RECORDED, ours::not_recorded), Contestant::ours("recorded", ours::recorded)];

/// The reference of what the C ABI costs.
pub(crate) const FROM_RUST: &str = "from Rust";

/// One lane, called from Rust and through the C ABI.
pub(crate) const THROUGH_ABI: &[Contestant] = &[
    Contestant::peer(FROM_RUST, ours::from_rust),
    Contestant::ours("through the C ABI", ours::through_abi),
    Contestant::ours("libred_core.so", ours::through_library),
];

fn ideal(setup: &Setup<'_>) -> Result<Runner, NotRun> {
    let (body, bodies) = (setup.body, setup.graph.makespan(setup.lanes));
    Ok(timed(move |runs| (0..runs * bodies).for_each(|node| body.run(node))))
}

#[cfg(test)]
pub(crate) mod tests;
