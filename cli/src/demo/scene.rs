//! The demo's workload, from what the networks cost on this machine.

use crate::outcome::Failure;
use crate::output;
use red_bodies::onnx::{Engine, Rten, on_lane};
use red_rt::placement::usable_cpus;
use red_rt::setup::Fifo;
use red_rt::stop::StopSignals;
use std::path::Path;
use std::time::{Duration, Instant};

/// EDF needs this many times the lanes while the obstacle is in sight, in percent.
const EDF_LOAD_PERCENT: u64 = 120;
/// The deadline is this many times one frame's work under EDF, in percent: with lanes to itself, EDF would be in
/// time.
const DEADLINE_PERCENT: u64 = 150;
/// WCET over that, in percent: what a busy machine adds now and then. Below the deadline's share, so that
/// sub-deadlines can be met.
const WCET_PERCENT: u64 = 140;
/// The obstacle comes and leaves, in percent of the run.
const OBSTACLE_PERCENT: (u64, u64) = (30, 60);
/// Time for measuring, over all networks, and how often each is run at least, also on a slow machine.
const MEASURING: Duration = Duration::from_millis(1_600);
const LEAST_ROUNDS: usize = 3;
/// What a camera and an actuator take.
pub(crate) const CAMERA_NS: u64 = 100_000;
pub(crate) const ACTUATE_NS: u64 = 50_000;

const NETWORKS: [&str; 5] = ["encoder", "lane", "segment", "detect", "control"];
/// The order in which a frame under EDF runs them, which is what the load is made for.
const FRAME: [usize; 8] = [0, 1, 0, 2, 0, 3, 0, 4];

/// What nine of ten executions of each network stay below, in nanoseconds: a run disturbs its networks more than a
/// measurement does.
pub(crate) struct Costs([u64; 5]);

impl Costs {
    /// Of the network of this name, in nanoseconds.
    pub(crate) fn of(&self, network: &str) -> u64 {
        NETWORKS.iter().zip(self.0).find(|(name, _)| **name == network).map_or(0, |(_, cost)| cost)
    }

    /// Measures every network on a thread like a lane's, for less than 2 s in all; nothing if a signal came.
    pub(crate) fn measure(folder: &Path) -> Result<Option<Self>, Failure> {
        let stop = StopSignals::install().map_err(|e| Failure::Machine(e.to_string()))?;
        output::note("measuring the networks on this machine, for 2 s at most");
        let measured = on_lane(|| {
            // On the CPU that a lane would have; without the right, as an ordinary thread.
            if let Some(cpu) = usable_cpus().ok().and_then(|cpus| cpus.last().copied()) {
                let _granted = Fifo { priority: 60, cpu }.apply();
            }
            let mut networks = Vec::new();
            for name in NETWORKS {
                let network = Rten.load(&folder.join(format!("{name}.onnx")))?;
                let (input, output) = (vec![0.5; network.input_len()], vec![0.0; network.output_len()]);
                networks.push((network.instance()?, input, output, Vec::new()));
            }
            // As in a run: a network that is run again and again finds its caches warm.
            let until = Instant::now() + MEASURING;
            let mut rounds = 0;
            while rounds < LEAST_ROUNDS || Instant::now() < until {
                for network in FRAME {
                    let (instance, input, output, times) = &mut networks[network];
                    if stop.requested().is_some() {
                        return Ok(None);
                    }
                    let start = Instant::now();
                    instance.run(input, output)?;
                    times.push(u64::try_from(start.elapsed().as_nanos()).unwrap_or(u64::MAX));
                }
                rounds += 1;
            }
            let mut costs = [0; NETWORKS.len()];
            for ((.., times), cost) in networks.iter_mut().zip(&mut costs) {
                times.sort_unstable();
                *cost = times[times.len() * 9 / 10];
            }
            Ok::<_, red_bodies::BodyError>(Some(Self(costs)))
        });
        let failed = |e: red_bodies::BodyError| Failure::Machine(format!("cannot measure the networks: {e}"));
        measured.and_then(|costs| costs).map_err(failed)
    }
}

