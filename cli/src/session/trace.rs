//! A run in the Chrome trace event format: opens in Perfetto (ui.perfetto.dev) and in chrome://tracing.
//!
//! Process 1 has a row for each lane: a slice per sub-job, arrows along the edges of the graph, marks where a
//! sub-deadline was missed or a WCET overrun. Process 2 has the rows of the tasks: a slice per job with what became of
//! it, marks for its deadline, predicted misses, sheds and hits, a row of graph versions where edits change the graph, and
//! one of standstills where there were any.

mod rows;
mod slices;

use crate::session::Session;
use crate::session::sub_deadlines::SubJob;
use red_core::EventKind;
use red_workload::metrics::JobEnd;
use serde_json::{Value, json};
use slices::{Slice, slices};
use std::collections::HashMap;
use std::io::{self, Write};

/// Processes of the trace.
const LANES: usize = 1;
const TASKS: usize = 2;

/// A trace, laid out.
pub(crate) struct Trace<'a> {
    session: &'a Session,
    slices: Vec<Slice>,
    sub_deadlines: HashMap<SubJob, u64>,
    /// Row of each job of each task, from 0 over all tasks.
    job_rows: Vec<Vec<usize>>,
    /// Titles of the rows of process 2.
    titles: Vec<String>,
    entries: Vec<Entry>,
}

/// One event of the trace.
struct Entry {
    at_ns: u64,
    process: usize,
    row: usize,
    what: What,
}

enum What {
    /// A sub-job on its lane, as an index.
    SubJob(usize),
    /// Task and job.
    Job(usize, usize),
    /// A version of a graph: title, end.
    Version(String, u64),
    /// An arrow leaves or arrives, by its number.
    Leave(usize),
    Arrive(usize),
    Mark(String, Value),
}

/// Chrome's unit: microseconds, with the nanoseconds behind the point.
fn us(ns: u64) -> f64 {
    ns as f64 / 1_000.0
}

impl<'a> Trace<'a> {
    /// Lays a run out.
    pub(crate) fn of(session: &'a Session) -> Self {
        let end_of = |task: usize, job: u64| {
            let job = usize::try_from(job).ok().and_then(|job| session.notes.logs[task].jobs().get(job));
            job.map_or(session.end_ns, |job| ended_ns(job, session.end_ns))
        };
        let mut trace = Self {
            session,
            slices: slices(&session.notes.events, &session.edges, end_of),
            sub_deadlines: session.sub_deadlines.all(),
            job_rows: Vec::new(),
            titles: Vec::new(),
            entries: Vec::new(),
        };
        // What encloses comes before what it encloses: the sort below keeps this order within an instant.
        trace.versions();
        trace.standstills();
        trace.jobs();
        trace.sub_jobs();
        trace.marks();
        trace.entries.sort_by_key(|entry| entry.at_ns);
        trace
    }

    /// Writes the trace, one event per line, by time.
    ///
    /// # Errors
    /// Those of `out`.
    pub(crate) fn write(&self, out: &mut impl Write) -> io::Result<()> {
        let report = &self.session.summary;
        let about = json!({ "policy": report.report.policy, "realtime": report.realtime,
            "events_dropped": report.notes_dropped });
        write!(out, "{{\"displayTimeUnit\":\"ms\",\"otherData\":{about},\"traceEvents\":[")?;
        let mut separator = "\n";
        for event in self.metadata().chain(self.entries.iter().map(|entry| self.event(entry))) {
            write!(out, "{separator}{event}")?;
            separator = ",\n";
        }
        writeln!(out, "\n]}}")
    }

    fn put(&mut self, at_ns: u64, process: usize, row: usize, what: What) {
        self.entries.push(Entry { at_ns, process, row, what });
    }

    fn mark(&mut self, at_ns: u64, process: usize, row: usize, name: String, args: Value) {
        self.put(at_ns, process, row, What::Mark(name, args));
    }

