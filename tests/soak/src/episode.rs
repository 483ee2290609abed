//! One random workload on real threads, with bodies that go wrong, recorded and replayed.

use crate::bodies::{Bodies, Tried};
use crate::counts::{Count, Counts};
use crate::figures::wrong_figures;
use crate::judge::{Judge, Robot};
use crate::replayed::replayed;
use crate::rights::PRIORITY;
use crate::workload::Drawn;
use red_core::{Empty, Scheduler, TaskId};
use red_record::{Header, Writer};
use red_rt::control::Control;
use red_rt::handler::Handler;
use red_rt::placement::{choose_cpus, usable_cpus};
use red_rt::runtime::{Mode, Setup, run};
use red_rt::stop::StopBy;
use red_rt::timeline::Releases;
use red_tests::rng::Rng;
use red_workload::build::{self, Plan};
use red_workload::model::{Arrival, Workload};
use red_workload::policy::Policy;
use std::path::Path;
use std::process::{self, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// Every job has ended long before, unless it was forgotten.
const DRAIN: Duration = Duration::from_secs(60);
/// Releases from outside come in bursts of so many.
const BURST: usize = 12;
/// Threads outside of the lanes that release.
const PRODUCERS: u64 = 2;
/// How long a process is halted: a standstill, and shorter than the bound of any body, so that none hangs by it.
const HALT_S: f64 = 0.06;
/// Lanes' threads have ended long before, those too that were given up.
const LATE: Duration = Duration::from_secs(30);

/// What is wrong on purpose, for the tests of the soak.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Plant {
    /// Each workload leaves a kibibyte behind.
    Leak,
    /// A node starts twice, says the event.
    Start,
    /// The log is fed to a scheduler that is set up in another way.
    Replay,
    /// Nothing is edited.
    Edits,
    /// A workload never ends; one apart is halted for good.
    Stuck,
}

/// How an episode goes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Conditions {
    /// Releases come for so long.
    pub(crate) length: Duration,
    /// In a process of its own, where threads may die and the process be halted.
    pub(crate) apart: bool,
    pub(crate) plant: Option<Plant>,
}

/// Runs a workload, its log at `log`. What happened, and whether a signal stopped it.
pub(crate) fn episode(drawn: &Drawn, to: Conditions, log: &Path) -> Result<(Counts, bool), String> {
    let Drawn { seed, workload, policy, realtime, .. } = drawn;
    let (scheduler, plan, tasks) = built(workload, *policy);
    let lanes: usize = workload.pools.iter().map(|pool| pool.lanes as usize).sum();
    let mut judge = Judge::new(built(workload, *policy).0, workload, &plan, &tasks, *policy);
    judge.planted = to.plant == Some(Plant::Start);
    drawn.removal.iter().for_each(|(task, at_ns)| judge.remove(*task, *at_ns));
    let (writer, tape) =
        Writer::start(log, &header(drawn, to.length)).map_err(|e| format!("{}: {e}", log.display()))?;
    let tried = Arc::new(Tried::default());
    let handlers = {
        let (tried, seed, spins, dies) = (tried.clone(), *seed, *realtime, to.apart);
        move |_lane| -> Box<dyn Handler> { Box::new(Bodies::of(seed, tried.clone(), spins, dies)) }
    };
    let cpus = || usable_cpus().and_then(|usable| choose_cpus(lanes, &usable)).map_err(|e| e.to_string());
    let mode =
        if *realtime { Mode::RealTime { priority: PRIORITY, cpus: cpus()? } } else { Mode::BestEffort };
    // A share of it is with each lane's thread, to its end.
    let threads = Arc::new(());
    let held = threads.clone();
    let by_clock = releases(workload, &tasks);
    let setup = Setup {
        scheduler,
        lanes,
        streams: 0,
        mode,
        releases: by_clock.clone(),
        duration_ns: to.length.as_nanos() as u64,
        drain_ns: DRAIN.as_nanos() as u64,
        stop: StopBy::Signals,
        tape: Some(tape),
        handlers: Arc::new(handlers),
        enclose: Arc::new(move |main: Box<dyn FnOnce() + Send>| {
            let _held = held.clone();
            main();
        }),
    };
    let halted = to.apart.then(|| halt(to.length / 4, to.plant != Some(Plant::Stuck)));
    let over = Arc::new(AtomicBool::new(false));
    let accepted = Arc::new(AtomicU64::new(0));
    let mut outside = Vec::new();
    let started = |control: Arc<dyn Control<Robot>>| {
        outside = (0..PRODUCERS)
            .map(|producer| {
                let rng = Rng::new(seed.wrapping_add(producer));
                burst(&control, &tasks, rng, &over, &accepted)
            })
            .collect();
    };
    let finished = run(setup, judge, started, |_now| {});
    over.store(true, Ordering::Relaxed);
    outside.into_iter().chain(halted).for_each(|thread| drop(thread.join()));
    let (totals, unwritten) = writer.finish();
    let (mut judge, report) = finished.map_err(|e| e.to_string())?;
    if !to.apart {
        ended(&threads)?;
    }
    let stopped = report.stopped_by.is_some();
    let accepted = accepted.load(Ordering::Relaxed);
    if !stopped && report.gave_up.is_none() {
        judge.none_forgotten(accepted + made_by_clock(&by_clock, to.length));
    }
    let wrong = [
        judge.wrong.take(),
        unwritten.map(|e| format!("the log: {e}")),
        (totals.dropped > 0).then(|| format!("{} inputs were not recorded", totals.dropped)),
        tried.twice().map(|work| format!("the body of {work:?} ran twice")),
        wrong_figures(&report, &tried),
    ];
    if let Some(wrong) = wrong.into_iter().flatten().next() {
        return Err(wrong);
    }
    let mut counts = judge.counts;
    counts[Count::Replayed] = replayed(log, to.plant == Some(Plant::Replay))?;
    counts[Count::Workloads] = 1;
    counts[Count::RealTime] = report.realtime.into();
    counts[Count::Outside] = accepted;
    counts[Count::Failed] = tried.failed.load(Ordering::Relaxed);
    counts[Count::Panicked] = tried.panicked.load(Ordering::Relaxed);
    counts[Count::Hung] = report.hung;
    counts[Count::Died] = report.threads_died.min(tried.died.load(Ordering::Relaxed));
    counts[Count::Standstills] = report.standstills;
    if to.plant == Some(Plant::Leak) {
        Vec::leak(vec![1_u8; 1024]);
    }
    while to.plant == Some(Plant::Stuck) {
        thread::park();
    }
    Ok((counts, stopped))
}

