//! The GPU as far as files tell: devices, libraries, driver, Jetson power modes. No CUDA call is made.

use super::Finding;
use super::check::Check;
use super::memory::variable;
use super::tree::{Tree, Unreadable};

const NO_GPU: &str = "no NVIDIA GPU: nothing to check";
const NO_JETSON: &str = "not a Jetson: nothing to check";

pub(super) fn examine(tree: &Tree<'_>) -> Vec<Finding> {
    let device =
        ["dev/nvidia0", "dev/nvgpu", "dev/nvhost-gpu", "dev/nvmap"].iter().find(|path| tree.exists(path));
    let present = device.is_some();
    let model = tree.read("proc/device-tree/model").ok().filter(|model| model.contains("Jetson"));
    let jetson = model.is_some();
    vec![
        DEVICE.pass_if(
            present,
            device.map_or_else(|| "no NVIDIA device file".into(), |path| format!("/{path}")),
        ),
        library(tree, &LIBCUDA, "libcuda.so.1", present),
        library(tree, &NVML, "libnvidia-ml.so.1", present && !jetson),
        driver(tree, present),
        mps(tree),
        only_from_driver(&COMPUTE_MODE, present),
        only_from_driver(&STREAM_PRIORITY, present),
        JETSON.pass(model.unwrap_or_else(|| NO_JETSON.into())),
        power_mode(tree, jetson),
        clocks(tree, jetson),
        load_node(tree, jetson),
        temperature(tree),
    ]
}

const DEVICE: Check = Check {
    id: "gpu.device",
    why: "pools of GPU lanes need one; CPU pools do not",
    fix: "install the NVIDIA driver; in a container: docker run --gpus all (Jetson: --runtime nvidia)",
};

const LIBCUDA: Check = Check {
    id: "gpu.libcuda",
    why: "the runtime loads the CUDA driver by this name",
    fix: "install the driver's user libraries (libcuda1), or add their folder to LD_LIBRARY_PATH",
};

const NVML: Check = Check {
    id: "gpu.nvml",
    why: "the load of a desktop GPU, which overload control looks at, is read through it",
    fix: "install the driver's user libraries (libnvidia-ml1)",
};

const COMPUTE_MODE: Check = Check {
    id: "gpu.compute_mode",
    why: "in mode Prohibited no process can use the GPU, in Exclusive only one",
    fix: "look: nvidia-smi --query-gpu=compute_mode --format=csv; set: nvidia-smi -c DEFAULT",
};

const STREAM_PRIORITY: Check = Check {
    id: "gpu.stream_priority",
    why: "urgent lanes go before others on the GPU only where its streams have more than one priority",
    fix: "look: measure.cuda, of `redrt doctor` without --quick",
};

const JETSON: Check =
    Check { id: "gpu.jetson_model", why: "its power modes change every WCET", fix: "none needed" };

fn library(tree: &Tree<'_>, check: &Check, name: &str, needed: bool) -> Finding {
    const FOLDERS: [&str; 9] = [
        "usr/lib/x86_64-linux-gnu",
        "usr/lib/aarch64-linux-gnu",
        "usr/lib/aarch64-linux-gnu/nvidia",
        "usr/lib/aarch64-linux-gnu/tegra",
        "usr/lib64",
        "usr/lib",
        "usr/local/nvidia/lib64",
        "usr/local/cuda/compat",
        "usr/lib/wsl/lib",
    ];
    let own = variable(tree, "LD_LIBRARY_PATH").ok().flatten().unwrap_or_default();
    let own = own.split(':').filter_map(|folder| folder.strip_prefix('/'));
    match own.chain(FOLDERS).map(|folder| format!("{folder}/{name}")).find(|path| tree.exists(path)) {
        Some(path) => check.pass(format!("/{path}")),
        None if needed => check.fail(format!("{name} not found")),
        None => check.pass(format!("{name} not found, and not needed here")),
    }
}

fn driver(tree: &Tree<'_>, present: bool) -> Finding {
    const CHECK: Check = Check {
        id: "gpu.driver",
        why: "the runtime wants CUDA 10.2, which drivers support from branch 440 on",
        fix: "install a driver of branch 440 or later",
    };
    const OLDEST_BRANCH: u32 = 440;
    const VERSION: &str = "proc/driver/nvidia/version";
    if !present {
        return CHECK.pass(NO_GPU);
    }
    if let Ok(release) = tree.read("etc/nv_tegra_release") {
        return CHECK.pass(release.lines().next().unwrap_or_default());
    }
    CHECK.on(tree.read(VERSION), |text| {
        // "NVRM version: NVIDIA UNIX x86_64 Kernel Module  535.104.05  Sat Aug 19 ..."
        let version = text.split_whitespace().find(|word| {
            word.split_once('.').is_some_and(|(branch, _)| branch.len() >= 3 && branch.parse::<u32>().is_ok())
        });
        match version.and_then(|version| Some((version, version.split('.').next()?.parse::<u32>().ok()?))) {
            Some((version, branch)) => CHECK.pass_if(branch >= OLDEST_BRANCH, version),
            None => CHECK.warn(Unreadable::new(VERSION, "no version number in it").to_string()),
        }
    })
}

