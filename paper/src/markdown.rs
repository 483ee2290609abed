//! Tables as Markdown, and the cells of tables as text.

use crate::stat::Estimate;
use crate::table::{Cell, Claim, Column, Table};
use std::fmt::Write;

/// A cell as text, to the decimals of its column.
#[must_use]
pub fn cell(cell: &Cell, column: &Column) -> String {
    let decimals = column.decimals;
    match cell {
        Cell::Words(words) => words.clone(),
        Cell::Number(Some(number)) => format!("{number:.decimals$}"),
        Cell::Mean(Some(Estimate { mean, half_width, .. })) => {
            let (mean, half) = (format!("{mean:.decimals$}"), format!("{half_width:.decimals$}"));
            // An interval that is below what is printed says nothing.
            if half.bytes().all(|b| matches!(b, b'0' | b'.')) { mean } else { format!("{mean} ± {half}") }
        }
        Cell::Number(None) | Cell::Mean(None) => "-".to_owned(),
        Cell::Verdict(verdict) => verdict.words().to_owned(),
    }
}

/// A column's head.
#[must_use]
pub fn head(column: &Column) -> String {
    if column.unit.is_empty() { column.name.to_owned() } else { format!("{} ({})", column.name, column.unit) }
}

/// Tables under one title.
#[must_use]
pub fn document(tables: &[Table], seeds: u64) -> String {
    let head = format!(
        "# The paper on trial\n\nWhat `redrt paper` prints as Markdown: the experiments of the RED paper in virtual time, its values \
         beside ours, and policies beside each other. Means over {seeds} seeds with 95 % confidence intervals, the same to the \
         byte wherever it is run. Verdicts: *reproduced*, direction and size; *shape only*, direction; *not reproducible*, \
         neither, and why; *calibrated*, what the model was fitted to, which is no evidence; *ours*, nothing in the paper to \
         compare with; *holds* and *fails*, what this project promises; *not kept*, a promise of overload, with what was \
         measured; *loses*, where a rule of this project is worse than another. Platforms and the reason for each of their \
         numbers are in `paper/src/platform.rs`.\n"
    );
    let parts = tables.iter().map(of).map(|part| part.trim_end().to_owned());
    [head.trim_end().to_owned()].into_iter().chain(parts).collect::<Vec<_>>().join("\n\n")
}

/// A table and its claims.
#[must_use]
pub fn of(table: &Table) -> String {
    let mut out = format!("## {}\n\n`redrt paper {}`; paper: {}.\n", table.title, table.name, table.source);
    for paragraph in &table.about {
        let _ = write!(out, "\n{paragraph}\n");
    }
    out.push('\n');
    rows(
        &mut out,
        table.columns.iter().map(head),
        table.rows.iter().map(|row| row.iter().zip(&table.columns).map(|(c, column)| cell(c, column))),
    );
    if !table.claims.is_empty() {
        out.push('\n');
        let claim = |c: &Claim| {
            [c.claim.clone(), c.paper.clone(), c.ours.clone(), c.verdict.words().to_owned(), c.why.to_owned()]
        };
        rows(
            &mut out,
            ["claim", "paper", "here", "verdict", "why"].map(str::to_owned),
            table.claims.iter().map(claim),
        );
    }
    out
}

fn rows(
    out: &mut String,
    head: impl IntoIterator<Item = String>,
    rows: impl IntoIterator<Item = impl IntoIterator<Item = String>>,
) {
    let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    let head: Vec<String> = head.into_iter().collect();
    let rule = vec!["---".to_owned(); head.len()];
    out.push_str(&line(head));
    out.push_str(&line(rule));
    for row in rows {
        out.push_str(&line(row.into_iter().collect()));
    }
}
