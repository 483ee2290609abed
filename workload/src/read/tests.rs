use crate::Refusal::{
    self, Conflict, Duplicate, Limit, Memory, Missing, Name, Quantity, Range, Type, UnknownKey,
};
use crate::fixtures::{EXAMPLE_TOML, EXAMPLE_YAML, accepted, refused, refused_as, with_nodes};
use crate::model::{Arrival, Body, Event, Node, Part, Pool, PoolKind, Sensor, Stage, Task, Work, Workload};
use crate::plan::plan;
use crate::{Format, parse};

const MS: u64 = 1_000_000;

fn part(wcet_ns: u64, body: Body) -> Part {
    Part { wcet_ns, bcet_ns: 0, body, pool: 0, memory_bytes: 0, atomic: false, contention_ns: 0 }
}

fn onnx(name: &str) -> Body {
    Body::Onnx { path: format!("models/{name}.onnx") }
}

fn example() -> Workload {
    let plain = |name: &str, after: &[&str], part| Node {
        name: name.to_owned(),
        after: after.iter().map(|name| (*name).to_owned()).collect(),
        before: Vec::new(),
        work: Work::Plain(part),
    };
    let spin = Body::Spin { duration_ns: 1_500_000 };
    let camera = plain("camera", &[], Part { bcet_ns: MS, ..part(2 * MS, spin) });
    let perception = Node {
        work: Work::Stage(Stage {
            weights: "mimo-v1".to_owned(),
            frame: "front".to_owned(),
            encoder: part(12 * MS, onnx("encoder")),
            decoders: vec![
                ("lane".to_owned(), part(4 * MS, onnx("lane"))),
                ("segment".to_owned(), part(6 * MS, onnx("segment"))),
            ],
        }),
        ..plain("perception", &["camera"], part(0, Body::None))
    };
    let plugin =
        Body::Plugin { path: "libcontrol.so".to_owned(), symbol: "control_step".to_owned(), graph: false };
    let control = Part { atomic: true, contention_ns: MS, memory_bytes: 8 << 20, ..part(3 * MS, plugin) };
    let detect = plain("detect", &["camera"], part(9 * MS, onnx("detect")));
    let event = |at_ns, add, remove| Event { at_ns, task: 0, add, remove };
    Workload {
        pools: vec![Pool {
            name: "gpu".to_owned(),
            kind: PoolKind::Cpu,
            lanes: 2,
            memory_bytes: Some(512 << 20),
            cpus: vec![1],
        }],
        sensors: vec![Sensor { name: "front".to_owned(), period_ns: 33 * MS }],
        tasks: vec![Task {
            name: "cruise".to_owned(),
            deadline_ns: 120 * MS,
            arrival: Arrival::Periodic { period_ns: 100 * MS },
            offset_ns: 0,
            value: 10,
            floor: Some((3, 4)),
            nodes: vec![camera, perception, plain("control", &["perception"], control)],
        }],
        events: vec![
            event(3_000 * MS, vec![Node { before: vec!["control".to_owned()], ..detect }], Vec::new()),
            event(6_000 * MS, Vec::new(), vec!["detect".to_owned()]),
        ],
        sync: None,
    }
}

#[test]
fn the_example_of_the_manual_is_read_to_the_letter() {
    assert_eq!(accepted(EXAMPLE_TOML), example());
    assert_eq!(parse(EXAMPLE_YAML.as_bytes(), Format::Yaml, "w"), Ok(example()));
}

/// A broken line of the example or of [`HEAD`], what is wrong with it, and words of the message.
type Case<'a> = (&'a str, &'a str, Refusal, &'a str);

