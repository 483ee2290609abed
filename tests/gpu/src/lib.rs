//! What only a CUDA device can show: that kernels compute what they should, also as a captured graph; that precedence
//! holds by the device's own clock; how long after a kernel's end the CPU knows; the obstacle scene under EDF and under
//! REDRT beside a load; and how a run ends whose kernel goes wrong.
//!
//! One program, `red-gpu-tests`, for a machine that has the device and no compiler. Where there is none, the stand-in for
//! the driver shows that each check runs, and that it fails where something is wrong.
#![forbid(unsafe_code)]

mod compute;
mod latency;
mod precedence;
mod runs;
mod scene;

use red_cuda::{Device, Module};
use std::error::Error;
use std::path::PathBuf;

/// Why a check does not hold, or could not be made.
pub type Failure = Box<dyn Error + Send + Sync>;

/// What a check printed: figures, a line each.
pub type Figures = Vec<String>;

/// What checks need.
#[derive(Clone, Debug)]
pub struct Bench {
    /// The device.
    pub device: Device,
    /// The command `redrt`.
    pub redrt: PathBuf,
}

/// A check by its name.
#[derive(Clone, Copy, Debug)]
pub struct Check {
    /// Its name.
    pub name: &'static str,
    /// What it shows.
    pub claim: &'static str,
    /// Makes it.
    pub run: fn(&Bench) -> Result<Figures, Failure>,
}

/// All of them, quick ones first.
pub const CHECKS: &[Check] = &[
    Check {
        name: "compute",
        claim: "a kernel computes, bit by bit, what the CPU does",
        run: compute::kernel,
    },
    Check { name: "graph", claim: "so does a captured graph, each time it is launched", run: compute::graph },
    Check {
        name: "precedence",
        claim: "no kernel of a thousand graphs begins before its predecessors end, by the device's clock",
        run: precedence::check,
    },
    Check {
        name: "latency",
        claim: "how long after a kernel's end the CPU knows, beside a loop that asks all the time",
        run: latency::check,
    },
    Check {
        name: "scene",
        claim: "the obstacle scene under EDF and REDRT beside a load",
        run: scene::compare,
    },
    Check {
        name: "illegal",
        claim: "an illegal access ends a run as documented, and the CPU's tasks go on",
        run: scene::illegal_access,
    },
];

const KERNELS: &str = include_str!("../kernels/checks.ptx");

/// The kernels of the checks.
fn kernels(bench: &Bench) -> Result<Module, Failure> {
    Ok(bench.device.module(KERNELS.as_bytes())?)
}
