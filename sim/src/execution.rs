//! How long nodes execute.
//!
//! Times are drawn from a hash of (seed, task, job, part), not from a stream: every policy sees the same times
//! for the same work, whatever order it runs it in.

use red_workload::build::{Numbered, Role};
use red_workload::model::{Part, Work, Workload};
use std::str::FromStr;

/// Execution-time model.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Execution {
    /// Every node takes its WCET.
    #[default]
    Wcet,
    /// Uniform between two shares of the WCET, in parts per million.
    Uniform {
        /// Lower end.
        low_ppm: u32,
        /// Upper end.
        high_ppm: u32,
    },
    /// Uniform between two shares of the WCET, and sometimes longer by a share of it: a WCET that was measured.
    Tailed {
        /// Lower end, in parts per million.
        low_ppm: u32,
        /// Upper end, in parts per million.
        high_ppm: u32,
        /// How many executions in a million are longer.
        tail_ppm: u32,
        /// By what share of the WCET, in parts per million.
        longer_ppm: u32,
    },
}

const WHOLE: u64 = 1_000_000;

impl Execution {
    /// Shortest time of a part that the model can give, in nanoseconds.
    #[must_use]
    pub fn best_case(self, wcet_ns: u64) -> u64 {
        match self {
            Self::Wcet => wcet_ns,
            Self::Uniform { low_ppm, .. } | Self::Tailed { low_ppm, .. } => scale(wcet_ns, low_ppm.into()),
        }
    }

    /// The workload with the best cases that the model can give.
    #[must_use]
    pub fn best_cases_of(self, workload: &Workload) -> Workload {
        let mut timed = workload.clone();
        let set = |part: &mut Part| part.bcet_ns = self.best_case(part.wcet_ns);
        let of_tasks = timed.tasks.iter_mut().flat_map(|t| &mut t.nodes);
        let of_events = timed.events.iter_mut().flat_map(|e| &mut e.add);
        for node in of_tasks.chain(of_events) {
            match &mut node.work {
                Work::Plain(part) => set(part),
                Work::Stage(stage) => {
                    set(&mut stage.encoder);
                    stage.decoders.iter_mut().for_each(|(_, part)| set(part));
                }
            }
        }
        timed
    }

    /// Time of one execution of a node, in nanoseconds; a stage that is one node takes the times of its parts.
    #[must_use]
    pub fn draw(self, seed: u64, task: usize, job: u64, node: &Numbered) -> u64 {
        match &node.role {
            Role::Plain(part) | Role::Encoder { part, .. } | Role::Decoder { part, .. } => {
                self.part(seed, task, job, &node.name, part)
            }
            Role::Coarse(stage) => {
                let name = |part: &str| format!("{}.{part}", node.name);
                let encoder = self.part(seed, task, job, &name("encoder"), &stage.encoder);
                let decoder = |(d, part): &(String, Part)| self.part(seed, task, job, &name(d), part);
                stage.decoders.iter().map(decoder).fold(encoder, u64::saturating_add)
            }
        }
    }

    fn part(self, seed: u64, task: usize, job: u64, name: &str, part: &Part) -> u64 {
        let mut state = seed ^ 0x9E37_79B9_7F4A_7C15;
        let mut between = |low_ppm: u32, high_ppm: u32| {
            for word in [task as u64, job].into_iter().chain(name.bytes().map(u64::from)) {
                state = mix(state ^ word);
            }
            u64::from(low_ppm) + state % (u64::from(high_ppm.saturating_sub(low_ppm)) + 1)
        };
        match self {
            Self::Wcet => part.wcet_ns,
            Self::Uniform { low_ppm, high_ppm } => scale(part.wcet_ns, between(low_ppm, high_ppm)),
            Self::Tailed { low_ppm, high_ppm, tail_ppm, longer_ppm } => {
                let usual = between(low_ppm, high_ppm);
                let is_longer = between(0, WHOLE as u32 - 1) < u64::from(tail_ppm);
                scale(part.wcet_ns, usual + if is_longer { longer_ppm.into() } else { 0 })
            }
        }
    }
}

/// One round of splitmix64.
const fn mix(state: u64) -> u64 {
    let z = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

fn scale(ns: u64, ppm: u64) -> u64 {
    u64::try_from(u128::from(ns) * u128::from(ppm) / u128::from(WHOLE)).unwrap_or(u64::MAX)
}

impl FromStr for Execution {
    type Err = String;

    /// `wcet`, or `uniform:0.5..1.0`: shares of the WCET from 0 to 1 with at most six decimals.
    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || "expected `wcet` or `uniform:LOW..HIGH` with 0 <= LOW <= HIGH <= 1".to_owned();
        if text == "wcet" {
            return Ok(Self::Wcet);
        }
        let (low, high) =
            text.strip_prefix("uniform:").and_then(|r| r.split_once("..")).ok_or_else(expected)?;
        let (low_ppm, high_ppm) = (share(low).ok_or_else(expected)?, share(high).ok_or_else(expected)?);
        if low_ppm > high_ppm { Err(expected()) } else { Ok(Self::Uniform { low_ppm, high_ppm }) }
    }
}

/// A decimal between 0 and 1 in parts per million, exactly.
fn share(text: &str) -> Option<u32> {
    let (whole, decimals) = text.split_once('.').unwrap_or((text, ""));
    let digits = |t: &str| t.bytes().all(|b| b.is_ascii_digit());
    if whole.is_empty() || !digits(whole) || !digits(decimals) || decimals.len() > 6 {
        return None;
    }
    let ppm = format!("{whole}{decimals:0<6}").parse::<u32>().ok()?;
    (ppm <= 1_000_000).then_some(ppm)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_read_exactly() {
        let read = |t: &str| t.parse::<Execution>();
        assert_eq!(
            read("uniform:0.5..1.0"),
            Ok(Execution::Uniform { low_ppm: 500_000, high_ppm: 1_000_000 })
        );
        assert_eq!(read("uniform:0..0.25"), Ok(Execution::Uniform { low_ppm: 0, high_ppm: 250_000 }));
        for bad in [
            "",
            "uniform",
            "uniform:1..0.5",
            "uniform:0.5..1.5",
            "uniform:nan..1",
            "uniform:-0..1",
            "normal:0..1",
        ] {
            assert!(read(bad).is_err(), "{bad}");
        }
    }
}
