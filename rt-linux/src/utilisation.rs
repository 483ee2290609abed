//! How much a GPU is used, whoever does so, for the overload monitor: what lanes keep busy they know themselves, and
//! nothing of other processes on the same device.
//!
//! *Rule.* Ten times a second a thread of its own asks the device's source, and a lane tells the scheduler
//! ([`Scheduler::observe_use`](red_core::Scheduler::observe_use)). Where no source knows the device, the scheduler's own
//! accounting is all there is.
//! *Paper reference.* The burst manager, section 4.5: U_GPU.

use crate::control::{AskError, Control};
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use core::time::Duration;
use red_core::{Capacity, PoolId, Ppm};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::{self, JoinHandle};

/// Between two looks.
const PERIOD: Duration = Duration::from_millis(100);

/// The source of a run where nothing else knows the device: the scheduler's own accounting of its lanes.
pub const OWN_ACCOUNTING: &str = "own";

/// Says how much a device is used.
pub trait Utilisation: Send {
    /// Which one this is: `nvml` or `sysfs`.
    fn source(&self) -> &'static str;

    /// What part of the last period the device was used; `None`: it is not known. Not for real time.
    fn sample(&mut self) -> Option<Ppm>;
}

/// The load that a Jetson's kernel counts, per mille.
#[derive(Clone, Debug)]
pub struct LoadNode(PathBuf);

impl LoadNode {
    /// Below `root`, which is `/` but in tests; `None`: this is no Jetson.
    #[must_use]
    pub fn find(root: &Path) -> Option<Self> {
        let of_devfreq = fs::read_dir(root.join("sys/class/devfreq")).into_iter().flatten().flatten();
        let gpus = of_devfreq.map(|entry| entry.path().join("device/load"));
        // Before L4T 32 the GPU had no devfreq.
        let older = ["sys/devices/gpu.0/load", "sys/devices/platform/gpu.0/load"].map(|path| root.join(path));
        let mut all = gpus.chain(older);
        all.find(|path| is_of_gpu(path) && per_mille(path).is_some()).map(Self)
    }
}

/// Other devices have a `devfreq`, too.
fn is_of_gpu(path: &Path) -> bool {
    let path = path.to_string_lossy();
    ["gpu", "gv11b", "ga10b", "gp10b", "gm20b", "gb10b"].iter().any(|name| path.contains(name))
}

fn per_mille(path: &Path) -> Option<u32> {
    fs::read_to_string(path).ok()?.trim().parse().ok().filter(|load| *load <= 1_000)
}

impl Utilisation for LoadNode {
    fn source(&self) -> &'static str {
        "sysfs"
    }

    fn sample(&mut self) -> Option<Ppm> {
        per_mille(&self.0).map(|load| Ppm(load * 1_000))
    }
}

/// NVIDIA's management library.
#[cfg(feature = "cuda")]
impl Utilisation for red_cuda::Nvml {
    fn source(&self) -> &'static str {
        "nvml"
    }

    fn sample(&mut self) -> Option<Ppm> {
        self.utilisation_percent().ok().filter(|percent| *percent <= 100).map(|percent| Ppm(percent * 10_000))
    }
}

/// What knows a CUDA device best; `None`: nothing does. Opening NVML takes tens of milliseconds: to be called before the
/// run, whose clock would count them.
#[cfg(feature = "cuda")]
#[must_use]
pub fn of_device(device: &red_cuda::Device, root: &Path) -> Option<Box<dyn Utilisation>> {
    let by_nvml = red_cuda::Nvml::open(device).ok().map(|nvml| Box::new(nvml) as Box<dyn Utilisation>);
    let by_node = || LoadNode::find(root).map(|node| Box::new(node) as Box<dyn Utilisation>);
    // Some devices have an NVML that does not know it.
    by_nvml.and_then(|mut nvml| nvml.sample().map(|_| nvml)).or_else(by_node)
}

/// Tells the scheduler of a run how much a device is used, as long as it is there.
#[derive(Debug)]
pub struct Observer {
    ends: Arc<AtomicBool>,
    highest: Arc<AtomicU32>,
    source: &'static str,
    thread: Option<JoinHandle<()>>,
}

impl Observer {
    /// For these pools of a run, from its start on. `None`: the system starts no thread.
    pub fn start<C: Capacity>(
        control: Arc<dyn Control<C>>,
        pools: Vec<PoolId>,
        mut source: Box<dyn Utilisation>,
    ) -> Option<Self> {
        let name = source.source();
        let (ends, highest) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicU32::new(0)));
        let (over, most) = (ends.clone(), highest.clone());
        let main = move || {
            while !over.load(Ordering::Relaxed) {
                if let Some(used) = source.sample() {
                    most.fetch_max(used.0, Ordering::Relaxed);
                    let pools = pools.clone();
                    let told = control.ask(Box::new(move |scheduler, _now| {
                        for pool in &pools {
                            scheduler.observe_use(*pool, used);
                        }
                    }));
                    if let Err(AskError::Over) = told {
                        break;
                    }
                }
                thread::park_timeout(PERIOD);
            }
        };
        let thread = thread::Builder::new().name("red-use".to_owned()).spawn(main).ok()?;
        Some(Self { ends, highest, source: name, thread: Some(thread) })
    }

    /// Who says so.
    #[must_use]
    pub const fn source(&self) -> &'static str {
        self.source
    }

    /// The highest use that was seen so far.
    #[must_use]
    pub fn highest(&self) -> Ppm {
        Ppm(self.highest.load(Ordering::Relaxed))
    }
}

impl Drop for Observer {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            // Its panic was printed, and is nobody else's.
            let _ended = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_jetson_has_a_node_and_other_machines_have_none() {
        let root = std::env::temp_dir().join(format!("red-load-{}", std::process::id()));
        let write = |path: &str, text: &str| {
            let path = root.join(path);
            fs::create_dir_all(path.parent().expect("a folder")).expect("in the folder for temporary files");
            fs::write(path, text).expect("a file");
        };
        assert!(LoadNode::find(&root).is_none());
        write("sys/class/devfreq/15340000.vic/device/load", "999");
        assert!(LoadNode::find(&root).is_none(), "of something else");
        write("sys/devices/gpu.0/load", "1001");
        assert!(LoadNode::find(&root).is_none(), "no load");
        write("sys/devices/gpu.0/load", "250\n");
        let mut older = LoadNode::find(&root).expect("a TX2");
        assert_eq!((older.source(), older.sample()), ("sysfs", Some(Ppm(250_000))));
        write("sys/class/devfreq/17000000.ga10b/device/load", "15");
        let mut orin = LoadNode::find(&root).expect("an Orin");
        assert_eq!(orin.sample(), Some(Ppm(15_000)));
        write("sys/class/devfreq/17000000.ga10b/device/load", "busy");
        assert_eq!(orin.sample(), None);
        fs::remove_dir_all(&root).expect("it is ours");
    }
}
