//! One plain table per measurement: figures, ratios, the bound and the verdict.

use std::fmt;
use std::iter::Sum;

use crate::measure::{Row, difference, median, ratio};

/// How to read the tables.
pub(crate) const LEGEND: &str = "\
min, median, max: over the rounds; x NAME: median of the ratios to the row NAME; ours/this: our row to this one
must: what the product is held to, in the unit of the table or in times NAME (x); ABOVE: that bound is exceeded, or a
peer that the row should be below is not above it";

/// What the product demands of our row.
#[derive(Clone, Copy)]
pub(crate) enum Must {
    /// At most this many times the reference.
    Ratio(f64),
    /// At most this many times the reference, and below every other row.
    RatioBelowPeers(f64),
    /// At most this figure, in the unit of the table.
    Figure(f64),
    /// At most this many times the reference, and at most this much above it.
    Over { ratio: f64, figure: f64 },
    /// Nothing: the row is there to be seen.
    Nothing,
}

/// Whether a row of ours keeps its bound.
enum Verdict<'a> {
    Kept,
    /// Kept among the peers that are at hand.
    KeptSoFar,
    Above,
    /// Within the factor, but not below this peer.
    NotBelow(&'a str),
}

impl Verdict<'_> {
    const fn is_kept(&self) -> bool {
        matches!(self, Self::Kept | Self::KeptSoFar)
    }
}

impl fmt::Display for Verdict<'_> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Kept => out.write_str("ok"),
            Self::KeptSoFar => out.write_str("ok, of those at hand"),
            Self::Above => out.write_str("ABOVE"),
            Self::NotBelow(peer) => write!(out, "ABOVE: not below {peer}"),
        }
    }
}

impl fmt::Display for Must {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Ratio(bound) => write!(out, "{bound:.2} x"),
            Self::RatioBelowPeers(bound) => write!(out, "{bound:.2} x and below all"),
            Self::Figure(bound) => write!(out, "{bound}"),
            Self::Over { ratio, figure } => write!(out, "{ratio:.2} x, +{figure}"),
            Self::Nothing => write!(out, "-"),
        }
    }
}

/// Rows to print under one title.
pub(crate) struct Table<'a> {
    pub(crate) title: String,
    pub(crate) unit: &'a str,
    /// Name of the row that the others are divided by.
    pub(crate) reference: &'a str,
    /// The bounds of our rows, in their order; the last one goes for those after it too. Empty = the product
    /// names none here.
    pub(crate) must: &'a [Must],
    pub(crate) rows: Vec<Row>,
}

/// What the tables printed so far add up to.
#[derive(Default, Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Outcome {
    /// Rows of ours above their bound.
    pub(crate) above: usize,
    /// Rows without figures that should have some.
    pub(crate) missing: usize,
    /// Rows of peers that this machine does not have.
    pub(crate) absent: usize,
}

impl Sum for Outcome {
    fn sum<I: Iterator<Item = Self>>(outcomes: I) -> Self {
        outcomes.fold(Self::default(), |sum, next| Self {
            above: sum.above + next.above,
            missing: sum.missing + next.missing,
            absent: sum.absent + next.absent,
        })
    }
}

impl Table<'_> {
    /// Prints the table to standard output.
    pub(crate) fn print(&self) -> Outcome {
        print!("{self}");
        Outcome {
            above: self
                .ours()
                .filter(|(row, must)| self.verdict(row, *must).is_some_and(|verdict| !verdict.is_kept()))
                .count(),
            missing: self.rows.iter().filter(|row| row.rounds.as_ref().is_err_and(|why| why.fails())).count(),
            absent: self.rows.iter().filter(|row| row.rounds.as_ref().is_err_and(|why| !why.fails())).count(),
        }
    }

    /// Our rows and their bounds.
    fn ours(&self) -> impl Iterator<Item = (&Row, Option<Must>)> {
        let ours = self.rows.iter().filter(|row| row.ours).enumerate();
        ours.map(|(place, row)| (row, self.must.get(place).or(self.must.last()).copied()))
    }

    fn over_reference(&self, row: &Row) -> Option<f64> {
        ratio(row, self.rows.iter().find(|row| row.name == self.reference)?)
    }

    fn above_reference(&self, row: &Row) -> Option<f64> {
        difference(row, self.rows.iter().find(|row| row.name == self.reference)?)
    }

    /// Whether `row` keeps the bound; `None` where the figures do not tell.
    fn verdict(&self, row: &Row, must: Option<Must>) -> Option<Verdict<'_>> {
        let kept = match must? {
            Must::Nothing => return None,
            Must::Figure(bound) => median(row.rounds.clone().ok()?)? <= bound,
            Must::Over { ratio, figure } => {
                self.over_reference(row)? <= ratio && self.above_reference(row)? <= figure
            }
            Must::Ratio(bound) | Must::RatioBelowPeers(bound) => self.over_reference(row)? <= bound,
        };
        Some(match must? {
            _ if !kept => Verdict::Above,
            Must::RatioBelowPeers(_) => self.below_peers(row),
            _ => Verdict::Kept,
        })
    }

    /// Whether `row` is below every peer; the reference is no peer.
    fn below_peers(&self, row: &Row) -> Verdict<'_> {
        let peers = || self.rows.iter().filter(|peer| !peer.ours && peer.name != self.reference);
        if let Some(ahead) = peers().find(|peer| ratio(row, peer).is_some_and(|times| times >= 1.0)) {
            return Verdict::NotBelow(&ahead.name);
        }
        if peers().all(|peer| peer.rounds.is_ok()) { Verdict::Kept } else { Verdict::KeptSoFar }
    }
}

impl fmt::Display for Table<'_> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let over = format!("x {}", self.reference);
        let width = self.rows.iter().map(|row| row.name.len()).max().unwrap_or(0).max(12);
        let wide = over.len().max(9);
        writeln!(out, "\n{}, {}", self.title, self.unit)?;
        writeln!(
            out,
            "  {:width$} {:>10} {:>10} {:>10}  {over:>wide$}  {:>9}  {:>7}  verdict",
            "", "min", "median", "max", "ours/this", "must"
        )?;
        for row in &self.rows {
            write!(out, "  {:width$} ", row.name)?;
            let figures = match &row.rounds {
                Ok(figures) => figures,
                Err(reason) => {
                    writeln!(out, "{reason}")?;
                    continue;
                }
            };
            let min = figures.iter().copied().reduce(f64::min);
            let max = figures.iter().copied().reduce(f64::max);
            let ours = self.ours().next().and_then(|(ours, _)| ratio(ours, row));
            write!(
                out,
                "{:>10} {:>10} {:>10}  {:>wide$}  {:>9}",
                cell(min, 1),
                cell(median(figures.clone()), 1),
                cell(max, 1),
                cell(self.over_reference(row), 3),
                cell(ours, 3)
            )?;
            if let Some((_, must)) = self.ours().find(|(ours, _)| std::ptr::eq(*ours, row)) {
                let verdict =
                    self.verdict(row, must).map_or_else(|| "-".to_owned(), |verdict| verdict.to_string());
                let must = must.map_or_else(|| "-".to_owned(), |must| must.to_string());
                write!(out, "  {must:>7}  {verdict}")?;
            }
            writeln!(out)?;
        }
        Ok(())
    }
}

fn cell(value: Option<f64>, decimals: usize) -> String {
    value.map_or_else(|| "-".to_owned(), |value| format!("{value:.decimals$}"))
}

#[cfg(test)]
mod tests;
