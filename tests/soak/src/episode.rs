//! One random workload on real threads for a few seconds, with bodies that go wrong, recorded and replayed.

use crate::judge::{Judge, Robot, Seen};
use red_core::{CommitError, Empty, Scheduler, TaskId};
use red_record::{Header, Reader, Writer, replay};
use red_rt::handler::{Failed, Handler, Work};
use red_rt::placement::{choose_cpus, usable_cpus};
use red_rt::runtime::{Control, Mode, Setup, run};
use red_rt::timeline::Releases;
use red_tests::rng::{Rng, Shape, random_workload};
use red_workload::build::{self, Plan};
use red_workload::model::{Arrival, Workload};
use red_workload::policy::Policy;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use std::process::{self, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant};

/// Releases come for so long.
const RELEASES: Duration = Duration::from_millis(1_500);
/// Every job has ended long before, unless it was forgotten.
const DRAIN: Duration = Duration::from_secs(60);
/// Releases from outside come in bursts of so many.
const BURST: usize = 12;

/// What an episode did.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Done {
    pub(crate) seen: Seen,
    pub(crate) units: u64,
    /// Bodies that failed, panicked or hung.
    pub(crate) faults: u64,
    pub(crate) inputs: u64,
    pub(crate) realtime: bool,
    /// A signal came.
    pub(crate) stopped: bool,
}

/// Bodies: they sleep or spin for a part of their WCET, and now and then go wrong.
struct Bodies {
    seed: u64,
    ran: Arc<AtomicU64>,
    spins: bool,
}

impl Handler for Bodies {
    fn run(&mut self, work: &Work) -> Result<(), Failed> {
        self.ran.fetch_add(1, Ordering::Relaxed);
        let node = (work.task as u64) << 8 | work.node.index() as u64;
        let mut rng = Rng::new(self.seed ^ work.job.rotate_left(20) ^ node.rotate_left(48));
        let took = Duration::from_nanos(work.wcet_ns * rng.within(0, 90) / 100);
        match rng.within(0, 1_999) {
            0..3 => return Err(Failed),
            3..6 => panic!("planted"),
            // Past the bound of 10 times the WCET and 100 ms.
            6 if work.wcet_ns < 1_000_000 => thread::sleep(Duration::from_millis(140)),
            _ if self.spins => {
                let until = Instant::now() + took;
                while Instant::now() < until {
                    std::hint::spin_loop();
                }
            }
            _ => thread::sleep(took),
        }
        Ok(())
    }
}

/// Runs the episode of a seed. Its log is left at `log` when something was wrong.
pub(crate) fn episode(seed: u64, log: &Path) -> Result<Done, String> {
    let rng = &mut Rng::new(seed);
    let realtime = rng.chance(40);
    let pools = if realtime { 1 } else { 2 };
    let shape = Shape { pools, nodes: 12, memory: false, sync: false, ..Shape::default() };
    let mut workload = random_workload(seed, &shape);
    if realtime {
        workload.pools[0].lanes = 1;
    }
    let policy = Policy::ALL[rng.index(5)];
    let (scheduler, plan, tasks) = built(&workload, policy);
    let lanes: usize = workload.pools.iter().map(|pool| pool.lanes as usize).sum();
    let judge = Judge::new(built(&workload, policy).0, &plan, &tasks, lanes);
    let (writer, tape) =
        Writer::start(log, &header(policy)).map_err(|e| format!("{}: {e}", log.display()))?;
    let ran = Arc::new(AtomicU64::new(0));
    let handlers = {
        let ran = ran.clone();
        move |_lane| -> Box<dyn Handler> { Box::new(Bodies { seed, ran: ran.clone(), spins: realtime }) }
    };
    let cpus = usable_cpus().and_then(|usable| choose_cpus(lanes, &usable));
    let mode = match cpus {
        Ok(cpus) if realtime => Mode::RealTime { priority: 60, cpus },
        _ => Mode::BestEffort,
    };
    let mut setup = Setup {
        scheduler,
        lanes,
        mode,
        releases: releases(&workload, &tasks),
        duration_ns: RELEASES.as_nanos() as u64,
        drain_ns: DRAIN.as_nanos() as u64,
        tape: Some(tape),
        handlers: Arc::new(handlers),
        enclose: Arc::new(|main: Box<dyn FnOnce() + Send>| main()),
    };
    if realtime && red_rt::setup::lock_memory().is_err() {
        setup.mode = Mode::BestEffort;
    }
    if rng.chance(20) {
        stop_and_go_on();
    }
    let over = Arc::new(AtomicBool::new(false));
    let started = |control: Arc<dyn Control>| burst(&control, &tasks, seed, &over);
    let finished = run(setup, judge, started, |_now| {});
    over.store(true, Ordering::Relaxed);
    let (mut judge, report) = finished.map_err(|e| e.to_string())?;
    let (totals, failed) = writer.finish();
    let stopped = report.stopped_by.is_some();
    if !stopped {
        judge.none_forgotten();
    }
    let ran = ran.load(Ordering::Relaxed);
    let wrong = [
        judge.wrong.take(),
        failed.map(|e| format!("the log: {e}")),
        (totals.dropped > 0).then(|| format!("{} inputs were not recorded", totals.dropped)),
        (report.events_dropped > 0).then(|| format!("{} events were dropped", report.events_dropped)),
        // A hung lane's unit may be discarded before its body began.
        (report.hung == 0 && !stopped && ran != report.counters.units)
            .then(|| format!("{} units, {ran} bodies", report.counters.units)),
        replayed(log, &workload, policy).err(),
    ];
    if let Some(wrong) = wrong.into_iter().flatten().next() {
        return Err(format!("policy {policy}, {lanes} lanes: {wrong}"));
    }
    Ok(Done {
        seen: judge.seen,
        units: report.counters.units,
        faults: report.failed + report.hung,
        inputs: totals.entries,
        realtime: report.realtime,
        stopped,
    })
}

