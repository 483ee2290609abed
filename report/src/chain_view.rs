//! Misses: why, in groups of one cause, and the chain of each.

use crate::blame::steps;
use crate::escape::html;
use crate::model::{Job, Kind, Miss, Run};
use crate::time::time;
use std::cmp::Reverse;
use std::fmt::Write;

/// Chains that a page shows: the worst ones, the first of them without being asked. The data in the page has them all.
const SHOWN: usize = 60;
const FIRST: usize = 6;
/// Whom a step names.
const NAMED: usize = 3;
/// Steps of a chain that are written out.
const STEPS: usize = 40;

/// The section; nothing where no job missed.
pub(crate) fn section(run: &Run) -> String {
    if run.misses.is_empty() {
        return "<p>No job missed its deadline.</p>".to_owned();
    }
    let mut out = String::new();
    groups(&mut out, run);
    tried(&mut out, run);
    out.push_str("<h4>The critical chain of each</h4><p class=\"note\">From a job's last node back to its release: each piece is \
                  time that nothing of the same job could have used better, and the pieces are as long together as the response. \
                  Execution is from the decision to start until the report of the end, so waking a lane's thread is in it: a log \
                  has no instant in between.</p>");
    legend(&mut out, run);
    let worst = worst(run);
    for (nth, (miss, job)) in worst.iter().take(SHOWN).enumerate() {
        if nth == FIRST {
            let more = worst.len().min(SHOWN) - FIRST;
            let _infallible = write!(out, "<details class=\"more\"><summary>{more} more</summary>");
        }
        one(&mut out, run, miss, job);
    }
    if worst.len() > FIRST {
        out.push_str("</details>");
    }
    if worst.len() > SHOWN {
        let _infallible = write!(
            out,
            "<p class=\"note\">{SHOWN} of {}: the latest of each cause, then the latest of all. The data of this page \
             (<code>redrt-data</code>) has the chain of each.</p>",
            worst.len()
        );
    }
    out
}

/// The latest of each cause, then all others, the latest first.
fn worst(run: &Run) -> Vec<(&Miss, &Job)> {
    let of = |i: usize| run.misses.get(i).and_then(|miss| Some((miss, run.job(miss.task, miss.job)?)));
    let late = |i: usize| of(i).map_or(0, |(miss, job)| miss.until_ns.saturating_sub(job.deadline_ns));
    let latest = |misses: &Vec<usize>| misses.iter().copied().min_by_key(|i| (Reverse(late(*i)), *i));
    let of_causes: Vec<usize> = run.groups.iter().filter_map(|group| latest(&group.misses)).collect();
    let mut worst: Vec<usize> = (0..run.misses.len()).collect();
    worst.sort_by_key(|i| (!of_causes.contains(i), Reverse(late(*i)), *i));
    worst.into_iter().filter_map(of).collect()
}

fn groups(out: &mut String, run: &Run) {
    out.push_str("<div class=\"scroll\"><table><thead><tr><th>what most of the time went to</th><th class=\"n\">misses</th>\
                  <th>smallest single change that saves most of them</th></tr></thead><tbody>");
    for group in &run.groups {
        let cure = match group.best.and_then(|(tried, saves)| Some((run.tried.get(tried)?, saves))) {
            Some((tried, saves)) => format!(
                "{} <span class=\"quiet\">(saves {saves} of {})</span>",
                html(&tried.change),
                group.misses.len()
            ),
            None if run.tried.is_empty() => "<span class=\"quiet\">not tried</span>".to_owned(),
            None => "<span class=\"quiet\">none of those that were tried</span>".to_owned(),
        };
        let _infallible = write!(
            out,
            "<tr><td>{}</td><td class=\"n\">{}</td><td>{cure}</td></tr>",
            html(&group.cause),
            group.misses.len()
        );
    }
    out.push_str("</tbody></table></div>");
}

fn tried(out: &mut String, run: &Run) {
    if !run.tried_note.is_empty() {
        let _infallible = write!(out, "<p class=\"note\">{}</p>", html(&run.tried_note));
    }
    if run.tried.is_empty() {
        return;
    }
    out.push_str("<details class=\"tried\"><summary>What was tried, what changes least first</summary><div class=\"scroll\"><table><thead>\
                  <tr><th>single change</th><th class=\"n\">on time</th><th class=\"n\">missed</th><th class=\"n\">of the misses \
                  here, saved</th></tr></thead><tbody>");
    for tried in &run.tried {
        let _infallible = write!(
            out,
            "<tr><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td></tr>",
            html(&tried.change),
            tried.on_time,
            tried.missed,
            tried.saves
        );
    }
    out.push_str("</tbody></table></div></details>");
}

