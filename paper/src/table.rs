//! A table of results: what the paper says, what we get, and the verdict.

use crate::stat::Estimate;
use serde::Serialize;

/// One experiment's results.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Table {
    /// Name on the command line.
    pub name: &'static str,
    /// What it is about.
    pub title: &'static str,
    /// Where in the paper.
    pub source: &'static str,
    /// What was run, and what has to be known to read it: paragraphs.
    pub about: Vec<String>,
    /// Columns of `rows`.
    pub columns: Vec<Column>,
    /// Rows, each as long as `columns`.
    pub rows: Vec<Vec<Cell>>,
    /// What the paper claims, and what became of it.
    pub claims: Vec<Claim>,
}

/// A column.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Column {
    /// Name.
    pub name: &'static str,
    /// Unit; empty for words and scores.
    pub unit: &'static str,
    /// Decimals to print.
    #[serde(skip)]
    pub decimals: usize,
}

impl Column {
    /// Of words.
    #[must_use]
    pub const fn words(name: &'static str) -> Self {
        Self { name, unit: "", decimals: 0 }
    }

    /// Of numbers.
    #[must_use]
    pub const fn numbers(name: &'static str, unit: &'static str, decimals: usize) -> Self {
        Self { name, unit, decimals }
    }
}

/// A cell.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Cell {
    /// Words.
    Words(String),
    /// A number that has no error, such as the paper's; `None` where there is none.
    Number(Option<f64>),
    /// A mean over seeds.
    Mean(Option<Estimate>),
    /// A verdict on the row.
    Verdict(Verdict),
}

impl From<&str> for Cell {
    fn from(words: &str) -> Self {
        Self::Words(words.to_owned())
    }
}

impl From<String> for Cell {
    fn from(words: String) -> Self {
        Self::Words(words)
    }
}

impl From<f64> for Cell {
    fn from(number: f64) -> Self {
        Self::Number(Some(number))
    }
}

impl From<Option<f64>> for Cell {
    fn from(number: Option<f64>) -> Self {
        Self::Number(number)
    }
}

impl From<Option<Estimate>> for Cell {
    fn from(mean: Option<Estimate>) -> Self {
        Self::Mean(mean)
    }
}

impl From<Verdict> for Cell {
    fn from(verdict: Verdict) -> Self {
        Self::Verdict(verdict)
    }
}

/// What became of a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The number that our model was fitted to: no evidence.
    Calibrated,
    /// Direction and size.
    Reproduced,
    /// Direction only.
    ShapeOnly,
    /// Neither.
    NotReproducible,
    /// Nothing in the paper to compare with.
    Ours,
    /// What this project promises, and keeps.
    Holds,
    /// What this project promises, and does not keep.
    Fails,
    /// What this project promises under overload, and does not keep everywhere: both figures stand beside.
    NotKept,
    /// Where a rule of this project is worse than another.
    Loses,
}

/// A size counts as reproduced up to this share of the paper's value.
const SAME_SIZE: f64 = 0.25;
/// Differences below these many percent have no direction.
const NO_DIFFERENCE: f64 = 1.0;

impl Verdict {
    /// Compares changes against a baseline, in percent.
    #[must_use]
    pub fn of_change(paper: f64, ours: f64) -> Self {
        let is_flat = |x: f64| x.abs() < NO_DIFFERENCE;
        let near = (ours - paper).abs() <= (SAME_SIZE * paper.abs()).max(NO_DIFFERENCE);
        let same_direction = if is_flat(paper) { is_flat(ours) } else { paper.signum() == ours.signum() };
        match (near, same_direction) {
            (true, _) => Self::Reproduced,
            (false, true) if !is_flat(ours) => Self::ShapeOnly,
            _ => Self::NotReproducible,
        }
    }

    /// Compares values, such as latencies, of a system; both come with the baseline's, which give the direction.
    #[must_use]
    pub fn of_value(paper: f64, ours: f64, paper_baseline: f64, our_baseline: f64) -> Self {
        let near = (ours - paper).abs() <= SAME_SIZE / 2.0 * paper.abs();
        let change = |value: f64, baseline: f64| 100.0 * (value / baseline - 1.0);
        match Self::of_change(change(paper, paper_baseline), change(ours, our_baseline)) {
            _ if near => Self::Reproduced,
            Self::NotReproducible => Self::NotReproducible,
            _ => Self::ShapeOnly,
        }
    }

    /// In words.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::Calibrated => "calibrated",
            Self::Reproduced => "reproduced",
            Self::ShapeOnly => "shape only",
            Self::NotReproducible => "not reproducible",
            Self::Ours => "ours",
            Self::Holds => "holds",
            Self::Fails => "fails",
            Self::NotKept => "not kept",
            Self::Loses => "loses",
        }
    }
}

/// A claim of the paper, or of ours.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Claim {
    /// What is claimed.
    pub claim: String,
    /// The paper's value, with its unit.
    pub paper: String,
    /// Ours.
    pub ours: String,
    /// What became of it.
    pub verdict: Verdict,
    /// Why, where it is not simply so.
    pub why: &'static str,
}

impl Claim {
    /// A change against a baseline, in percent.
    #[must_use]
    pub fn change(claim: impl Into<String>, paper: f64, ours: Option<Estimate>, why: &'static str) -> Self {
        let (text, verdict) = match ours {
            Some(e) => (percent(e), Verdict::of_change(paper, e.mean)),
            None => ("-".to_owned(), Verdict::NotReproducible),
        };
        Self { claim: claim.into(), paper: format!("{paper:+.1} %"), ours: text, verdict, why }
    }
}

/// A change with its interval.
#[must_use]
pub fn percent(change: Estimate) -> String {
    format!("{:+.1} ± {:.1} %", change.mean, change.half_width)
}

#[cfg(test)]
mod tests;
