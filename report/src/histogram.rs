//! Response times of a task against its deadline. Bars are drawn, labels are text beside them, so that they stay as large
//! as other text on a small screen.

use crate::escape::html;
use crate::model::Task;
use crate::time::{or_dash, step, time};
use std::fmt::Write;

/// Bars.
const BINS: usize = 48;
/// Units of the drawing.
const WIDTH: f64 = 960.0;
const HEIGHT: f64 = 160.0;

/// The figure of a task.
pub(crate) fn figure(task: &Task) -> String {
    let name = html(&task.name);
    let [p50, p99, max] = task.figures.response_ns;
    let Some(max_ns) = max else {
        return format!(
            "<figure class=\"hist\"><figcaption>{name}</figcaption><p>No job completed.</p></figure>"
        );
    };
    let scale_ns = scale(max_ns.max(task.deadline_ns), task.deadline_ns);
    let bins = bins(&task.figures.responses_ns, scale_ns);
    let late = task.figures.responses_ns.iter().filter(|ns| **ns > task.deadline_ns).count();
    let words = format!(
        "Response times of {name}: {} jobs completed, half of them within {}, 99 % within {}, all within {}; the deadline is {}, \
         {late} were later.",
        task.figures.responses_ns.len(),
        or_dash(p50),
        or_dash(p99),
        time(max_ns),
        time(task.deadline_ns)
    );
    let mut out = format!(
        "<figure class=\"hist\"><figcaption>{name}</figcaption><div class=\"plot\"><svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" \
         preserveAspectRatio=\"none\" role=\"img\" aria-label=\"{words}\">"
    );
    let most = bins.iter().copied().max().unwrap_or(1).max(1);
    let share = |ns: u64| ns as f64 / scale_ns as f64;
    for (i, count) in bins.iter().enumerate().filter(|(_, count)| **count > 0) {
        // The root shows single jobs beside thousands.
        let height = ((*count as f64 / most as f64).sqrt() * (HEIGHT - 4.0)).max(3.0);
        let width = WIDTH / BINS as f64;
        let from_ns = scale_ns as f64 * i as f64 / BINS as f64;
        let class = if from_ns >= task.deadline_ns as f64 { "late" } else { "ok" };
        let _infallible = write!(
            out,
            "<rect class=\"{class}\" x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{height:.1}\"/>",
            i as f64 * width + 1.0,
            HEIGHT - height,
            width - 2.0
        );
    }
    let _infallible = write!(
        out,
        "<line class=\"deadline\" x1=\"{0:.1}\" x2=\"{0:.1}\" y1=\"0\" y2=\"{HEIGHT}\"/></svg>",
        share(task.deadline_ns) * WIDTH
    );
    out.push_str("<div class=\"axis\">");
    let tick_ns = step(scale_ns, 5);
    // At most so many as there are steps.
    for tick in (0..=scale_ns / tick_ns).map(|i| i * tick_ns).filter(|ns| share(*ns) < 0.94) {
        let _infallible =
            write!(out, "<span style=\"left:{:.2}%\">{}</span>", share(tick) * 100.0, short(tick));
    }
    out.push_str("</div><div class=\"marks\">");
    for (label, ns) in [("median", p50), ("p99", p99), ("max", max), ("deadline", Some(task.deadline_ns))] {
        let Some(ns) = ns else { continue };
        let side = if share(ns) > 0.55 { " class=\"left\"" } else { "" };
        let _infallible = write!(
            out,
            "<div class=\"{label}\"><span{side} style=\"left:{:.2}%\">{label} {}</span></div>",
            share(ns) * 100.0,
            time(ns)
        );
    }
    let _infallible = write!(out, "</div></div><p class=\"sr\">{words}</p></figure>");
    out
}

/// A tick without needless digits.
fn short(ns: u64) -> String {
    let (unit, name) = match ns {
        0 => return "0".to_owned(),
        1_000_000_000.. => (1_000_000_000, "s"),
        1_000_000.. => (1_000_000, "ms"),
        1_000.. => (1_000, "µs"),
        _ => (1, "ns"),
    };
    if ns.is_multiple_of(unit) {
        format!("{} {name}", ns / unit)
    } else {
        format!("{:.1} {name}", ns as f64 / unit as f64)
    }
}

/// Somewhat beyond the largest value, and a round number of nanoseconds for each bar. No bar lies across the deadline, but where
/// that is shorter than a bar.
fn scale(largest_ns: u64, deadline_ns: u64) -> u64 {
    let least = largest_ns.div_ceil(BINS as u64 - 2).max(1);
    let before = deadline_ns / least;
    let each = if before == 0 { least } else { deadline_ns.div_ceil(before) };
    each.saturating_mul(BINS as u64)
}

/// How many values are in each bar.
fn bins(values: &[u64], scale_ns: u64) -> Vec<u64> {
    let mut bins = vec![0; BINS];
    for value in values {
        let bin = u128::from(*value) * BINS as u128 / u128::from(scale_ns.max(1));
        let bin = usize::try_from(bin).map_or(BINS - 1, |bin| bin.min(BINS - 1));
        bins[bin] += 1;
    }
    bins
}

#[cfg(test)]
mod tests;
