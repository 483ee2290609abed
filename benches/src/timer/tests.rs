use super::*;

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
