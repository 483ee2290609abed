use super::QuantityError::{NoUnit, NotANumber, NotWhole, TooLarge, UnknownUnit};
use super::{memory_bytes, time_ns};

#[test]
fn each_unit_is_exact() {
    let times = [("7ns", 7), ("7us", 7_000), ("7ms", 7_000_000), ("7s", 7_000_000_000), ("0ns", 0)];
    for (text, expected) in times {
        assert_eq!(time_ns(text), Ok(expected), "{text}");
    }
    let amounts = [("3B", 3), ("3KiB", 3 << 10), ("3MiB", 3 << 20), ("3GiB", 3 << 30), ("0B", 0)];
    for (text, expected) in amounts {
        assert_eq!(memory_bytes(text), Ok(expected), "{text}");
    }
}

#[test]
fn the_largest_value_of_a_unit_is_the_last_that_is_accepted() {
    assert_eq!(time_ns("18446744073709551615ns"), Ok(u64::MAX));
    assert_eq!(time_ns("18446744073709551616ns"), Err(TooLarge));
    assert_eq!(time_ns("18446744073s"), Ok(18_446_744_073_000_000_000));
    assert_eq!(time_ns("18446744074s"), Err(TooLarge));
    assert_eq!(memory_bytes("17179869183GiB"), Ok(u64::MAX - (1 << 30) + 1));
    assert_eq!(memory_bytes("17179869184GiB"), Err(TooLarge));
    assert_eq!(time_ns(&format!("{}s", "9".repeat(1_000_000))), Err(TooLarge));
}

#[test]
fn whatever_is_not_digits_and_a_unit_is_refused() {
    let cases = [
        ("", NotANumber),
        ("ms", NotANumber),
        ("-5ms", NotANumber),
        ("+5ms", NotANumber),
        (" 5ms", NotANumber),
        ("NaN", NotANumber),
        ("inf", NotANumber),
        ("٣ms", NotANumber),
        ("5", NoUnit),
        ("1.5ms", NotWhole),
        ("1e3ns", NotWhole),
        ("5 ms", UnknownUnit),
        ("5ms ", UnknownUnit),
        ("5MS", UnknownUnit),
        ("5m", UnknownUnit),
        ("5min", UnknownUnit),
        ("5µs", UnknownUnit),
        ("5KiB", UnknownUnit),
    ];
    for (text, expected) in cases {
        assert_eq!(time_ns(text), Err(expected), "{text}");
    }
    for text in ["8MB", "8KB", "8kib", "8Mi", "8ms"] {
        assert_eq!(memory_bytes(text), Err(UnknownUnit), "{text}");
    }
}
