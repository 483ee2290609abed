//! Tables of results beside what a paper says: a bar in each cell, intervals of confidence on them, and verdicts.

use crate::escape::html;
use crate::page::{Head, document};
use std::fmt::Write;

/// A table of results.
#[derive(Clone, Debug, Default)]
pub struct Table {
    /// Name on the command line.
    pub name: String,
    /// What it is about.
    pub title: String,
    /// Where in the paper.
    pub source: String,
    /// Paragraphs.
    pub about: Vec<String>,
    /// Heads of columns.
    pub columns: Vec<Column>,
    /// Rows, as long as `columns`.
    pub rows: Vec<Vec<Cell>>,
    /// What is claimed.
    pub claims: Vec<Claim>,
}

/// A column.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Column {
    /// Name with unit.
    pub head: String,
    /// What it measures: columns of one name have one scale.
    pub measures: String,
    /// Whether its numbers are the paper's.
    pub is_paper: bool,
}

/// A cell.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Words.
    Words(String),
    /// A number as text, its value and half of its interval.
    Number(String, Option<(f64, f64)>),
    /// A verdict.
    Verdict(String),
}

/// A claim and what became of it.
#[derive(Clone, Debug, Default)]
pub struct Claim {
    /// What is claimed.
    pub claim: String,
    /// The paper's value.
    pub paper: String,
    /// Ours.
    pub ours: String,
    /// What became of it.
    pub verdict: String,
    /// Why, where it is not simply so.
    pub why: String,
}

/// The page of these tables.
#[must_use]
pub fn page(head: &Head, tables: &[Table]) -> String {
    let mut body = String::from("<nav><ul class=\"toc\">");
    for table in tables {
        let _infallible =
            write!(body, "<li><a href=\"#{0}\">{1}</a></li>", html(&table.name), html(&table.title));
    }
    body.push_str("</ul></nav>");
    summary(&mut body, tables);
    tables.iter().for_each(|table| one(&mut body, table));
    document(head, &body, "")
}

/// How many claims came to which verdict.
fn summary(body: &mut String, tables: &[Table]) {
    let mut counts: Vec<(&str, u64)> = Vec::new();
    for claim in tables.iter().flat_map(|table| &table.claims) {
        match counts.iter_mut().find(|(verdict, _)| *verdict == claim.verdict) {
            Some((_, count)) => *count += 1,
            None => counts.push((&claim.verdict, 1)),
        }
    }
    body.push_str("<ul class=\"keys\">");
    for (verdict, count) in counts {
        let _infallible = write!(body, "<li>{} {count}</li>", badge(verdict));
    }
    body.push_str("<li><i class=\"k-ours\"></i>here, with the 95 % interval</li><li><i class=\"k-paper\"></i>the paper</li></ul>");
}

fn badge(verdict: &str) -> String {
    let class = match verdict {
        "reproduced" | "holds" => "good",
        "not reproducible" | "fails" | "not kept" => "bad",
        "shape only" | "loses" => "fair",
        _ => "plain",
    };
    format!("<span class=\"badge {class}\">{}</span>", html(verdict))
}

fn one(body: &mut String, table: &Table) {
    let _infallible = write!(
        body,
        "<section class=\"results\" id=\"{0}\"><h2>{1}</h2><p class=\"note\">{2}; <code>redrt paper {0}</code></p>",
        html(&table.name),
        html(&table.title),
        html(&table.source)
    );
    for paragraph in &table.about {
        let _infallible = write!(body, "<p>{}</p>", html(paragraph));
    }
    body.push_str("<div class=\"scroll\"><table><thead><tr>");
    for (i, column) in table.columns.iter().enumerate() {
        let class = if is_numeric(table, i) { " class=\"n\"" } else { "" };
        let _infallible = write!(body, "<th{class}>{}</th>", html(&column.head));
    }
    body.push_str("</tr></thead><tbody>");
    let scales: Vec<Scale> = table.columns.iter().map(|column| Scale::of(table, column)).collect();
    for row in &table.rows {
        // Some tables have the paper's values in rows of their own.
        let is_paper =
            matches!(row.first(), Some(Cell::Words(words)) if words == "paper" || words.ends_with(", paper"));
        body.push_str("<tr>");
        for ((cell, column), scale) in row.iter().zip(&table.columns).zip(&scales) {
            self::cell(body, cell, column.is_paper || is_paper, *scale);
        }
        body.push_str("</tr>");
    }
    body.push_str("</tbody></table></div>");
    claims(body, table);
    body.push_str("</section>");
}

fn is_numeric(table: &Table, column: usize) -> bool {
    table.rows.iter().any(|row| matches!(row.get(column), Some(Cell::Number(..))))
}

/// From where to where bars go: beyond the ends of all intervals among columns that measure the same, and from zero on where
/// none has a value below it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Scale {
    low: f64,
    high: f64,
}

impl Scale {
    fn of(table: &Table, column: &Column) -> Self {
        let same = |i: &usize| table.columns[*i].measures == column.measures;
        let columns: Vec<usize> = (0..table.columns.len()).filter(same).collect();
        let cells = table.rows.iter().flat_map(|row| columns.iter().filter_map(|i| row.get(*i)));
        cells.fold(Self::default(), |Self { low, high }, cell| match cell {
            Cell::Number(_, Some((value, half))) => {
                let below = if *value < 0.0 { value - half } else { 0.0 };
                Self { low: low.min(below), high: high.max(value + half) }
            }
            _ => Self { low, high },
        })
    }

