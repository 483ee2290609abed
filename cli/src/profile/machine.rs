//! The machine that is measured: its CPUs, the rights that it grants, and its name.

use crate::denied::Denied;
use crate::outcome::Failure;
use red_rt::placement::{choose_cpus, usable_cpus};
use red_rt::setup::{Fifo, SetupError, lock_memory};
use red_workload::model::{MAX_LANES, PoolKind, Workload};
use std::fs;
use std::thread;

/// Priority of the lanes, as in a run.
pub(super) use crate::session::PRIORITY;

/// What there is to measure on.
pub(super) struct Machine {
    /// A CPU for each lane that is no stream, those furthest from the kernel's own work first.
    pub(super) cpus: Vec<usize>,
    /// The lanes that each pool may use, never none; those of streams come after the CPUs'.
    pub(super) lanes_of_pool: Vec<Vec<usize>>,
    /// Why this is not real time.
    pub(super) denied: Option<Denied>,
    /// CPU model.
    pub(super) model: String,
    /// Kernel release.
    pub(super) kernel: String,
    /// The CUDA device, if nodes run there.
    pub(super) device: Option<String>,
}

impl Machine {
    /// Takes all usable CPUs, in real time where that is granted.
    ///
    /// # Errors
    /// Real time is not granted or not on the CPUs that pools name, and `best_effort` does not allow less.
    pub(super) fn take(workload: &Workload, best_effort: bool) -> Result<Self, Failure> {
        let told = |e: Denied| {
            Failure::Machine(format!("{e}; `--best-effort` measures without real time, labelled so"))
        };
        let usable = usable_cpus().map_err(|e| told(e.into()))?;
        let mut cpus =
            choose_cpus(usable.len().min(MAX_LANES as usize), &usable).map_err(|e| told(e.into()))?;
        cpus.reverse();
        let granted = placed(workload, &cpus).and_then(|lanes| granted(cpus[0]).map(|()| lanes));
        let (lanes_of_pool, denied) = match granted {
            Ok(lanes) => (lanes, None),
            Err(e) if best_effort => (vec![(0..cpus.len()).collect(); workload.pools.len()], Some(e.into())),
            Err(e) => return Err(told(e.into())),
        };
        let mut streams = cpus.len();
        let lanes_of_pool = workload.pools.iter().zip(lanes_of_pool).map(|(pool, lanes)| {
            if pool.kind != PoolKind::Cuda {
                return lanes;
            }
            streams += pool.lanes as usize;
            (streams - pool.lanes as usize..streams).collect()
        });
        // All pools together must stay within the limit that a file has.
        let share = MAX_LANES as usize / workload.pools.len().max(1);
        let lanes_of_pool = lanes_of_pool.map(|mut lanes: Vec<usize>| {
            lanes.truncate(share.max(1));
            lanes
        });
        let lanes_of_pool = lanes_of_pool.collect();
        Ok(Self { cpus, lanes_of_pool, denied, model: model(), kernel: kernel(), device: None })
    }

    /// Whether lanes have SCHED_FIFO and locked memory.
    pub(super) const fn realtime(&self) -> bool {
        self.denied.is_none()
    }
}

/// The lanes of each pool: on the CPUs that it names, else on those that no pool names.
fn placed(workload: &Workload, cpus: &[usize]) -> Result<Vec<Vec<usize>>, SetupError> {
    let named = |lane: &usize| {
        workload.pools.iter().any(|pool| pool.cpus.iter().any(|cpu| *cpu as usize == cpus[*lane]))
    };
    let all = || (0..cpus.len()).collect::<Vec<usize>>();
    let mut free: Vec<usize> = (0..cpus.len()).filter(|lane| !named(lane)).collect();
    if free.is_empty() {
        free = all();
    }
    let of_pool = |pool: &red_workload::model::Pool| {
        if pool.cpus.is_empty() {
            return Ok(free.clone());
        }
        let lane = |cpu: &u32| {
            let cpu = *cpu as usize;
            let place = cpus.iter().position(|usable| *usable == cpu);
            place.ok_or_else(|| SetupError::CpuNotUsable { cpu, usable: cpus.to_vec() })
        };
        pool.cpus.iter().map(lane).collect()
    };
    workload.pools.iter().map(of_pool).collect()
}

/// Asked for on a thread of its own, so that this one stays as it is.
fn granted(cpu: usize) -> Result<(), SetupError> {
    let probe = Fifo { priority: PRIORITY, cpu };
    thread::spawn(move || probe.apply().and_then(|()| lock_memory())).join().unwrap_or(Ok(()))
}

fn model() -> String {
    let info = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let of_cpu =
        info.lines().find_map(|line| line.strip_prefix("model name")?.trim_start().strip_prefix(':'));
    // ARM boards are known by their device tree.
    let board = || fs::read_to_string("/proc/device-tree/model").ok();
    plain(&of_cpu.map(str::to_owned).or_else(board).unwrap_or_else(|| "unknown CPU".to_owned()))
}

fn kernel() -> String {
    plain(
        &fs::read_to_string("/proc/sys/kernel/osrelease").unwrap_or_else(|_| "of unknown release".to_owned()),
    )
}

/// One line of printable text, for a comment.
fn plain(text: &str) -> String {
    text.chars().filter(|c| !c.is_control()).collect::<String>().trim().to_owned()
}
