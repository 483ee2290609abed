//! Policies beside each other: a bar each, and how they changed against the first beside what the paper says.

use crate::escape::html;
use std::fmt::Write;

/// Something that policies are compared in.
#[derive(Clone, Debug, Default)]
pub struct Compared {
    /// What.
    pub what: String,
    /// Its unit.
    pub unit: String,
    /// Policies and their values.
    pub values: Vec<(String, f64)>,
    /// What the paper says of the change from its baseline to its system, in percent, and of whom.
    pub paper_percent: Option<(f64, String)>,
    /// Whether less is better.
    pub less_is_better: bool,
}

/// All of them.
pub(crate) fn section(all: &[Compared]) -> String {
    let mut out = String::from("<div class=\"bars\">");
    for compared in all {
        one(&mut out, compared);
    }
    out.push_str("</div>");
    out
}

fn one(out: &mut String, compared: &Compared) {
    let Compared { what, unit, values, less_is_better, .. } = compared;
    let better = if *less_is_better { "less is better" } else { "more is better" };
    let _infallible = write!(
        out,
        "<figure class=\"bar\"><figcaption>{} <span class=\"quiet\">{better}</span></figcaption>",
        html(what)
    );
    let most = values.iter().map(|(_, value)| *value).fold(0.0, f64::max);
    for (i, (policy, value)) in values.iter().enumerate() {
        let share = if most > 0.0 { value / most * 100.0 } else { 0.0 };
        let _infallible = write!(
            out,
            "<div class=\"row\"><span class=\"name\">{}</span><span class=\"track\"><i class=\"p{}\" style=\"width:{share:.2}%\"></i>\
             </span><span class=\"n\">{} {}</span></div>",
            html(policy),
            i % 5,
            number(*value),
            html(unit)
        );
    }
    if let Some(words) = change(compared) {
        let _infallible = write!(out, "<p class=\"quiet\">{words}</p>");
    }
    out.push_str("</figure>");
}

/// The change from the first policy to the last, and the paper's.
fn change(compared: &Compared) -> Option<String> {
    let ((first, before), (last, after)) = (compared.values.first()?, compared.values.last()?);
    // A change from nothing has no size.
    let percent = (*before != 0.0).then(|| 100.0 * (after / before - 1.0))?;
    let ours = format!("{} against {}: <b>{}</b>", html(last), html(first), percentage(percent));
    Some(match &compared.paper_percent {
        Some((percent, of)) => format!("{ours}; the paper, {}: {}", html(of), percentage(*percent)),
        None => ours,
    })
}

fn percentage(percent: f64) -> String {
    let sign = if percent < 0.0 { "−" } else { "+" };
    format!("{sign}{:.1} %", percent.abs())
}

/// Three digits; nothing is 0.
pub(crate) fn number(value: f64) -> String {
    match value.abs() {
        0.0 => "0".to_owned(),
        100.0.. => format!("{value:.0}"),
        10.0.. => format!("{value:.1}"),
        _ => format!("{value:.2}"),
    }
}
