//! What admission says of a workload, in words.

use crate::plan::of_limit;
use crate::table::at_most;
use red_core::Duration;
use red_workload::plan::{Guarantee, Plan, Proof};

/// A line for each task, one for each graph after an edit, and the verdict.
pub(super) fn words(plan: &Plan) -> Vec<String> {
    let admission = &plan.admission;
    let verdict =
        if admission.fits { "Every test says that the workload fits" } else { "The workload does not fit" };
    let worth = match (admission.fits, admission.guarantee) {
        (_, Guarantee::Analytic) => {
            "; proved for every release offset and every execution time up to the WCET"
        }
        (true, _) => "; that is no proof, `redrt plan` simulates it",
        (false, _) => "; `redrt plan` says what would make it fit",
    };
    let mut lines = vec![
        format!("{verdict}{worth}."),
        format!("Binding: {}, margin {}.", admission.binding, of_limit(plan, admission.margin_ns)),
    ];
    for task in &plan.tasks {
        lines.push(format!("{}: {}", task.name, bound(&task.certificate.base)));
        for proof in &task.certificate.changes {
            let at = Duration::from_nanos(proof.at_ns);
            lines.push(format!("{}, after the edit at {at}: {}", task.name, bound(proof)));
        }
    }
    lines.extend(together(plan));
    lines.push("This is of the default policy, with every node at its WCET; a bound of a job alone is of one that has its lanes to itself.".to_owned());
    lines
}

/// What is proved of each task beside all others; nothing of a task that is alone anyway.
fn together(plan: &Plan) -> Vec<String> {
    let tasks = &plan.certificate.tasks;
    if tasks.len() < 2 {
        return Vec::new();
    }
    let of = |task: &red_certificate::TaskProof| match task.response_ns {
        Some(ns) => format!(
            "{}, beside all other tasks: every job is proved to end within {} of its release.",
            task.name,
            at_most(ns)
        ),
        None => format!("{}, beside all other tasks: nothing is proved.", task.name),
    };
    tasks.iter().map(of).collect()
}

fn bound(proof: &Proof) -> String {
    let name = match proof.bound {
        "several-pools" => "Graham's bound over its pools",
        "long-path" => "its longest disjoint paths",
        _ => "Graham's bound",
    };
    let verdict = if proof.fits { "within" } else { "above" };
    let but = if proof.memory_holds && proof.shares_evenly {
        ""
    } else {
        "; not sufficient, for nodes may wait for memory or an encoder"
    };
    format!(
        "a job alone ends within {} by {}, {verdict} the limit of {}{but}.",
        at_most(proof.response_ns),
        name,
        Duration::from_nanos(proof.limit_ns)
    )
}
