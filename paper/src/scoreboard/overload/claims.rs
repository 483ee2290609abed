//! What this project promises under overload, whether it is kept, and where others are better.

use super::load::Times;
use super::rules::Rule;
use super::{LANES, LOADS, Measure, Point, Results, points};
use crate::stat::Estimate;
use crate::table::{Claim, Verdict};

/// The rule that is on trial, in [`Rule::ALL`].
pub(super) const OURS: usize = 0;
/// The measure of groups that stay whole, and of broken ones that were blocked, in [`Measure::ALL`].
pub(super) const WHOLE: usize = 3;
const BLOCKED: usize = 4;

/// Protected groups that stay whole, in percent: on one lane, and on more.
const MUST_BE_WHOLE: [f64; 2] = [95.0, 85.0];
/// Value on time over the bound in sets without floors, in percent.
const MUST_HAVE_VALUE: f64 = 80.0;
/// Jobs of one graph alone that are on time, of those that fit, in percent, at these loads.
const MUST_CARRY: f64 = 97.0;
const CARRIED: [f64; 3] = [1.1, 1.33, 2.0];

/// Which execution times a promise is looked at for.
#[derive(Clone, Copy)]
struct When(&'static str, fn(Times) -> bool, &'static str);

const WHEN: [When; 2] = [
    When("at WCET", |times| matches!(times, Times::Wcet), UNKNOWN),
    When("where times vary", |times| !matches!(times, Times::Wcet), BY_MEANS),
];

pub(super) fn of(results: &Results) -> Vec<Claim> {
    let mut claims = Vec::new();
    for when in WHEN {
        claims.extend(whole(results, when));
    }
    claims.extend(WHEN.map(|when| value(results, when)));
    for measure in Measure::ALL.iter().filter(|measure| measure.shape.is_alone()) {
        claims.extend(WHEN.map(|when| carried(results, measure, when)));
    }
    let compared = Measure::ALL.iter().enumerate().filter(|(nth, _)| *nth != BLOCKED);
    claims.extend(compared.map(|(_, measure)| beside(results, measure)));
    claims
}

/// A promise, and what was measured: that it is not kept is said in words.
fn promise(claim: String, must: f64, measured: f64, more: &str, why: &'static str) -> Claim {
    let is_kept = measured >= must;
    let ours = if is_kept {
        format!("measured {measured:.1}{more}")
    } else {
        format!("not kept: promised {must} %, measured {measured:.1}{more}")
    };
    let verdict = if is_kept { Verdict::Holds } else { Verdict::NotKept };
    Claim { claim, paper: "-".to_owned(), ours, verdict, why: if is_kept { "" } else { why } }
}

/// Parts and whole of all seeds.
fn total(results: &Results, measure: usize, is_chosen: impl Fn(&Point) -> bool) -> (f64, f64) {
    let sums = results.sums(&Measure::ALL[measure], OURS, is_chosen);
    sums.iter().fold((0.0, 0.0), |all, sum| (all.0 + sum.0, all.1 + sum.1))
}

fn whole(results: &Results, When(when, is_then, why): When) -> [Claim; 2] {
    [(MUST_BE_WHOLE[0], false, "one lane"), (MUST_BE_WHOLE[1], true, "two and four lanes")].map(
        |(must, is_wide, words)| {
            let is_chosen = |point: &Point| (point.lanes > 1) == is_wide && is_then(point.times);
            let (whole, all) = total(results, WHOLE, is_chosen);
            let (blocked, broken) = total(results, BLOCKED, is_chosen);
            let each: Vec<f64> = [vec![100.0; whole as usize], vec![0.0; (all - whole) as usize]].concat();
            let share = Estimate::of(&each).unwrap_or_default();
            promise(
                format!(
                    "{} keeps at least {must} % of protected groups whole on {words}, {when}",
                    Rule::ALL[OURS].name()
                ),
                must,
                share.mean,
                &format!(
                    " ± {:.1} %, {whole} of {all}; of the {broken} others {blocked} were blocked",
                    share.half_width
                ),
                why,
            )
        },
    )
}

