use super::*;

const RATES: [u64; 6] = [1, 1_000, 32_768, 1_000_000, 25_000_000, 1_000_000_000];

#[test]
fn a_tick_is_itself_again() {
    for hz in RATES {
        for tick in [0, 1, 2, 999, 32_767, 1 << 31, u64::from(u32::MAX), 1 << 33] {
            let at = nanos(tick, hz);
            assert_eq!(ticks(at, hz, u64::div_ceil), tick, "{tick} at {hz} Hz");
        }
    }
}

#[test]
fn who_sleeps_until_an_instant_does_not_wake_before_it() {
    for hz in RATES {
        for at in [0, 1, 999, 1_000, 1_001, 30_517, 30_518, 123_456_789, 1_000_000_001] {
            let wake = ticks(at, hz, u64::div_ceil);
            assert!(nanos(wake, hz) >= at, "{at} ns at {hz} Hz");
            assert!(wake == 0 || nanos(wake - 1, hz) < at, "{at} ns at {hz} Hz: a tick too late");
            assert!(nanos(ticks(at, hz, |a, b| a / b), hz) <= at, "{at} ns at {hz} Hz");
        }
    }
}

#[test]
fn the_end_of_time_stays_the_end() {
    assert_eq!(nanos(u64::MAX, 1), u64::MAX);
    assert!(ticks(u64::MAX, 1_000_000, u64::div_ceil) > 1 << 53);
}

#[test]
fn every_wrap_counts_once() {
    let extension = TickExtension::new();
    let step = 1u32 << 30;
    let (mut counter, mut expected) = (u32::MAX - 5, u64::from(u32::MAX - 5));
    for _ in 0..100 {
        assert_eq!(extension.extend(|| counter), expected);
        counter = counter.wrapping_add(step);
        expected += u64::from(step);
    }
    assert!(expected >> 32 > 20, "the counter wrapped often");
}
