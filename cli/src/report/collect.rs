//! A run as plain data, from a replay that is followed.

use super::graphs;
use crate::replay::figures::Figures;
use red_core::{Bytes, Capacity, Event, EventKind, Gate, Scheduler, TaskId, UnitId};
use red_record::{Answer, Call, Entry};
use red_report::model::{Hit, Job, Lane, Pool, Run, Slice, SubJob, Task};
use red_workload::build::Numbered;
use red_workload::metrics::TaskLog;
use red_workload::model::Workload;
use std::collections::HashMap;

/// Follows a replay.
pub(super) struct Collector {
    /// What is known so far.
    pub(super) run: Run,
    /// Ends of jobs, as metrics want them.
    pub(super) logs: Vec<TaskLog>,
    /// Value, and m and k of the floor, of each task.
    pub(super) ranks: Vec<(u32, Option<(u32, u32)>)>,
    /// What happened to lanes, and what a simulation takes over.
    pub(super) figures: Figures,
    /// The task of [`Run::tasks`] in each place of the scheduler.
    places: HashMap<usize, usize>,
    /// Newest graph of each task.
    newest: Vec<usize>,
    /// Slices that have not ended, by lane.
    on_lane: HashMap<usize, Vec<usize>>,
    /// Units that were given to their lanes before they start.
    ahead: HashMap<usize, UnitId>,
}

impl Collector {
    /// Of a run of a workload, whose tasks the scheduler calls `ids`.
    pub(super) fn new<C: Capacity>(
        workload: &Workload,
        nodes: &[Vec<Numbered>],
        scheduler: &Scheduler<C>,
        ids: &[TaskId],
    ) -> Self {
        let mut collector = Self::of(Figures::new(workload, nodes.to_vec()));
        collector.run.level_gate = scheduler.config().gate == Gate::Level;
        for pool in &workload.pools {
            collector.pool(pool.name.clone(), pool.lanes as usize, pool.memory_bytes.is_some());
        }
        for ((task, nodes), id) in workload.tasks.iter().zip(nodes).zip(ids) {
            let nodes = nodes.iter().map(|node| node.name.clone()).collect();
            collector.task(
                task.name.clone(),
                task.deadline_ns,
                (task.value, task.floor),
                nodes,
                scheduler,
                *id,
            );
        }
        collector
    }

    /// Of a run whose scheduler is set up by calls, and was configured just now.
    pub(super) fn by_calls() -> Self {
        Self::of(Figures::of_lanes())
    }

    fn of(figures: Figures) -> Self {
        Self {
            run: Run::default(),
            logs: Vec::new(),
            ranks: Vec::new(),
            figures,
            places: HashMap::new(),
            newest: Vec::new(),
            on_lane: HashMap::new(),
            ahead: HashMap::new(),
        }
    }

    fn pool(&mut self, name: String, lanes: usize, is_limited: bool) {
        let pool = self.run.pools.len();
        self.run.lanes.extend((0..lanes).map(|lane| Lane { name: format!("{name} lane {lane}"), pool }));
        self.run.pools.push(Pool { name, is_limited, busy_ns: 0 });
    }

    fn task<C: Capacity>(
        &mut self,
        name: String,
        deadline_ns: u64,
        rank: (u32, Option<(u32, u32)>),
        nodes: Vec<String>,
        scheduler: &Scheduler<C>,
        id: TaskId,
    ) {
        self.places.insert(id.index(), self.run.tasks.len());
        self.run.tasks.push(Task { name, deadline_ns, nodes, ..Task::default() });
        self.run.jobs.push(Vec::new());
        self.logs.push(TaskLog::default());
        self.ranks.push(rank);
        self.newest.push(self.run.graphs.len());
        self.run.graphs.push(scheduler.edit(id).map(|dag| graphs::of(&dag)).unwrap_or_default());
    }

