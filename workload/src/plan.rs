//! What `redrt plan` says about a workload: heights, shares, sub-deadlines by every rule, bounds, and the verdict.
//!
//! Field names and their order are a contract: other programs read them as JSON. Fields that are skipped there
//! are for people.

mod admission;
mod cure;
mod division;
mod level_capacity;
mod search;
mod together;
mod utilisation;

use crate::build::{self, BuildError};
use crate::model::{Arrival, Task, Workload};
use admission::{Pools, Versions};
use level_capacity::level_capacity;
use red_core::{
    Capacity, Config, Dag, DeadlineRule, Duration, Empty, LevelShare, Levels, Scheduler, SubDeadlines, shares,
};
use serde::Serialize;

pub use admission::{Admission, Certificate, Guarantee, Proof};
pub use cure::{Cure, Stretch};
pub use division::{Divided, Division, division};
pub use search::{Cures, Judge, cures, passes};

/// A whole plan.
#[derive(Clone, Debug, Serialize)]
pub struct Plan {
    /// Per task, in file order.
    pub tasks: Vec<TaskPlan>,
    /// Whether everything fits together.
    pub admission: Admission,

    /// State of the scheduler, without its event record.
    pub scheduler_bytes: usize,
    /// What is proved of all tasks together; `redrt verify` checks it against the workload.
    pub certificate: red_certificate::Certificate,
    /// Clusters that would prove more tasks, once somebody looked for some; see [`division`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub division: Option<Division>,
}

/// A task before its first event.
#[derive(Clone, Debug, Serialize)]
pub struct TaskPlan {
    /// Task.
    pub name: String,
    /// End-to-end deadline D.
    pub deadline_ns: u64,
    /// Sum of all costs.
    pub work_ns: u64,
    /// Cost of the longest path.
    pub critical_path_ns: u64,
    /// From the sources on.
    pub levels: Vec<LevelPlan>,
    /// In file order, refined stages expanded in place.
    pub nodes: Vec<NodePlan>,
    /// Bounds on the response time of the task alone.
    pub certificate: Certificate,
}

/// One level of a task's graph.
#[derive(Clone, Debug, Serialize)]
pub struct LevelPlan {
    /// Height of its nodes.
    pub height: usize,
    /// Sum of their costs.
    pub cost_ns: u64,
    /// Share of the deadline under the paper's rule, LevelSum.
    pub share_ns: u64,
    /// Graham's bound of the level alone on its lanes.
    #[serde(skip)]
    pub graham_ns: u64,
}

/// One node of a task's graph. Sub-deadlines count from the release.
#[derive(Clone, Debug, Serialize)]
pub struct NodePlan {
    /// `camera`, `perception.lane`.
    pub name: String,
    /// Edges on the longest way from a source.
    pub height: usize,
    /// WCET, plus contention where atomic.
    pub cost_ns: u64,
    /// Sub-deadline of the paper's rule.
    pub level_sum_ns: i64,
    /// Sub-deadline with Graham's bound of each level covered first.
    pub level_graham_ns: i64,
    /// D * head / (head + tail).
    pub path_proportional_ns: i64,
    /// D - tail: below zero where D is below the critical path.
    pub latest_finish_ns: i128,
    /// D - tail - cost.
    pub latest_start_ns: i128,
    /// Index of its pool.
    #[serde(skip)]
    pub pool: usize,
    /// Footprint.
    #[serde(skip)]
    pub memory_bytes: u64,
}

/// Plans a workload for an executive of these capacities.
///
/// # Errors
/// [`BuildError`]; not for files that this crate accepted, with the capacities of `redrt`.
pub fn plan<C: Capacity>(workload: &Workload) -> Result<Plan, BuildError> {
    let built = built::<C>(workload)?;
    let pools = Pools::of(workload);
    let versions = admission::versions(workload, &built, &pools)?;
    let certificate = red_analysis::prove(&together::set(workload, &built, &versions)?);
    let tasks = workload.tasks.iter().enumerate();
    Ok(Plan {
        tasks: tasks
            .map(|(i, task)| task_plan(task, &built.dags[i], &built.nodes[i], &versions[i], &pools))
            .collect(),
        admission: admission::judge(workload, &pools, &versions, &certificate),
        scheduler_bytes: Scheduler::<C>::SIZE - Scheduler::<C>::RECORD_SIZE,
        certificate,
        division: None,
    })
}

