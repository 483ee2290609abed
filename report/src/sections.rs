//! The parts of a run's page that are tables and sentences.

use crate::escape::html;
use crate::model::{Figures, Run, Task};
use crate::time::{or_dash, time};
use std::fmt::Write;

/// How it went, in a sentence or two.
pub(crate) fn verdict(run: &Run) -> String {
    let sum = |of: fn(&Figures) -> u64| -> u64 { run.tasks.iter().map(|task| of(&task.figures)).sum() };
    let (released, on_time, missed, shed) =
        (sum(|f| f.released), sum(|f| f.on_time), sum(|f| f.missed), sum(|f| f.shed));
    if released == 0 {
        return "No job was released.".to_owned();
    }
    let jobs = |count: u64| if count == 1 { "1 job".to_owned() } else { format!("{count} jobs") };
    if missed == 0 {
        let open = released - on_time;
        let rest = if open > 0 {
            format!("; {} had not ended and had time left", jobs(open))
        } else {
            String::new()
        };
        let all = if open == 0 { "All " } else { "" };
        return format!(
            "{all}{} met their deadlines{rest}.",
            if open == 0 { jobs(released) } else { jobs(on_time) }
        );
    }
    let percent = 100.0 * missed as f64 / released as f64;
    let shown = if percent < 0.1 { "less than 0.1 %".to_owned() } else { format!("{percent:.1} %") };
    let given_up = if shed > 0 { format!(", {shed} of them given up") } else { String::new() };
    let late = |miss: &&crate::model::Miss| {
        let late = run.job(miss.task, miss.job).filter(|job| job.shed.is_none());
        late.map_or(0, |job| miss.until_ns.saturating_sub(job.deadline_ns))
    };
    let worst = run.misses.iter().max_by_key(late).filter(|miss| late(miss) > 0);
    let worst = worst.map_or_else(String::new, |miss| {
        format!(" The worst, {} #{}, was {} late.", html(run.task(miss.task)), miss.job, time(late(&miss)))
    });
    format!("{missed} of {} missed ({shown}{given_up}).{worst}", jobs(released))
}

/// The table of tasks.
pub(crate) fn tasks(run: &Run) -> String {
    let mut out = String::from(
        "<div class=\"scroll\"><table><thead><tr><th>task</th><th class=\"n\">released</th><th class=\"n\">on time</th>\
         <th class=\"n\">missed</th><th class=\"n\">of them shed</th><th class=\"n\">p50</th><th class=\"n\">p99</th>\
         <th class=\"n\">max</th><th class=\"n\">deadline</th><th class=\"n\">value on time</th>\
         <th class=\"n\">floor</th></tr></thead><tbody>",
    );
    for (number, task) in run.tasks.iter().enumerate() {
        row(&mut out, number, task);
    }
    out.push_str("</tbody></table></div>");
    out
}

fn row(out: &mut String, number: usize, Task { name, deadline_ns, figures, .. }: &Task) {
    let Figures { released, on_time, missed, shed, reasons, response_ns, floor, value, .. } = figures;
    let reasons: Vec<String> =
        reasons.iter().map(|(reason, count)| format!("{} {count}", html(reason))).collect();
    let reasons = if reasons.is_empty() {
        String::new()
    } else {
        format!("<br/><span class=\"quiet\">{}</span>", reasons.join(", "))
    };
    let bad = if *missed > 0 { " bad" } else { "" };
    let _infallible = write!(
        out,
        "<tr><td class=\"task\"><i class=\"dot c{}\"></i>{}</td><td class=\"n\">{released}</td><td class=\"n\">{on_time}</td>\
         <td class=\"n{bad}\">{missed}</td><td class=\"n\">{shed}{reasons}</td>",
        number % crate::overview::COLOURS,
        html(name)
    );
    for ns in response_ns {
        let over = if ns.is_some_and(|ns| ns > *deadline_ns) { " bad" } else { "" };
        let _infallible = write!(out, "<td class=\"n{over}\">{}</td>", or_dash(*ns));
    }
    let [on_time, all] = value;
    let _infallible =
        write!(out, "<td class=\"n\">{}</td><td class=\"n\">{on_time} of {all}</td>", time(*deadline_ns));
    let (bad, floor) = match floor {
        None => ("", "\u{2013}".to_owned()),
        Some((m, k, worst)) if worst >= m => {
            ("", format!("{m} of {k} kept<br/><span class=\"quiet\">worst {worst}</span>"))
        }
        Some((m, k, worst)) => {
            (" bad", format!("{m} of {k} broken<br/><span class=\"quiet\">worst {worst}</span>"))
        }
    };
    let _infallible = write!(out, "<td class=\"n{bad}\">{floor}</td></tr>");
}

