//! What a job of a higher value needs later, lanes and memory, is not taken from it by a lower one.

use red_sim::simulate;
use red_tests::differential::options;
use red_tests::oracle;
use red_workload::{Format, parse};

const SECOND_NS: u64 = 1_000_000_000;

/// Name, what comes after it, WCET in microseconds, memory in MiB.
type Node<'a> = (&'a str, &'a [&'a str], u64, u64);

fn task(name: &str, value: u32, (period, deadline): (u64, u64), nodes: &[Node]) -> String {
    let floor = if value > 1 { "floor = [1, 1]" } else { "" };
    let mut text = format!(
        "[[task]]\nname = '{name}'\nvalue = {value}\n{floor}\nperiod = '{period}ms'\ndeadline = '{deadline}ms'\n"
    );
    for (node, after, us, mib) in nodes {
        text += &format!(
            "[[task.node]]\nname = '{node}'\nafter = {after:?}\nwcet = '{us}us'\nmemory = '{mib}MiB'\n"
        );
    }
    text
}

/// Of the task `high` of a file: jobs on time in 20 s, and jobs that were due.
fn high_of(lanes: u8, memory: &str, tasks: &str) -> (u64, u64) {
    let file = format!("[[pool]]\nname = 'gpu'\nlanes = {lanes}\n{memory}\n{tasks}");
    let workload =
        parse(file.as_bytes(), Format::Toml, "needs.toml").unwrap_or_else(|e| panic!("{e}\n{file}"));
    let report = simulate(&workload, &options(oracle::Policy::Redrt, 20 * SECOND_NS)).expect("it fits");
    let high = report.tasks.iter().find(|task| task.name == "high").expect("there is one");
    (high.on_time, high.on_time + high.missed)
}

fn loses_nothing(lanes: u8, memory: &str, high: &str, low: &[String]) {
    for tasks in [format!("{high}{}", low.concat()), format!("{}{high}", low.concat())] {
        let (on_time, due) = high_of(lanes, memory, &tasks);
        assert!(on_time == due && due > 0, "{on_time} of {due}: {lanes} lanes, {memory}\n{tasks}");
    }
}

/// A branch begins when the node before it ends, on a lane that a lower one would still have.
#[test]
fn a_branch_of_a_higher_value_finds_its_lane_free() {
    let low = [
        task("short", 1, (2, 4), &[("a", &[], 1_500, 0), ("b", &["a"], 1_000, 0)]),
        task("long", 1, (60, 240), &[("a", &[], 18_000, 0), ("b", &["a"], 12_000, 0)]),
    ];
    let fork: &[Node] = &[("n", &[], 2_000, 0), ("b", &["n"], 6_000, 0), ("c", &["n"], 9_000, 0)];
    loses_nothing(2, "", &task("high", 1_000, (20, 16), fork), &low);
    let wide: &[Node] =
        &[("n", &[], 2_000, 0), ("b", &["n"], 6_000, 0), ("c", &["n"], 9_000, 0), ("d", &["n"], 8_000, 0)];
    loses_nothing(3, "", &task("high", 1_000, (20, 12), wide), &low);
    let again: &[Node] = &[
        ("n", &[], 2_000, 0),
        ("b", &["n"], 5_000, 0),
        ("c", &["n"], 4_000, 0),
        ("m", &["b", "c"], 1_000, 0),
        ("d", &["m"], 4_000, 0),
        ("e", &["m"], 5_000, 0),
    ];
    loses_nothing(2, "", &task("high", 1_000, (20, 14), again), &low);
}

/// A pool with a memory budget that all nodes fit into keeps the word of one without.
#[test]
fn a_memory_budget_costs_a_higher_value_nothing() {
    let low = [task("low", 1, (20, 40), &[("c", &[], 10_000, 1)])];
    let chain: &[Node] = &[("a", &[], 8_000, 1), ("b", &["a"], 6_000, 1)];
    loses_nothing(1, "memory = '64MiB'", &task("high", 1_000, (20, 20), chain), &low);
    let sides: &[Node] = &[("a", &[], 9_000, 1), ("b", &[], 9_000, 1)];
    loses_nothing(2, "memory = '64MiB'", &task("high", 1_000, (20, 15), sides), &low);
}

/// Memory is held like a lane: what has it when the higher value comes makes it late.
#[test]
fn memory_of_a_higher_value_is_not_taken_by_a_lower_one() {
    let high = |mib| task("high", 1_000, (20, 15), &[("a", &[], 6_000, mib), ("b", &["a"], 6_000, mib)]);
    for mib in [30, 40, 60] {
        let low = [
            task("one", 1, (20, 40), &[("c", &[], 10_000, 40)]),
            task("other", 1, (15, 60), &[("c", &[], 14_000, 20)]),
        ];
        loses_nothing(2, "memory = '64MiB'", &high(mib), &low);
        loses_nothing(3, "memory = '64MiB'", &high(mib), &low);
    }
}

