//! Tables for people: a head, rows, columns as wide as they need.

use red_core::Duration;
use std::fmt;

/// Rows of text. The first column is aligned left, the others right.
#[derive(Default)]
pub(crate) struct Table {
    rows: Vec<Vec<String>>,
}

impl Table {
    /// A table with this head.
    pub(crate) fn new(head: &[&str]) -> Self {
        Self { rows: vec![head.iter().map(|cell| (*cell).to_owned()).collect()] }
    }

    /// Adds a row.
    pub(crate) fn row(&mut self, cells: impl IntoIterator<Item = String>) {
        self.rows.push(cells.into_iter().collect());
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let columns = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let width = |column: usize| {
            self.rows
                .iter()
                .filter_map(|row| row.get(column))
                .map(|cell| cell.chars().count())
                .max()
                .unwrap_or(0)
        };
        let widths: Vec<usize> = (0..columns).map(width).collect();
        for (i, row) in self.rows.iter().enumerate() {
            if i > 0 {
                writeln!(f)?;
            }
            for (column, (cell, width)) in row.iter().zip(&widths).enumerate() {
                match column {
                    0 => write!(f, "  {cell:<width$}")?,
                    _ => write!(f, "  {cell:>width$}")?,
                }
            }
        }
        Ok(())
    }
}

/// A time, or a dash where there is none.
pub(crate) fn time(ns: Option<u64>) -> String {
    ns.map_or_else(|| "-".to_owned(), |ns| Duration::from_nanos(ns).to_string())
}

/// A time that nothing is above: what is not shown of it counts as one more of the last digit.
pub(crate) fn at_most(ns: u64) -> String {
    let digit = match ns {
        1_000_000_000.. => 1_000_000,
        1_000_000.. => 1_000,
        _ => 1,
    };
    Duration::from_nanos(ns.div_ceil(digit).saturating_mul(digit)).to_string()
}

/// A time that may be below zero.
pub(crate) fn signed(ns: i128) -> String {
    let magnitude = ns.unsigned_abs();
    let shown = match u64::try_from(magnitude) {
        Ok(magnitude) => Duration::from_nanos(magnitude).to_string(),
        Err(_) => format!("{}.{:03} s", magnitude / 1_000_000_000, magnitude / 1_000_000 % 1_000),
    };
    if ns < 0 { format!("-{shown}") } else { shown }
}

#[cfg(test)]
mod tests;
