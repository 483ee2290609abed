//! Values of options that several subcommands take.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use red_workload::policy::Policy;
use red_workload::units;

/// A time such as `60s`, in nanoseconds.
pub(crate) fn time_ns(text: &str) -> Result<u64, String> {
    units::time_ns(text)
        .map_err(|error| format!("{error}; expected a whole number and one of ns, us, ms, s, such as 60s"))
}

/// A policy by its name.
pub(crate) fn policy() -> impl TypedValueParser<Value = Policy> {
    PossibleValuesParser::new(Policy::ALL.map(Policy::name)).try_map(|name| name.parse::<Policy>())
}
