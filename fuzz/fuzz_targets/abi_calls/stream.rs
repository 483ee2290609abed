//! What a host may rely on whatever it called: a unit is given out once, on a lane that was free; a job that was released
//! ends once; what is counted is what happened.

use std::collections::BTreeMap;
use std::path::PathBuf;

use red_core::{Action, Outcome};
use red_ffi::{red_figures, red_status};

use crate::planted::{Bug, has};

/// Handles of the past that are kept for calls that should be refused.
const PAST: usize = 16;

#[derive(Default)]
pub(crate) struct Stream {
    /// Tasks that were ever admitted, and units that run or ran.
    pub(crate) tasks: Vec<u32>,
    /// Of a runtime: its tasks, with the windows of their floors.
    pub(crate) floors: Vec<(u32, u32)>,
    pub(crate) live: Vec<u64>,
    pub(crate) dead: Vec<u64>,
    /// Jobs that were released and did not end yet, with their tasks.
    jobs: BTreeMap<u32, u32>,
    retired: u32,
    last_unit: u64,
    units: u64,
    preempts: bool,
    /// Whether units may wait on lanes that run something, and be reported by those behind them.
    is_ahead: bool,
    /// Where its log is, if it has one.
    pub(crate) log: Option<PathBuf>,
    /// What a runtime says went wrong.
    pub(crate) said: &'static str,
}

impl Stream {
    pub(crate) fn new(preempts: bool) -> Self {
        Self { preempts, ..Self::default() }
    }

    pub(crate) fn goes_ahead(&mut self) {
        self.is_ahead = true;
    }

    pub(crate) fn released(&mut self, job: u32, task: u32) {
        assert!(self.jobs.insert(job, task).is_none(), "job {job:x} was another job's name");
    }

    pub(crate) fn act(&mut self, action: Option<Action>) {
        match action {
            Some(Action::Dispatch(started)) => {
                self.started(started.unit.to_bits(), started.lane.index());
                if has(Bug::Twice) {
                    self.started(started.unit.to_bits(), started.lane.index());
                }
            }
            Some(Action::Ahead(given)) => {
                assert!(self.is_ahead, "{given:?} of a pool that does not dispatch ahead");
                self.started(given.unit.to_bits(), given.lane.index());
            }
            Some(Action::Preempt(stopped)) => {
                assert!(self.preempts && self.end(stopped.unit.to_bits()), "{stopped:?} does not run");
            }
            Some(Action::Ended(outcome)) => self.ended(&outcome),
            _ => {}
        }
    }

    fn started(&mut self, unit: u64, lane: usize) {
        assert!(unit >> 16 > self.last_unit, "unit {unit:x} was given out before");
        assert_eq!(unit as u8, lane as u8, "a unit names its lane");
        let others = self.live.iter().filter(|other| **other as u8 == unit as u8).count();
        assert!(others == 0 || self.is_ahead, "two units on one lane");
        assert!(self.retired >> lane & 1 == 0, "a unit on a lane that was retired");
        self.last_unit = unit >> 16;
        self.units += 1;
        self.live.push(unit);
    }

    pub(crate) fn ended(&mut self, outcome: &Outcome) {
        let task = self.jobs.remove(&outcome.job.to_bits());
        assert_eq!(task, Some(outcome.task.to_bits()), "{outcome:?} of a job that was not in flight");
    }

    /// A unit was reported, and this was answered.
    pub(crate) fn reported(&mut self, unit: u64, status: red_status) {
        match status {
            red_status::Stale if self.is_ahead => _ = self.end(unit),
            red_status::Ok | red_status::Late => assert!(self.end(unit), "unit {unit:x} does not run"),
            _ => assert!(!self.live.contains(&unit), "unit {unit:x} runs"),
        }
    }

    /// Whether it ran.
    fn end(&mut self, unit: u64) -> bool {
        let Some(at) = self.live.iter().position(|live| *live == unit) else { return false };
        self.live.swap_remove(at);
        if self.dead.len() == PAST {
            self.dead.remove(0);
        }
        self.dead.push(unit);
        true
    }

    pub(crate) fn retire(&mut self, lane: u8) {
        let is_idle = self.live.iter().all(|unit| *unit as u8 != lane);
        assert!(is_idle || self.is_ahead, "a lane is retired that runs something");
        self.retired |= 1 << lane;
    }

    pub(crate) fn restore(&mut self, lane: u8) {
        assert!(self.retired >> lane & 1 != 0, "a lane is restored that was not retired");
        self.retired &= !(1 << lane);
    }

    pub(crate) fn holds(&self, figures: &red_figures) {
        let runs = figures.running as usize;
        assert!(runs == self.live.len() || self.is_ahead && runs <= self.live.len(), "units that run");
        assert_eq!(figures.units, self.units, "units that were given out");
        assert!(figures.jobs_in_flight as usize <= self.jobs.len(), "more jobs than were released");
    }

    /// Nothing is left.
    pub(crate) fn is_over(&self) -> bool {
        self.live.is_empty() && self.jobs.is_empty()
    }
}
