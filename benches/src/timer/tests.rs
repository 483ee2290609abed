use super::*;
use crate::peers::tests::machine;

const OUTPUT: &str = "# /dev/cpu_dma_latency set to 0us\n# Histogram\n000000 000000\n000003 000060\n\
    000004 000038\n000009 000001\n# Total: 000000099\n# Min Latencies: 00003\n# Avg Latencies: 00003\n\
    # Max Latencies: 12345\n# Histogram Overflows: 00001\n# Histogram Overflow at cycle number:\n# Thread 0: 00042\n";

#[test]
fn percentiles_come_out_of_the_histogram() {
    assert_eq!(parse(OUTPUT), Some(Lateness { median: 3_000.0, p99: 9_000.0 }));
}

#[test]
fn a_percentile_beyond_the_histogram_is_infinite() {
    let late = OUTPUT.replace("Overflows: 00001", "Overflows: 00400");
    assert_eq!(parse(&late), Some(Lateness { median: f64::INFINITY, p99: f64::INFINITY }));
}

#[test]
fn output_without_a_histogram_is_none() {
    assert_eq!(parse("# Total: 0\n"), None);
    assert_eq!(parse(""), None);
}

#[test]
fn percentiles_of_samples_are_samples() {
    let samples: Vec<u64> = (1..=200).rev().collect();
    assert_eq!(Lateness::of(&samples), Some(Lateness { median: 100.0, p99: 198.0 }));
    assert_eq!(Lateness::of(&[7]), Some(Lateness { median: 7.0, p99: 7.0 }));
    assert_eq!(Lateness::of(&[]), None);
}

#[test]
fn red_releases_without_rights_too() {
    let late = red::measure(machine(), Duration::from_millis(20));
    assert!(late.as_ref().is_ok_and(|late| late.median > 0.0 && late.p99 >= late.median), "{late:?}");
}