/// A workload as a [`Certificate`](red_certificate::Certificate) is about it.
///
/// # Errors
/// As [`plan`].
pub fn set<C: Capacity>(workload: &Workload) -> Result<red_certificate::Set, BuildError> {
    let built = built::<C>(workload)?;
    let versions = admission::versions(workload, &built, &Pools::of(workload))?;
    together::set(workload, &built, &versions)
}

/// The graphs of a workload, as the default policy has them.
fn built<C: Capacity>(workload: &Workload) -> Result<build::Plan<C>, BuildError> {
    let mut scheduler: Box<Scheduler<C>> = Box::new(Scheduler::EMPTY);
    Ok(build::admit(&mut scheduler, workload, Config::REDRT)?.0)
}

fn task_plan<C: Capacity>(
    task: &Task,
    dag: &Dag<C>,
    numbered: &[build::Numbered],
    versions: &Versions,
    pools: &Pools,
) -> TaskPlan {
    let levels = Levels::of(dag);
    let deadline = Duration::from_nanos(task.deadline_ns);
    let level_sum = shares(&levels, DeadlineRule::LevelSum, deadline, &pools.lanes);
    let level_sum = level_sum.as_ref().get(..levels.count()).unwrap_or_default();
    let capacity = level_capacity(level_sum, dag.work(), deadline, versions.base.proof.lanes);
    TaskPlan {
        name: task.name.clone(),
        deadline_ns: task.deadline_ns,
        work_ns: dag.work(),
        critical_path_ns: levels.critical_path(),
        levels: level_plans(level_sum),
        nodes: node_plans(dag, &levels, level_sum, deadline, numbered, pools),
        certificate: Certificate::of(versions, &capacity),
    }
}

fn level_plans(shares: &[LevelShare]) -> Vec<LevelPlan> {
    let level = |(height, level): (usize, &LevelShare)| LevelPlan {
        height,
        cost_ns: level.cost,
        share_ns: level.share,
        graham_ns: level.graham,
    };
    shares.iter().enumerate().map(level).collect()
}

fn node_plans<C: Capacity>(
    dag: &Dag<C>,
    levels: &Levels<'_, C>,
    level_sum: &[LevelShare],
    deadline: Duration,
    numbered: &[build::Numbered],
    pools: &Pools,
) -> Vec<NodePlan> {
    let level_graham = shares(levels, DeadlineRule::LevelGraham, deadline, &pools.lanes);
    let proportional = SubDeadlines::assign(levels, DeadlineRule::PathProportional, deadline, &pools.lanes);
    let nodes = dag.nodes().zip(numbered).filter_map(|(id, numbered)| {
        let (node, height) = (dag.node(id)?, levels.height(id));
        // The scheduler's own keys saturate; here D - tail is exact for every cost that a file can hold.
        let latest_finish_ns = i128::from(deadline.as_nanos()) - i128::from(levels.tail(id));
        Some(NodePlan {
            name: numbered.name.clone(),
            height,
            cost_ns: node.cost(),
            level_sum_ns: level_sum.get(height)?.end.cast_signed(),
            level_graham_ns: level_graham[height].end.cast_signed(),
            path_proportional_ns: proportional.sub_deadline(id),
            latest_finish_ns,
            latest_start_ns: latest_finish_ns - i128::from(node.cost()),
            pool: node.pool().index(),
            memory_bytes: node.footprint().0,
        })
    });
    nodes.collect()
}

/// Period or minimum inter-arrival time; `None` for a task that is released once.
const fn period_ns(task: &Task) -> Option<u64> {
    match task.arrival {
        Arrival::Periodic { period_ns: t } | Arrival::Sporadic { min_interarrival_ns: t } => Some(t),
        Arrival::Once => None,
    }
}

#[cfg(test)]
mod tests;
