//! The host in virtual time: events of one instant in their order, then dispatch, then the next instant.

use core::fmt::{self, Write};

use red_core::{Action, Dispatch, Instant, Outcome, Scheduler, TaskId, UnitId};
use red_sync::{Request, SharedScheduler, TicketLock};

use crate::rng::Rng;
use crate::workload::{self, Arrival, Common};
use crate::{Board, Order, POLICIES};

const TASKS: usize = 4;
const LANES: usize = 8;
/// Releases and edits happen before it; then what is in flight ends.
const HORIZON_NS: u64 = 15_000_000;
/// Places in the mailbox: more releases of one instant are refused there.
const LETTERS: usize = 4;

type Lock = TicketLock<Scheduler<Board>>;

/// A task, and when its next job comes.
#[derive(Clone, Copy, Debug)]
struct Source {
    task: TaskId,
    period_ns: u64,
    next_ns: u64,
}

pub(crate) struct Host {
    seed: u64,
    order: Order,
    shared: SharedScheduler<Board, Lock, 1, LETTERS>,
    sources: [Option<Source>; TASKS],
    common: Common,
    next_edit_ns: u64,
    /// When each lane ends, and what it runs.
    running: [Option<(u64, UnitId)>; LANES],
    rng: Rng,
}

impl Host {
    pub(crate) fn new(seed: u64, order: Order) -> Self {
        let rng = &mut Rng::new(seed);
        let config = workload::config(seed, rng);
        let mut scheduler = Scheduler::new(config);
        let common = workload::common(&config, rng);
        for (lanes, memory) in common.pools.into_iter().flatten() {
            let _pool = scheduler.add_pool(lanes, memory).expect("capacity for it");
        }
        let _sensor = common.sensor.map(|period| scheduler.add_sensor(period).expect("capacity for it"));
        let count = rng.within(1, TASKS as u64);
        let load = rng.within(60, 500) / count;
        let mut sources = [None; TASKS];
        for source in &mut sources[..count as usize] {
            let (dag, terms, Arrival { offset_ns, period_ns }) =
                workload::task(&common, load, rng, &mut |_| {});
            let task = scheduler.add_task(&dag, terms.timing()).expect("a random task is valid");
            *source = Some(Source { task, period_ns, next_ns: offset_ns });
        }
        Self {
            seed,
            order,
            shared: SharedScheduler::new(scheduler),
            sources,
            common,
            next_edit_ns: rng.within(0, HORIZON_NS),
            running: [None; LANES],
            rng: rng.clone(),
        }
    }

    pub(crate) fn run(mut self, out: &mut impl Write) -> fmt::Result {
        let (policy, _) = POLICIES[(self.seed % POLICIES.len() as u64) as usize];
        writeln!(out, "workload {} {policy}", self.seed)?;
        while let Some(now_ns) = self.next_instant() {
            let now = Instant::from_nanos(now_ns);
            self.report_lanes(now, out)?;
            if now_ns < HORIZON_NS {
                self.edit(now, out)?;
                self.release(now, out)?;
            }
            self.dispatch(now, out)?;
        }
        self.shared.with(|scheduler, _| writeln!(out, "{:?}", scheduler.counters()))
    }

    fn next_instant(&self) -> Option<u64> {
        let releases = self.sources.iter().flatten().map(|source| source.next_ns);
        let outside = releases.chain([self.next_edit_ns]).filter(|ns| *ns < HORIZON_NS).min();
        let finish = self.running.iter().flatten().map(|(finish_ns, _)| *finish_ns).min();
        let poll = self.shared.with(|scheduler, _| scheduler.poll_at()).map(Instant::as_nanos);
        [outside, finish, poll].into_iter().flatten().min()
    }

    fn report_lanes(&mut self, now: Instant, out: &mut impl Write) -> fmt::Result {
        for turn in 0..LANES {
            let lane = if self.order == Order::ByLane { turn } else { LANES - 1 - turn };
            let due = self.running[lane].filter(|(finish_ns, _)| *finish_ns <= now.as_nanos());
            let Some((_, unit)) = due else { continue };
            self.running[lane] = None;
            let (fails, repeats) = (self.rng.chance(3), self.rng.chance(3));
            for _ in 0..1 + u8::from(repeats) {
                self.tell(out, |scheduler, out| {
                    let told = if fails { scheduler.fail(unit, now) } else { scheduler.complete(unit, now) };
                    writeln!(out, "{} report {lane} {:x} {told:?}", now.as_nanos(), unit.to_bits())
                })?;
            }
        }
        Ok(())
    }

    /// Changes the graph of some task; what is refused is left.
    fn edit(&mut self, now: Instant, out: &mut impl Write) -> fmt::Result {
        if self.next_edit_ns != now.as_nanos() {
            return Ok(());
        }
        self.next_edit_ns = now.as_nanos() + self.rng.within(1, 4_000_000);
        let source = self.sources[self.rng.index(TASKS)];
        let edit = source.and_then(|source| self.shared.with(|scheduler, _| scheduler.edit(source.task)));
        let Some(mut edit) = edit else { return Ok(()) };
        for _ in 0..self.rng.within(1, 3) {
            workload::change(&mut edit, &self.common, &mut self.rng);
        }
        self.tell(out, |scheduler, out| {
            let answer = scheduler.commit(&edit, now).map(|certificate| certificate.margin());
            writeln!(out, "{} commit {answer:?}", now.as_nanos())
        })
    }