/// The result of an encoder stays in memory when the encoder has ended, of the higher one or of a lower one.
#[test]
fn results_of_encoders_count_as_memory() {
    let stage = |encoder: &str, decoders: &str| {
        format!(
            "node = [{{ name = 's', mimonet = {{ weights = 'w', frame = 'f', encoder = {encoder}, decoders = [{decoders}] }} }}]\n"
        )
    };
    let own = stage("{ wcet = '4ms', memory = '8MiB' }", "{ name = 'd', wcet = '4ms', memory = '16MiB' }");
    let high = format!(
        "[[task]]\nname = 'high'\nvalue = 1000\nfloor = [1, 1]\nperiod = '32ms'\ndeadline = '16ms'\n{own}"
    );
    for us in [16_000, 24_000, 32_000, 48_000] {
        let low = task("low", 1, (100, 300), &[("c", &[], us, 48)]);
        loses_nothing(2, "memory = '64MiB'", &high, &[low]);
    }
    let high = task("high", 1_000, (16, 16), &[("n", &[], 3_000, 40)]);
    let other = stage(
        "{ wcet = '19ms', memory = '16MiB' }",
        "{ name = 'd', wcet = '24ms' }, { name = 'e', wcet = '30ms' }",
    );
    let low = format!("[[task]]\nname = 'low'\nperiod = '40ms'\ndeadline = '102ms'\n{other}");
    loses_nothing(2, "memory = '64MiB'", &high, &[low]);
}

/// A node of a lower rank holds its lane while several jobs of a short period come, which then need the other lane.
#[test]
fn all_jobs_that_come_while_a_node_runs_are_waited_for() {
    let short = "[[task]]\nname = 'short'\nvalue = 100\nfloor = [1, 1]\nperiod = '5ms'\ndeadline = '5ms'\n\
                 node = [{ name = 'a', wcet = '1ms' }, { name = 'b', wcet = '1ms' }]\n";
    let chain: &[Node] =
        &[("a", &[], 8_000, 0), ("b", &["a"], 10_000, 0), ("c", &["b"], 3_000, 0), ("d", &["c"], 9_000, 0)];
    let other = "[[task]]\nname = 'other'\nvalue = 1000\nperiod = '50ms'\ndeadline = '100ms'\n\
                 node = [{ name = 'n', wcet = '26ms' }]\n";
    loses_nothing(2, "", &task("high", 10, (50, 50), chain), &[short.to_owned(), other.to_owned()]);
}

/// What follows on another pool may have to share a lane there, which the first one's wait has to leave time for.
#[test]
fn the_lanes_of_another_pool_count() {
    let high = |deadline: u64, work: [u64; 3]| {
        let [a, b, c] = work.map(|us| format!("wcet = '{us}us'"));
        format!(
            "[[task]]\nname = 'high'\nvalue = 1000\nfloor = [1, 1]\nperiod = '20ms'\ndeadline = '{deadline}ms'\n\
             node = [{{ name = 'a', {a} }}, {{ name = 'b', {b}, after = ['a'], pool = 'cpu' }}, \
             {{ name = 'c', {c}, after = ['a'], pool = 'cpu' }}]\n[[pool]]\nname = 'cpu'\nlanes = 1\n"
        )
    };
    for ms in 33..42 {
        let low = task("low", 1, (100, 210), &[("n", &[], 1_000 * ms, 0)]);
        loses_nothing(1, "", &high(20, [1_000; 3]), &[low]);
    }
    let low = task("low", 1, (30, 30), &[("a", &[], 16_000, 0), ("b", &[], 11_000, 0)]);
    loses_nothing(2, "", &high(20, [4_000, 6_000, 7_000]), &[low]);
}

/// Files that nobody chose: one of a high value that is on time alone, beside one or two of value 1.
#[test]
fn nothing_is_lost_to_a_lower_value_in_sets_that_nobody_chose() {
    let mut state = 0x5eed_u64;
    let mut draw = |least: u64, most: u64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        least + (state >> 33) % (most - least + 1)
    };
    let (mut tried, mut broken) = (0, Vec::new());
    while tried < 120 {
        let (lanes, budget) = (draw(1, 4) as u8, draw(0, 1) == 1);
        let memory = if budget { "memory = '64MiB'" } else { "" };
        let mut graph = |name: &str, value, period, deadline, most: u64| {
            let shape = [&[][..], &["n0"], &["n0"], &["n1", "n2"]];
            let len = draw(1, 4) as usize;
            let names = ["n0", "n1", "n2", "n3"];
            let nodes: Vec<Node> = (0..len)
                .map(|nth| {
                    let after = if draw(0, 2) > 0 && nth < shape.len() { shape[nth] } else { &[] };
                    (names[nth], after, 1_000 * draw(1, most), if budget { draw(1, 40) } else { 0 })
                })
                .collect();
            task(name, value, (period, deadline), &nodes)
        };
        let high = graph("high", 1_000, 20, 18, 8);
        let low = [graph("one", 1, 13, 40, 12), graph("other", 1, 31, 120, 20)].concat();
        let (alone, due) = high_of(lanes, memory, &high);
        if alone < due {
            continue;
        }
        tried += 1;
        let (on_time, due) = high_of(lanes, memory, &format!("{low}{high}"));
        if 100 * on_time < 99 * due {
            broken.push(format!("{on_time} of {due}: {lanes} lanes, {memory}\n{low}{high}"));
        }
    }
    assert!(broken.is_empty(), "{} of {tried}:\n{}", broken.len(), broken.join("\n"));
}
