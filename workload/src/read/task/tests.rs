use crate::Refusal::{Limit, Overflow};
use crate::fixtures::{accepted, refused, with_nodes};
use crate::model::{Arrival, PoolKind};

const MS: u64 = 1_000_000;

#[test]
fn a_task_has_room_for_256_nodes_over_all_its_versions() {
    let nodes = |count: usize| -> String {
        (0..count).map(|n| format!("{{ name = 'n{n}', wcet = '1ms' }},")).collect()
    };
    let stage = "{ name = 's', mimonet = { weights = 'w', frame = 'f', encoder = { wcet = '1ms' }, \
                 decoders = [{ name = 'x', wcet = '1ms' }] } },";
    let event = |at: u32, change: &str| format!("[[event]]\nat = '{at}s'\ntask = 't'\n{change}\n");
    let add = event(1, "add = [{ name = 'a', wcet = '1ms' }]");
    let back = event(2, "remove = ['a']") + &event(3, "add = [{ name = 'a', wcet = '1ms' }]");
    for (nodes, events) in [
        (nodes(256), String::new()),
        (nodes(254) + stage, String::new()),
        (nodes(255), add.clone()),
        (nodes(254), add.clone() + &back),
    ] {
        accepted(&with_nodes(&nodes, &events));
    }
    for (nodes, events) in [
        (nodes(257), String::new()),
        (nodes(255) + stage, String::new()),
        (nodes(256), add.clone()),
        (nodes(255), add.clone() + &back),
    ] {
        let error = refused(&with_nodes(&nodes, &events));
        assert_eq!(error.refusal, Limit, "{error}");
    }
}

#[test]
fn sums_over_a_task_fit_64_bits_or_are_refused() {
    let huge = "{ name = 'a', wcet = '18446744073709551614ns' },";
    let unlimited =
        |amount: &str| format!("{{ name = 'm{amount}', wcet = '0s', pool = 'gpu', memory = '{amount}' }},");
    let event = |node: &str| format!("[[event]]\nat = '1s'\ntask = 't'\nadd = [{node}]\n");
    let small = "{ name = 'b', wcet = '1ns', pool = 'gpu' },";
    let other = |node: &str| format!("[[task]]\nname = 'o'\ndeadline = '1s'\nonce = true\nnode = [{node}]\n");
    accepted(&with_nodes(&(huge.to_owned() + &small.replace(", pool = 'gpu'", "")), ""));
    accepted(&with_nodes(&(unlimited("17179869183GiB") + &unlimited("1073741823B")), ""));
    for (nodes, events) in [
        (huge.to_owned() + "{ name = 'b', wcet = '2ns' }", String::new()),
        (huge.to_owned() + "{ name = 'b', wcet = '1ns', atomic = true, contention = '1ns' }", String::new()),
        (huge.to_owned(), event("{ name = 'b', wcet = '2ns' }")),
        (unlimited("17179869183GiB") + &unlimited("1GiB"), String::new()),
        // In two pools, the bound on the response time is a larger sum.
        (huge.to_owned() + small, String::new()),
        // Memory is shown for a pool over all tasks.
        (unlimited("17179869183GiB"), other(&unlimited("1GiB"))),
        (unlimited("1GiB"), other(&unlimited("17179869183GiB"))),
        (unlimited("17179869183GiB"), other(small) + &event(&unlimited("1GiB")).replace("'t'", "'o'")),
    ] {
        let error = refused(&with_nodes(&nodes, &events));
        assert_eq!(error.refusal, Overflow, "{error}");
    }
}

#[test]
fn arrivals_and_defaults() {
    let workload = accepted(&with_nodes("{ name = 'a', wcet = '0ns' }", ""));
    let task = &workload.tasks[0];
    assert_eq!((task.offset_ns, task.value, task.floor), (0, 1, None));
    let [cpu, gpu] = &workload.pools[..] else { panic!("two pools were written") };
    assert_eq!((cpu.kind, cpu.memory_bytes, gpu.memory_bytes), (PoolKind::Cpu, Some(1 << 10), None));
    let text = with_nodes("{ name = 'a', wcet = '1ms' }", "");
    let once = accepted(&text.replace("period = \"10ms\"", "once = true\noffset = '3ms'"));
    assert_eq!((once.tasks[0].arrival, once.tasks[0].offset_ns), (Arrival::Once, 3 * MS));
    let sporadic = accepted(&text.replace("period", "min_interarrival"));
    assert_eq!(sporadic.tasks[0].arrival, Arrival::Sporadic { min_interarrival_ns: 10 * MS });
}