    fn jobs(&mut self) {
        let Session { notes, tasks, end_ns, .. } = self.session;
        for (task, log) in notes.logs.iter().enumerate() {
            let first = self.titles.len();
            let spans = log.jobs().iter().map(|job| (job.release_ns, ended_ns(job, *end_ns)));
            let rows: Vec<usize> = rows::rows(spans).iter().map(|row| first + row).collect();
            let last = rows.iter().copied().max().unwrap_or(first);
            self.titles.push(tasks[task].clone());
            self.titles
                .extend((first + 1..=last).map(|row| format!("{} ({})", tasks[task], row - first + 1)));
            for (index, (job, row)) in log.jobs().iter().zip(&rows).enumerate() {
                self.put(job.release_ns, TASKS, *row, What::Job(task, index));
                let end_ns = ended_ns(job, *end_ns);
                if let Some(reason) = job.shed {
                    let at_ns = within(end_ns, job.release_ns, end_ns);
                    self.mark(
                        at_ns,
                        TASKS,
                        *row,
                        format!("shed: {}", reason.name()),
                        json!({ "job": index }),
                    );
                }
                if let Some(at_ns) = job.warned_ns {
                    let ahead = json!({ "job": index, "due_ns": job.deadline_ns });
                    self.mark(at_ns, TASKS, *row, "miss predicted".to_owned(), ahead);
                }
                if end_ns > job.deadline_ns {
                    let late = json!({ "job": index, "late_ns": end_ns - job.deadline_ns });
                    self.mark(job.deadline_ns, TASKS, *row, "deadline missed".to_owned(), late);
                }
            }
            self.job_rows.push(rows);
        }
    }

    /// A row of graph versions for each task whose graph changed.
    fn versions(&mut self) {
        let Session { notes, tasks, edits, end_ns, .. } = self.session;
        for (task, edits) in edits.iter().enumerate().filter(|(_, edits)| !edits.is_empty()) {
            let edited =
                |event: &&red_core::Event| event.kind == EventKind::Edited && event.task.index() == task;
            let at = notes.events.iter().filter(edited).map(|event| event.at.as_nanos());
            let starts: Vec<u64> = std::iter::once(0).chain(at).collect();
            let titles = std::iter::once("as in the file").chain(edits.iter().map(String::as_str));
            let row = self.titles.len();
            self.titles.push(format!("{} graph", tasks[task]));
            for (i, (start, title)) in starts.iter().zip(titles).enumerate() {
                let end = starts.get(i + 1).copied().unwrap_or(*end_ns);
                self.put(*start, TASKS, row, What::Version(title.to_owned(), end));
            }
        }
    }

    /// When nothing ran.
    fn standstills(&mut self) {
        let row = self.titles.len();
        let standstills = &self.session.notes.standstills;
        if !standstills.is_empty() {
            self.titles.push("standstills".to_owned());
        }
        for (from_ns, until_ns) in standstills {
            self.put(*from_ns, TASKS, row, What::Version("nothing ran".to_owned(), *until_ns));
        }
    }

    fn sub_jobs(&mut self) {
        let mut arrows = 0;
        for index in 0..self.slices.len() {
            let Slice { of, lane, start_ns, end_ns, completed, ref after } = self.slices[index];
            let after = after.clone();
            self.put(start_ns, LANES, lane, What::SubJob(index));
            if let Some(due_ns) =
                self.sub_deadlines.get(&of).copied().filter(|due| completed && *due < end_ns)
            {
                let name = format!("sub-deadline missed: {}", self.name(of));
                let late = json!({ "job": of.1, "sub_deadline_ns": due_ns, "late_ns": end_ns - due_ns });
                self.mark(within(due_ns, start_ns, end_ns), LANES, lane, name, late);
            }
            for from in after {
                // Inside of the slices that they connect, by which viewers tell which those are.
                let Slice { lane: from_lane, start_ns: left_ns, end_ns: ended_ns, .. } = self.slices[from];
                self.put(within(ended_ns, left_ns, ended_ns), LANES, from_lane, What::Leave(arrows));
                self.put(within(start_ns + 1, start_ns, end_ns), LANES, lane, What::Arrive(arrows));
                arrows += 1;
            }
        }
    }

    fn marks(&mut self) {
        for event in &self.session.notes.events {
            let (task, at_ns) = (event.task.index(), event.at.as_nanos());
            let of = (task, event.job, event.node.index());
            let of_job =
                usize::try_from(event.job).ok().and_then(|job| self.job_rows[task].get(job).copied());
            let what = match event.kind {
                EventKind::Hit => "hit",
                EventKind::Evicted => "evicted",
                EventKind::Overran => {
                    let name = format!("overrun: {}", self.name(of));
                    // The slice ends at this instant, and the mark belongs to it.
                    let lane = event.lane.index();
                    self.mark(at_ns.saturating_sub(1), LANES, lane, name, json!({ "job": event.job }));
                    continue;
                }
                _ => continue,
            };
            if let Some(row) = of_job {
                let name = format!("{what}: {}", self.name(of));
                self.mark(at_ns, TASKS, row, name, json!({ "job": event.job }));
            }
        }
    }

