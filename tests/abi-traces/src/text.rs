//! A workload as text: one thing a line, words and decimal numbers, `-` for none.
//!
//! ```text
//! workload SEED CLASS POLICY INSTANTS
//! config LANES MEMORY RULE GATE REASSIGN REFINE SKEW CACHE SHED LATE BEST PPM QUEUE TICKS TICK ADMISSION PREEMPT
//! pool LANES MEMORY | sensor PERIOD
//! task DEADLINE PERIOD VALUE KEEP OF, and its steps:
//!   node NODE | edge FROM TO | refine STAGE COUNT ENCODER DECODER... | replace PLACE NODE | remove NODE | cut FROM TO
//! fate PERCENT HOW REPEATS
//! at NS admit TASK | release TASK AT CAPTURE | remove TASK | begin PLACE TASK | change PLACE STEP | commit PLACE
//!       | drop PLACE | retire LANE | restore LANE | stray UNIT TASK | back NS | take
//! end
//! ```
//!
//! A node is WCET BEST CONTENTION MEMORY POOL ROLE WEIGHTS FRAME SENSOR, a contention or `-`.

use std::io::{self, Write};

use red_core::{Node, Role};

use crate::script::{Class, Event, INSTANTS, Script, Step};
use crate::words::{config, or_none};

pub(crate) fn write(script: &Script, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "workload {} {} {} {INSTANTS}", script.seed, class(script.class), script.policy)?;
    writeln!(out, "config {}", config(&script.config))?;
    for (lanes, memory) in &script.pools {
        writeln!(out, "pool {lanes} {}", or_none(memory.map(|memory| memory.0)))?;
    }
    for period in &script.sensors {
        writeln!(out, "sensor {}", period.as_nanos())?;
    }
    for task in &script.tasks {
        let (terms, (keep, of)) = (&task.terms, task.terms.floor);
        let (deadline, period) = (terms.deadline.as_nanos(), terms.period.as_nanos());
        writeln!(out, "task {deadline} {period} {} {keep} {of}", terms.value)?;
        for of_task in &task.steps {
            writeln!(out, "{}", step(of_task))?;
        }
    }
    for fate in &script.fates {
        writeln!(out, "fate {} {:?} {}", fate.percent, fate.how, u8::from(fate.repeats))?;
    }
    for (at_ns, what) in &script.events {
        writeln!(out, "at {at_ns} {}", event(what))?;
    }
    writeln!(out, "end")
}

/// As the functions of the C ABI are named.
pub(crate) const fn class(class: Class) -> &'static str {
    match class {
        Class::Small => "4x16x16",
        Class::Medium => "8x64x32",
        Class::Large => "16x256x64",
    }
}

fn step(step: &Step) -> String {
    match step {
        Step::Node(of) => format!("node {}", node(of)),
        Step::Edge(from, to) => format!("edge {from} {to}"),
        Step::Refine(stage, encoder, decoders) => {
            let parts = [encoder].into_iter().chain(decoders).map(node).collect::<Vec<_>>().join(" ");
            format!("refine {stage} {} {parts}", decoders.len())
        }
        Step::Replace(place, by) => format!("replace {place} {}", node(by)),
        Step::Remove(node) => format!("remove {node}"),
        Step::Cut(from, to) => format!("cut {from} {to}"),
    }
}

/// A node, by what it says of itself.
pub(crate) fn node(node: &Node) -> String {
    let frame = match node.role() {
        Role::Ordinary => "Ordinary 0 0 -".to_owned(),
        Role::Decoder => "Decoder 0 0 -".to_owned(),
        Role::SharedEncoder(frame) => {
            let sensor = or_none(frame.sensor.map(|sensor| sensor.index() as u64));
            format!("SharedEncoder {} {} {sensor}", frame.weights, frame.frame)
        }
    };
    let wcet = node.wcet().as_nanos();
    let contention = or_none(node.is_atomic().then(|| node.cost() - wcet));
    let (best, memory, pool) = (node.best().as_nanos(), node.footprint().0, node.pool().index());
    format!("{wcet} {best} {contention} {memory} {pool} {frame}")
}

fn event(event: &Event) -> String {
    match event {
        Event::Admit(task) => format!("admit {task}"),
        Event::Release { task, at_ns, capture } => format!("release {task} {at_ns} {}", or_none(*capture)),
        Event::Remove(task) => format!("remove {task}"),
        Event::Begin { place, task } => format!("begin {place} {task}"),
        Event::Change { place, step: change } => format!("change {place} {}", step(change)),
        Event::Commit(place) => format!("commit {place}"),
        Event::Drop(place) => format!("drop {place}"),
        Event::Retire(lane) => format!("retire {lane}"),
        Event::Restore(lane) => format!("restore {lane}"),
        Event::Stray { unit, task } => format!("stray {unit} {task}"),
        Event::Back(ns) => format!("back {ns}"),
        Event::Take => "take".to_owned(),
    }
}
