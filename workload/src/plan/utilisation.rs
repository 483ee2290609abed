//! The necessary test over several tasks: no pool may be asked for more than its lanes can do.
//!
//! It is not sufficient, whatever the slack: it ignores deadlines, blocking and carried-in work.

/// What one periodic task asks of one pool: (work of one job, period), in nanoseconds.
pub(super) type Demand = (u64, u64);

/// Idle lane time per second that `demands` leave on `lanes` lanes, in nanoseconds; negative when they ask for
/// more than there is. Exact where the hyperperiod and its work fit 64 bits; else rounded towards "does not fit",
/// by less than one nanosecond per demand.
pub(super) fn slack(demands: &[Demand], lanes: u8) -> i128 {
    const SECOND: u128 = 1_000_000_000;
    let asked = |&(work, period): &Demand| (u128::from(work) * SECOND).div_ceil(period.max(1).into());
    let sum: u128 = match over_hyperperiod(demands) {
        Some(all) => asked(&all),
        None => demands.iter().map(asked).sum(),
    };
    i128::from(lanes) * SECOND.cast_signed() - sum.cast_signed()
}

/// All demands as one: a pool that is exactly full then shows no rounding.
fn over_hyperperiod(demands: &[Demand]) -> Option<Demand> {
    let lcm = |lcm: u64, (_, period): &Demand| (lcm / gcd(lcm, *period)).checked_mul(*period);
    let hyperperiod = demands.iter().try_fold(1, lcm)?;
    let add = |sum: u64, (work, period): &Demand| sum.checked_add(work.checked_mul(hyperperiod / period)?);
    Some((demands.iter().try_fold(0, add)?, hyperperiod))
}

const fn gcd(mut a: u64, mut b: u64) -> u64 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

#[cfg(test)]
mod tests {
    use super::slack;

    #[test]
    fn half_full_three_times_leaves_half_of_two_lanes_and_is_too_much_for_one() {
        let half = (5_000_000, 10_000_000);
        assert_eq!(slack(&[half; 3], 2), 500_000_000);
        assert_eq!(slack(&[half; 3], 1), -500_000_000);
    }

    #[test]
    fn a_pool_that_is_exactly_full_has_no_slack_and_lacks_none() {
        assert_eq!(slack(&[(1, 3); 3], 1), 0);
        assert_eq!(slack(&[(1, 3), (1, 3), (2, 3)], 1), -333_333_334);
    }

    #[test]
    fn what_has_no_hyperperiod_in_64_bits_is_rounded_against_the_pool() {
        assert_eq!(slack(&[(1, u64::MAX), (1, u64::MAX - 1)], 1), 999_999_998);
    }
}
