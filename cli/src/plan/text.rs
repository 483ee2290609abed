//! A plan for people.

use super::Planned;
use super::overload::Overload;
use crate::table::{Table, at_most, signed, time};
use red_core::Duration;
use red_workload::model::{Arrival, Task, Workload};
use red_workload::plan::{Cures, Guarantee, Plan, Proof, TaskPlan};

/// The whole plan: tasks, pools, verdict, and why it does not fit where it does not.
pub(super) fn text(workload: &Workload, planned: &Planned, why: &[String]) -> String {
    let Planned { plan, overload } = planned;
    let mut parts: Vec<String> = workload
        .tasks
        .iter()
        .zip(&plan.tasks)
        .map(|(task, planned)| of_task(workload, task, planned))
        .collect();
    parts.push(pools(workload, plan).to_string());
    parts.push(together(plan));
    parts.push(verdict(plan));
    parts.push(why.join("\n"));
    if !plan.admission.fits {
        parts.push(overload.as_ref().map_or_else(|| Overload::none(workload), Overload::text));
    }
    parts.retain(|part| !part.is_empty());
    parts.join("\n\n")
}

/// Which test says that it does not fit.
pub(super) fn refusal(plan: &Plan) -> Vec<String> {
    let missing = of_limit(plan, -plan.admission.margin_ns);
    vec![format!("does not fit: {} exceeds its limit by {missing}", plan.admission.binding)]
}

/// What makes it fit, in lines; `is_cut_short`: the search ended before it had seen everything.
pub(super) fn remedies(cures: &Cures, is_cut_short: bool) -> Vec<String> {
    let mut lines = match (&cures.single[..], &cures.together) {
        ([], Some(cure)) => vec![
            "no single change of deadlines, periods, lanes or costs was found that makes it fit; together these do:"
                .to_owned(),
            format!("  {cure}"),
        ],
        ([], None) => vec![
            "no single change of deadlines, periods, lanes or costs was found that makes it fit, and no slower pace \
             of all tasks"
                .to_owned(),
        ],
        _ => vec!["any one of these makes it fit:".to_owned()],
    };
    lines.extend(cures.single.iter().map(|cure| format!("  {cure}")));
    if is_cut_short {
        lines.push("the search was cut short, for the workload is large: there may be more".to_owned());
    }
    lines
}

fn of_task(workload: &Workload, task: &Task, planned: &TaskPlan) -> String {
    let arrival = match task.arrival {
        Arrival::Periodic { period_ns } => format!("period {}", Duration::from_nanos(period_ns)),
        Arrival::Sporadic { min_interarrival_ns: t } => {
            format!("min inter-arrival {}", Duration::from_nanos(t))
        }
        Arrival::Once => "released once".to_owned(),
    };
    let head = format!(
        "task `{}`: deadline {}, {arrival}, work {}, critical path {}",
        task.name,
        Duration::from_nanos(task.deadline_ns),
        Duration::from_nanos(planned.work_ns),
        Duration::from_nanos(planned.critical_path_ns),
    );
    let certificate = &planned.certificate;
    let proofs = [&certificate.base].into_iter().chain(&certificate.changes);
    let proofs: Vec<String> = proofs.enumerate().map(|(i, proof)| in_words(proof, i > 0)).collect();
    let short: Vec<String> = planned
        .levels
        .iter()
        .filter(|level| level.graham_ns > level.share_ns)
        .map(|level| level.height.to_string())
        .collect();
    let by_level = match short.len() {
        0 => "  by level: each level's Graham bound is within its share".to_owned(),
        _ => format!(
            "  by level: Graham bound above the share at height {}; not needed to fit",
            short.join(", ")
        ),
    };
    let condition = if certificate.paper_condition { "holds" } else { "does not hold" };
    let condition =
        format!("  paper's condition (ii), work <= lanes * deadline: {condition}; necessary only");
    let tables = [levels(planned), nodes(workload, planned), sub_deadlines(planned)].map(|t| t.to_string());
    let legend = "  by level sum, level Graham, path proportion, latest finish, latest start";
    format!("{head}\n\n{}\n{legend}\n\n{}\n{by_level}\n{condition}", tables.join("\n\n"), proofs.join("\n"))
}

fn levels(planned: &TaskPlan) -> Table {
    let mut table = Table::new(&["height", "cost", "share", "Graham bound"]);
    for level in &planned.levels {
        let times = [level.cost_ns, level.share_ns, level.graham_ns].map(|ns| time(Some(ns)));
        table.row([level.height.to_string()].into_iter().chain(times));
    }
    table
}

fn nodes(workload: &Workload, planned: &TaskPlan) -> Table {
    let mut table = Table::new(&["node", "height", "pool", "memory", "cost"]);
    for node in &planned.nodes {
        let pool = workload.pools.get(node.pool).map_or("", |pool| &pool.name);
        let names = [node.name.clone(), node.height.to_string(), pool.to_owned(), memory(node.memory_bytes)];
        table.row(names.into_iter().chain([time(Some(node.cost_ns))]));
    }
    table
}