fn legend(out: &mut String, run: &Run) {
    out.push_str("<ul class=\"keys\">");
    let occurs = |kind: &Kind| run.misses.iter().flat_map(|miss| &miss.parts).any(|part| part.kind == *kind);
    for kind in Kind::ALL.iter().filter(|kind| occurs(kind)) {
        let _infallible = write!(out, "<li><i class=\"k-{}\"></i>{}</li>", kind.name(), kind.words());
    }
    out.push_str("<li><i class=\"k-deadline\"></i>deadline</li></ul>");
}

fn one(out: &mut String, run: &Run, miss: &Miss, job: &Job) {
    let response_ns = miss.until_ns.saturating_sub(job.release_ns);
    let late_ns = miss.until_ns.saturating_sub(job.deadline_ns);
    let outcome = match &job.shed {
        Some(reason) => format!("given up ({}) after {}", html(reason), time(response_ns)),
        None if job.end_ns.is_none() => format!("not ended {} after its release", time(response_ns)),
        None => format!("{} late", time(late_ns)),
    };
    let _infallible = write!(
        out,
        "<details class=\"chain\"><summary><b>{} #{}</b> <span class=\"quiet\">released at {}</span> <span class=\"bad\">{outcome}</span>",
        html(run.task(miss.task)),
        miss.job,
        time(job.release_ns)
    );
    let whole = response_ns.max(job.deadline_ns.saturating_sub(job.release_ns)).max(1) as f64;
    out.push_str("<span class=\"strip\">");
    let steps = steps(&miss.parts);
    for step in &steps {
        let share = step.ns as f64 / whole * 100.0;
        if share >= 0.1 {
            let _infallible =
                write!(out, "<i class=\"k-{}\" style=\"width:{share:.2}%\"></i>", step.kind.name());
        }
    }
    let due = job.deadline_ns.saturating_sub(job.release_ns) as f64 / whole * 100.0;
    let _infallible = write!(out, "<u style=\"left:{due:.2}%\"></u></span></summary><ol>");
    for step in steps.iter().take(STEPS) {
        let node = step.node.map(|node| html(&run.node(miss.task, node))).unwrap_or_default();
        let _infallible = write!(
            out,
            "<li><i class=\"k-{}\"></i><b class=\"n\">{}</b> <span>{node} <span class=\"quiet\">{}</span>",
            step.kind.name(),
            time(step.ns),
            step.kind.words()
        );
        let named =
            step.by.iter().take(NAMED).map(|(by, ns)| format!("{} ({})", html(&run.sub_job(*by)), time(*ns)));
        let named = named.collect::<Vec<_>>().join(", ");
        if !named.is_empty() {
            let more = step.by.len().saturating_sub(NAMED);
            let more = if more > 0 { format!(" and {more} more") } else { String::new() };
            let _infallible = write!(out, "<br/><span class=\"quiet\">which {named}{more} had</span>");
        }
        out.push_str("</span></li>");
    }
    if steps.len() > STEPS {
        let rest: u64 = steps[STEPS..].iter().map(|step| step.ns).sum();
        let _infallible = write!(
            out,
            "<li><i></i><b class=\"n\">{}</b> <span>in {} more steps</span></li>",
            time(rest),
            steps.len() - STEPS
        );
    }
    let _infallible = write!(
        out,
        "<li class=\"sum\"><i></i><b class=\"n\">{}</b> <span>together, of a deadline of {}</span></li></ol>",
        time(response_ns),
        time(job.deadline_ns.saturating_sub(job.release_ns))
    );
    let cure = match miss.saved_by.and_then(|tried| run.tried.get(tried)) {
        Some(tried) => format!("Would have been saved by: <b>{}</b>", html(&tried.change)),
        None if run.tried.is_empty() => "No change was tried.".to_owned(),
        None => "None of the changes that were tried saves it.".to_owned(),
    };
    let _infallible = write!(out, "<p>{cure}</p></details>");
}
