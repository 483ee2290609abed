//! RED as a timer: a run of one pinned lane and one task of one empty node, released every period.

use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

use red_core::{Caps, Config, Event, Instant, JobId, Outcome, PoolId, ReleaseError, Scheduler};
use red_rt::clock::now_ns;
use red_rt::handler::{Failed, Handler, Work};
use red_rt::runtime::{Mode, Setup, run};
use red_rt::stop::StopBy;
use red_rt::timeline::{Host, Releases};

use super::{Lateness, PERIOD};
use crate::graphs::Graph;
use crate::machine::{Machine, PRIORITY};
use crate::not_run::NotRun;
use crate::ours::{admit, dag, failed};

/// One job in flight: a release that passes while another waits is refused, as cyclictest skips it. So one stall of
/// the machine counts once for both.
type OneNode = Caps<1, 1, 1, 1>;

/// Runs on a thread of its own, because the thread that measures has the CPU of the lane.
pub(super) fn measure(machine: &'static Machine, duration: Duration) -> Result<Lateness, NotRun> {
    let measured = thread::spawn(move || {
        machine.become_ordinary().map_err(failed)?;
        on_a_lane(machine, duration)
    });
    measured.join().unwrap_or_else(|_| Err(NotRun::Failed("RED: the run panicked".to_owned())))
}

fn on_a_lane(machine: &'static Machine, duration: Duration) -> Result<Lateness, NotRun> {
    let mut scheduler = Box::new(Scheduler::<OneNode>::new(Config::REDRT));
    let task = admit(&mut scheduler, &dag(&Graph::chain(1), |_| PoolId::new(0))?)?;
    let period_ns = PERIOD.as_nanos() as u64;
    let duration_ns = duration.as_nanos() as u64;
    // Room for all, so that no body allocates.
    let late_ns = Arc::new(Mutex::new(Vec::with_capacity((duration_ns / period_ns) as usize + 1)));
    let handlers = {
        let late_ns = Arc::clone(&late_ns);
        move |_| -> Box<dyn Handler> { Box::new(Stopwatch { origin_ns: 0, late_ns: Arc::clone(&late_ns) }) }
    };
    let priority = PRIORITY as u8;
    let mode = if machine.realtime {
        Mode::RealTime { priority, cpus: machine.lanes[..1].to_vec() }
    } else {
        Mode::BestEffort
    };
    let setup = Setup {
        scheduler,
        lanes: 1,
        streams: 0,
        mode,
        releases: vec![Releases { task, first_ns: period_ns, period_ns: Some(period_ns) }],
        duration_ns,
        drain_ns: period_ns,
        stop: StopBy::Signals,
        tape: None,
        handlers: Arc::new(handlers),
        enclose: Arc::new(|main: Box<dyn FnOnce() + Send>| main()),
    };
    run(setup, Silent, |_| (), |_| ()).map_err(failed)?;
    let late_ns = late_ns.lock().map_err(failed)?;
    Lateness::of(&late_ns).ok_or_else(|| NotRun::Failed("RED: nothing was released".to_owned()))
}

/// Takes the time at the start of the body.
struct Stopwatch {
    origin_ns: u64,
    late_ns: Arc<Mutex<Vec<u64>>>,
}

impl Handler for Stopwatch {
    fn begin(&mut self, origin_ns: u64) {
        self.origin_ns = origin_ns;
    }

    fn run(&mut self, work: &Work) -> Result<(), Failed> {
        let late_ns = now_ns() - self.origin_ns - work.release_ns;
        self.late_ns.lock().map_err(|_| Failed)?.push(late_ns);
        Ok(())
    }
}

/// A host that keeps nothing.
struct Silent;

impl Host<OneNode> for Silent {
    fn released(&mut self, _task: usize, _release: Instant, _taken: Result<JobId, ReleaseError>) {}
    fn ended(&mut self, _outcome: &Outcome) {}
    fn event(&mut self, _event: &Event) {}
}