    /// The next entry, which was as recorded, and what the scheduler recorded at it.
    pub(super) fn watch<C: Capacity>(&mut self, scheduler: &Scheduler<C>, entry: &Entry, events: &[Event]) {
        self.figures.watch(scheduler, entry, events);
        if self.run.pools.is_empty() {
            let config = scheduler.config();
            self.run.level_gate = config.gate == Gate::Level;
            self.pool("pool-0".to_owned(), config.lanes.into(), config.memory.is_some());
        }
        match (entry.call, entry.answer) {
            (Call::AddPool { lanes, memory }, Answer::Pool(Ok(pool))) => {
                let memory: Option<Bytes> = memory;
                self.pool(format!("pool-{}", pool.index()), lanes.into(), memory.is_some());
            }
            (Call::AddTask { deadline, value, floor: [m, k], .. }, Answer::Task(Ok(id))) => {
                // In a place that another task had, it is another one all the same.
                let again = self.places.contains_key(&id.index());
                let number = if again { self.run.tasks.len() } else { id.index() };
                let rank = (value, (k > 0).then_some((m.into(), k.into())));
                self.task(format!("task-{number}"), deadline.as_nanos(), rank, Vec::new(), scheduler, id);
            }
            (Call::StoodStill(time), _) => {
                let until_ns = entry.now.as_nanos();
                self.run.standstills.push((until_ns.saturating_sub(time.as_nanos()), until_ns));
            }
            (Call::Release { task, at, .. }, Answer::Released(answer)) => {
                self.released(task, at.as_nanos(), entry.now.as_nanos(), answer.is_ok());
            }
            (_, Answer::Ahead(started)) => drop(self.ahead.insert(started.unit.lane().index(), started.unit)),
            _ => {}
        }
        let started = match entry.answer {
            Answer::Started(started) => Some(started.unit),
            _ => None,
        };
        for (i, event) in events.iter().enumerate() {
            self.event(scheduler, event, started, &events[..i]);
        }
        match (entry.call, entry.answer) {
            // What nobody wanted any more has no event.
            (Call::Complete(unit) | Call::Fail(unit), Answer::Reported(_))
                if scheduler.unit(unit).is_none() =>
            {
                self.leave(unit.lane().index(), entry.now.as_nanos(), started);
            }
            (_, Answer::Ended(outcome)) => {
                let Some(task) = self.places.get(&outcome.task.index()).copied() else { return };
                self.logs[task].ended(&outcome);
                let job =
                    usize::try_from(outcome.index).ok().and_then(|job| self.run.jobs[task].get_mut(job));
                if let Some(job) = job {
                    job.end_ns = Some(outcome.at.as_nanos());
                    job.shed = outcome.shed.map(|reason| reason.name().to_owned());
                }
            }
            (Call::End, _) => {
                self.run.end_ns = entry.now.as_nanos();
                let counters = scheduler.counters();
                (self.run.units, self.run.saved) = (counters.units, counters.encoder_runs_saved);
                let open: Vec<usize> = self.on_lane.keys().copied().collect();
                open.into_iter().for_each(|lane| self.leave(lane, self.run.end_ns, None));
            }
            _ => {}
        }
    }

    fn released(&mut self, task: TaskId, release_ns: u64, recorded_ns: u64, is_taken: bool) {
        let Some(task) = self.places.get(&task.index()).copied() else { return };
        let deadline_ns = release_ns.saturating_add(self.run.tasks[task].deadline_ns);
        let log = &mut self.logs[task];
        if is_taken {
            log.released(release_ns, deadline_ns);
        } else {
            log.refused(release_ns, deadline_ns);
        }
        self.run.jobs[task].push(Job {
            release_ns,
            recorded_ns: recorded_ns.max(release_ns),
            deadline_ns,
            end_ns: (!is_taken).then_some(release_ns),
            shed: (!is_taken).then(|| "full".to_owned()),
            graph: self.newest[task],
            counts: false,
        });
    }

