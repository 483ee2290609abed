//! A run as a Chrome trace: opens in Perfetto (ui.perfetto.dev) and in chrome://tracing.
//!
//! Lanes are rows of process 1; tasks are rows of process 2 with one span per job, its deadline, and what happened
//! to it. Arrows lead along the edges of the graph; instants mark misses, sheds, hits and graph edits.

use red_core::{Event, EventKind};
use red_workload::build::Numbered;
use red_workload::metrics::TaskLog;
use serde_json::{Value, json};
use std::collections::HashMap;
use std::io::{self, Write};

/// What a trace is made from.
#[derive(Debug)]
pub(crate) struct Trace<'a> {
    /// Policy, for the title.
    pub(crate) policy: &'a str,
    /// Task names.
    pub(crate) tasks: Vec<&'a str>,
    /// Numbered nodes of each task.
    pub(crate) nodes: &'a [Vec<Numbered>],
    /// Edges of each task by node number, all versions together.
    pub(crate) edges: &'a [Vec<(usize, usize)>],
    /// Row title of each lane.
    pub(crate) lanes: Vec<String>,
    /// The record.
    pub(crate) events: &'a [Event],
    /// Jobs of each task.
    pub(crate) logs: &'a [TaskLog],
    /// End of the run.
    pub(crate) end_ns: u64,
}

/// Processes of the trace.
const LANES: u32 = 1;
const TASKS: u32 = 2;

/// Chrome's unit: microseconds, with the nanoseconds behind the point.
fn us(ns: u64) -> Value {
    json!(ns as f64 / 1_000.0)
}

impl Trace<'_> {
    /// Writes the trace, one event per line.
    ///
    /// # Errors
    /// Those of `out`.
    pub(crate) fn write(&self, out: &mut impl Write) -> io::Result<()> {
        let mut rows = Rows { out, first: true };
        writeln!(
            rows.out,
            "{{\"displayTimeUnit\":\"ms\",\"otherData\":{},\"traceEvents\":[",
            json!({ "policy": self.policy })
        )?;
        self.titles(&mut rows)?;
        self.jobs(&mut rows)?;
        self.sub_jobs(&mut rows)?;
        writeln!(rows.out, "\n]}}")
    }

    fn titles(&self, rows: &mut Rows<impl Write>) -> io::Result<()> {
        let title = |name: &str, pid: u32, tid: usize, label: &str| json!({ "ph": "M", "name": name, "pid": pid, "tid": tid, "args": { "name": label } });
        rows.put(&title("process_name", LANES, 0, "lanes"))?;
        rows.put(&title("process_name", TASKS, 0, "tasks"))?;
        for (i, lane) in self.lanes.iter().enumerate() {
            rows.put(&title("thread_name", LANES, i, lane))?;
        }
        for (i, task) in self.tasks.iter().enumerate() {
            rows.put(&title("thread_name", TASKS, i, task))?;
        }
        Ok(())
    }

    fn jobs(&self, rows: &mut Rows<impl Write>) -> io::Result<()> {
        for (task, log) in self.logs.iter().enumerate() {
            for (index, job) in log.jobs().iter().enumerate() {
                let name = format!("{} #{index}", self.tasks[task]);
                let end = job.at_ns.unwrap_or(self.end_ns).max(job.release_ns);
                let id = format!("{task}.{index}");
                let args = json!({ "deadline_ns": job.deadline_ns, "shed": job.shed.map(|r| r.name()) });
                rows.put(
                    &json!({ "ph": "b", "cat": "job", "id": id, "name": name, "pid": TASKS, "tid": task,
                    "ts": us(job.release_ns), "args": args }),
                )?;
                rows.put(
                    &json!({ "ph": "e", "cat": "job", "id": id, "name": name, "pid": TASKS, "tid": task,
                    "ts": us(end) }),
                )?;
                if let Some(reason) = job.shed {
                    rows.mark(&format!("shed: {}", reason.name()), TASKS, task, end)?;
                } else if end > job.deadline_ns {
                    rows.mark("deadline missed", TASKS, task, job.deadline_ns)?;
                }
            }
        }
        Ok(())
    }

    fn sub_jobs(&self, rows: &mut Rows<impl Write>) -> io::Result<()> {
        let mut started: HashMap<(usize, u64, usize), u64> = HashMap::new();
        // Where a finished sub-job's arrows leave: lane and time.
        let mut left: HashMap<(usize, u64, usize), (usize, u64)> = HashMap::new();
        let mut arrows = 0u64;
        for event in self.events {
            let (task, node, lane, at) =
                (event.task.index(), event.node.index(), event.lane.index(), event.at.as_nanos());
            let key = (task, event.job, node);
            let name = || self.nodes.get(task).and_then(|n| n.get(node)).map_or("?", |n| n.name.as_str());
            match event.kind {
                EventKind::Started => {
                    started.insert(key, at);
                    for (from, _) in self.edges[task].iter().filter(|(_, to)| *to == node) {
                        if let Some((from_lane, from_at)) = left.get(&(task, event.job, *from)) {
                            arrows += 1;
                            let arrow = |ph: &str, tid: usize, ts: u64| {
                                json!({ "ph": ph, "bp": "e", "cat": "edge", "name": "edge", "id": arrows,
                                    "pid": LANES, "tid": tid, "ts": us(ts) })
                            };
                            rows.put(&arrow("s", *from_lane, from_at.saturating_sub(1)))?;
                            rows.put(&arrow("f", lane, at + 1))?;
                        }
                    }
                }
                EventKind::Completed => {
                    let start = started.remove(&key).unwrap_or(at);
                    let job = self.logs[task].jobs().get(usize::try_from(event.job).unwrap_or(usize::MAX));
                    let args = json!({ "task": self.tasks[task], "job": event.job,
                        "deadline_ns": job.map(|j| j.deadline_ns) });
                    rows.put(&json!({ "ph": "X", "cat": "node", "name": name(), "pid": LANES, "tid": lane,
                        "ts": us(start), "dur": us(at - start), "args": args }))?;
                    left.insert(key, (lane, at));
                }
                EventKind::Hit => rows.mark(&format!("hit: {} #{}", name(), event.job), TASKS, task, at)?,
                EventKind::Overran => rows.mark(&format!("overrun: {}", name()), LANES, lane, at)?,
                EventKind::Edited => rows.mark("graph edited", TASKS, task, at)?,
                EventKind::Evicted => rows.mark(&format!("evicted: {}", name()), TASKS, task, at)?,
                EventKind::Refused => rows.mark("refused: full", TASKS, task, at)?,
                _ => {}
            }
        }
        Ok(())
    }
}

struct Rows<'a, W> {
    out: &'a mut W,
    first: bool,
}

impl<W: Write> Rows<'_, W> {
    fn put(&mut self, event: &Value) -> io::Result<()> {
        if !std::mem::take(&mut self.first) {
            writeln!(self.out, ",")?;
        }
        write!(self.out, "{event}")
    }

    fn mark(&mut self, name: &str, pid: u32, tid: usize, at: u64) -> io::Result<()> {
        self.put(&json!({ "ph": "i", "s": "t", "cat": "event", "name": name, "pid": pid, "tid": tid, "ts": us(at) }))
    }
}
