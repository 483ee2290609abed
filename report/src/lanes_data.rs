//! What the script of the timeline draws: numbers in few bytes, for pages have a hundred thousand slices.

use crate::escape::{script, string};
use crate::model::Run;
use crate::overview::COLOURS;
use crate::window::window;
use std::fmt::Write;

/// Slices that a page has at most: those around its first window.
const MOST: usize = 200_000;

/// The JSON of a run's timeline, fit for a script element, and whether it has every slice.
///
/// `s` has slices as lane, start, length, task, job, node, sub-deadline or -1, members of its unit, whether it completed;
/// `j` has jobs as task, number, release, deadline, end or -1, outcome, row; starts and releases as differences to those before.
pub(crate) fn json(run: &Run) -> (String, bool) {
    let (from, until) = window(run);
    let middle = run.slices.partition_point(|slice| slice.start_ns < from.midpoint(until));
    let first = middle.saturating_sub(MOST / 2).min(run.slices.len().saturating_sub(MOST));
    let kept = &run.slices[first..run.slices.len().min(first + MOST)];
    let mut out =
        format!("{{\"end\":{},\"window\":[{from},{until}],\"colours\":{COLOURS},\"lanes\":", run.end_ns);
    list(&mut out, run.lanes.iter().map(|lane| string(&lane.name)));
    out.push_str(",\"tasks\":");
    list(
        &mut out,
        run.tasks.iter().map(|task| {
            let mut nodes = String::new();
            list(&mut nodes, task.nodes.iter().map(|node| string(node)));
            format!("{{\"name\":{},\"nodes\":{nodes}}}", string(&task.name))
        }),
    );
    out.push_str(",\"edits\":");
    list(&mut out, run.edits.iter().map(|(at, words)| format!("[{at},{}]", string(words))));
    out.push_str(",\"misses\":");
    list(&mut out, run.misses.iter().map(|miss| format!("[{},{}]", miss.task, miss.job)));
    out.push_str(",\"hits\":");
    list(
        &mut out,
        run.hits.iter().take(MOST).map(|hit| {
            let (task, job, node) = hit.of;
            format!("[{},{task},{job},{node}]", hit.at_ns)
        }),
    );
    slices(&mut out, run, kept);
    jobs(&mut out, run);
    out.push('}');
    (script(&out), kept.len() == run.slices.len())
}

fn slices(out: &mut String, run: &Run, kept: &[crate::model::Slice]) {
    out.push_str(",\"s\":[");
    let (mut before, mut separator) = (0, "");
    for (i, slice) in kept.iter().enumerate() {
        let (task, job, node) = slice.of;
        // Members of a unit follow each other; the first of them says how many there are.
        let is_member = i > 0 && kept[i - 1].unit == slice.unit && kept[i - 1].lane == slice.lane;
        let members =
            kept[i..].iter().take_while(|other| other.unit == slice.unit && other.lane == slice.lane).count();
        let due = slice.due_ns.map_or(-1, i128::from);
        let _infallible = write!(
            out,
            "{separator}{},{},{},{task},{job},{node},{due},{},{}",
            slice.lane,
            slice.start_ns - before,
            slice.end_ns - slice.start_ns,
            if is_member { 0 } else { members },
            u8::from(slice.completed)
        );
        (before, separator) = (slice.start_ns, ",");
    }
    let _infallible = write!(out, "],\"whole\":{}", kept.len() == run.slices.len());
}

fn jobs(out: &mut String, run: &Run) {
    out.push_str(",\"j\":[");
    let mut separator = "";
    for (task, jobs) in run.jobs.iter().enumerate() {
        let mut free_at: Vec<u64> = Vec::new();
        for (number, job) in jobs.iter().enumerate().take(MOST) {
            let end = job.end_ns.unwrap_or(run.end_ns).max(job.release_ns);
            // The first row that is free again; beyond so many the last one holds what is left.
            let free = free_at.iter().position(|free| *free <= job.release_ns);
            let row = free.unwrap_or_else(|| free_at.len().min(ROWS - 1));
            match free_at.get_mut(row) {
                Some(free) => *free = end.max(*free),
                None => free_at.push(end),
            }
            let end = job.end_ns.map_or(-1, i128::from);
            let outcome = match run.outcome(job) {
                "on time" => 0,
                "late" => 1,
                "given up" => 2,
                _ => 3,
            };
            let _infallible = write!(
                out,
                "{separator}{task},{number},{},{},{end},{outcome},{row}",
                job.release_ns, job.deadline_ns
            );
            separator = ",";
        }
    }
    out.push(']');
}

/// Rows for the jobs of a task at most.
const ROWS: usize = 10;

fn list(out: &mut String, items: impl Iterator<Item = String>) {
    out.push('[');
    for (i, item) in items.enumerate() {
        out.push_str(if i > 0 { "," } else { "" });
        out.push_str(&item);
    }
    out.push(']');
}
