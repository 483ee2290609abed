//! The log of a workload, fed to a scheduler again: as `redrt replay` does, from nothing but the log.

use crate::judge::Robot;
use red_core::{CommitError, Empty, LaneId, Scheduler};
use red_record::{Reader, replay};
use red_workload::policy::Policy;
use red_workload::{Format, build, parse};
use std::fmt::Display;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// How many inputs were replayed. `planted`: the scheduler has a lane less than the one that was recorded.
pub(crate) fn replayed(log: &Path, planted: bool) -> Result<u64, String> {
    let file = File::open(log).map_err(|e| told(&e))?;
    let mut reader = Reader::new(BufReader::new(file)).map_err(|e| told(&e))?;
    let header = reader.header();
    let policy: Policy = header.policy.parse()?;
    let workload = parse(header.workload.as_bytes(), Format::Toml, &header.file).map_err(|e| told(&e))?;
    let mut scheduler: Box<Scheduler<Robot>> = Box::new(Scheduler::EMPTY);
    let (plan, tasks) = build::admit(&mut scheduler, &workload, policy.config()).map_err(|e| told(&e))?;
    if planted {
        scheduler.retire_lane(LaneId::new(0));
    }
    let change = |scheduler: &mut Scheduler<Robot>, number: u32, now| {
        let change = plan.changes.get(number as usize).ok_or(CommitError::UnknownTask)?;
        build::apply(scheduler, change, tasks[change.task], now)
    };
    let found = replay(&mut reader, &mut scheduler, change, |_, _| {}).map_err(|e| told(&e))?;
    found.difference.map_or(Ok(found.inputs), |difference| {
        Err(format!(
            "input {} is replayed as {}, it was {}",
            difference.input, difference.now, difference.recorded
        ))
    })
}

fn told(error: &impl Display) -> String {
    format!("the log: {error}")
}
