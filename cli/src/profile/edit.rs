//! The copy of a workload file with other times and lanes, and everything else as it was.

use crate::outcome::Failure;
use red_workload::model::Workload;
use red_workload::units::time_ns;
use toml_edit::{DocumentMut, Item, TableLike, Value};

/// What a node gets, in nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Times {
    /// Worst case.
    pub(super) wcet_ns: u64,
    /// Best case.
    pub(super) bcet_ns: u64,
    /// Contention; as in the file if absent.
    pub(super) contention_ns: Option<u64>,
}

/// Puts `times` (of each task, in the order of the nodes' numbers) and `lanes` (of each pool) into the text of
/// `workload`, under `header`.
///
/// # Errors
/// The text is not that of the workload.
pub(super) fn rewrite(
    text: &str,
    workload: &Workload,
    times: &[Vec<Times>],
    lanes: &[Option<u64>],
    header: &str,
) -> Result<String, Failure> {
    let changed = || Failure::Input("the file was changed while it was measured; start again".to_owned());
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut document: DocumentMut = text.parse().map_err(|_| changed())?;
    for pool in document.get_mut("pool").map(tables).into_iter().flatten() {
        // A divided pool is several of the workload's, and its clusters say how many lanes it has.
        let name = pool.get("name").and_then(Item::as_str);
        let of = workload.pools.iter().position(|pool| Some(pool.name.as_str()) == name);
        if let Some(lanes) = of.and_then(|of| lanes.get(of).copied().flatten()) {
            set(pool, "lanes", i64::try_from(lanes).unwrap_or(i64::MAX).into());
        }
    }
    // Numbers go over the nodes of a task first, and then over those of its events by their instants.
    let mut of_tasks: Vec<_> = times.iter().map(|times| times.iter()).collect();
    for (task, times) in document.get_mut("task").map(tables).into_iter().flatten().zip(&mut of_tasks) {
        put(task.get_mut("node"), times).ok_or_else(changed)?;
    }
    let mut events = document.get_mut("event").map(tables).unwrap_or_default();
    events.sort_by_key(|event| event.get("at").and_then(Item::as_str).and_then(|at| time_ns(at).ok()));
    for event in events {
        let name = event.get("task").and_then(Item::as_str);
        let task =
            workload.tasks.iter().position(|task| Some(task.name.as_str()) == name).ok_or_else(changed)?;
        put(event.get_mut("add"), &mut of_tasks[task]).ok_or_else(changed)?;
    }
    if of_tasks.iter().any(|rest| rest.len() > 0) {
        return Err(changed());
    }
    Ok(format!("{header}{document}"))
}

/// Gives the nodes of a list their times, in order; nothing if there are too few.
fn put<'t>(nodes: Option<&mut Item>, times: &mut impl Iterator<Item = &'t Times>) -> Option<()> {
    for part in nodes.map(tables).into_iter().flatten().flat_map(parts) {
        let Times { wcet_ns, bcet_ns, contention_ns } = times.next()?;
        set(part, "wcet", written(*wcet_ns).into());
        set(part, "bcet", written(*bcet_ns).into());
        if let Some(contention_ns) = contention_ns {
            set(part, "contention", written(*contention_ns).into());
        }
    }
    Some(())
}

/// The tables of a list, which TOML may write as tables or as inline tables.
fn tables(list: &mut Item) -> Vec<&mut dyn TableLike> {
    match list {
        Item::ArrayOfTables(tables) => tables.iter_mut().map(|table| table as &mut dyn TableLike).collect(),
        Item::Value(Value::Array(values)) => values
            .iter_mut()
            .filter_map(Value::as_inline_table_mut)
            .map(|table| table as &mut dyn TableLike)
            .collect(),
        _ => Vec::new(),
    }
}

/// What has times in a node: the node, or the encoder and then the decoders of a stage.
fn parts(node: &mut dyn TableLike) -> Vec<&mut dyn TableLike> {
    if !node.contains_key("mimonet") {
        return vec![node];
    }
    let stage = node.get_mut("mimonet").and_then(Item::as_table_like_mut);
    let (mut encoder, mut decoders) = (None, Vec::new());
    for (key, item) in stage.into_iter().flat_map(TableLike::iter_mut) {
        match key.get() {
            "encoder" => encoder = item.as_table_like_mut(),
            "decoders" => decoders = tables(item),
            _ => {}
        }
    }
    encoder.into_iter().chain(decoders).collect()
}

/// Replaces a value, leaving what stands around it, or adds it at the end.
fn set(table: &mut dyn TableLike, key: &str, mut value: Value) {
    if let Some(old) = table.get_mut(key).and_then(Item::as_value_mut) {
        *value.decor_mut() = old.decor().clone();
        *old = value;
        return;
    }
    // The space before the closing brace of an inline table belongs to its last value.
    if let Some(last) = table.iter_mut().last().and_then(|(_, item)| item.as_value_mut()) {
        let space = last.decor().suffix().and_then(|suffix| suffix.as_str()).unwrap_or_default().to_owned();
        if space.trim().is_empty() {
            last.decor_mut().set_suffix("");
            value.decor_mut().set_prefix(" ");
            value.decor_mut().set_suffix(space);
        }
    }
    table.insert(key, Item::Value(value));
}

/// A time in the largest unit in which it is whole.
fn written(ns: u64) -> String {
    let units = [(1_000_000_000, "s"), (1_000_000, "ms"), (1_000, "us")];
    let whole = units.into_iter().find(|(unit, _)| ns > 0 && ns.is_multiple_of(*unit));
    let (unit, name) = whole.unwrap_or((1, "ns"));
    format!("{}{name}", ns / unit)
}

#[cfg(test)]
mod tests;
