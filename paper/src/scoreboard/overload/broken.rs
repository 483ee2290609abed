//! The protected groups that `redrt` breaks, and who kept a lane from each.

use super::blocking::{self, Met, Why};
use super::claims::OURS;
use super::groups::{self, Group};
use super::load::{Set, Shape, Times};
use super::rules::Rule;
use super::{Point, points};
use crate::run::{PaperError, Run};
use crate::scoreboard::drive::Ends;
use crate::table::{Cell, Claim, Column, Table, Verdict};
use std::collections::BTreeMap;

/// A group that broke.
struct Row {
    cells: Vec<Cell>,
    is_blocked: bool,
}

pub(crate) fn run(run: &Run<'_>) -> Result<Table, PaperError> {
    let mut cells = Vec::new();
    for point in points() {
        cells.extend((1..=run.seeds).map(|seed| (point, seed)));
    }
    let found = run.each(&cells, |(point, seed)| rows(*point, *seed).ok_or(PaperError::Capacity))?;
    let rows: Vec<Row> = found.into_iter().flatten().collect();
    let blocked = rows.iter().filter(|row| row.is_blocked).count();
    let all = rows.len();
    Ok(Table {
        name: "broken-groups",
        title: "Protected groups that redrt breaks",
        source: "not in the paper",
        about: vec![
            format!(
                "Every protected group of `overload`, seeds 1 to {}, that is not whole under redrt: its first job that was not on \
                 time, and the nodes of lower value that had a lane before that job ended, while the group had something in flight \
                 without a break. Tasks are t0, t1 and so on, with their values.",
                run.seeds
            ),
            "Nothing ready: when the node started, no node of the group was ready. Could wait: all of the group that was in flight \
             then could still end in time behind the node, at mean times and with nobody else on the lanes. In both cases nobody \
             needed the lane yet; what came later lacked the time. A group is blocked if it met such nodes only."
                .to_owned(),
        ],
        columns: vec![
            Column::numbers("lanes", "", 0),
            Column::numbers("load", "", 2),
            Column::words("times"),
            Column::numbers("seed", "", 0),
            Column::words("group"),
            Column::numbers("least on time", "%", 1),
            Column::words("first miss"),
            Column::words("met on a lane"),
        ],
        rows: rows.into_iter().map(|row| row.cells).collect(),
        claims: vec![Claim {
            claim: "a group that redrt breaks was blocked".to_owned(),
            paper: "-".to_owned(),
            ours: format!("{blocked} of {all}"),
            verdict: if blocked == all { Verdict::Holds } else { Verdict::NotKept },
            why: if blocked == all { "" } else { WHY },
        }],
    })
}

const WHY: &str = "a node of lower value had started although the group could not wait, by a schedule of the group alone; that of redrt \
                   has all jobs in flight, and their measured times";

fn rows(point: Point, seed: u64) -> Option<Vec<Row>> {
    let Point { lanes, load, times } = point;
    let set = Set::draw(Shape::Values, lanes, load, times, seed);
    let protected = groups::protected(&set)?;
    if protected.is_empty() {
        return Some(Vec::new());
    }
    let ends = Rule::ALL[OURS].run(&set)?;
    let broken = protected.into_iter().map(|group| (groups::fate(&set, &group, &ends), group));
    let row = |(fate, group): (Group, Vec<usize>)| Row {
        cells: [
            f64::from(lanes).into(),
            load.into(),
            times.name().into(),
            (seed as f64).into(),
            group.iter().map(|task| name(&set, *task)).collect::<Vec<_>>().join(", ").into(),
            (100.0 * groups::least_on_time(&group, &ends)).into(),
        ]
        .into_iter()
        .chain(first_miss(&set, &group, &ends).map(Cell::from))
        .collect(),
        is_blocked: fate == Group::Blocked,
    };
    Some(broken.filter(|(fate, _)| *fate != Group::Whole).map(row).collect())
}

/// The first job that was missed, and whom it met.
fn first_miss(set: &Set, group: &[usize], ends: &Ends) -> [String; 2] {
    let Some(job) = blocking::first_missed(set, group, ends) else { return Default::default() };
    let release = set.releases[job.0][job.1 as usize];
    let missed = format!("{}, released at {}", name(set, job.0), ms(release));
    let mut by: BTreeMap<(usize, Why), (u32, u64)> = BTreeMap::new();
    for Met { span, why } in blocking::met(set, group, ends, job) {
        let (nodes, nanos) = by.entry((span.task, why)).or_default();
        (*nodes, *nanos) = (*nodes + 1, *nanos + span.end - span.start);
    }
    let met = |(&(task, why), &(nodes, nanos)): (&(usize, Why), &(u32, u64))| {
        let why = match why {
            Why::NothingReady => "nothing ready",
            Why::CouldWait => "could wait",
            Why::CouldNotWait => "could not wait",
        };
        let nodes = if nodes == 1 { "1 node".to_owned() } else { format!("{nodes} nodes") };
        format!("{}: {nodes}, {}, {why}", name(set, task), ms(nanos))
    };
    let met: Vec<String> = by.iter().map(met).collect();
    [missed, if met.is_empty() { "nobody".to_owned() } else { met.join("; ") }]
}

fn name(set: &Set, task: usize) -> String {
    format!("t{task} (value {})", set.values[task])
}

fn ms(nanos: u64) -> String {
    format!("{:.1} ms", nanos as f64 / 1e6)
}

impl Times {
    const fn name(self) -> &'static str {
        match self {
            Self::Wcet => "WCET",
            Self::Uniform => "uniform",
            Self::Bimodal => "bimodal",
        }
    }
}
