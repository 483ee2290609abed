//! The protected groups that `redrt` breaks, and who kept a lane from each.

use super::blocking::{self, Met, Why};
use super::claims::OURS;
use super::groups;
use super::load::{Set, Shape};
use super::rules::Rule;
use super::{Point, points};
use crate::run::{PaperError, Run};
use crate::table::{Cell, Claim, Column, Table, Verdict};
use std::collections::BTreeMap;

/// A group that broke: what it is, and whom it met.
struct Broken {
    group: Vec<Cell>,
    met: Vec<[Cell; 4]>,
    is_blocked: bool,
}

pub(crate) fn run(run: &Run<'_>) -> Result<Table, PaperError> {
    let mut cells = Vec::new();
    for point in points() {
        cells.extend((1..=run.seeds).map(|seed| (point, seed)));
    }
    let found = run.each(&cells, |(point, seed)| broken(*point, *seed).ok_or(PaperError::Capacity))?;
    let groups: Vec<Broken> = found.into_iter().flatten().collect();
    let (blocked, all) = (groups.iter().filter(|group| group.is_blocked).count(), groups.len());
    let rows =
        groups.iter().flat_map(|Broken { group, met, .. }| met.iter().map(|met| [group, &met[..]].concat()));
    Ok(Table {
        name: "broken-groups",
        title: "Protected groups that redrt breaks",
        source: "not in the paper",
        about: vec![
            format!(
                "Every protected group of `overload`, seeds 1 to {}, that is not whole under redrt: the share of jobs on time of the \
                 task that has the least, the first job that was not, and the nodes of lower value that had a lane before that job \
                 ended, while the group had something in flight without a break. Tasks are t0, t1 and so on, with their values; a \
                 row for each task of lower value, and for each state in which its nodes found the group.",
                run.seeds
            ),
            "Not ready: when the node started, no node of the group was ready. Could wait: all of the group that was in flight then \
             could still end in time behind the node, at mean times and with nobody else on the lanes. In both cases nobody needed \
             the lane yet; what came later lacked the time. A group is blocked if it met such nodes only."
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
            Column::words("met"),
            Column::numbers("nodes", "", 0),
            Column::numbers("ran", "ms", 1),
            Column::words("the group"),
        ],
        rows: rows.collect(),
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

fn broken(point: Point, seed: u64) -> Option<Vec<Broken>> {
    let Point { lanes, load, times } = point;
    let set = Set::draw(Shape::Values, lanes, load, times, seed);
    let protected = groups::protected(&set)?;
    if protected.is_empty() {
        return Some(Vec::new());
    }
    let ends = Rule::ALL[OURS].run(&set)?;
    let broken = |group: Vec<usize>| {
        let met = blocking::met(&set, &group, &ends);
        let missed = blocking::first_missed(&set, &group, &ends);
        let names: Vec<String> = group.iter().map(|task| name(&set, *task)).collect();
        Broken {
            group: vec![
                f64::from(lanes).into(),
                load.into(),
                times.name().into(),
                (seed as f64).into(),
                names.join(", ").into(),
                (100.0 * groups::least_on_time(&group, &ends)).into(),
                missed.map_or_else(String::new, |job| released(&set, job)).into(),
            ],
            is_blocked: blocking::is_blocked(&met),
            met: rows(&set, &met),
        }
    };
    Some(protected.into_iter().filter(|group| !groups::is_whole(group, &ends)).map(broken).collect())
}

/// Whom the first job met that was missed, and in which state of its group: how many nodes, and how long these ran.
fn rows(set: &Set, met: &[Met]) -> Vec<[Cell; 4]> {
    let mut by: BTreeMap<(usize, Why), (u32, u64)> = BTreeMap::new();
    for &Met { span, why } in met {
        let (nodes, nanos) = by.entry((span.task, why)).or_default();
        (*nodes, *nanos) = (*nodes + 1, *nanos + span.end - span.start);
    }
    let row = |(&(task, why), &(nodes, nanos)): (&(usize, Why), &(u32, u64))| {
        let why = match why {
            Why::NothingReady => "not ready",
            Why::CouldWait => "could wait",
            Why::CouldNotWait => "could not wait",
        };
        [name(set, task).into(), f64::from(nodes).into(), (nanos as f64 / 1e6).into(), why.into()]
    };
    if by.is_empty() {
        return vec![["nobody".into(), Cell::Number(None), Cell::Number(None), "".into()]];
    }
    by.iter().map(row).collect()
}

fn released(set: &Set, (task, job): (usize, u64)) -> String {
    format!("t{task} of {:.1} ms", set.releases[task][job as usize] as f64 / 1e6)
}

fn name(set: &Set, task: usize) -> String {
    format!("t{task} ({})", set.values[task])
}
