//! From the core's events to the rows of a schedule, and to the report.

use crate::host::Host;
use crate::report::{PoolMetrics, Report, Row};
use red_core::{Event, EventKind};
use red_workload::build::{Numbered, Role};
use red_workload::metrics::{TaskMetrics, summarise};

impl Host<'_> {
    /// Hits outside of a dispatch; everything else is told by actions.
    pub(crate) fn note_events(&mut self) {
        while let Some(event) = self.scheduler.take_event().copied() {
            if event.kind == EventKind::Hit {
                self.row(&event, None, event.at.as_nanos());
            }
        }
    }

    /// Members of the unit that just started, and hits that its start allowed.
    pub(crate) fn note_rows(&mut self, finish: u64) {
        while let Some(event) = self.scheduler.take_event().copied() {
            match event.kind {
                EventKind::Started => self.row(&event, Some(event.lane.index()), finish),
                EventKind::Hit => self.row(&event, None, event.at.as_nanos()),
                _ => {}
            }
        }
    }

    pub(crate) fn note_preempted(&mut self, now: u64, left: (u64, u64)) {
        while let Some(event) = self.scheduler.take_event().copied() {
            if event.kind != EventKind::Preempted {
                continue;
            }
            let (task, node) = (event.task.index(), event.node.index());
            let names = (&self.workload.tasks[task].name, &self.nodes[task][node].name);
            let row = self.rows.iter_mut().rev().find(|r| r.job == event.job && (&r.task, &r.node) == names);
            if let Some(row) = row {
                row.finish_ns = now;
            }
            if let Some(job) = self.scheduler.job_id(event.task, event.job) {
                self.suspended.insert((job, event.node), left);
            }
        }
    }

    pub(crate) fn row(&mut self, event: &Event, lane: Option<usize>, finish_ns: u64) {
        if !self.options.schedule {
            return;
        }
        let (task, node) = (event.task.index(), event.node.index());
        let node = &self.nodes[task][node];
        let pool = lane.map_or_else(|| pool_of_node(node), |lane| self.pool_of(lane));
        let first = self.first_lane[pool];
        self.rows.push(Row {
            task: self.workload.tasks[task].name.clone(),
            job: event.job,
            node: node.name.clone(),
            pool: self.workload.pools[pool].name.clone(),
            lane: lane.map(|lane| u32::try_from(lane - first).unwrap_or(u32::MAX)),
            start_ns: event.at.as_nanos(),
            finish_ns,
        });
    }

    pub(crate) fn report(mut self) -> Report {
        // By what is printed: (start, pool, lane, task, job, node), hits before lane 0.
        let mut rows = std::mem::take(&mut self.rows);
        rows.sort_by(|a, b| {
            let key = |r: &Row| (r.start_ns, r.lane, r.job);
            let ((start_a, lane_a, job_a), (start_b, lane_b, job_b)) = (key(a), key(b));
            let first = start_a.cmp(&start_b).then_with(|| a.pool.cmp(&b.pool)).then(lane_a.cmp(&lane_b));
            first.then_with(|| a.task.cmp(&b.task)).then(job_a.cmp(&job_b)).then_with(|| a.node.cmp(&b.node))
        });
        let named = self.workload.tasks.iter().zip(&self.logs).enumerate();
        let tasks = named.map(|(number, (task, log))| TaskMetrics {
            nodes: self.executions.of(number),
            ..summarise(task, log, self.horizon, self.horizon)
        });
        let pools = self.workload.pools.iter().zip(&self.busy);
        let counters = self.scheduler.counters();
        Report {
            policy: self.options.policy.name(),
            seed: self.options.seed,
            horizon_ns: self.options.horizon_ns,
            tasks: tasks.collect(),
            nodes_missed: self.nodes_missed,
            units_dispatched: counters.units,
            encoder_runs_saved: counters.encoder_runs_saved,
            pools: pools
                .map(|(p, busy)| PoolMetrics { name: p.name.clone(), lanes: p.lanes, busy_ns: *busy })
                .collect(),
            schedule: self.options.schedule.then_some(rows),
            sheds: self.options.schedule.then_some(self.sheds),
            jobs: self.logs.iter().map(|log| log.jobs().to_vec()).collect(),
        }
    }
}

/// Pool of a node by the file, for rows without a lane.
fn pool_of_node(node: &Numbered) -> usize {
    match &node.role {
        Role::Plain(part) | Role::Encoder { part, .. } | Role::Decoder { part, .. } => part.pool,
        Role::Coarse(stage) => stage.encoder.pool,
    }
}
