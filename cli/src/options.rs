//! Values of options that several subcommands take.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use red_workload::policy::Policy;
use red_workload::units;

/// A time such as `60s`, in nanoseconds.
pub(crate) fn time_ns(text: &str) -> Result<u64, String> {
    units::time_ns(text)
        .map_err(|error| format!("{error}; expected a whole number and one of ns, us, ms, s, such as 60s"))
}

/// How long to run, in nanoseconds.
pub(crate) fn duration_ns(text: &str) -> Result<u64, String> {
    match horizon_ns(text)? {
        0 => Err("expected more than 0, such as 10s".to_owned()),
        duration => Ok(duration),
    }
}

/// Latest horizon, in nanoseconds: a release before it and the longest deadline, 2^62 ns each, stay below 2^63.
const LATEST_HORIZON_NS: u64 = 1 << 62;

/// A horizon of virtual time, in nanoseconds.
pub(crate) fn horizon_ns(text: &str) -> Result<u64, String> {
    let horizon = time_ns(text)?;
    if horizon > LATEST_HORIZON_NS {
        return Err(format!("expected at most {LATEST_HORIZON_NS}ns, which are 146 years"));
    }
    Ok(horizon)
}

/// A seed of random numbers.
pub(crate) fn seed(text: &str) -> Result<u64, String> {
    text.parse().map_err(|_| format!("expected a whole number from 0 to {}", u64::MAX))
}

/// A policy by its name.
pub(crate) fn policy() -> impl TypedValueParser<Value = Policy> {
    PossibleValuesParser::new(Policy::NAMED.map(Policy::name)).try_map(|name| name.parse::<Policy>())
}
