//! Whether memory stays flat: bytes in use on the heap, looked at after every workload when all of it is gone.
//!
//! Single looks differ by what a thread that ends late still holds. So medians are compared: of the last quarter of the
//! workloads with that of the second one. The first is left out, in which tables of the process grow to their size.

use crate::allocator::live_bytes;
use std::fmt;
use std::fs;

/// What a workload may leave behind. It owns some hundred kilobytes while it runs.
const BOUND: f64 = 256.0;
/// Fewer workloads say nothing.
const FEWEST: usize = 16;
/// What the process may have from the kernel: so many times what it had after the first quarter, and more.
const RESIDENT_TIMES: u64 = 2;
const RESIDENT_PLUS_KIB: u64 = 64 * 1024;

/// One look.
#[derive(Clone, Copy, Debug)]
struct Look {
    live: usize,
    resident_kib: u64,
}

/// All looks of a soak.
pub(crate) struct Memory {
    looks: Vec<Look>,
}

/// What they say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Verdict {
    /// Too few.
    Unknown,
    Flat(Growth),
    Grows(Growth),
}

/// How memory grew.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Growth {
    /// Bytes of the heap, by the workload.
    bytes: f64,
    live: usize,
    resident_kib: u64,
    resident_bound_kib: u64,
}

impl Memory {
    /// With room for so many looks, so that it does not grow itself.
    pub(crate) fn with_room(looks: usize) -> Self {
        Self { looks: Vec::with_capacity(looks) }
    }

    /// Looks now.
    pub(crate) fn look(&mut self) {
        self.looks.push(Look { live: live_bytes(), resident_kib: resident_kib() });
    }

    /// What the looks so far say.
    pub(crate) fn verdict(&self) -> Verdict {
        let count = self.looks.len();
        if count < FEWEST {
            return Verdict::Unknown;
        }
        let quarter = |number: usize| {
            let part = &self.looks[count * number / 4..count * (number + 1) / 4];
            let mut live: Vec<usize> = part.iter().map(|look| look.live).collect();
            live.sort_unstable();
            live[live.len() / 2]
        };
        let (before, after) = (quarter(1), quarter(3));
        let resident_bound_kib = self.looks[count / 4].resident_kib * RESIDENT_TIMES + RESIDENT_PLUS_KIB;
        let growth = Growth {
            bytes: (after as f64 - before as f64) / (count as f64 / 2.0),
            live: after,
            resident_kib: self.looks[count - 1].resident_kib,
            resident_bound_kib,
        };
        let is_flat = growth.bytes <= BOUND && growth.resident_kib <= resident_bound_kib;
        if is_flat { Verdict::Flat(growth) } else { Verdict::Grows(growth) }
    }
}

impl fmt::Display for Growth {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} KiB in use, {:+.0} bytes a workload (bound {BOUND:.0} bytes); {} MiB resident (bound {} MiB)",
            self.live / 1024,
            self.bytes,
            self.resident_kib / 1024,
            self.resident_bound_kib / 1024
        )
    }
}

/// Memory of this process that is in RAM, in KiB.
fn resident_kib() -> u64 {
    let status = fs::read_to_string("/proc/self/status").expect("/proc is mounted");
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let number = line.and_then(|line| line.split_whitespace().next()?.parse().ok());
    // A bound that is held against nothing would always hold.
    number.expect("the kernel says VmRSS")
}

#[cfg(test)]
mod tests;
