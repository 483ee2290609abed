//! Times and amounts of memory as workload files and command lines write them: a whole number and a unit, exact.

use std::fmt;

type Unit = (&'static str, u64);

const TIME: [Unit; 4] = [("ns", 1), ("us", 1_000), ("ms", 1_000_000), ("s", 1_000_000_000)];
const MEMORY: [Unit; 4] = [("B", 1), ("KiB", 1 << 10), ("MiB", 1 << 20), ("GiB", 1 << 30)];

/// Reads a time such as `5ms`, with one of the units `ns`, `us`, `ms`, `s`, as nanoseconds.
///
/// # Errors
///
/// A sign, a fraction, a missing or unknown unit, white space, more than `u64` nanoseconds.
pub fn time_ns(text: &str) -> Result<u64, QuantityError> {
    quantity(text, &TIME)
}

/// Reads an amount of memory such as `8MiB`, with one of the units `B`, `KiB`, `MiB`, `GiB`, as bytes.
///
/// # Errors
///
/// As for [`time_ns`].
pub fn memory_bytes(text: &str) -> Result<u64, QuantityError> {
    quantity(text, &MEMORY)
}

/// Why a text is not a quantity. `Display` completes the sentence "the text is ...".
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QuantityError {
    /// No digits in front: empty, signed, a word, `NaN`.
    NotANumber,
    /// A fraction or an exponent.
    NotWhole,
    /// A number alone.
    NoUnit,
    /// A number and something that is not a unit.
    UnknownUnit,
    /// More than `u64` of the smallest unit.
    TooLarge,
}

impl fmt::Display for QuantityError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotANumber => "not a whole number with a unit",
            Self::NotWhole => "not whole: use a smaller unit",
            Self::NoUnit => "without a unit",
            Self::UnknownUnit => "in an unknown unit",
            Self::TooLarge => "too large for 64 bits",
        })
    }
}

impl std::error::Error for QuantityError {}

fn quantity(text: &str, units: &[Unit]) -> Result<u64, QuantityError> {
    let digits = text.len() - text.trim_start_matches(|c: char| c.is_ascii_digit()).len();
    let (number, unit) = text.split_at(digits);
    if number.is_empty() {
        return Err(QuantityError::NotANumber);
    }
    if unit.is_empty() {
        return Err(QuantityError::NoUnit);
    }
    let Some((_, factor)) = units.iter().find(|(name, _)| *name == unit) else {
        let is_fraction = unit.starts_with(['.', 'e', 'E']);
        return Err(if is_fraction { QuantityError::NotWhole } else { QuantityError::UnknownUnit });
    };
    let count: u64 = number.parse().map_err(|_| QuantityError::TooLarge)?;
    count.checked_mul(*factor).ok_or(QuantityError::TooLarge)
}

#[cfg(test)]
mod tests;
