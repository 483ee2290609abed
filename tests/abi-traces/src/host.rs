//! The executor in virtual time: what lanes report, what happens, what is to be started, and so on to the next instant.
//! Every call and its answer is a line, and behind it are the events that it made.

use std::io::{self, Write};

use red_core::{Action, Capacity, Dag, Instant, LaneId, NodeId, Outcome, PoolId, Scheduler, TaskId, UnitId};

use crate::script::{Event, Fate, How, INSTANTS, Script};
use crate::text::class;
use crate::words::{answer, config, event, or_none, shed};

/// No execution takes longer, whatever its WCET.
const LONGEST_NS: u64 = 1_000_000_000;

/// What runs on a lane: until when, and what its first member is.
#[derive(Clone, Copy)]
struct Running {
    finish_ns: u64,
    unit: UnitId,
    fate: Fate,
    task: TaskId,
    node: NodeId,
}

pub(crate) struct Host<'a, C: Capacity> {
    pub(crate) script: &'a Script,
    pub(crate) core: Box<Scheduler<C>>,
    pub(crate) out: &'a mut dyn Write,
    /// By pool.
    pub(crate) lanes: Vec<u8>,
    /// The newest name of each task, and how often it was released.
    pub(crate) tasks: Vec<(TaskId, u64)>,
    pub(crate) edits: [Option<Box<Dag<C>>>; 2],
    running: Vec<Option<Running>>,
    /// Units so far, and events.
    started: usize,
    happened: usize,
    pub(crate) now: u64,
}

/// Writes the trace of a workload.
pub(crate) fn run<C: Capacity>(script: &Script, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "workload {} {} {}", script.seed, class(script.class), script.policy)?;
    writeln!(out, "preset {}", config(&script.preset))?;
    let mut core = Box::new(Scheduler::<C>::new(script.config));
    writeln!(out, "config {}", config(core.config()))?;
    let mut lanes = vec![script.config.lanes];
    for (more, memory) in &script.pools {
        let added = core.add_pool(*more, *memory);
        lanes.extend(added.ok().map(|_| *more));
        writeln!(out, "pool {}", answer(added.map(PoolId::index)))?;
    }
    for period in &script.sensors {
        let added = core.add_sensor(*period);
        writeln!(out, "sensor {}", answer(added.map(|sensor| sensor.index())))?;
    }
    let host = Host {
        script,
        core,
        out,
        lanes,
        tasks: vec![(TaskId::from_bits(u32::MAX), 0); script.tasks.len()],
        edits: [None, None],
        running: vec![None; C::LANES],
        started: 0,
        happened: 0,
        now: 0,
    };
    host.play()
}

