//! What programs read: the keys of `run --json` as far as a log knows them, and the misses with their blame.

use red_report::blame::steps;
use red_report::model::{Miss, Run, SubJob};
use red_sim::PoolMetrics;
use red_workload::metrics::TaskMetrics;
use serde::Serialize;

/// Whom a step names at most.
const NAMED: usize = 8;

/// A run.
#[derive(Serialize)]
pub(crate) struct Answer {
    policy: String,
    seed: u64,
    horizon_ns: u64,
    tasks: Vec<TaskMetrics>,
    nodes_missed: u64,
    units_dispatched: u64,
    encoder_runs_saved: u64,
    pools: Vec<PoolMetrics>,
    realtime: bool,
    program: String,
    /// The workload's file; empty where the run had none.
    file: String,
    /// The log.
    log: String,
    /// The page.
    pub(crate) report: String,
    end_ns: u64,
    edits: Vec<Edit>,
    standstills: Vec<Standstill>,
    misses: Vec<Missed>,
    groups: Vec<Cause>,
    tried: Vec<Change>,
    admission: Vec<String>,
}

/// What the answer has that the run has not.
pub(crate) struct About {
    pub(crate) horizon_ns: u64,
    pub(crate) realtime: bool,
    pub(crate) program: String,
    pub(crate) file: String,
    pub(crate) log: String,
    pub(crate) report: String,
}

#[derive(Serialize)]
struct Edit {
    at_ns: u64,
    change: String,
}

/// Nothing ran.
#[derive(Serialize)]
struct Standstill {
    from_ns: u64,
    until_ns: u64,
}

#[derive(Serialize)]
struct Missed {
    task: String,
    job: u64,
    release_ns: u64,
    deadline_ns: u64,
    /// When it ended, was given up, or the run ended.
    until_ns: u64,
    outcome: &'static str,
    reason: Option<String>,
    response_ns: u64,
    late_ns: u64,
    /// From the release on; as long together as the response.
    parts: Vec<Step>,
    saved_by: Option<String>,
}

#[derive(Serialize)]
struct Step {
    kind: &'static str,
    node: Option<String>,
    ns: u64,
    by: Vec<By>,
}

#[derive(Serialize)]
struct By {
    task: String,
    job: u64,
    node: String,
    ns: u64,
}

#[derive(Serialize)]
struct Cause {
    cause: String,
    misses: usize,
    saved_by: Option<String>,
    saves: usize,
}

#[derive(Serialize)]
struct Change {
    change: String,
    on_time: u64,
    missed: u64,
    saves: u64,
}

impl Answer {
    pub(crate) fn of(run: &Run, tasks: Vec<TaskMetrics>, about: About) -> Self {
        let lanes = |pool: usize| run.lanes.iter().filter(|lane| lane.pool == pool).count();
        let pools = run.pools.iter().enumerate().map(|(number, pool)| PoolMetrics {
            name: pool.name.clone(),
            lanes: u32::try_from(lanes(number)).unwrap_or(u32::MAX),
            busy_ns: pool.busy_ns,
        });
        let change = |tried: usize| run.tried.get(tried).map(|tried| tried.change.clone());
        let About { horizon_ns, realtime, program, file, log, report } = about;
        Self {
            policy: run.policy.clone(),
            seed: 0,
            horizon_ns,
            tasks,
            nodes_missed: run.nodes_missed,
            units_dispatched: run.units,
            encoder_runs_saved: run.saved,
            pools: pools.collect(),
            realtime,
            program,
            file,
            log,
            report,
            end_ns: run.end_ns,
            standstills: run
                .standstills
                .iter()
                .map(|(from_ns, until_ns)| Standstill { from_ns: *from_ns, until_ns: *until_ns })
                .collect(),
            edits: run
                .edits
                .iter()
                .map(|(at_ns, change)| Edit { at_ns: *at_ns, change: change.clone() })
                .collect(),
            misses: run.misses.iter().filter_map(|miss| missed(run, miss)).collect(),
            groups: run
                .groups
                .iter()
                .map(|group| Cause {
                    cause: group.cause.clone(),
                    misses: group.misses.len(),
                    saved_by: group.best.and_then(|(tried, _)| change(tried)),
                    saves: group.best.map_or(0, |(_, saves)| saves),
                })
                .collect(),
            tried: run
                .tried
                .iter()
                .map(|tried| Change {
                    change: tried.change.clone(),
                    on_time: tried.on_time,
                    missed: tried.missed,
                    saves: tried.saves,
                })
                .collect(),
            admission: run.certificate.clone(),
        }
    }
}

fn missed(run: &Run, miss: &Miss) -> Option<Missed> {
    let job = run.job(miss.task, miss.job)?;
    let by = |((task, job, node), ns): &(SubJob, u64)| By {
        task: run.task(*task).to_owned(),
        job: *job,
        node: run.node(*task, *node),
        ns: *ns,
    };
    let parts = steps(&miss.parts).into_iter().map(|step| Step {
        kind: step.kind.name(),
        node: step.node.map(|node| run.node(miss.task, node)),
        ns: step.ns,
        by: step.by.iter().take(NAMED).map(by).collect(),
    });
    Some(Missed {
        task: run.task(miss.task).to_owned(),
        job: miss.job,
        release_ns: job.release_ns,
        deadline_ns: job.deadline_ns,
        until_ns: miss.until_ns,
        outcome: run.outcome(job),
        reason: job.shed.clone(),
        response_ns: miss.until_ns.saturating_sub(job.release_ns),
        late_ns: miss.until_ns.saturating_sub(job.deadline_ns),
        parts: parts.collect(),
        saved_by: miss.saved_by.and_then(|tried| run.tried.get(tried)).map(|tried| tried.change.clone()),
    })
}
