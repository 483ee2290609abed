//! What only the CUDA driver tells.

use super::Finding;
use super::check::Check;
use crate::cuda::{self, CudaUnavailable};
use red_cuda::{CudaError, Device, Driver, LoadError};

const CHECK: Check = Check {
    id: "measure.cuda",
    why: "pools of kind cuda run on this device, whose most urgent streams go before other work on it",
    fix: "follow the gpu.* findings above",
};

/// Opens the first CUDA device, and tells what it has; where there is no driver, that there is none.
pub fn device() -> Finding {
    match cuda::open(0) {
        Ok(device) => match told(&device) {
            Ok((value, has_priorities)) => CHECK.pass_if(has_priorities, value),
            Err(error) => CHECK.warn(CudaUnavailable::from(error).to_string()),
        },
        Err(CudaUnavailable::Driver(LoadError::NoLibrary(_))) => {
            CHECK.pass("no CUDA driver: nothing to check")
        }
        Err(why) => CHECK.warn(why.to_string()),
    }
}

/// In words, and whether streams have more than one priority.
fn told(device: &Device) -> Result<(String, bool), CudaError> {
    const MIB: usize = 1 << 20;
    let version = Driver::load().map_or(0, Driver::version);
    let ((major, minor), (free, total)) = (device.capability()?, device.memory()?);
    let priorities = device.priorities()?;
    let count = priorities.least_urgent.abs_diff(priorities.most_urgent) + 1;
    let value = format!(
        "{}, compute capability {major}.{minor}, CUDA {}.{}, {} of {} MiB free, {count} {} of streams",
        device.name(),
        version / 1000,
        version % 1000 / 10,
        free / MIB,
        total / MIB,
        if count == 1 { "priority" } else { "priorities" },
    );
    Ok((value, count > 1))
}