fn built(workload: &Workload, policy: Policy) -> (Box<Scheduler<Robot>>, Plan<Robot>, Vec<TaskId>) {
    let mut scheduler: Box<Scheduler<Robot>> = Box::new(Scheduler::EMPTY);
    let (plan, tasks) =
        build::admit(&mut scheduler, workload, policy.config()).expect("random workloads are valid");
    (scheduler, plan, tasks)
}

fn header(policy: Policy) -> Header {
    Header {
        program: "soak".to_owned(),
        capacities: Header::capacities_of::<Robot>(),
        policy: policy.name().to_owned(),
        duration_ns: RELEASES.as_nanos() as u64,
        realtime: false,
        file: "random".to_owned(),
        format: "toml".to_owned(),
        workload: String::new(),
    }
}

fn releases(workload: &Workload, tasks: &[TaskId]) -> Vec<Releases> {
    let by_clock = workload.tasks.iter().zip(tasks).filter_map(|(task, id)| {
        let period_ns = match task.arrival {
            Arrival::Periodic { period_ns } => Some(period_ns),
            Arrival::Once => None,
            Arrival::Sporadic { .. } => return None,
        };
        Some(Releases { task: *id, first_ns: task.offset_ns, period_ns })
    });
    by_clock.collect()
}

/// Releases from threads that are no lanes, in bursts, until the run is over.
fn burst(control: &Arc<dyn Control>, tasks: &[TaskId], seed: u64, over: &Arc<AtomicBool>) {
    for producer in 0..2 {
        let (control, tasks, over) = (control.clone(), tasks.to_vec(), over.clone());
        thread::spawn(move || {
            let rng = &mut Rng::new(seed.wrapping_add(producer as u64));
            while !over.load(Ordering::Relaxed) {
                for _ in 0..rng.index(BURST) {
                    let _full_or_over = control.release(producer, tasks[rng.index(tasks.len())]);
                }
                thread::sleep(Duration::from_millis(rng.within(1, 200)));
            }
        });
    }
}

/// Stops this process for a while, from another one.
fn stop_and_go_on() {
    let me = process::id();
    let script = format!("sleep 0.4; kill -STOP {me}; sleep 0.3; kill -CONT {me}");
    let helper = Command::new("sh").args(["-c", &script]).stdin(Stdio::null()).spawn();
    if let Ok(mut helper) = helper {
        thread::spawn(move || helper.wait());
    }
}

/// The log fed to a scheduler again.
fn replayed(log: &Path, workload: &Workload, policy: Policy) -> Result<(), String> {
    let (mut scheduler, plan, tasks) = built(workload, policy);
    let change = |scheduler: &mut Scheduler<Robot>, number: u32, now| {
        let change = plan.changes.get(number as usize).ok_or(CommitError::UnknownTask)?;
        build::apply(scheduler, change, tasks[change.task], now)
    };
    let file = File::open(log).map_err(|e| e.to_string())?;
    let mut reader = Reader::new(BufReader::new(file)).map_err(|e| format!("the log: {e}"))?;
    let found =
        replay(&mut reader, &mut scheduler, change, |_, _| {}).map_err(|e| format!("the log: {e}"))?;
    found.difference.map_or(Ok(()), |difference| {
        Err(format!(
            "input {} is replayed as {}, it was {}",
            difference.input, difference.now, difference.recorded
        ))
    })
}
