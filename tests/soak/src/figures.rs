//! Whether the figures of a run agree with what its bodies did.

use crate::bodies::Tried;
use red_rt::report::RunReport;
use std::sync::atomic::Ordering;

/// What the figures of a run contradict.
pub(crate) fn wrong_figures(report: &RunReport, tried: &Tried) -> Option<String> {
    let [ran, failed, panicked, died] =
        [&tried.ran, &tried.failed, &tried.panicked, &tried.died].map(|count| count.load(Ordering::Relaxed));
    let units = report.counters.units;
    // Of each lane a unit may lie unbegun at the end, whose job was given up or which a stop came before; of a thread
    // that was lost it may be discarded, and the figures are lost with the thread.
    let lost = report.hung + died;
    let unbegun = report.busy_ns.len() as u64 + lost;
    let wrong = failed + panicked;
    if let Some(why) = report.gave_up {
        Some(format!("the run gave up: {why}"))
    } else if report.lanes_lost > 0 {
        Some(format!("{} lanes were lost", report.lanes_lost))
    } else if report.events_dropped > 0 {
        Some(format!("{} events were dropped", report.events_dropped))
    } else if report.counters.clock_steps_back > 0 {
        Some(format!("time went back {} times", report.counters.clock_steps_back))
    } else if ran > units || units - ran > unbegun {
        Some(format!("{units} units, {ran} bodies; at most {unbegun} may not have begun"))
    } else if report.failed > wrong || wrong - report.failed > tried.untold(lost) {
        Some(format!("{failed} bodies failed and {panicked} panicked, told are {}", report.failed))
    } else if report.threads_died > died {
        Some(format!("{died} threads died, told are {}", report.threads_died))
    } else {
        None
    }
}

#[cfg(test)]
mod tests;