/// By every rule; two columns of them are latest instants.
fn sub_deadlines(planned: &TaskPlan) -> Table {
    let mut table = Table::new(&["sub-deadline", "level sum", "Graham", "path", "finish", "start"]);
    for node in &planned.nodes {
        let due = [
            node.level_sum_ns.into(),
            node.level_graham_ns.into(),
            node.path_proportional_ns.into(),
            node.latest_finish_ns,
            node.latest_start_ns,
        ];
        table.row([node.name.clone()].into_iter().chain(due.map(signed)));
    }
    table
}

/// A certificate in words: the bound, its numbers, and what it is held against.
fn in_words(proof: &Proof, is_change: bool) -> String {
    let when =
        if is_change { format!("after {}", Duration::from_nanos(proof.at_ns)) } else { "alone".to_owned() };
    let (work, path) = (Duration::from_nanos(proof.work_ns), Duration::from_nanos(proof.critical_path_ns));
    let bound = match proof.bound {
        "several-pools" => format!("(1 - 1/{}) * L + the sum of W/m over its pools", proof.lanes),
        "long-path" => format!("L + what is beside the {} longest disjoint paths", proof.paths),
        _ => format!("L + (W - L)/m, m = {}", proof.lanes),
    };
    let verdict = if proof.fits { "within" } else { "above" };
    let but = match (proof.memory_holds, proof.shares_evenly) {
        (true, true) => "",
        (false, _) => "; not sufficient, for nodes may wait for memory",
        (true, false) => "; not sufficient, for an encoder may wait for a longer one of its frame",
    };
    format!(
        "  {when}: response <= {} by {} ({bound}; W {work}, L {path}), {verdict} min(deadline, period) {}, margin \
         {}{but}",
        at_most(proof.response_ns),
        proof.bound,
        Duration::from_nanos(proof.limit_ns),
        signed(proof.margin_ns),
    )
}

fn pools(workload: &Workload, plan: &Plan) -> Table {
    let mut table = Table::new(&["pool", "lanes", "memory", "largest node", "all nodes"]);
    for (p, pool) in workload.pools.iter().enumerate() {
        let here = || plan.tasks.iter().flat_map(|task| &task.nodes).filter(|node| node.pool == p);
        let all = here().map(|node| node.memory_bytes).sum();
        let largest = here().map(|node| node.memory_bytes).max().unwrap_or(0);
        let budget = pool.memory_bytes.map_or_else(|| "unlimited".to_owned(), memory);
        table.row([pool.name.clone(), pool.lanes.to_string(), budget, memory(largest), memory(all)]);
    }
    table
}

/// What is proved of all tasks together, and by which division more would be; nothing of a task that is alone anyway.
fn together(plan: &Plan) -> String {
    let tasks = &plan.certificate.tasks;
    if tasks.len() < 2 {
        return String::new();
    }
    let mut lines = vec!["all tasks together, for every offset and execution time:".to_owned()];
    for task in tasks {
        let slowest = task.versions.iter().find(|version| version.response_ns == task.response_ns);
        let proof = slowest.and_then(|version| version.proof.as_ref());
        lines.push(match task.response_ns.zip(proof) {
            Some((ns, proof)) => {
                format!("  task `{}`: response <= {} by {}", task.name, at_most(ns), proof.name())
            }
            None => format!("  task `{}`: not proved", task.name),
        });
    }
    if tasks.iter().any(|task| task.response_ns.is_none())
        && tasks.iter().any(|task| task.response_ns.is_some())
    {
        lines.push(
            "  (bounds of tasks that share lanes with one that is not proved end where that one is late)"
                .to_owned(),
        );
    }
    if let Some(division) = &plan.division {
        lines.push(format!(
            "with these clusters {} of {} tasks are proved; put into the file:\n{division}",
            division.proved,
            tasks.len()
        ));
    }
    lines.join("\n").trim_end().to_owned()
}

fn verdict(plan: &Plan) -> String {
    let admission = &plan.admission;
    let worth = match admission.guarantee {
        Guarantee::Analytic => {
            "analytic: proved for every release offset and every execution time up to the WCET"
        }
        Guarantee::Empirical => {
            "empirical: every test says yes and a simulation at WCET shows no miss; not a proof"
        }
        Guarantee::BestEffort => {
            "best effort: no proof, and no simulation without a miss that saw every task and event"
        }
    };
    let fits = if admission.fits { "yes" } else { "no" };
    format!(
        "fits: {fits}\nguarantee: {worth}\nbinding: {}, margin {}\nscheduler state: {} bytes",
        admission.binding,
        of_limit(plan, admission.margin_ns),
        plan.scheduler_bytes,
    )
}

/// A margin of the binding test, in what the test measures.
pub(crate) fn of_limit(plan: &Plan, margin_ns: i128) -> String {
    let unit =
        if plan.admission.binding.starts_with("utilisation") { " of lane time per second" } else { "" };
    format!("{}{unit}", signed(margin_ns))
}

fn memory(bytes: u64) -> String {
    let (count, unit) = match bytes {
        0 => return "-".to_owned(),
        b if b.is_multiple_of(1 << 30) => (b >> 30, "GiB"),
        b if b.is_multiple_of(1 << 20) => (b >> 20, "MiB"),
        b if b.is_multiple_of(1 << 10) => (b >> 10, "KiB"),
        b => (b, "B"),
    };
    format!("{count} {unit}")
}