/// Waits until the threads of all lanes have ended, those too that were given up: nothing is held after that.
fn ended(threads: &Arc<()>) -> Result<(), String> {
    let until = Instant::now() + LATE;
    while Arc::strong_count(threads) > 1 {
        if Instant::now() > until {
            return Err("a lane's thread has not ended".to_owned());
        }
        thread::sleep(Duration::from_millis(1));
    }
    Ok(())
}

pub(crate) fn built(
    workload: &Workload,
    policy: Policy,
) -> (Box<Scheduler<Robot>>, Plan<Robot>, Vec<TaskId>) {
    let mut scheduler: Box<Scheduler<Robot>> = Box::new(Scheduler::EMPTY);
    let (plan, tasks) =
        build::admit(&mut scheduler, workload, policy.config()).expect("random workloads are valid");
    (scheduler, plan, tasks)
}

fn header(drawn: &Drawn, length: Duration) -> Header {
    Header {
        program: concat!("red-soak ", env!("CARGO_PKG_VERSION")).to_owned(),
        capacities: Header::capacities_of::<Robot>(),
        policy: drawn.policy.name().to_owned(),
        duration_ns: length.as_nanos() as u64,
        realtime: drawn.realtime,
        file: format!("seed {}", drawn.seed),
        format: "toml".to_owned(),
        workload: drawn.text.clone(),
        config: None,
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

/// How many releases the clock brings before the end.
fn made_by_clock(releases: &[Releases], length: Duration) -> u64 {
    let length_ns = length.as_nanos() as u64;
    let in_time = releases.iter().filter(|of| of.first_ns < length_ns);
    in_time.map(|of| of.period_ns.map_or(1, |period| (length_ns - 1 - of.first_ns) / period + 1)).sum()
}

/// Releases from a thread that is no lane, in bursts, until the run is over.
fn burst(
    control: &Arc<dyn Control<Robot>>,
    tasks: &[TaskId],
    mut rng: Rng,
    over: &Arc<AtomicBool>,
    accepted: &Arc<AtomicU64>,
) -> JoinHandle<()> {
    let (control, tasks, over, accepted) = (control.clone(), tasks.to_vec(), over.clone(), accepted.clone());
    thread::spawn(move || {
        while !over.load(Ordering::Relaxed) {
            for _ in 0..rng.index(BURST) {
                // Refused where its box is full, or the run is over.
                let taken = control.release(tasks[rng.index(tasks.len())], None);
                accepted.fetch_add(taken.is_ok().into(), Ordering::Relaxed);
            }
            thread::sleep(Duration::from_millis(rng.within(1, 200)));
        }
    })
}

/// Halts this process from another one, for a while if it `goes_on`.
fn halt(after: Duration, goes_on: bool) -> JoinHandle<()> {
    let me = process::id();
    let after = after.as_secs_f64();
    let go_on = if goes_on { format!("sleep {HALT_S}; kill -CONT {me}") } else { String::new() };
    // A Ctrl-C is for all processes of the terminal: who let this one go on must not end before.
    let script = format!("trap '' INT TERM HUP; sleep {after}; kill -STOP {me}; {go_on}");
    thread::spawn(move || {
        // Where there is no shell nothing stands still, which the counts tell.
        let _status = Command::new("sh").args(["-c", &script]).stdin(Stdio::null()).status();
    })
}

#[cfg(test)]
mod tests;
