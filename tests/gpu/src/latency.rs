//! How long after a kernel's end the CPU knows: a kernel ends when the CPU lets it, so both times are of one clock. Once
//! by a loop that asks for an event all the time, once by a lane of the runtime, which asks for a while and then sleeps
//! between two looks, or in best effort until the driver calls it.

use crate::runs::{self, Robot};
use crate::{Bench, Failure, Figures, kernels};
use red_core::{Dag, Node, Wcet};
use red_cuda::{Arguments, Kernel, Pinned};
use red_rt::clock::now_ns;
use red_rt::cuda::NotSubmitted;
use red_rt::setup::SetupError;
use std::hint::{black_box, spin_loop};
use std::thread::{self, JoinHandle};

const RUNS: usize = 200;
/// Long beside what a kernel takes, so that a machine that is busy keeps up: a release into a full table would be refused, and its
/// kernel never begin.
const PERIOD_NS: u64 = 20_000_000;
/// A kernel's place: whether it has begun, and whether it may end.
const PLACE: usize = 16;
/// A kernel that does not begin within this never does.
const PATIENCE_NS: u64 = 20_000_000_000;
/// At most so many times the bare loop's, as a goal.
const GOAL: f64 = 1.2;

/// Lets each kernel end so long after it began. When it did.
fn opener(mut places: Pinned, after_ns: u64) -> JoinHandle<Option<Vec<u64>>> {
    thread::spawn(move || {
        let opened = |run: usize| {
            let asked = now_ns();
            // Another one writes there: it is to be read each time.
            while black_box(&places).bytes()[run * PLACE] == 0 {
                spin_loop();
                if now_ns() - asked > PATIENCE_NS {
                    return None;
                }
            }
            let begun = now_ns();
            while now_ns() - begun < after_ns {
                spin_loop();
            }
            let now = now_ns();
            black_box(&mut places).bytes_mut()[run * PLACE + 8] = 1;
            black_box(&places);
            Some(now)
        };
        (0..RUNS).map(opened).collect()
    })
}

fn gate(bench: &Bench) -> Result<(Kernel, Arguments), Failure> {
    Ok((kernels(bench)?.kernel(c"gate", [1; 3], [1; 3])?, Arguments::new(1)))
}

/// Median and 99th percentile.
fn figures(ends: &[u64], known: &[u64]) -> (u64, u64) {
    let mut after: Vec<u64> = known.iter().zip(ends).map(|(known, end)| known.saturating_sub(*end)).collect();
    after.sort_unstable();
    (after[after.len() / 2], after[after.len() * 99 / 100])
}

type Latency = Result<(u64, u64), Failure>;

const NONE_BEGAN: &str = "a kernel did not begin";

fn bare_loop(bench: &Bench, after_ns: u64) -> Latency {
    let (gate, mut arguments) = gate(bench)?;
    let (stream, event) = (bench.device.stream(0)?, bench.device.event()?);
    let places = bench.device.pinned(RUNS * PLACE)?;
    let address = places.address();
    let opener = opener(places, after_ns);
    let mut known = Vec::new();
    for run in 0..RUNS {
        arguments.set(0, address + (run * PLACE) as u64);
        stream.launch(&gate, &mut arguments)?;
        stream.record(&event)?;
        while !event.is_done()? {
            spin_loop();
        }
        known.push(now_ns());
    }
    let ends = opener.join().ok().flatten().ok_or(NONE_BEGAN)?;
    Ok(figures(&ends, &known))
}

fn of_lane(bench: &Bench, after_ns: u64) -> Result<((u64, u64), Option<SetupError>), Failure> {
    let mut dag = Dag::<Robot>::new();
    dag.add_node(Node::new(Wcet::from_millis(100))).map_err(|error| error.to_string())?;
    let places = bench.device.pinned(RUNS * PLACE)?;
    let address = places.address();
    let opener = opener(places, after_ns);
    let ran = runs::jobs(bench, &dag, 1, (RUNS, PERIOD_NS), |_| {
        let (gate, mut arguments) = gate(bench)?;
        Ok(Box::new(move |work, stream| {
            arguments.set(0, address + work.job * PLACE as u64);
            stream.launch(&gate, &mut arguments).map_err(NotSubmitted::from)
        }))
    })?;
    let ends = opener.join().ok().flatten().ok_or(NONE_BEGAN)?;
    let known: Option<Vec<u64>> = ran.ends.ended_ns.into_iter().collect();
    Ok((figures(&ends, &known.ok_or("a job did not end")?), ran.denied))
}

pub(crate) fn check(bench: &Bench) -> Result<Figures, Failure> {
    let mut told = Vec::new();
    let mut why = None;
    for (how, after_ns) in [("while it asks", 10_000), ("while it sleeps", 2_000_000)] {
        let (bare, p99) = bare_loop(bench, after_ns)?;
        let ((lane, lane_p99), denied) = of_lane(bench, after_ns)?;
        let ratio = lane as f64 / bare.max(1) as f64;
        let met = if ratio <= GOAL { "met" } else { "MISSED" };
        told.push(format!(
            "a kernel that ends {how}: loop p50 {bare} ns, p99 {p99} ns; lane p50 {lane} ns, p99 {lane_p99} ns; \
             {ratio:.2} times, of at most {GOAL} the goal is {met}"
        ));
        why = denied;
    }
    told.extend(why.map(|why| format!("best effort, where no lane asks again and again: {why}")));
    Ok(told)
}