/// Replaces the line of the example that starts like the broken one, in TOML and in YAML.
#[test]
fn a_broken_line_of_the_example_is_refused_at_that_line() {
    let cases: [Case<'_>; 38] = [
        ("name   = \"gpu\"", "name = \"g p\"", Name, "1 to 64"),
        ("name   = \"gpu\"", "name = \"\"", Name, "1 to 64"),
        ("name   = \"gpu\"", "name = \"g.p\"", Name, "1 to 64"),
        ("name   = \"gpu\"", "name = \"\\u001b[31m\"", Name, "\\u{1b}[31m"),
        ("kind   = \"cpu\"", "kind = \"cudda\"", Range, "did you mean `cuda`?"),
        ("lanes  = 2", "lanes = 0", Range, "from 1 to 32"),
        ("lanes  = 2", "lanes = 33", Range, "from 1 to 32"),
        ("lanes  = 2", "lanes = 2.0", Type, "integer"),
        ("memory = \"512MiB\"", "memory = 512", Quantity, "unit"),
        ("memory = \"512MiB\"", "memory = \"7MiB\"", Memory, "7340032 bytes of pool `gpu`"),
        ("cpus   = [1]", "cpus = [1, 1]", Duplicate, "each CPU once"),
        ("cpus   = [1]", "cpus = [4096]", Range, "4095"),
        ("cpus   = [1]", "cpus = 1", Type, "a list"),
        ("period = \"33ms\"", "period = \"0ms\"", Range, "from 1ns"),
        ("deadline = \"120ms\"", "deadline = \"0s\"", Range, "from 1ns"),
        ("deadline = \"120ms\"", "deadline = \"9223372036s\"", Range, "4611686018427387904ns"),
        ("deadline = \"120ms\"", "deadline = \"-1ms\"", Quantity, "not a whole number"),
        ("deadline = \"120ms\"", "deadline = \"nan\"", Quantity, "not a whole number"),
        ("deadline = \"120ms\"", "deadline = \"1.5ms\"", Quantity, "smaller unit"),
        ("deadline = \"120ms\"", "deadline = 120", Quantity, "unit"),
        ("deadline = \"120ms\"", "deadline = \"99999999999s\"", Quantity, "too large"),
        ("period   = \"100ms\"", "period = \"0us\"", Range, "from 1ns"),
        ("period   = \"100ms\"", "min_interarrival = \"0us\"", Range, "from 1ns"),
        ("period   = \"100ms\"", "once = false", Range, "`true`"),
        ("period   = \"100ms\"", "peroid = \"100ms\"", UnknownKey, "did you mean `period`?"),
        ("offset   = \"0ms\"", "once = true", Conflict, "both `period` and `once`"),
        ("value    = 10", "value = -1", Range, "from 0"),
        ("floor    = [3, 4]", "floor = [5, 4]", Range, "from 0 to 4"),
        ("floor    = [3, 4]", "floor = [0, 0]", Range, "from 1"),
        ("floor    = [3, 4]", "floor = [3]", Type, "two integers"),
        ("floor    = [3, 4]", "floor = [3, 4, 5]", Type, "two integers"),
        ("bcet   = \"1ms\"", "bcet = \"3ms\"", Range, "above `wcet`"),
        ("atomic = true", "atomic = false", Conflict, "without `atomic = true`"),
        ("atomic = true", "atomic = \"yes\"", Type, "`true` or `false`"),
        ("pool   = \"gpu\"", "pool = \"gpus\"", Refusal::Reference, "did you mean `gpu`?"),
        ("memory = \"8MiB\"", "memory = \"1GiB\"", Memory, "536870912 bytes of pool `gpu`"),
        ("task = \"cruise\"", "task = \"cruize\"", Refusal::Reference, "did you mean `cruise`?"),
        ("remove = [\"detect\"]", "remove = []", Missing, "changes nothing"),
    ];
    for (line, broken, refusal, words) in cases {
        let text = EXAMPLE_TOML.replacen(line, broken, 1);
        assert_ne!(text, EXAMPLE_TOML, "{line}");
        let error = refused(&text);
        assert_eq!(error.refusal, refusal, "{broken}: {error}");
        assert!(error.to_string().contains(words), "{broken}: {error}");
    }
    for (line, broken, refusal, (row, column)) in [
        ("kind: cpu", "kind: cpuu", Range, (4, 23)),
        ("lanes: 2", "lanes: 40", Range, (4, 35)),
        ("deadline: 120ms", "deadline: 120", Quantity, (10, 15)),
        ("    offset: 0ms", "    once: true", Conflict, (12, 11)),
        ("floor: [3, 4]", "floor: [3, 0]", Range, (14, 16)),
        ("        bcet: 1ms", "        bcet: 3ms", Range, (18, 15)),
        ("after: [camera]", "after: [camra]", Refusal::Reference, (21, 17)),
        ("frame: 'front'", "fram: 'front'", UnknownKey, (24, 11)),
        ("atomic: true", "atomic: false", Conflict, (33, 21)),
        ("remove: [detect]", "remove: [detekt]", Refusal::Reference, (46, 37)),
    ] {
        let text = EXAMPLE_YAML.replacen(line, broken, 1);
        let error = refused_as(text.as_bytes(), Format::Yaml);
        let place = error.place.map(|place| (place.line, place.column));
        assert_eq!((error.refusal, place), (refusal, Some((row, column))), "{broken}: {error}");
    }
}