impl<C: Capacity> Host<'_, C> {
    fn play(mut self) -> io::Result<()> {
        for _ in 0..INSTANTS {
            let Some(now) = self.next() else { break };
            self.now = now;
            for lane in 0..self.running.len() {
                self.report(lane)?;
            }
            while let Some((at_ns, what)) =
                self.script.events.get(self.happened).filter(|(at_ns, _)| *at_ns <= now)
            {
                debug_assert_eq!(*at_ns, now);
                self.happened += 1;
                self.happen(what)?;
                self.tell()?;
            }
            while self.poll(now)? {}
            self.figures()?;
        }
        debug_assert!(self.next().is_none(), "workload {} never ends", self.script.seed);
        writeln!(self.out, "end {}", self.now)
    }

    fn next(&self) -> Option<u64> {
        let event = self.script.events.get(self.happened).map(|(at_ns, _)| *at_ns);
        let finish = self.running.iter().flatten().map(|running| running.finish_ns).min();
        let poll = self.core.poll_at().map(Instant::as_nanos);
        [event, finish, poll].into_iter().flatten().min()
    }

    /// A lane whose unit is over says so.
    fn report(&mut self, lane: usize) -> io::Result<()> {
        let Some(Running { unit, fate, task, node, .. }) =
            self.running[lane].filter(|it| it.finish_ns <= self.now)
        else {
            return Ok(());
        };
        self.running[lane] = None;
        for _ in 0..1 + u8::from(fate.repeats) {
            let now = self.instant();
            let (done, next) = match fate.how {
                How::Complete | How::PollOn => (self.core.complete(unit, now), None),
                How::Fail => (self.core.fail(unit, now), None),
                How::CompleteAndPoll => match self.core.complete_and_poll(unit, now) {
                    Ok(action) => (Ok(()), action),
                    Err(error) => (Err(error), None),
                },
            };
            let told = answer(done.map(|()| "ok"));
            writeln!(self.out, "{} report {lane} {} {:?} {told}", self.now, unit.to_bits(), fate.how)?;
            self.tell()?;
            next.map_or(Ok(()), |action| self.act(action))?;
        }
        let took = self.core.task_node(task, node).map(|(_, took)| {
            let (mean, least, most) = (took.mean(), took.minimum(), took.maximum());
            let ns = |time: Option<red_core::Duration>| or_none(time.map(|time| time.as_nanos()));
            format!("{} {} {}", or_none(mean.map(|mean| mean.as_nanos())), ns(least), ns(most))
        });
        writeln!(self.out, "{} took {}", self.now, took.as_deref().unwrap_or("unknown"))?;
        if matches!(fate.how, How::PollOn) {
            let now = self.instant();
            let action = self.core.poll_on(LaneId::new(lane as u8), now);
            self.asked(action)?;
        }
        Ok(())
    }

    /// One question at a time, and whether there was an answer.
    pub(crate) fn poll(&mut self, at_ns: u64) -> io::Result<bool> {
        let action = self.core.poll(Instant::from_nanos(at_ns));
        self.asked(action)
    }

    fn asked(&mut self, action: Option<Action>) -> io::Result<bool> {
        let is_some = action.is_some();
        match action {
            Some(action) => self.act(action)?,
            None => writeln!(self.out, "{} nothing", self.now)?,
        }
        self.tell()?;
        Ok(is_some)
    }

    fn act(&mut self, action: Action) -> io::Result<()> {
        match action {
            Action::Dispatch(started) => self.start(started.lane.index(), started.unit),
            Action::Preempt(stopped) => {
                self.running[stopped.lane.index()] = None;
                writeln!(self.out, "{} preempt {} {}", self.now, stopped.lane.index(), stopped.unit.to_bits())
            }
            Action::Ended(outcome) => self.ended(&outcome),
            other => writeln!(self.out, "{} {other:?}", self.now),
        }
    }

    fn start(&mut self, lane: usize, unit: UnitId) -> io::Result<()> {
        let fate = self.script.fates[self.started % self.script.fates.len()];
        self.started += 1;
        let Some(data) = self.core.unit(unit) else {
            return writeln!(self.out, "{} start {lane} {} unknown", self.now, unit.to_bits());
        };
        let (task, node, wcet_ns) = (data.first.task, data.first.node, data.wcet.as_nanos());
        let finish_ns = self.now + wcet_ns.min(LONGEST_NS) * fate.percent / 100;
        self.running[lane] = Some(Running { finish_ns, unit, fate, task, node });
        let (pool, output) = (data.pool.index(), or_none(data.output.map(u64::from)));
        let began = data.started.as_nanos();
        write!(self.out, "{} start {lane} {} {pool} {output} {began} {wcet_ns}", self.now, unit.to_bits())?;
        let members: Vec<_> = self.core.members(unit).collect();
        // The first of the unit is one of its members.
        for m in [data.first].into_iter().chain(members) {
            let (task, job, node) = (m.task.to_bits(), m.job.to_bits(), m.node.index());
            let (release, deadline, due) =
                (m.release.as_nanos(), m.deadline.as_nanos(), m.sub_deadline.as_nanos());
            write!(self.out, " {task}.{}.{node}:{job}@{release},{deadline},{due}", m.index)?;
        }
        writeln!(self.out)
    }

    pub(crate) fn ended(&mut self, o: &Outcome) -> io::Result<()> {
        let (task, job, why) = (o.task.to_bits(), o.job.to_bits(), shed(o.shed));
        let (release, deadline, at) = (o.release.as_nanos(), o.deadline.as_nanos(), o.at.as_nanos());
        writeln!(self.out, "{} end {task}.{}:{job} {release} {deadline} {at} {why}", self.now, o.index)
    }

    /// The events of the last call.
    fn tell(&mut self) -> io::Result<()> {
        while let Some(e) = self.core.take_event() {
            let (task, node, lane) = (e.task.to_bits(), e.node.index(), e.lane.index());
            writeln!(self.out, "  {} {} {task}.{}.{node} {lane}", e.at.as_nanos(), event(e.kind), e.job)?;
        }
        Ok(())
    }

    /// When to ask again, what pools hold, and what is counted.
    fn figures(&mut self) -> io::Result<()> {
        let at = or_none(self.core.poll_at().map(Instant::as_nanos));
        write!(self.out, "{} until {at} holding", self.now)?;
        for pool in 0..self.lanes.len() {
            write!(self.out, " {}", self.core.memory_used(PoolId::new(pool as u8)).0)?;
        }
        let (core, so_far) = (&self.core, self.core.counters());
        writeln!(
            self.out,
            " counting {} {} {} {} {} {} {} {} {} {} {} {}",
            so_far.units,
            so_far.encoder_runs_saved,
            so_far.overruns,
            so_far.clock_steps_back,
            so_far.late_completions,
            so_far.evictions,
            core.events_dropped(),
            core.lanes(),
            core.jobs_in_flight(),
            core.ready_sub_jobs(),
            core.running_units(),
            u8::from(core.can_dispatch()),
        )
    }

    pub(crate) const fn instant(&self) -> Instant {
        Instant::from_nanos(self.now)
    }

    fn happen(&mut self, what: &Event) -> io::Result<()> {
        match what {
            Event::Admit(task) => self.admit(*task),
            Event::Release { task, at_ns, capture } => self.release(*task, *at_ns, *capture),
            Event::Remove(task) => self.remove(*task),
            Event::Begin { place, task } => self.begin(*place, *task),
            Event::Change { place, step } => self.change(*place, step),
            Event::Commit(place) => self.commit(*place),
            Event::Drop(place) => {
                self.edits[*place] = None;
                writeln!(self.out, "{} drop {place}", self.now)
            }
            Event::Retire(lane) => self.retire(*lane),
            Event::Restore(lane) => self.restore(*lane),
            Event::Stray { unit, task } => self.stray(*unit, *task),
            Event::Back(ns) => self.poll(self.now.saturating_sub(*ns)).map(drop),
            Event::Take => self.take(),
        }
    }
}
