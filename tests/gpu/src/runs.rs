//! Runs of the real runtime whose lanes are streams, with kernels that a check brings.

use crate::{Bench, Failure};
use red_core::{
    Caps, Config, Dag, Duration, Event, Instant, JobId, Outcome, PoolId, ReleaseError, Scheduler, Shed,
    Timing,
};
use red_cuda::Stream;
use red_rt::clock::now_ns;
use red_rt::cuda::{Bodies, Cuda, CudaFigures, NotSubmitted};
use red_rt::handler::{Failed, Handler, Work};
use red_rt::placement::{choose_cpus, usable_cpus};
use red_rt::runtime::{Mode, Setup, run};
use red_rt::setup::SetupError;
use red_rt::stop::StopBy;
use red_rt::timeline::{Host, Releases};
use std::sync::Arc;

/// One task of a few nodes on a few streams. A machine that stands still for a while has as many jobs at once as it missed.
pub(crate) type Robot = Caps<1, 16, 64, 8, 2, 1, 64>;

/// Priority of lanes, as in a run of `redrt`.
const PRIORITY: u8 = 70;

/// Submits a node's kernels.
pub(crate) type Submit = Box<dyn FnMut(&Work, &Stream) -> Result<(), NotSubmitted> + Send>;

struct Submits(Submit);

impl Bodies for Submits {
    fn submit(&mut self, work: &Work, stream: &Stream) -> Result<(), NotSubmitted> {
        (self.0)(work, stream)
    }
}

struct OnCpu;

impl Handler for OnCpu {
    fn run(&mut self, _: &Work) -> Result<(), Failed> {
        Ok(())
    }
}

/// When each job ended, by the CPU's clock, and how many were given up.
#[derive(Debug, Default)]
pub(crate) struct Ends {
    pub(crate) ended_ns: Vec<Option<u64>>,
    pub(crate) given_up: usize,
}

impl Host<Robot> for Ends {
    fn released(&mut self, _: usize, _: Instant, taken: Result<JobId, ReleaseError>) {
        self.given_up += usize::from(taken.is_err());
    }

    fn ended(&mut self, outcome: &Outcome) {
        let now = now_ns();
        if let Some(place) = self.ended_ns.get_mut(outcome.index as usize) {
            *place = Some(now);
        }
        self.given_up += usize::from(outcome.shed.is_some());
    }

    fn event(&mut self, _: &Event) {}
}

/// What a run was.
pub(crate) struct Ran {
    pub(crate) ends: Ends,
    pub(crate) streams: CudaFigures,
    pub(crate) ahead: u64,
    /// Why it was not in real time.
    pub(crate) denied: Option<SetupError>,
}

/// So many jobs of a graph, one each period. Nodes of the first pool are on so many streams, each with what `submit` makes
/// for its lane; those of the second on a lane of the CPU, and do nothing.
pub(crate) fn jobs(
    bench: &Bench,
    dag: &Dag<Robot>,
    streams: u8,
    (count, period_ns): (usize, u64),
    submit: impl Fn(usize) -> Result<Submit, Failure>,
) -> Result<Ran, Failure> {
    let lanes = usize::from(streams) + 1;
    let (mode, denied) = match real_time(lanes) {
        Ok(mode) => (mode, None),
        Err(why) => (Mode::BestEffort, Some(why)),
    };
    // What is looked at is the device: every job runs, however late the machine is.
    let config = Config { shed: Shed::Never, ..Config::REDRT }.with_lanes(streams);
    let mut scheduler = Box::new(Scheduler::<Robot>::new(config));
    scheduler.add_pool(1, None).map_err(|error| error.to_string())?;
    scheduler.dispatch_ahead(PoolId::new(0));
    let task = scheduler.add_task(dag, Timing::new(Duration::from_secs(10)));
    let task = task.map_err(|error| error.to_string())?;
    let of_streams = (1 << streams) - 1;
    let cuda = Cuda::new(bench.device.clone(), of_streams)?;
    let bodies =
        (0..usize::from(streams)).map(|lane| Ok((lane, Box::new(Submits(submit(lane)?)) as Box<dyn Bodies>)));
    let bodies: Vec<_> = bodies.collect::<Result<_, Failure>>()?;
    let handlers = cuda.handlers(bodies.into_iter())?;
    let setup = Setup {
        scheduler,
        lanes,
        streams: of_streams,
        mode,
        releases: vec![Releases { task, first_ns: 0, period_ns: Some(period_ns) }],
        duration_ns: count as u64 * period_ns,
        drain_ns: 10_000_000_000,
        stop: StopBy::Signals,
        tape: None,
        handlers: Arc::new(move |lane| handlers.take(lane).unwrap_or_else(|| Box::new(OnCpu))),
        enclose: Arc::new(|main| main()),
    };
    let ends = Ends { ended_ns: vec![None; count], given_up: 0 };
    let (ends, report) = run(setup, ends, drop, |_| {})?;
    if let Some(error) = cuda.lost() {
        return Err(error.into());
    }
    Ok(Ran { ends, streams: cuda.figures(), ahead: report.ahead, denied })
}

fn real_time(lanes: usize) -> Result<Mode, SetupError> {
    let cpus = choose_cpus(lanes, &usable_cpus()?)?;
    let probe = red_rt::setup::Fifo { priority: PRIORITY, cpu: cpus[0] };
    // On a thread of its own, so that this one stays as it is.
    let asked = std::thread::spawn(move || probe.apply().and_then(|()| red_rt::setup::lock_memory()));
    asked.join().unwrap_or(Ok(())).map(|()| Mode::RealTime { priority: PRIORITY, cpus })
}
