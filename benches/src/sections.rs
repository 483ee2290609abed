//! The sections of the bench: what is run against what, and the bound of each.

use std::time::Duration;

use red_core::{Caps, Scheduler};
use red_sync::{SharedScheduler, TicketLock};

use crate::count;
use crate::edit;
use crate::graphs::{Body, Graph};
use crate::growth;
use crate::handoff;
use crate::machine::Machine;
use crate::measure::{Plan, Row, interleave};
use crate::overload;
use crate::peers::{
    Contestant, EMBASSY, FROM_RUST, IDEAL, NOT_RECORDED, ONE_LANE, RECORDED, RELEASED_FROM_OUTSIDE, Setup,
    THROUGH_ABI, TWO_LANES,
};
use crate::queue;
use crate::table::{Must, Outcome, Table};
use crate::timer;

/// How and where to run.
pub(crate) struct Bench {
    pub(crate) machine: &'static Machine,
    /// Fewer rounds: for a look, not for a claim.
    pub(crate) quick: bool,
}

/// A section and the name by which it is asked for.
pub(crate) type Section = (&'static str, fn(&Bench) -> Outcome);

/// All sections, in the order in which they run.
pub(crate) const SECTIONS: &[Section] = &[
    ("dispatch", dispatch),
    ("instructions", instructions),
    ("lanes", lanes),
    ("record", record),
    ("abi", abi),
    ("frame", frame),
    ("handoff", handoff),
    ("timer", timer),
    ("queue", queue),
    ("state", state),
    ("growth", growth),
    ("edit", edit),
    ("overload", overload),
];

impl Bench {
    fn rounds(&self) -> usize {
        if self.quick { 11 } else { 51 }
    }
}

fn field(contestants: &[Contestant], setup: &Setup<'_>, plan: &Plan) -> Vec<Row> {
    interleave(contestants.iter().map(|contestant| contestant.enter(setup)).collect(), plan)
}

fn dispatch(bench: &Bench) -> Outcome {
    let tables = Graph::all().into_iter().map(|graph| {
        let setup = Setup { graph: &graph, lanes: 1, body: Body::EMPTY, machine: bench.machine };
        let nodes = graph.nodes();
        // Long samples, because a peer with a thread of its own pays a wake per sample, or per run.
        let plan = Plan { rounds: bench.rounds(), samples: 3, runs: 16_384 / nodes, units: nodes };
        Table {
            title: format!("dispatch {}, one lane, empty bodies", graph.name),
            unit: "ns/node",
            reference: EMBASSY,
            must: &[Must::Ratio(1.0), Must::Nothing],
            rows: field(ONE_LANE, &setup, &plan),
        }
        .print()
    });
    tables.sum()
}

fn instructions(bench: &Bench) -> Outcome {
    let runs = if bench.quick { 50 } else { 200 };
    let tables = Graph::all().into_iter().map(|graph| {
        let setup = Setup { graph: &graph, lanes: 1, body: Body::EMPTY, machine: bench.machine };
        let row = |contestant: &Contestant| {
            // Built here first: a helper that is compiled must not be compiled under callgrind.
            let built = (contestant.build)(&setup).map(drop);
            let counted = built.and_then(|()| count::instructions(contestant.name, &graph, runs));
            let rounds = counted.map(|figure| vec![figure]);
            Row { name: contestant.name.to_owned(), ours: contestant.ours, rounds }
        };
        Table {
            title: format!("instructions {}, one lane, empty bodies", graph.name),
            unit: "instructions/node",
            reference: EMBASSY,
            must: if graph.name == "layered256" { &[Must::Figure(250.0), Must::Figure(300.0)] } else { &[] },
            rows: ONE_LANE.iter().map(row).collect(),
        }
        .print()
    });
    tables.sum()
}

fn lanes(bench: &Bench) -> Outcome {
    let body = Body::calibrated(2_000);
    let tables = [("forkjoin64", 1.10), ("mimonet6", 1.12)].into_iter().filter_map(|(name, bound)| {
        let graph = Graph::named(name)?;
        let setup = Setup { graph: &graph, lanes: 2, body, machine: bench.machine };
        let nodes = graph.nodes();
        let plan = Plan { rounds: bench.rounds(), samples: 9, runs: 512 / nodes, units: nodes };
        let table = Table {
            title: format!("two lanes {name}, bodies of 2 us"),
            unit: "ns/node",
            reference: IDEAL,
            must: &[Must::RatioBelowPeers(bound)],
            rows: field(TWO_LANES, &setup, &plan),
        };
        Some(table.print())
    });
    tables.sum()
}

fn record(bench: &Bench) -> Outcome {
    let Some(graph) = Graph::named("layered256") else { return Outcome::default() };
    let body = Body::calibrated(2_000);
    let setup = Setup { graph: &graph, lanes: 1, body, machine: bench.machine };
    let plan = Plan { rounds: bench.rounds(), samples: 9, runs: 2, units: graph.nodes() };
    Table {
        title: "every input recorded, layered256, one lane, bodies of 2 us".to_owned(),
        unit: "ns/node",
        reference: NOT_RECORDED,
        must: &[Must::Over { ratio: 1.01, figure: 8.0 }],
        rows: field(RECORDED, &setup, &plan),
    }
    .print()
}

fn abi(bench: &Bench) -> Outcome {
    let Some(graph) = Graph::named("layered256") else { return Outcome::default() };
    let setup = Setup { graph: &graph, lanes: 1, body: Body::EMPTY, machine: bench.machine };
    let plan = Plan { rounds: bench.rounds(), samples: 9, runs: 64, units: graph.nodes() };
    Table {
        title: "layered256 through the C ABI, one lane, empty bodies".to_owned(),
        unit: "ns/node",
        reference: FROM_RUST,
        must: &[Must::Ratio(1.10)],
        rows: field(THROUGH_ABI, &setup, &plan),
    }
    .print()
}

fn frame(bench: &Bench) -> Outcome {
    let Some(graph) = Graph::named("mimonet6") else { return Outcome::default() };
    let setup = Setup { graph: &graph, lanes: 1, body: Body::EMPTY, machine: bench.machine };
    let plan = Plan { rounds: bench.rounds(), samples: 101, runs: 1, units: 1 };
    Table {
        title: "one empty mimonet6 frame, released by another thread".to_owned(),
        unit: "ns/frame",
        reference: "mutex and heap",
        must: &[Must::Figure(2_000.0)],
        rows: field(RELEASED_FROM_OUTSIDE, &setup, &plan),
    }
    .print()
}

fn handoff(bench: &Bench) -> Outcome {
    let plan = Plan { rounds: bench.rounds(), samples: 101, runs: 1, units: handoff::HOPS };
    let entries = handoff::CONTESTANTS.iter().map(|contestant| contestant.enter(bench.machine)).collect();
    Table {
        title: "hand-off from lane to lane".to_owned(),
        unit: "ns one way",
        reference: handoff::BARE_FLAG,
        must: &[Must::Ratio(2.0)],
        rows: interleave(entries, &plan),
    }
    .print()
}

fn timer(bench: &Bench) -> Outcome {
    let (turns, seconds) = if bench.quick { (5, 2) } else { (15, 4) };
    let rows = timer::measure(bench.machine, turns, Duration::from_secs(seconds));
    let table = |figure, unit, must, rows| Table {
        title: format!("timed release at 1 kHz, {turns} turns of {seconds} s, {figure}"),
        unit,
        reference: timer::CYCLICTEST,
        must,
        rows,
    };
    let below = &[Must::Ratio(1.0)];
    [
        table("median", "ns late", below, rows.medians).print(),
        table("99th percentile", "ns late", below, rows.p99s).print(),
        table("processor time", "% of a CPU", &[], rows.cpu).print(),
    ]
    .into_iter()
    .sum()
}

fn queue(bench: &Bench) -> Outcome {
    let plan = Plan { rounds: bench.rounds(), samples: 21, runs: 1_000, units: 1 };
    let table = |size, operation, entries| Table {
        title: format!("ready queue of {size} entries, {operation}"),
        unit: "ns",
        reference: queue::ORX,
        must: &[Must::Ratio(1.0)],
        rows: interleave(entries, &plan),
    };
    let tables = queue::SIZES.into_iter().flat_map(|size| {
        let hold = queue::CONTESTANTS.iter().map(|queue| queue.enter((queue.hold)(size))).collect();
        let rekey = queue::CONTESTANTS.iter().map(|queue| queue.enter((queue.rekey)(size))).collect();
        [table(size, "pop and push", hold).print(), table(size, "re-key", rekey).print()]
    });
    tables.sum()
}

/// The scheduler of the paper's workload: 4 tasks of 16 nodes, 16 jobs, 4 lanes.
fn state(_: &Bench) -> Outcome {
    type Paper = Caps<4, 16, 16>;
    type Shared = SharedScheduler<Paper, TicketLock<Scheduler<Paper>>, 1, 8>;
    let row =
        |name: &str, ours, bytes: usize| Row { name: name.to_owned(), ours, rounds: Ok(vec![bytes as f64]) };
    let used = size_of::<Shared>() - Scheduler::<Paper>::RECORD_SIZE;
    Table {
        title: "state for the workload of the paper, record apart".to_owned(),
        unit: "bytes",
        reference: "the paper",
        must: &[Must::Figure(12_288.0)],
        rows: vec![row("the paper", false, 5_120), row("RED", true, used)],
    }
    .print()
}

fn growth(bench: &Bench) -> Outcome {
    let plan = Plan { rounds: bench.rounds(), samples: 21, runs: 100, units: growth::CALLS };
    let tables = growth::CALLED.into_iter().map(|(name, call)| {
        Table {
            title: format!("one call of {name} as nodes grow"),
            unit: "ns",
            reference: growth::SMALLEST,
            must: &[Must::Ratio(2.0)],
            rows: interleave(growth::field(call), &plan),
        }
        .print()
    });
    tables.sum()
}

fn edit(bench: &Bench) -> Outcome {
    let Some(graph) = Graph::named("layered256") else { return Outcome::default() };
    let plan = Plan { rounds: bench.rounds(), samples: 21, runs: 10, units: 1 };
    Table {
        title: "one commit of 256 nodes and 1,024 edges".to_owned(),
        unit: "ns",
        reference: edit::READ_ONCE,
        must: &[Must::Figure(10_000.0)],
        rows: interleave(edit::field(&graph), &plan),
    }
    .print()
}

fn overload(bench: &Bench) -> Outcome {
    let fields = [
        ("8 jobs of 8 nodes", 10_000.0, overload::few()),
        ("64 jobs of 16 nodes", 200_000.0, overload::many()),
    ];
    let tables = fields.into_iter().map(|(what, bound, entries)| {
        let plan = Plan { rounds: bench.rounds(), samples: 9, runs: 16, units: 1 };
        Table {
            title: format!("a look at the forward schedule of {what}"),
            unit: "ns/look",
            reference: overload::READ_ONCE,
            must: &[Must::Figure(bound)],
            rows: interleave(entries, &plan),
        }
        .print()
    });
    tables.sum()
}
