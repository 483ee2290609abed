//! The tables as a page.

use super::{Tables, real};
use crate::outcome::Failure;
use crate::report::to_json;
use red_paper::markdown;
use red_paper::stat::Estimate;
use red_paper::table::{Cell, Column, Table};
use red_report::page::Head;
use red_report::results;

/// How a column of the paper's values is called after what it measures.
const PAPER: &str = ", paper";

/// The page, which says what was `left` out, with what `--json` prints in it.
pub(super) fn of(tables: &[Table], seeds: u64, left: Option<&str>) -> Result<String, Failure> {
    let title = match tables {
        [one] => one.title.to_owned(),
        _ => "The paper on trial".to_owned(),
    };
    let (command, means) = match tables {
        [one] if one.name == real::NAME => {
            ("redrt paper real".to_owned(), "rounds on this machine".to_owned())
        }
        [one] => (format!("redrt paper {} --seeds {seeds}", one.name), format!("{seeds} seeds")),
        _ => (format!("redrt paper --seeds {seeds}"), format!("{seeds} seeds")),
    };
    let left = left.map_or_else(String::new, |left| format!("; {left}"));
    let head = Head {
        title,
        program: concat!("redrt ", env!("CARGO_PKG_VERSION")).to_owned(),
        about: format!(
            "The RED paper's values beside ours; means over {means} with 95 % confidence intervals{left}"
        ),
        data: to_json(&Tables::of(tables, seeds))?,
        command,
    };
    Ok(results::page(&head, &tables.iter().map(table).collect::<Vec<_>>()))
}

fn table(table: &Table) -> results::Table {
    let cell = |(cell, column): (&Cell, &Column)| match cell {
        Cell::Words(words) => results::Cell::Words(words.clone()),
        Cell::Verdict(verdict) => results::Cell::Verdict(verdict.words().to_owned()),
        Cell::Number(value) => {
            results::Cell::Number(markdown::cell(cell, column), value.map(|value| (value, 0.0)))
        }
        Cell::Mean(mean) => results::Cell::Number(
            markdown::cell(cell, column),
            mean.map(|Estimate { mean, half_width, .. }| (mean, half_width)),
        ),
    };
    let column = |column: &Column| results::Column {
        head: markdown::head(column),
        measures: format!("{} {}", column.name.strip_suffix(PAPER).unwrap_or(column.name), column.unit),
        is_paper: column.name.ends_with(PAPER) || column.name == "paper",
    };
    results::Table {
        name: table.name.to_owned(),
        title: table.title.to_owned(),
        source: table.source.to_owned(),
        about: table.about.clone(),
        columns: table.columns.iter().map(column).collect(),
        rows: table.rows.iter().map(|row| row.iter().zip(&table.columns).map(cell).collect()).collect(),
        claims: table
            .claims
            .iter()
            .map(|claim| results::Claim {
                claim: claim.claim.clone(),
                paper: claim.paper.clone(),
                ours: claim.ours.clone(),
                verdict: claim.verdict.words().to_owned(),
                why: claim.why.to_owned(),
            })
            .collect(),
    }
}
