use super::*;
use red_workload::{Format, parse};

const FILE: &str = r#"# Top.
[[pool]]
name  = "cpu"
lanes = 2     # as many as there are

[[event]]   # the later one first
at   = "2s"
task = "t"
add  = [ { name = "late", wcet = "9ms", after = ["a"] } ]

[[event]]
at   = "1s"
task = "t"
add  = [ { name = "early", wcet = "9ms", bcet = "1ms" } ]

[[task]]
name     = "t"   # the task
deadline = "10ms"
period   = "10ms"

[[task.node]]
name = "a"
wcet = "2ms"   # guessed
body = { spin = "1ms" }

# A stage.
[[task.node]]
name    = "s"
atomic  = true
contention = "7ms"
mimonet = { weights = "w", frame = "f", encoder = { wcet = "12ms" }, decoders = [
  { name = "d", wcet = "4ms", body = { spin = "3ms" } },   # comment in a list
] }
"#;

fn times(of: &[(u64, u64, Option<u64>)]) -> Vec<Times> {
    of.iter()
        .map(|(wcet_ns, bcet_ns, contention_ns)| Times {
            wcet_ns: *wcet_ns,
            bcet_ns: *bcet_ns,
            contention_ns: *contention_ns,
        })
        .collect()
}

#[test]
fn every_part_gets_its_own_times_and_the_rest_stays() {
    let workload = parse(FILE.as_bytes(), Format::Toml, "f").unwrap();
    let of = times(&[
        (1_000, 10, None),
        (2_000, 20, Some(5)),
        (3_000, 30, Some(0)),
        (4_000, 40, None),
        (5_000, 50, None),
    ]);
    let text = rewrite(FILE, &workload, &[of], &[Some(1)], "# Header.\n\n").unwrap();
    let expected = r#"# Header.

# Top.
[[pool]]
name  = "cpu"
lanes = 1     # as many as there are

[[event]]   # the later one first
at   = "2s"
task = "t"
add  = [ { name = "late", wcet = "5us", after = ["a"], bcet = "50ns" } ]

[[event]]
at   = "1s"
task = "t"
add  = [ { name = "early", wcet = "4us", bcet = "40ns" } ]

[[task]]
name     = "t"   # the task
deadline = "10ms"
period   = "10ms"

[[task.node]]
name = "a"
wcet = "1us"   # guessed
body = { spin = "1ms" }
bcet = "10ns"

# A stage.
[[task.node]]
name    = "s"
atomic  = true
contention = "7ms"
mimonet = { weights = "w", frame = "f", encoder = { wcet = "2us", bcet = "20ns", contention = "5ns" }, decoders = [
  { name = "d", wcet = "3us", body = { spin = "3ms" }, bcet = "30ns", contention = "0ns" },   # comment in a list
] }
"#;
    assert_eq!(text, expected);
    parse(text.as_bytes(), Format::Toml, "f").unwrap();
}

#[test]
fn inline_lists_tables_of_stages_and_line_ends_are_taken_as_they_are() {
    let file = "\u{feff}pool = [{ name = \"p\", lanes = 4 }]\r\n[[task]]\r\nname = \"t\"\r\nonce = true\r\ndeadline = \"1s\"\r\n\
                [[task.node]]\r\nname = \"s\"\r\n[task.node.mimonet]\r\nweights = \"w\"\r\nframe = \"f\"\r\n\
                encoder.wcet = \"1ms\"\r\n[[task.node.mimonet.decoders]]\r\nname = \"d\"\r\nwcet = \"1ms\"\r\n";
    let workload = parse(file.as_bytes(), Format::Toml, "f").unwrap();
    let of = times(&[(9_000_000, 0, None), (2_000_000_000, 7, None)]);
    let text = rewrite(file, &workload, &[of], &[None], "").unwrap();
    let after = parse(text.as_bytes(), Format::Toml, "f").unwrap();
    assert_eq!(after.pools, workload.pools);
    let red_workload::model::Work::Stage(stage) = &after.tasks[0].nodes[0].work else { panic!("a stage") };
    assert_eq!((stage.encoder.wcet_ns, stage.encoder.bcet_ns), (9_000_000, 0));
    assert_eq!((stage.decoders[0].1.wcet_ns, stage.decoders[0].1.bcet_ns), (2_000_000_000, 7));
}

#[test]
fn a_file_with_other_nodes_is_refused() {
    let workload = parse(FILE.as_bytes(), Format::Toml, "f").unwrap();
    for count in [4, 6] {
        let of = times(&vec![(1, 0, None); count]);
        assert!(matches!(rewrite(FILE, &workload, &[of], &[None], ""), Err(Failure::Input(_))), "{count}");
    }
}

#[test]
fn a_divided_pool_keeps_its_lanes_and_those_after_it_get_theirs() {
    let file = r#"
pool = [
  { name = "gpu", lanes = 3, clusters = [{ name = "near", lanes = 1 }, { name = "far", lanes = 2 }] },
  { name = "dsp", lanes = 2 },
]

[[task]]
name     = "t"
deadline = "10ms"
period   = "10ms"
cluster  = "far"
node     = [ { name = "a", wcet = "2ms" } ]
"#;
    let workload = parse(file.as_bytes(), Format::Toml, "f").unwrap();
    assert_eq!(workload.pools.len(), 3);
    let of = times(&[(2_000_000, 0, None)]);
    let text = rewrite(file, &workload, &[of], &[Some(7), Some(7), Some(1)], "").unwrap();
    assert!(text.contains("{ name = \"gpu\", lanes = 3, clusters"), "{text}");
    assert!(text.contains("{ name = \"dsp\", lanes = 1 }"), "{text}");
}
