use super::*;

fn all(of_each: u64) -> Counts {
    Counts([of_each; ALL.len()])
}

#[test]
fn the_table_is_in_the_order_of_the_counts() {
    assert!((0..).zip(ALL).all(|(place, (count, _, _))| count as usize == place));
}

#[test]
fn what_was_promised_and_never_happened_is_told() {
    assert!(all(ENOUGH).missing(true).is_empty());
    let promised = ALL.iter().filter(|(count, _, promise)| *promise != Open && *count != Workloads);
    for (count, words, promise) in promised {
        let mut counts = all(ENOUGH);
        counts[*count] = 0;
        assert_eq!(counts.missing(true), [*words]);
        assert_eq!(counts.missing(false).is_empty(), *promise == WithRights, "{words}");
    }
    // Too short to tell.
    assert!(all(0).missing(true).is_empty());
}

#[test]
fn a_summary_is_read_as_it_was_written() {
    let mut counts = Counts::default();
    (0..).zip(ALL).for_each(|(number, (count, _, _))| counts[count] = number * 1_000);
    assert_eq!(Counts::read(&format!("soak: begins\n{counts}soak: clean\n12 of another\n")), counts);
}
