//! Logs that need no workload: their schedulers were set up by calls, which are in them.

use super::names::Names;
use super::refused::Refused;
use super::{Args, Log, compared};
use crate::outcome::{Answer, Failure};
use crate::progress;
use red_core::{Capacity, Empty, Scheduler};
use red_record::class::{self, ForClass, with_class};
use red_record::replay_calls;

/// Replays one and reports.
pub(super) fn main(args: &Args, log: Log) -> Result<Answer, Failure> {
    let (policy, capacities) = (log.header().policy.clone(), log.header().capacities);
    let refused = |reason, message: String| {
        Refused::new(&args.log, reason, message).tell(args.json, Some(policy.clone()), None)
    };
    if !args.what_if.is_empty() {
        return Err(refused(
            "no-workload",
            "--what-if: the log was set up by calls, and has no workload file in which something could be changed; write \
             the tasks as a workload file and try it with `redrt sim`, or record it with `redrt run --record`"
                .to_owned(),
        ));
    }
    with_class(capacities, Fed { args, log }).unwrap_or_else(|| {
        Err(refused(
            "capacities",
            format!(
                "it was recorded with capacities (tasks, nodes, jobs, lanes, pools) that this program does not have: \
                 {capacities:?}; it has {:?}; replay it with the program that recorded it",
                class::ALL
            ),
        ))
    })
}

/// A log that is fed to a scheduler of its class.
struct Fed<'a> {
    args: &'a Args,
    log: Log,
}

impl ForClass for Fed<'_> {
    type Output = Result<Answer, Failure>;

    fn with<C: Capacity>(self) -> Self::Output {
        let Self { args, mut log } = self;
        let mut scheduler: Box<Scheduler<C>> = Box::new(Scheduler::EMPTY);
        let mut names = Names::by_number(C::TASKS);
        let found = progress::during("replaying", || {
            replay_calls(&mut log, &mut scheduler, |_, entry| names.watch(entry))
        });
        let header = log.header();
        let found = found.map_err(|broken| {
            Refused::after(&args.log, &broken).tell(args.json, Some(header.policy.clone()), Some(&broken))
        })?;
        compared(args, header, &found, &names, &scheduler, None)
    }
}