/// As many lanes as there are usable CPUs less one, at least one.
pub(crate) fn lanes() -> Result<u64, Failure> {
    let cpus = usable_cpus().map_err(|e| Failure::Machine(e.to_string()))?;
    Ok(cpus.len().saturating_sub(1).clamp(1, 32) as u64)
}

/// The demo's workload and why it is as it is.
pub(crate) struct Plan {
    /// As a workload file.
    pub(crate) file: String,
    /// In words.
    pub(crate) explained: String,
    /// While the obstacle is in sight.
    pub(crate) obstacle_ns: (u64, u64),
}

/// Derives period and deadline from the costs.
pub(crate) fn plan(costs: &Costs, lanes: u64, duration_ns: u64) -> Plan {
    let [encoder, lane, segment, detect, control] = costs.0;
    let heads = lane + segment + detect + control;
    let fixed = CAMERA_NS + ACTUATE_NS;
    let edf = fixed + 4 * encoder + heads;
    let redrt = fixed + encoder + heads;
    let period = (edf * 100 / EDF_LOAD_PERCENT / lanes).max(1);
    let deadline = (edf * DEADLINE_PERCENT / 100).max(period);
    let obstacle_ns = (duration_ns / 100 * OBSTACLE_PERCENT.0, duration_ns / 100 * OBSTACLE_PERCENT.1);
    let wcet = |ns: u64| ns * WCET_PERCENT / 100;
    let stage = |name: &str, head: u64| {
        format!(
            "mimonet = {{ weights = \"mimo\", frame = \"front\", encoder = {{ wcet = \"{}ns\", bcet = \"{}ns\", \
             body = {{ onnx = \"encoder.onnx\" }} }}, decoders = [ {{ name = \"head\", wcet = \"{}ns\", \
             body = {{ onnx = \"{name}.onnx\" }} }} ] }}",
            wcet(encoder),
            encoder / 2,
            wcet(head)
        )
    };
    let file = format!(
        "[[pool]]\nname = \"cpu\"\nlanes = {lanes}\n\n\
         [[task]]\nname = \"cruise\"\nperiod = \"{period}ns\"\ndeadline = \"{deadline}ns\"\n\n\
         [[task.node]]\nname = \"camera\"\nwcet = \"{}ns\"\nbody = {{ spin = \"{CAMERA_NS}ns\" }}\n\n\
         [[task.node]]\nname = \"lane\"\nafter = [\"camera\"]\n{}\n\n\
         [[task.node]]\nname = \"segment\"\nafter = [\"lane\"]\n{}\n\n\
         [[task.node]]\nname = \"control\"\nafter = [\"segment\"]\n{}\n\n\
         [[task.node]]\nname = \"actuate\"\nafter = [\"control\"]\nwcet = \"{}ns\"\nbody = {{ spin = \"{ACTUATE_NS}ns\" }}\n\n\
         [[event]]\nat = \"{}ns\"\ntask = \"cruise\"\nadd = [ {{ name = \"detect\", after = [\"lane\"], before = [\"control\"], {} }} ]\n\n\
         [[event]]\nat = \"{}ns\"\ntask = \"cruise\"\nremove = [\"detect\"]\n",
        wcet(CAMERA_NS),
        stage("lane", lane),
        stage("segment", segment),
        stage("control", control),
        wcet(ACTUATE_NS),
        obstacle_ns.0,
        stage("detect", detect),
        obstacle_ns.1,
    );
    let ms = |ns: u64| ns as f64 / 1e6;
    let explained = format!(
        "costs in ms: encoder {:.2}, lane {:.2}, segment {:.2}, detect {:.2}, control {:.2}\n\
         a frame with the obstacle: {:.2} ms, with the encoder once in it {:.2} ms\n\
         {lanes} lane{}, period {:.2} ms, deadline {:.2} ms; load: EDF {:.2}, REDRT {:.2}",
        ms(encoder),
        ms(lane),
        ms(segment),
        ms(detect),
        ms(control),
        ms(edf),
        ms(redrt),
        if lanes == 1 { "" } else { "s" },
        ms(period),
        ms(deadline),
        edf as f64 / (period * lanes) as f64,
        redrt as f64 / (period * lanes) as f64,
    );
    Plan { file, explained, obstacle_ns }
}