    /// `unit` is the one that starts, `before` what happened before in the same call.
    fn event<C: Capacity>(
        &mut self,
        scheduler: &Scheduler<C>,
        event: &Event,
        unit: Option<UnitId>,
        before: &[Event],
    ) {
        let at_ns = event.at.as_nanos();
        let Some(task) = self.places.get(&event.task.index()).copied() else { return };
        let of = (task, event.job, event.node.index());
        let lane = event.lane.index();
        match event.kind {
            EventKind::Started => {
                let unit = unit.filter(|unit| unit.lane() == event.lane).or_else(|| self.ahead.remove(&lane));
                let due = unit.and_then(|unit| {
                    let is_meant =
                        |member: &red_core::Member| (member.index, member.node) == (event.job, event.node);
                    scheduler.members(unit).find(|member| member.task == event.task && is_meant(member))
                });
                let number = unit.map_or(0, |unit| unit.to_bits() >> 16);
                let of_unit = |slice: &usize| self.run.slices[*slice].unit == number;
                if !self.on_lane.get(&lane).is_none_or(|open| open.iter().all(of_unit)) {
                    self.leave(lane, at_ns, None);
                }
                self.on_lane.entry(lane).or_default().push(self.run.slices.len());
                let due_ns = due.map(|member| member.sub_deadline.as_nanos());
                self.run.slices.push(Slice {
                    of,
                    lane,
                    start_ns: at_ns,
                    end_ns: at_ns,
                    due_ns,
                    completed: false,
                    unit: number,
                });
            }
            EventKind::Completed => self.ended(lane, of, at_ns, true),
            EventKind::Preempted => self.ended(lane, of, at_ns, false),
            EventKind::Hit => {
                let by = before.iter().rev().find_map(|event| self.encoder(event)).filter(|by| *by != of);
                self.run.hits.push(Hit { of, at_ns, by });
            }
            EventKind::Warned => self.logs[task].warned(event.job, at_ns),
            EventKind::Edited => self.edited(scheduler, event.task, task, at_ns),
            _ => {}
        }
    }

    /// The encoder whose end an event tells.
    fn encoder(&self, event: &Event) -> Option<SubJob> {
        let task = *self.places.get(&event.task.index())?;
        let graph = self.run.graphs.get(self.run.job(task, event.job)?.graph)?;
        let is_encoder = graph.nodes.get(&event.node.index())?.is_encoder;
        (event.kind == EventKind::Completed && is_encoder).then_some((task, event.job, event.node.index()))
    }

    fn edited<C: Capacity>(&mut self, scheduler: &Scheduler<C>, id: TaskId, task: usize, at_ns: u64) {
        let Some(graph) = scheduler.edit(id).map(|dag| graphs::of(&dag)) else { return };
        let words =
            graphs::difference(&self.run.graphs[self.newest[task]], &graph, |node| self.run.node(task, node));
        let of_task =
            if self.run.tasks.len() > 1 { format!("{}: ", self.run.task(task)) } else { String::new() };
        self.run.edits.push((at_ns, format!("{of_task}{words}")));
        self.newest[task] = self.run.graphs.len();
        self.run.graphs.push(graph);
    }

    /// A sub-job left its lane.
    fn ended(&mut self, lane: usize, of: SubJob, at_ns: u64, completed: bool) {
        let Some(open) = self.on_lane.get_mut(&lane) else { return };
        if let Some(place) = open.iter().position(|slice| self.run.slices[*slice].of == of) {
            let slice = &mut self.run.slices[open.remove(place)];
            (slice.end_ns, slice.completed) = (at_ns, completed);
        }
    }

    /// All that is on a lane has left it, but for what starts on it now.
    fn leave(&mut self, lane: usize, at_ns: u64, starts: Option<UnitId>) {
        let starts = starts.map(|unit| unit.to_bits() >> 16);
        let Some(open) = self.on_lane.get_mut(&lane) else { return };
        open.retain(|slice| {
            let slice = &mut self.run.slices[*slice];
            if Some(slice.unit) != starts {
                slice.end_ns = at_ns;
            }
            Some(slice.unit) == starts
        });
    }
}
