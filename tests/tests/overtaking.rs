//! At most as many nodes as a pool has lanes overtake a head that does not fit into memory. An encoder whose result was
//! thrown away is such a head anew when it runs again, whichever way it was done before.

use red_tests::differential::{Found, compare, core, options};
use red_tests::oracle::{Policy, Row};
use red_workload::{Format, parse};

const MS: u64 = 1_000_000;

/// A job of these nodes and of `h`, which needs so much memory and comes before `two.d`, beside jobs that need none: `a`
/// and `b`, and `late` later. Rows as `node start..finish`, in milliseconds, which the oracle has to make, too.
fn rows(nodes: &str, h: &str, late_ms: u64) -> Vec<String> {
    let text = format!(
        r#"
        [[pool]]
        name = "gpu"
        lanes = 2
        memory = "100B"
        [[task]]
        name = "T"
        deadline = "100ms"
        once = true
        node = [{nodes}]
        [[event]]
        at = "0ms"
        task = "T"
        add = [{{ name = "h", wcet = "2ms", memory = "{h}", before = ["two.d"] }}]
        [[task]]
        name = "light"
        deadline = "100ms"
        once = true
        node = [{{ name = "a", wcet = "1ms" }}, {{ name = "b", wcet = "1ms" }}]
        [[task]]
        name = "later"
        deadline = "100ms"
        offset = "{late_ms}ms"
        once = true
        node = [{{ name = "late", wcet = "1ms" }}]
        "#
    );
    let workload = parse(text.as_bytes(), Format::Toml, "overtaking.toml").unwrap_or_else(|e| panic!("{e}"));
    let found = Found::of(core(&workload, &options(Policy::Redrt, 50 * MS)));
    compare(&found, &workload, Policy::Redrt, 50 * MS).unwrap_or_else(|why| panic!("{why}"));
    let row = |row: &Row| format!("{} {}..{}", row.node, row.start_ns / MS, row.finish_ns / MS);
    found.rows.iter().map(row).collect()
}

#[test]
fn an_encoder_that_ran_in_the_unit_of_another_is_overtaken_anew_when_it_runs_again() {
    // Beside `p`, a and b overtake the encoder of `two`, which then runs in the unit of `one`. The result goes for `h`;
    // late overtakes that encoder once more.
    let nodes = r#"
        { name = "p", wcet = "10ms", memory = "55B" },
        { name = "one", after = ["p"], mimonet = { weights = "w", frame = "f",
            encoder = { wcet = "5ms", memory = "60B" }, decoders = [{ name = "d", wcet = "4ms" }] } },
        { name = "two", mimonet = { weights = "w", frame = "f",
            encoder = { wcet = "5ms", memory = "60B" }, decoders = [{ name = "d", wcet = "1ms" }] } }
    "#;
    let expected = [
        "p 0..10",
        "a 0..1",
        "b 1..2",
        "one.encoder 10..15",
        "two.encoder 10..15",
        "one.d 15..19",
        "h 19..21",
        "late 20..21",
        "two.encoder 21..26",
        "two.d 26..27",
    ];
    assert_eq!(rows(nodes, "50B", 20), expected);
}

#[test]
fn an_encoder_that_was_a_hit_is_overtaken_anew_when_it_runs_again() {
    // Beside `p` the smaller encoder of `one` overtakes that of `two`, which then is a hit. The result goes for `h`;
    // b and late overtake that encoder then.
    let nodes = r#"
        { name = "p", wcet = "10ms", memory = "55B" },
        { name = "one", mimonet = { weights = "w", frame = "f",
            encoder = { wcet = "5ms", memory = "40B" }, decoders = [{ name = "d", wcet = "1ms" }] } },
        { name = "two", mimonet = { weights = "w", frame = "f",
            encoder = { wcet = "5ms", memory = "60B" }, decoders = [{ name = "d", wcet = "4ms" }] } }
    "#;
    let expected = [
        "p 0..10",
        "one.encoder 0..5",
        "two.encoder 5..5",
        "one.d 5..6",
        "a 6..7",
        "h 10..12",
        "b 10..11",
        "late 11..12",
        "two.encoder 12..17",
        "two.d 17..21",
    ];
    assert_eq!(rows(nodes, "65B", 11), expected);
}