#[test]
fn tables_that_are_missing_or_doubled_are_refused() {
    let node = "node = [{ name = 'a', wcet = '1ms' }]\n";
    let task = |name: &str| format!("[[task]]\nname = '{name}'\ndeadline = '1ms'\nonce = true\n{node}");
    let pool = "[[pool]]\nname = 'p'\nlanes = 1\n";
    let sensor = "[[sensor]]\nname = 's'\nperiod = '1ms'\n";
    let valid = format!("{pool}{sensor}{}", task("t"));
    assert_eq!(accepted(&valid).tasks[0].arrival, Arrival::Once);
    let cases = [
        (task("t"), Missing, "no `pool`"),
        (format!("pool = []\n{}", task("t")), Missing, "at least one pool"),
        (pool.to_owned(), Missing, "no `task`"),
        (format!("task = []\n{pool}"), Missing, "at least one task"),
        (valid.replace(node, ""), Missing, "no `node`"),
        (valid.replace(node, "node = []\n"), Missing, "at least one node"),
        (valid.replace("once = true\n", ""), Missing, "none of `period`, `min_interarrival`, `once`"),
        (valid.replace("deadline = '1ms'\n", ""), Missing, "no `deadline`"),
        (valid.replace("lanes = 1\n", ""), Missing, "no `lanes`"),
        (format!("{valid}{}", task("t")), Duplicate, "a task named `t`"),
        (format!("{valid}{pool}"), Duplicate, "a pool named `p`"),
        (format!("{valid}{sensor}"), Duplicate, "a sensor named `s`"),
        (format!("{valid}[sync]\ngrid = '0ms'\ncost = '0ms'\n"), Range, "from 1ns"),
        (format!("{valid}[sync]\ngrid = '1ms'\n"), Missing, "no `cost`"),
        (
            format!("{valid}{}", (1..=16).map(|n| task(&n.to_string())).collect::<String>()),
            Limit,
            "at most 16",
        ),
        (format!("{valid}[[pool]]\nname = 'q'\nlanes = 32\n"), Limit, "at most 32 lanes"),
    ];
    for (text, refusal, words) in cases {
        let error = refused(&text);
        assert_eq!(error.refusal, refusal, "{error}");
        assert!(error.to_string().contains(words), "{error}");
    }
    assert!(accepted(&format!("{valid}[sync]\ngrid = '5ms'\ncost = '0ms'\n")).sync.is_some());
}

#[test]
fn sensors_of_many_periods_are_told_apart_as_far_as_stages_read_them() {
    let text = |tasks: usize, sensors: usize| {
        let sensor = |n: usize| format!("[[sensor]]\nname = 's{n}'\nperiod = '{}ms'\n", n + 1);
        let stage = |n: usize| {
            format!(
                "[[task.node]]\nname = 'n{n}'\nmimonet = {{ weights = 'w', frame = 's{n}', \
                 encoder = {{ wcet = '1ns' }}, decoders = [{{ name = 'd', wcet = '1ns' }}] }}\n"
            )
        };
        let task = |t: usize| {
            let head = format!("[[task]]\nname = 't{t}'\ndeadline = '1s'\nonce = true\n");
            head + &(t * 128..(t + 1) * 128).map(stage).collect::<String>()
        };
        let sensors: String = (0..sensors).map(sensor).collect();
        format!("[[pool]]\nname = 'p'\nlanes = 1\n{sensors}{}", (0..tasks).map(task).collect::<String>())
    };
    for valid in [text(1, 300), text(2, 256), text(3, 256)] {
        let workload = accepted(&valid);
        assert!(plan::<red_core::Caps<16, 256, 64, 32, 32, 4, 16>>(&workload).is_ok());
    }
    let error = refused(&text(3, 257));
    assert_eq!((error.refusal, error.place.map(|place| place.line)), (Limit, Some(3 + 257 * 3)), "{error}");
}

#[test]
fn messages_stay_short_whatever_the_file_says() {
    let long = "x".repeat(1_000_000);
    let many: String = (0..200).map(|n| format!("'{n}{}',", "y".repeat(60))).collect();
    for text in [
        format!("{long} = 1\n"),
        format!("pool = '{long}'\n"),
        format!("[[pool]]\nname = '{long}'\n"),
        with_nodes(&format!("{{ name = 'a', wcet = '{long}' }}"), ""),
        with_nodes(&format!("{{ name = 'a', wcet = '1ms', after = ['{long}'] }}"), ""),
        with_nodes(&format!("{{ name = 'a', wcet = '1ms', after = ['a.{long}'] }}"), ""),
        with_nodes(&format!("{{ name = 'a', wcet = '1ms', after = [{many}] }}"), ""),
        with_nodes("{ name = 'a', wcet = '1ms' }", &format!("[[event]]\nat = '1s'\ntask = '{long}'\n")),
    ] {
        refused(&text);
    }
    let error = parse(b"x = 1", Format::Toml, &long).unwrap_err();
    assert!(error.to_string().chars().count() < 2000);
}