fn value(results: &Results, When(when, is_then, _): When) -> Claim {
    let measure = &Measure::ALL[WHOLE - 1];
    let mean = |is_chosen: &dyn Fn(&Point) -> bool| {
        results.percent(measure, OURS, is_chosen).map_or(0.0, |estimate| estimate.mean)
    };
    let each = LANES.iter().flat_map(|lanes| LOADS.map(|load| (*lanes, load)));
    let means = each.map(|(lanes, load)| {
        (mean(&|p| p.lanes == lanes && p.load == load && is_then(p.times)), lanes, load)
    });
    let (least, lanes, load) = means.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default();
    promise(
        format!(
            "{} has at least {MUST_HAVE_VALUE} % of the bound's value on time in sets without floors, {when}",
            Rule::ALL[OURS].name()
        ),
        MUST_HAVE_VALUE,
        mean(&|point| is_then(point.times)),
        &format!(" % in the mean; the least of all lanes and loads: {least:.1} % on {lanes} at {load}"),
        "",
    )
}

fn carried(results: &Results, measure: &Measure, When(when, is_then, _): When) -> Claim {
    let of = points().into_iter().filter(|point| CARRIED.contains(&point.load) && is_then(point.times));
    let means = of.map(|point| {
        let mean = results.percent(measure, OURS, |other| *other == point).map_or(0.0, |e| e.mean);
        (mean, point)
    });
    let least = means.min_by(|a, b| a.0.total_cmp(&b.0));
    let (mean, more) = least.map_or((0.0, String::new()), |(mean, Point { lanes, load, .. })| {
        (mean, format!(" %; the least, on {lanes} at load {load}"))
    });
    promise(
        format!(
            "{} carries at least {MUST_CARRY} % of what fits, {when}, at loads {} on 1, 2 and 4 lanes: {}",
            Rule::ALL[OURS].name(),
            CARRIED.map(|load| load.to_string()).join(", "),
            measure.name,
        ),
        MUST_CARRY,
        mean,
        &more,
        IDLE,
    )
}

/// Where another rule is better than ours, beyond the interval of the difference of like seeds.
fn beside(results: &Results, measure: &Measure) -> Claim {
    let points = points();
    let mut found = Vec::new();
    for (rule, name) in Rule::ALL.iter().enumerate().skip(OURS + 1).map(|(nth, rule)| (nth, rule.name())) {
        let by: Vec<f64> = points.iter().filter_map(|point| below(results, measure, rule, point)).collect();
        if !by.is_empty() {
            let most = by.iter().copied().fold(0.0, f64::max);
            found.push(format!("{name} at {} (by {most:.1} % at most)", by.len()));
        }
    }
    let is_kept = found.is_empty();
    Claim {
        claim: format!("{} is nowhere behind another rule: {}", Rule::ALL[OURS].name(), measure.name),
        paper: "-".to_owned(),
        ours: if is_kept {
            format!("at none of {} points", points.len())
        } else {
            format!("of {} points, behind {}", points.len(), found.join(", "))
        },
        verdict: if is_kept { Verdict::Holds } else { Verdict::Loses },
        why: "",
    }
}

/// By how many percent ours is below another rule at a point, if it is.
fn below(results: &Results, measure: &Measure, rule: usize, point: &Point) -> Option<f64> {
    let sums = |rule| results.sums(measure, rule, |other| other == point);
    let both = sums(rule).into_iter().zip(sums(OURS)).filter(|(a, b)| a.1 > 0.0 && b.1 > 0.0);
    let (theirs, ours): (Vec<f64>, Vec<f64>) =
        both.map(|(a, b)| (100.0 * a.0 / a.1, 100.0 * b.0 / b.1)).unzip();
    let by = Estimate::paired(&theirs, &ours, |theirs, ours| theirs - ours)?;
    (by.samples > 1 && by.mean > by.half_width).then_some(by.mean)
}

const UNKNOWN: &str = "lower jobs run while a higher one can wait, before others come that nobody knew of";
const BY_MEANS: &str = "the forward schedule goes by mean times, so that a lower job that was to leave room makes a higher one late \
                        where it takes longer; and lower jobs run while a higher one can wait, before others come that nobody \
                        knew of";
const IDLE: &str = "a job that was to be in time at mean times and is late has taken lanes for nothing, and a lane idles where the \
                    next job would be late";
