//! What a real-time run must not do: fault pages in, and be pushed off its CPU.

use nix::sys::resource::{UsageWho, getrusage};

/// Counters of the kernel since the start of the process or thread.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Usage {
    /// Page faults served from memory.
    pub minor_faults: u64,
    /// Page faults that waited for a device.
    pub major_faults: u64,
    /// Times the CPU was taken away from a thread that wanted to run on.
    pub involuntary_switches: u64,
}

impl Usage {
    /// Of all threads of this process.
    #[must_use]
    pub fn of_process() -> Self {
        Self::read(UsageWho::RUSAGE_SELF)
    }

    /// Of the calling thread.
    #[must_use]
    pub fn of_thread() -> Self {
        Self::read(UsageWho::RUSAGE_THREAD)
    }

    /// What was added since `earlier`.
    #[must_use]
    pub const fn since(self, earlier: Self) -> Self {
        Self {
            minor_faults: self.minor_faults.saturating_sub(earlier.minor_faults),
            major_faults: self.major_faults.saturating_sub(earlier.major_faults),
            involuntary_switches: self.involuntary_switches.saturating_sub(earlier.involuntary_switches),
        }
    }

    fn read(who: UsageWho) -> Self {
        let usage = getrusage(who).expect("getrusage fails only for an unknown subject");
        Self {
            minor_faults: usage.minor_page_faults().unsigned_abs(),
            major_faults: usage.major_page_faults().unsigned_abs(),
            involuntary_switches: usage.involuntary_context_switches().unsigned_abs(),
        }
    }
}

#[cfg(test)]
mod tests;