    /// Posts what is due, as an interrupt would, and then applies it, as a lane would.
    fn release(&mut self, now: Instant, out: &mut impl Write) -> fmt::Result {
        for source in self.sources.iter_mut().flatten().filter(|source| source.next_ns == now.as_nanos()) {
            source.next_ns += source.period_ns;
            let capture = self.rng.chance(20).then(|| now.as_nanos() / 2_000_000);
            // Now and then the host learns of a release late.
            let late_ns =
                if self.rng.chance(10) { self.rng.within(0, now.as_nanos().min(300_000)) } else { 0 };
            let at = Instant::from_nanos(now.as_nanos() - late_ns);
            let post = self.shared.producer(0).expect("nobody else posts");
            if let Err(lost) = post.push(Request { task: source.task, at, capture }) {
                writeln!(out, "{} lost {:?}", now.as_nanos(), lost.task)?;
            }
        }
        self.shared.with(|scheduler, requests| {
            while let Some(Request { task, at, capture }) = requests.next() {
                let answer = scheduler.release_at(task, at, capture, now);
                writeln!(out, "{} release {} {answer:?}", now.as_nanos(), task.index())?;
                write_events(scheduler, out)?;
            }
            Ok(())
        })
    }

    fn dispatch(&mut self, now: Instant, out: &mut impl Write) -> fmt::Result {
        if self.rng.chance(3) {
            // The scheduler holds its time, and answers as if the clock had not moved.
            let before = Instant::from_nanos(now.as_nanos().saturating_sub(self.rng.within(1, 100_000)));
            self.act(before, now, out)?;
        }
        while self.act(now, now, out)? {}
        Ok(())
    }

    /// One question at `at`, which is `now` or a step back, and what it answers. Whether there was an answer.
    fn act(&mut self, at: Instant, now: Instant, out: &mut impl Write) -> Result<bool, fmt::Error> {
        let Self { shared, running, rng, .. } = self;
        shared.with(|scheduler, _| {
            let action = scheduler.poll(at);
            match action {
                Some(Action::Dispatch(started)) => {
                    let wcet_ns = write_dispatch(scheduler, started, now, out)?;
                    let percent = if rng.chance(5) { rng.within(100, 250) } else { rng.within(30, 100) };
                    let finish_ns = now.as_nanos() + wcet_ns * percent / 100;
                    running[started.lane.index()] = Some((finish_ns, started.unit));
                }
                Some(Action::Preempt(stopped)) => {
                    running[stopped.lane.index()] = None;
                    writeln!(out, "{} preempt {:x}", now.as_nanos(), stopped.unit.to_bits())?;
                }
                Some(Action::Ended(outcome)) => write_outcome(&outcome, now, out)?,
                Some(other) => writeln!(out, "{} {other:?}", now.as_nanos())?,
                None => {}
            }
            write_events(scheduler, out)?;
            Ok(action.is_some())
        })
    }

    fn tell<W: Write>(
        &mut self,
        out: &mut W,
        call: impl FnOnce(&mut Scheduler<Board>, &mut W) -> fmt::Result,
    ) -> fmt::Result {
        self.shared.with(|scheduler, _| {
            call(scheduler, out)?;
            write_events(scheduler, out)
        })
    }
}

/// Writes a dispatch with all its members; the longest of their WCETs.
fn write_dispatch(
    scheduler: &Scheduler<Board>,
    started: Dispatch,
    now: Instant,
    out: &mut impl Write,
) -> Result<u64, fmt::Error> {
    write!(out, "{} start {} {:x}", now.as_nanos(), started.lane.index(), started.unit.to_bits())?;
    let mut longest_ns = 0;
    for member in scheduler.members(started.unit) {
        let node = scheduler.task_node(member.task, member.node).map(|(node, _)| node.wcet().as_nanos());
        longest_ns = node.unwrap_or(0).max(longest_ns);
        let (task, node, due) = (member.task.index(), member.node.index(), member.sub_deadline.as_nanos());
        write!(out, " {task}.{}.{node}@{due}", member.index)?;
    }
    writeln!(out)?;
    Ok(longest_ns)
}

fn write_outcome(outcome: &Outcome, now: Instant, out: &mut impl Write) -> fmt::Result {
    let (task, shed) = (outcome.task.index(), outcome.shed.map_or("done", |reason| reason.name()));
    let lateness = outcome.lateness().as_nanos();
    writeln!(out, "{} end {task}.{} {shed} {lateness}", now.as_nanos(), outcome.index)
}

fn write_events(scheduler: &mut Scheduler<Board>, out: &mut impl Write) -> fmt::Result {
    while let Some(event) = scheduler.take_event() {
        let (task, node, lane) = (event.task.index(), event.node.index(), event.lane.index());
        writeln!(out, "{} {:?} {task}.{}.{node} {lane}", event.at.as_nanos(), event.kind, event.job)?;
    }
    Ok(())
}
