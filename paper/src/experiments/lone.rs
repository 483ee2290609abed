//! A pipeline that runs ten times, one run after the other: the setting of section 5.

use crate::platform::{EXECUTION, Platform};
use crate::scenario::{Calls, OBSTACLE, OBSTACLE_FREE, Scenario, workload};
use crate::trial::Trial;
use red_workload::model::{Arrival, SyncGrid};

/// The two scenarios of section 5.
pub(super) const SCENARIOS: [Scenario; 2] = [OBSTACLE_FREE, OBSTACLE];

/// Runs of each scenario.
pub(super) const RUNS: u64 = 10;

/// From one run to the next: so long that each ends before the next, and an odd part of a barrier interval, so that runs
/// begin everywhere between two barriers.
fn spacing_ns(platform: &Platform, deadline_ns: u64) -> u64 {
    const ODD_PER_MILLE: u64 = 382;
    let grid = platform.grid_ns();
    (4 * deadline_ns.max(platform.loose_ns)).next_multiple_of(grid) + grid * ODD_PER_MILLE / 1_000
}

/// Ten runs of a scenario.
pub(super) fn trial(platform: &Platform, scenario: &Scenario, deadline_ns: u64, calls: Calls) -> Trial {
    let period_ns = spacing_ns(platform, deadline_ns);
    let task = calls.pipeline(scenario.stages, deadline_ns, Arrival::Periodic { period_ns });
    let sync = SyncGrid { grid_ns: platform.grid_ns(), cost_ns: platform.barrier_ns };
    Trial {
        workload: workload(platform.lanes, vec![task], Some(sync)),
        execution: EXECUTION,
        horizon_ns: RUNS * period_ns,
    }
}
