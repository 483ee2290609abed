use super::{MAX_LEAD_NS, SpinLead};

/// A reproducible sequence of lateness: `base` plus up to `spread`, and one in 500 is `outlier`.
fn lateness(count: u64, base: u64, spread: u64, outlier: u64) -> impl Iterator<Item = u64> {
    let mut state = 0x9E37_79B9_7F4A_7C15_u64;
    (0..count).map(move |i| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        if i % 500 == 499 { outlier } else { base + (state >> 33) % spread }
    })
}

/// Runs periodic waits in virtual time; returns (spin share in per mille, on-time wake-ups in per mille) of the
/// second half.
fn run(period_ns: u64, late: impl Iterator<Item = u64>) -> (u64, u64) {
    let late: Vec<u64> = late.collect();
    let mut lead = SpinLead::new();
    let (mut spin, mut on_time) = (0, 0);
    let half = late.len() / 2;
    for (i, &late) in late.iter().enumerate() {
        let at = (i as u64 + 1) * period_ns;
        let ahead = lead.begin(at);
        let spun = if ahead >= period_ns {
            lead.skipped();
            period_ns
        } else {
            lead.woke(late);
            ahead.saturating_sub(late)
        };
        if i >= half {
            spin += spun;
            on_time += u64::from(late <= ahead);
        }
    }
    let waits = (late.len() - half) as u64;
    (spin * 1_000 / (waits * period_ns), on_time * 1_000 / waits)
}

#[test]
fn a_steady_machine_is_on_time_for_little_spin() {
    let (share, on_time) = run(1_000_000, lateness(20_000, 10_000, 10_000, 20_000));
    assert!(share <= 12, "{share} per mille spent");
    assert!(on_time >= 980, "{on_time} per mille on time");
}

#[test]
fn the_lead_finds_the_percentile_from_both_sides() {
    for base in [2_000, 150_000] {
        let mut lead = SpinLead::new();
        for (i, late) in lateness(20_000, base, base / 10, base).enumerate() {
            lead.begin(i as u64 * 10_000_000);
            lead.woke(late);
        }
        let found = lead.lead_ns();
        assert!((base..base * 13 / 10).contains(&found), "base {base}: lead {found}");
    }
}

#[test]
fn the_share_stays_bounded_where_the_percentile_is_too_dear() {
    // Nine of ten wake at once, one in ten is 200 us late: the percentile alone would cost 18 % at 1 kHz.
    for period in [1_000_000, 200_000, 50_000, 20_000] {
        let late = (0..20_000).map(|i| if i % 10 == 0 { 200_000 } else { 1_000 });
        let (share, _) = run(period, late);
        assert!(share <= 33, "period {period}: {share} per mille spent");
    }
}

#[test]
fn one_outlier_moves_the_lead_by_a_tenth() {
    let mut lead = SpinLead::new();
    let before = lead.begin(0);
    lead.woke(1_000_000_000);
    assert!(lead.lead_ns() <= before + before / 8);
}

#[test]
fn waits_that_end_early_do_not_shorten_the_interval() {
    let (mut rung, mut quiet) = (SpinLead::new(), SpinLead::new());
    for period in 1..=100_u64 {
        for _ in 0..10 {
            rung.begin(period * 1_000_000);
        }
        quiet.begin(period * 1_000_000);
        rung.woke(100_000);
        quiet.woke(100_000);
    }
    assert_eq!(rung.lead_ns(), quiet.lead_ns());
}

#[test]
fn no_input_takes_the_lead_out_of_its_range() {
    let mut lead = SpinLead::new();
    for i in 0..10_000_u64 {
        lead.begin(i.wrapping_mul(u64::MAX / 7));
        lead.woke(u64::MAX);
        assert!(lead.lead_ns() <= MAX_LEAD_NS);
    }
    for i in 0..100_000 {
        lead.begin(i);
        lead.woke(0);
    }
    assert_eq!(lead.lead_ns(), 0);
}