    /// Percent of the way.
    fn at(self, value: f64) -> f64 {
        let whole = self.high - self.low;
        if whole > 0.0 { ((value - self.low) / whole * 100.0).clamp(0.0, 100.0) } else { 0.0 }
    }
}

fn cell(body: &mut String, cell: &Cell, is_paper: bool, scale: Scale) {
    let _infallible = match cell {
        // Names do not break at their hyphens.
        Cell::Words(words) if words.len() <= 20 => write!(body, "<td class=\"name\">{}</td>", html(words)),
        Cell::Words(words) => write!(body, "<td>{}</td>", html(words)),
        Cell::Verdict(verdict) => write!(body, "<td>{}</td>", badge(verdict)),
        Cell::Number(text, None) => write!(body, "<td class=\"n\">{}</td>", html(text)),
        Cell::Number(text, Some((value, half))) => {
            let class = if is_paper { "k-paper" } else { "k-ours" };
            let (zero, end) = (scale.at(0.0), scale.at(*value));
            let (from, width) = (zero.min(end), (end - zero).abs());
            let (least, most) = (scale.at(value - half), scale.at(value + half));
            let whisker = if *half > 0.0 && most - least > 0.5 {
                format!("<u style=\"left:{least:.1}%;width:{:.1}%\"></u>", most - least)
            } else {
                String::new()
            };
            let axis =
                if scale.low < 0.0 { format!("<b style=\"left:{zero:.1}%\"></b>") } else { String::new() };
            write!(
                body,
                "<td class=\"n bar\">{}<span class=\"track\"><i class=\"{class}\" style=\"margin-left:{from:.1}%;width:{width:.1}%\">\
                 </i>{axis}{whisker}</span></td>",
                html(text),
            )
        }
    };
}

fn claims(body: &mut String, table: &Table) {
    if table.claims.is_empty() {
        return;
    }
    body.push_str("<h3>Claims</h3><div class=\"scroll\"><table class=\"claims\"><thead><tr><th>claim</th><th>paper</th><th>here</th>\
                   <th></th><th>verdict</th></tr></thead><tbody>");
    for claim in &table.claims {
        let _infallible = write!(
            body,
            "<tr><td>{}</td><td>{}</td><td>{}</td><td class=\"change\">{}</td><td>{}</td></tr>",
            html(&claim.claim),
            html(&claim.paper),
            html(&claim.ours),
            changes(claim),
            badge(&claim.verdict)
        );
    }
    body.push_str("</tbody></table></div>");
    let mut reasons: Vec<&str> =
        table.claims.iter().map(|claim| &*claim.why).filter(|why| !why.is_empty()).collect();
    reasons.dedup();
    for why in reasons {
        let _infallible = write!(body, "<p class=\"note\">Why: {}</p>", html(why));
    }
}

/// Both changes on one axis, where both are in percent: a bar from zero, and a mark for the paper's.
fn changes(claim: &Claim) -> String {
    let (Some((paper, _)), Some((ours, half))) = (percent(&claim.paper), percent(&claim.ours)) else {
        return String::new();
    };
    let reach = [paper.abs(), ours.abs() + half].into_iter().fold(1.0, f64::max).min(200.0);
    let at = |value: f64| 50.0 + (value / reach).clamp(-1.0, 1.0) * 48.0;
    let (from, until) = if ours < 0.0 { (at(ours), 50.0) } else { (50.0, at(ours)) };
    let (least, most) = (at(ours - half), at(ours + half));
    let words = format!("here {ours:+.1} %, the paper {paper:+.1} %");
    let mut out = format!(
        "<svg viewBox=\"0 0 100 16\" preserveAspectRatio=\"none\" role=\"img\" aria-label=\"{words}\"><line class=\"zero\" x1=\"50\" \
         x2=\"50\" y1=\"0\" y2=\"16\"/><rect class=\"ours\" x=\"{from:.1}\" y=\"4\" width=\"{:.1}\" height=\"8\"/>",
        until - from
    );
    if half > 0.0 {
        let _infallible =
            write!(out, "<line class=\"whisker\" x1=\"{least:.1}\" x2=\"{most:.1}\" y1=\"8\" y2=\"8\"/>");
    }
    let _infallible = write!(
        out,
        "<line class=\"paper\" x1=\"{0:.1}\" x2=\"{0:.1}\" y1=\"0\" y2=\"16\"/></svg>",
        at(paper)
    );
    out
}

/// `-18.0 ± 0.2 %` as numbers, and nothing else.
fn percent(text: &str) -> Option<(f64, f64)> {
    let numbers = text.strip_suffix(" %")?;
    let (value, half) = numbers.split_once(" ± ").unwrap_or((numbers, "0"));
    let is_change = value.starts_with(['+', '-']);
    Some((value.parse().ok().filter(|_| is_change)?, half.parse().ok()?))
}

#[cfg(test)]
mod tests;
