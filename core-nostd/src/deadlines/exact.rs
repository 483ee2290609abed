//! `floor(a * b / c)` without loss, also where the product needs more than 128 bits.

/// `floor(a * b / c)` for `b <= c`, so that the result is at most `a`. `c` must be below 2^126.
pub(crate) fn share(a: u64, b: u128, c: u128) -> u64 {
    debug_assert!(b <= c && c > 0 && c < 1 << 126, "a share of a whole");
    match b.checked_mul(u128::from(a)) {
        Some(product) => (product / c.max(1)) as u64,
        None => long_share(a, b, c),
    }
}

/// Binary long multiplication and division in one: 64 rounds, no product wider than `3 * c`.
#[cold]
fn long_share(a: u64, b: u128, c: u128) -> u64 {
    let (mut quotient, mut rest) = (0u64, 0u128);
    for bit in (0..u64::BITS).rev() {
        rest = 2 * rest + if a >> bit & 1 != 0 { b } else { 0 };
        quotient <<= 1;
        while rest >= c {
            rest -= c;
            quotient += 1;
        }
    }
    quotient
}

#[cfg(test)]
mod tests;
