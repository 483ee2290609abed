//! Times for people: three digits that say something.

/// A time such as `12.4 ms`.
#[must_use]
pub fn time(ns: u64) -> String {
    let (unit, name) = match ns {
        1_000_000_000.. => (1_000_000_000, "s"),
        1_000_000.. => (1_000_000, "ms"),
        1_000.. => (1_000, "µs"),
        _ => return format!("{ns} ns"),
    };
    let value = ns as f64 / unit as f64;
    match value {
        100.0.. => format!("{value:.0} {name}"),
        10.0.. => format!("{value:.1} {name}"),
        _ => format!("{value:.2} {name}"),
    }
}

/// A time, or a dash.
pub(crate) fn or_dash(ns: Option<u64>) -> String {
    ns.map_or_else(|| "–".to_owned(), time)
}

/// Steps of an axis of about `count` parts up to `span_ns`: 1, 2 or 5 times a power of ten.
pub(crate) fn step(span_ns: u64, count: u64) -> u64 {
    let least = span_ns.div_ceil(count.max(1)).max(1);
    let power = 10_u64.pow(least.ilog10());
    [1, 2, 5, 10]
        .into_iter()
        .map(|times| power.saturating_mul(times))
        .find(|step| *step >= least)
        .unwrap_or(least)
}

#[cfg(test)]
mod tests;
