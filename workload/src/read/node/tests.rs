use crate::Refusal::{self, Conflict, Duplicate, Memory, Missing, Name, Overflow, Type, UnknownKey};
use crate::fixtures::{accepted, refused, with_nodes};
use crate::model::{Part, Work};

fn assert_node_refused(node: &str, refusal: Refusal, words: &str) {
    let error = refused(&with_nodes(&format!("{{ {node} }}"), ""));
    assert_eq!(error.refusal, refusal, "{node}: {error}");
    assert!(error.to_string().contains(words), "{node}: {error}");
}

#[test]
fn nodes_and_stages_that_are_incomplete_or_too_much_are_refused() {
    let cases = [
        ("name = 'a'", Missing, "none of `wcet`, `mimonet`"),
        ("wcet = '1ms'", Missing, "no `name`"),
        ("name = 'a.b', wcet = '1ms'", Name, "letters"),
        ("name = 'a', wcet = '1ms', contention = '0ns'", Conflict, "without `atomic = true`"),
        ("name = 'a', wcet = '1ms', memory = '1025B'", Memory, "1024 bytes of pool `cpu`"),
        ("name = 'a', wcet = '1ms', after = 'b'", Type, "a list"),
        ("name = 'a', wcet = '1ms', after = [1]", Type, "a text"),
        (
            "name = 'a', wcet = '18446744073709551615ns', atomic = true, contention = '1ns'",
            Overflow,
            "64 bits",
        ),
    ];
    for (node, refusal, words) in cases {
        assert_node_refused(node, refusal, words);
    }
    let stage = |rest: &str| format!("name = 's', {rest} weights = 'w', frame = 'f',");
    let cases = [
        ("", "decoders = [{ name = 'x', wcet = '1ms' }]", Missing, "no `encoder`"),
        ("", "encoder = { wcet = '1ms' }", Missing, "no `decoders`"),
        ("", "encoder = { wcet = '1ms' }, decoders = []", Missing, "at least one decoder"),
        ("", "encoder = {}, decoders = []", Missing, "no `wcet`"),
        ("", "encoder = { name = 'e', wcet = '1ms' }, decoders = []", UnknownKey, "no key `name`"),
        ("", "encoder = { wcet = '1ms' }, decoders = [{ wcet = '1ms' }]", Missing, "no `name`"),
        (
            "",
            "encoder = { wcet = '1ms' }, decoders = [{ name = 'encoder', wcet = '1ms' }]",
            Duplicate,
            "encoder",
        ),
        (
            "",
            "encoder = { wcet = '1ms' }, decoders = [{ name = 'x', wcet = '1ms' }, { name = 'x', wcet = '1ms' }]",
            Duplicate,
            "a decoder named `x`",
        ),
        ("wcet = '1ms',", "", Conflict, "both `wcet` and `mimonet`"),
        ("bcet = '1ms',", "", Conflict, "`bcet`"),
        ("body = { spin = '1ms' },", "", Conflict, "`body`"),
        (
            "memory = '513B',",
            "encoder = { wcet = '1ms' }, decoders = [{ name = 'x', wcet = '1ms' }]",
            Memory,
            "1026",
        ),
        (
            "contention = '1ms',",
            "encoder = { wcet = '1ms' }, decoders = [{ name = 'x', wcet = '1ms' }]",
            Conflict,
            "without `atomic = true`",
        ),
    ];
    for (node, mimonet, refusal, words) in cases {
        let stage = stage("").replace("name = 's', ", &format!("name = 's', {node} mimonet = {{"));
        assert_node_refused(&format!("{stage} {mimonet} }}"), refusal, words);
    }
}

#[test]
fn a_part_overrides_its_stage() {
    let parts = "encoder = { wcet = '1ms', pool = 'cpu', memory = '1KiB' }, \
                 decoders = [{ name = 'x', wcet = '1ms' }, { name = 'y', wcet = '1ms', atomic = false }]";
    let node = format!(
        "{{ name = 's', pool = 'gpu', memory = '2KiB', atomic = true, contention = '3ns', \
         mimonet = {{ weights = 'w', frame = 'f', {parts} }} }}"
    );
    let workload = accepted(&with_nodes(&node, ""));
    let Work::Stage(stage) = &workload.tasks[0].nodes[0].work else { panic!("a stage was written") };
    let traits = |part: &Part| (part.pool, part.memory_bytes, part.atomic, part.contention_ns);
    assert_eq!(traits(&stage.encoder), (0, 1 << 10, true, 3));
    assert_eq!(traits(&stage.decoders[0].1), (1, 2 << 10, true, 3));
    assert_eq!(traits(&stage.decoders[1].1), (1, 2 << 10, false, 0));
}