    /// Names and order of processes and rows.
    fn metadata(&self) -> impl Iterator<Item = Value> {
        let about = |process: usize, row: Option<usize>, title: &str, order: usize| {
            let (kind, tid) = if row.is_some() { ("thread", row) } else { ("process", None) };
            let tid = tid.map_or(0, |row| row + 1);
            let of = |name: &str, args: Value| json!({ "ph": "M", "name": format!("{kind}_{name}"), "pid": process, "tid": tid, "args": args });
            [of("name", json!({ "name": title })), of("sort_index", json!({ "sort_index": order }))]
        };
        let processes = [(LANES, "lanes", &self.session.lanes), (TASKS, "tasks", &self.titles)];
        processes.into_iter().flat_map(move |(process, name, rows)| {
            let rows = rows.iter().enumerate();
            let rows = rows.flat_map(move |(i, title)| about(process, Some(i), title, i));
            about(process, None, name, process).into_iter().chain(rows)
        })
    }

    /// An entry as an event of the format. Viewers keep row 0 for the system, so rows count from 1.
    fn event(&self, entry: &Entry) -> Value {
        let mut event = match &entry.what {
            What::SubJob(index) => self.sub_job(&self.slices[*index]),
            What::Job(task, index) => self.job(*task, *index),
            What::Version(title, end_ns) => {
                json!({ "ph": "X", "cat": "edit", "name": title, "dur": us(end_ns - entry.at_ns) })
            }
            What::Leave(id) => json!({ "ph": "s", "cat": "edge", "name": "edge", "id": id }),
            What::Arrive(id) => json!({ "ph": "f", "bp": "e", "cat": "edge", "name": "edge", "id": id }),
            What::Mark(name, args) => {
                json!({ "ph": "i", "s": "t", "cat": "mark", "name": name, "args": args })
            }
        };
        event["pid"] = entry.process.into();
        event["tid"] = (entry.row + 1).into();
        event["ts"] = us(entry.at_ns).into();
        event
    }

    fn sub_job(&self, slice: &Slice) -> Value {
        let (task, job, _) = slice.of;
        let log = usize::try_from(job).ok().and_then(|job| self.session.notes.logs[task].jobs().get(job));
        let args = json!({ "task": self.session.tasks[task], "job": job, "completed": slice.completed,
            "deadline_ns": log.map(|log| log.deadline_ns), "sub_deadline_ns": self.sub_deadlines.get(&slice.of) });
        json!({ "ph": "X", "cat": "node", "name": self.name(slice.of), "dur": us(slice.end_ns - slice.start_ns),
            "args": args })
    }

    fn job(&self, task: usize, index: usize) -> Value {
        let job = &self.session.notes.logs[task].jobs()[index];
        let end_ns = ended_ns(job, self.session.end_ns);
        let outcome = match (job.at_ns, job.shed) {
            (_, Some(_)) => "shed",
            (None, None) => "unfinished",
            (Some(at), None) if at > job.deadline_ns => "late",
            (Some(_), None) => "on time",
        };
        // Viewers colour slices by their names, numbers apart: what was missed has another colour.
        let suffix = if outcome == "on time" { String::new() } else { format!(" {outcome}") };
        let args = json!({ "job": index, "deadline_ns": job.deadline_ns, "outcome": outcome,
            "reason": job.shed.map(|reason| reason.name()) });
        json!({ "ph": "X", "cat": "job", "name": format!("{} #{index}{suffix}", self.session.tasks[task]),
            "dur": us(end_ns - job.release_ns), "args": args })
    }

    fn name(&self, (task, _, node): SubJob) -> &'a str {
        self.session.nodes.get(task).and_then(|nodes| nodes.get(node)).map_or("?", |node| &node.name)
    }
}

/// When a job ended, at the latest with the run.
fn ended_ns(job: &JobEnd, run_end_ns: u64) -> u64 {
    job.at_ns.unwrap_or(run_end_ns).max(job.release_ns)
}

/// `at`, moved into the slice from `start` to before `end`.
fn within(at: u64, start: u64, end: u64) -> u64 {
    at.min(end.saturating_sub(1)).max(start)
}
