//! The whole run in one narrow drawing: how busy each lane was with whom, where jobs missed, and when graphs changed. It
//! needs no script; with one it is what the timeline is chosen in.

use crate::escape::html;
use crate::model::Run;
use crate::time::time;
use std::fmt::Write;

/// Columns.
const BINS: usize = 240;
/// Units of the drawing: of a lane, between lanes, of the row of misses.
const WIDTH: f64 = 1_200.0;
const LANE: f64 = 26.0;
const GAP: f64 = 3.0;
const MISSES: f64 = 12.0;
/// Colours of tasks.
pub(crate) const COLOURS: usize = 8;

/// The drawing.
pub(crate) fn figure(run: &Run) -> String {
    let end_ns = run.end_ns.max(1);
    let height = run.lanes.len() as f64 * (LANE + GAP) + MISSES;
    let mut out = format!(
        "<div class=\"overview\"><svg viewBox=\"0 0 {WIDTH} {height}\" preserveAspectRatio=\"none\" role=\"img\" \
         aria-label=\"How busy lanes were over the whole run, and where jobs missed\">"
    );
    for (lane, busy) in busy(run, end_ns).iter().enumerate() {
        let top = lane as f64 * (LANE + GAP);
        let _infallible =
            write!(out, "<rect class=\"track\" x=\"0\" y=\"{top}\" width=\"{WIDTH}\" height=\"{LANE}\"/>");
        let mut below = vec![0.0; BINS];
        for (colour, shares) in busy.iter().enumerate() {
            let path = path(shares, &mut below, top);
            if !path.is_empty() {
                let _infallible = write!(out, "<path class=\"c{colour}\" d=\"{path}\"/>");
            }
        }
    }
    for (bin, _) in misses(run, end_ns).into_iter().enumerate().filter(|(_, count)| *count > 0) {
        let _infallible = write!(
            out,
            "<rect class=\"miss\" x=\"{:.0}\" y=\"{:.0}\" width=\"{:.0}\" height=\"{MISSES}\"/>",
            bin as f64 * WIDTH / BINS as f64,
            height - MISSES,
            WIDTH / BINS as f64
        );
    }
    for (from_ns, until_ns) in &run.standstills {
        let [from, until] = [from_ns, until_ns].map(|ns| *ns as f64 / end_ns as f64 * WIDTH);
        let width = (until - from).max(1.0);
        let _infallible = write!(
            out,
            "<rect class=\"still\" x=\"{from:.1}\" y=\"0\" width=\"{width:.1}\" height=\"{height}\"/>"
        );
    }
    for (at_ns, _) in &run.edits {
        let x = *at_ns as f64 / end_ns as f64 * WIDTH;
        let _infallible =
            write!(out, "<line class=\"edit\" x1=\"{x:.1}\" x2=\"{x:.1}\" y1=\"0\" y2=\"{height}\"/>");
    }
    out.push_str("</svg><div class=\"edits\">");
    // Those that would stand on each other are in the table of edits.
    let mut last = f64::NEG_INFINITY;
    for (at_ns, words) in &run.edits {
        let share = *at_ns as f64 / end_ns as f64 * 100.0;
        if share - last >= 18.0 {
            let side = if share > 70.0 { " class=\"left\"" } else { "" };
            let _infallible = write!(out, "<span{side} style=\"left:{share:.2}%\">{}</span>", html(words));
            last = share;
        }
    }
    let _infallible =
        write!(out, "</div><div class=\"ends\"><span>0</span><span>{}</span></div></div>", time(run.end_ns));
    out
}

/// By lane, colour and column: the share of time that tasks of that colour had.
fn busy(run: &Run, end_ns: u64) -> Vec<Vec<Vec<f64>>> {
    let mut busy = vec![vec![vec![0.0; BINS]; COLOURS]; run.lanes.len()];
    let bin_ns = end_ns as f64 / BINS as f64;
    let mut last = vec![u64::MAX; run.lanes.len()];
    for slice in &run.slices {
        // Of several members of a unit one stands for all.
        let Some(lane) = busy.get_mut(slice.lane).filter(|_| last[slice.lane] != slice.unit) else {
            continue;
        };
        last[slice.lane] = slice.unit;
        let shares = &mut lane[slice.of.0 % COLOURS];
        let (from, until) = (slice.start_ns as f64 / bin_ns, slice.end_ns as f64 / bin_ns);
        for (bin, share) in shares.iter_mut().enumerate().take(until as usize + 1).skip(from as usize) {
            *share += (until.min(bin as f64 + 1.0) - from.max(bin as f64)).max(0.0);
        }
    }
    busy
}

/// Columns of a colour, on top of those that are there.
fn path(shares: &[f64], below: &mut [f64], top: f64) -> String {
    let width = WIDTH / BINS as f64;
    let mut path = String::new();
    for (bin, (share, below)) in shares.iter().zip(below).enumerate() {
        let height = share.min(1.0 - *below) * LANE;
        if height >= 0.05 {
            let bottom = top + LANE - *below * LANE;
            let _infallible =
                write!(path, "M{:.0} {bottom:.1}h{width:.0}v-{height:.1}h-{width:.0}z", bin as f64 * width);
            *below += height / LANE;
        }
    }
    path
}

/// By column: jobs that missed, at their deadlines.
fn misses(run: &Run, end_ns: u64) -> Vec<u64> {
    let mut counts = vec![0; BINS];
    for job in run.misses.iter().filter_map(|miss| run.job(miss.task, miss.job)) {
        let bin = u128::from(job.deadline_ns) * BINS as u128 / u128::from(end_ns);
        counts[usize::try_from(bin).map_or(BINS - 1, |bin| bin.min(BINS - 1))] += 1;
    }
    counts
}