/// Numbers of the whole run, large.
pub(crate) fn tiles(run: &Run) -> String {
    let sum = |of: fn(&Figures) -> u64| -> u64 { run.tasks.iter().map(|task| of(&task.figures)).sum() };
    let mut out = String::from("<dl class=\"tiles\">");
    let mut tile = |title: &str, value: u64, class: &str| {
        let _infallible = write!(out, "<div{class}><dt>{title}</dt><dd>{value}</dd></div>");
    };
    tile("released", sum(|f| f.released), "");
    tile("on time", sum(|f| f.on_time), "");
    let missed = sum(|f| f.missed);
    tile("missed", missed, if missed > 0 { " class=\"bad\"" } else { "" });
    tile("shed", sum(|f| f.shed), "");
    tile("sub-deadlines missed", run.nodes_missed, "");
    tile("units dispatched", run.units, "");
    tile("encoder runs saved", run.saved, "");
    out.push_str("</dl>");
    out
}

/// When nothing ran, in words; empty where that never was.
pub(crate) fn standstills(run: &Run) -> String {
    let Some(longest) = run.standstills.iter().map(|(from, until)| until - from).max() else {
        return String::new();
    };
    let count = run.standstills.len();
    let all: u64 = run.standstills.iter().map(|(from, until)| until - from).sum();
    format!(
        "<p class=\"note\">Nothing ran {count} times, {} in all and {} at the longest: the process was halted, throttled, or \
         out of its CPU quota. No node is blamed for that time, but jobs missed their deadlines by it.</p>",
        time(all),
        time(longest)
    )
}

/// Facts: a title and a value each.
pub(crate) fn facts(run: &Run) -> String {
    let mut out = String::from("<dl class=\"facts\">");
    for (title, value) in &run.facts {
        let _infallible = write!(out, "<div><dt>{}</dt><dd>{}</dd></div>", html(title), html(value));
    }
    let lanes = |pool: usize| run.lanes.iter().filter(|lane| lane.pool == pool).count();
    for (number, pool) in run.pools.iter().enumerate() {
        let whole = lanes(number) as f64 * run.end_ns as f64;
        let busy = if whole > 0.0 { 100.0 * pool.busy_ns as f64 / whole } else { 0.0 };
        let plural = if lanes(number) == 1 { "" } else { "s" };
        let _infallible = write!(
            out,
            "<div><dt>pool {}</dt><dd>{} lane{plural}, busy {busy:.1} %</dd></div>",
            html(&pool.name),
            lanes(number)
        );
    }
    out.push_str("</dl>");
    out
}

/// Graph changes.
pub(crate) fn edits(run: &Run) -> String {
    if run.edits.is_empty() {
        return String::new();
    }
    let mut out = String::from("<p class=\"note\">Graph edits: ");
    let words: Vec<String> =
        run.edits.iter().map(|(at, words)| format!("{} at {}", html(words), time(*at))).collect();
    let shown = words.len().min(12);
    out.push_str(&words[..shown].join("; "));
    if words.len() > shown {
        let _infallible = write!(out, "; and {} more", words.len() - shown);
    }
    out.push_str(".</p>");
    out
}

/// What admission says.
pub(crate) fn certificate(run: &Run) -> String {
    let lines: Vec<String> = run.certificate.iter().map(|line| format!("<li>{}</li>", code(line))).collect();
    format!("<ul class=\"lines\">{}</ul>", lines.concat())
}

/// What stands between backticks, as code.
fn code(text: &str) -> String {
    let mut parts = text.split('`').map(html);
    let first = parts.next().unwrap_or_default();
    let tagged = parts.enumerate().map(|(nth, part)| format!("{}{part}", ["<code>", "</code>"][nth % 2]));
    first + &tagged.collect::<String>() + if text.matches('`').count() % 2 == 1 { "</code>" } else { "" }
}