fn mps(tree: &Tree<'_>) -> Finding {
    const CHECK: Check = Check {
        id: "gpu.mps",
        why: "under MPS other processes run on the GPU at the same time, and their kernels are in no WCET",
        fix: "echo quit | nvidia-cuda-mps-control",
    };
    // "nvidia-cuda-mps-control", as the kernel cuts it.
    CHECK.on(tree.runs("nvidia-cuda-mps"), |runs| {
        CHECK.pass_if(!runs, if runs { "running" } else { "not running" })
    })
}

fn only_from_driver(check: &Check, present: bool) -> Finding {
    if present { check.warn("not checked: only the driver tells") } else { check.pass(NO_GPU) }
}

fn power_mode(tree: &Tree<'_>, jetson: bool) -> Finding {
    const CHECK: Check = Check {
        id: "gpu.nvpmodel",
        why: "the power mode caps clocks and CPUs; 0 is the one with the most, and WCETs hold for one mode only",
        fix: "nvpmodel -m 0, and profile again after each change",
    };
    if !jetson {
        return CHECK.pass(NO_JETSON);
    }
    CHECK.on(tree.read("var/lib/nvpmodel/status"), |status| {
        let mode = status.trim_start_matches("pmode:").parse::<u32>();
        CHECK.pass_if(mode == Ok(0), status)
    })
}

/// The folder of the GPU among the devices with a variable clock.
fn gpu_clock(tree: &Tree<'_>) -> Result<String, Unreadable> {
    const FOLDER: &str = "sys/class/devfreq";
    let name = tree
        .names(FOLDER)?
        .into_iter()
        .find(|name| ["gpu", "gv11b", "ga10b", "gp10b"].iter().any(|gpu| name.contains(gpu)));
    name.map(|name| format!("{FOLDER}/{name}")).ok_or_else(|| Unreadable::new(FOLDER, "no GPU in it"))
}

fn clocks(tree: &Tree<'_>, jetson: bool) -> Finding {
    const CHECK: Check = Check {
        id: "gpu.jetson_clocks",
        why: "an idle GPU lowers its clock, and the first kernels after it run several times longer",
        fix: "jetson_clocks",
    };
    if !jetson {
        return CHECK.pass(NO_JETSON);
    }
    let range = || {
        let gpu = gpu_clock(tree)?;
        Ok((tree.read(&format!("{gpu}/min_freq"))?, tree.read(&format!("{gpu}/max_freq"))?))
    };
    CHECK.on(range(), |(low, high)| CHECK.pass_if(low == high, format!("{low}-{high} Hz")))
}

fn load_node(tree: &Tree<'_>, jetson: bool) -> Finding {
    const CHECK: Check = Check {
        id: "gpu.load_node",
        why: "the load of a Jetson's GPU, which overload control looks at, is read here (per mille)",
        fix: "use the kernel of NVIDIA's L4T, which has /sys/class/devfreq/<gpu>/device/load",
    };
    if !jetson {
        return CHECK.pass(NO_JETSON);
    }
    let load = || tree.read(&format!("{}/device/load", gpu_clock(tree)?));
    CHECK.on(load(), |load| CHECK.pass(load))
}

fn temperature(tree: &Tree<'_>) -> Finding {
    const CHECK: Check = Check {
        id: "gpu.thermal",
        why: "above its passive trip point the machine lowers its clocks, and WCETs no longer hold",
        fix: "cool it, or profile in a lower power mode",
    };
    const FOLDER: &str = "sys/class/thermal";
    CHECK.on(tree.names(FOLDER), |names| {
        let zones: Vec<_> = names.iter().filter(|name| name.starts_with("thermal_zone")).collect();
        let hot: Vec<_> = zones
            .iter()
            .filter_map(|zone| {
                let number =
                    |file: &str| tree.read(&format!("{FOLDER}/{zone}/{file}")).ok()?.parse::<i64>().ok();
                let passive = (0..16).find(|trip| {
                    tree.read(&format!("{FOLDER}/{zone}/trip_point_{trip}_type"))
                        .is_ok_and(|kind| kind == "passive")
                })?;
                let (now, limit) = (number("temp")?, number(&format!("trip_point_{passive}_temp"))?);
                (now >= limit).then(|| format!("{zone} at {now} of {limit} millidegrees"))
            })
            .collect();
        if hot.is_empty() {
            CHECK.pass(format!("none of {} zones above its passive trip point", zones.len()))
        } else {
            CHECK.warn(hot.join(", "))
        }
    })
}
