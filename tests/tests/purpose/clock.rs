//! A host whose clock is never a round number, beside one that is on time to the nanosecond.

use super::sets::{Set, Task, Times, Wish};
use super::{LOADS, VALUES};
use red_core::Outcome;
use red_tests::drive::{Drive, Watch};
use red_workload::model::Workload;
use red_workload::policy::Policy;
use red_workload::{Format, parse};
use std::collections::{BTreeMap, BTreeSet};

const HORIZON_NS: u64 = 3_000_000_000;
/// How late a thread may be that sleeps until an instant.
const LATE_NS: (u64, u64) = (1, 60_000);
/// The same for the paper's rule, which carries a backlog on: one job that goes or stays by chance shows for seconds.
const RED_LATE_NS: (u64, u64) = (1, 10_000);

/// How jobs ended: by task and reason, or on time, or late.
#[derive(Debug, Default)]
struct Ends(BTreeMap<(usize, &'static str), u64>);

impl Watch for Ends {
    fn ended(&mut self, outcome: &Outcome) {
        let end = match outcome.shed {
            Some(reason) => reason.name(),
            None if outcome.at <= outcome.deadline => "on time",
            None => "late",
        };
        *self.0.entry((outcome.task.index(), end)).or_default() += 1;
    }
}

fn ends(set: &Set, policy: Policy, percent: u64, late_ns: (u64, u64), seed: u64) -> Ends {
    ends_of(&set.workload(), policy, percent, late_ns, seed)
}

fn ends_of(workload: &Workload, policy: Policy, percent: u64, late_ns: (u64, u64), seed: u64) -> Ends {
    let mut ends = Ends::default();
    Drive::new(workload, policy.config(), (percent, percent), seed)
        .late_by(late_ns)
        .run(HORIZON_NS, &mut ends);
    ends
}

/// A task without a floor whose nodes, with their WCET in milliseconds, follow each other.
fn task(name: &str, value: u32, period_deadline_ms: (u64, u64), nodes_ms: &[u64]) -> Task {
    let after = |nth: usize| nth.checked_sub(1).into_iter().collect();
    Task {
        name: name.to_owned(),
        value,
        floor: None,
        period_ns: period_deadline_ms.0 * 1_000_000,
        deadline_ns: period_deadline_ms.1 * 1_000_000,
        nodes: nodes_ms.iter().enumerate().map(|(nth, ms)| (ms * 1_000_000, after(nth))).collect(),
        jitter: false,
        seed: 1,
        until_ns: u64::MAX,
    }
}

/// One chain alone, whose nodes end at other instants than those of a tick.
fn chain(load_percent: u64) -> Set {
    let nodes = [0, 1, 2, 3, 4, 5, 6].map(|nth: usize| {
        let wcet = [950_000, 8_550_000, 11_400_000, 4_750_000, 3_800_000, 2_850_000, 5_700_000][nth];
        (wcet, nth.checked_sub(1).into_iter().collect())
    });
    let period_ns = 38_000_000 * 100 / load_percent;
    let task = Task {
        name: "chain".to_owned(),
        value: 1,
        floor: None,
        period_ns,
        deadline_ns: 66_000_000,
        nodes: nodes.to_vec(),
        jitter: false,
        seed: 1,
        until_ns: u64::MAX,
    };
    Set { lanes: 1, times: Times::Wcet, tasks: vec![task] }
}

/// Lateness costs a few jobs and moves others: no mechanism rests on an instant that a real clock never shows.
#[test]
fn a_clock_that_is_never_round_changes_little() {
    for policy in Policy::NAMED {
        let mut seen = BTreeSet::new();
        let sets = [1, 2, 4].into_iter().flat_map(|lanes| {
            let each = (0..).zip(LOADS).flat_map(|of| [(1, 1), (2, 5)].map(|tasks| (of, tasks)));
            each.map(move |((seed, load_percent), tasks)| {
                let times = Times::Wcet;
                let wish = Wish { tasks, lanes, load_percent, times, values: VALUES, floors: true };
                (lanes, seed, Set::draw(seed, wish))
            })
        });
        for (lanes, seed, set) in sets.chain(LOADS.iter().map(|load| (1, *load, chain(*load)))) {
            let late_ns = if policy == Policy::Red { RED_LATE_NS } else { LATE_NS };
            let [ideal, real] = [(0, 0), late_ns].map(|late| ends(&set, policy, 100, late, seed).0);
            let all: u64 = ideal.values().sum();
            // Who looks late finds lost for certain what was predicted, and both are given up for the same.
            let same = |end| if end == "hopeless" { "overload" } else { end };
            for key in ideal.keys().chain(real.keys()).map(|(task, end)| (*task, same(end))) {
                let of = |ends: &BTreeMap<(usize, &'static str), u64>| -> u64 {
                    let alike = ends.iter().filter(|((task, end), _)| (*task, same(end)) == key);
                    alike.map(|(_, count)| count).sum()
                };
                let [ideal, real] = [&ideal, &real].map(of);
                assert!(
                    10 * ideal.abs_diff(real) <= all,
                    "{}, {lanes} lanes, seed {seed}: of {all} jobs, task {} has {ideal} {} beside a clock that is \
                     never late, and {real} here",
                    policy.name(),
                    key.0,
                    key.1
                );
            }
            seen.extend(real.keys().map(|(_, end)| *end));
        }
        let must = match policy {
            Policy::Red => &["urgency"] as &[_],
            Policy::Redrt | Policy::RedrtLookahead => &["overload", "hopeless"],
            _ => &["late"],
        };
        assert!(must.iter().all(|end| seen.contains(end)), "{}: {seen:?}", policy.name());
    }
}

/// Releases that come at ticks are judged as of these, however much later somebody looks. On one lane, with periods, deadlines
/// and nodes in milliseconds.
#[test]
fn the_paper_s_rule_sheds_the_same_whenever_it_looks() {
    type Case = (u32, (u64, u64), &'static [u64]);
    let cases: [&[Case]; 3] = [
        &[(1000, (20, 20), &[2]), (1, (1, 200), &[2])],
        &[(1, (10, 30), &[3, 3]), (1, (5, 60), &[2]), (5, (20, 40), &[4])],
        &[(9, (15, 20), &[3]), (1, (5, 150), &[2, 2, 2])],
    ];
    for case in cases {
        let tasks = (0..)
            .zip(case)
            .map(|(nth, (value, times, nodes))| task(&format!("t{nth}"), *value, *times, nodes));
        let set = Set { lanes: 1, times: Times::Wcet, tasks: tasks.collect() };
        // No node ends at a tick.
        let [ideal, real] = [(0, 0), RED_LATE_NS].map(|late| ends(&set, Policy::Red, 97, late, 3).0);
        for nth in 0..case.len() {
            let shed = |ends: &BTreeMap<_, u64>| ends.get(&(nth, "urgency")).copied().unwrap_or(0);
            let (ideal, real) = (shed(&ideal), shed(&real));
            assert!(
                10 * ideal.abs_diff(real) <= ideal.max(20),
                "{case:?}: of task {nth} {ideal} given up beside a clock that is never late, and {real} here"
            );
        }
    }
}

/// Nor where who is less urgent at the tick is more urgent when somebody looks: sub-deadlines are those of the tick, too.
#[test]
fn the_paper_s_rule_sheds_who_was_least_urgent_at_the_tick() {
    let task = |name: &str, period: u32, deadline: &str, weights: &str, encoder: u32, decoders: &str| {
        format!(
            "[[task]]\nname = '{name}'\nperiod = '{period}ms'\ndeadline = '{deadline}'\n\
             [[task.node]]\nname = 'p'\n[task.node.mimonet]\nweights = '{weights}'\nframe = 'camera'\n\
             encoder = {{ wcet = '{encoder}ms' }}\ndecoders = [{decoders}]\n\
             [[task.node]]\nname = 'control'\nafter = ['p']\nwcet = '2ms'\n"
        )
    };
    let file = "[[pool]]\nname = 'cpu'\nlanes = 1\n[[sensor]]\nname = 'camera'\nperiod = '30ms'\n".to_owned()
        + &task("lane", 30, "45200us", "shared", 9, "{ name = 'x', wcet = '6ms' }")
        + &task("det", 30, "30ms", "shared", 9, "{ name = 'y', wcet = '8ms' }, { name = 'z', wcet = '7ms' }")
        + &task("seg", 60, "60ms", "own", 11, "{ name = 's', wcet = '9ms' }");
    let workload = parse(file.as_bytes(), Format::Toml, "tie.toml").expect("a workload");
    let [ideal, real] = [(0, 0), RED_LATE_NS].map(|late| ends_of(&workload, Policy::Red, 97, late, 3).0);
    for task in 0..3 {
        let shed = |ends: &BTreeMap<_, u64>| ends.get(&(task, "urgency")).copied().unwrap_or(0);
        let (ideal, real) = (shed(&ideal), shed(&real));
        assert!(
            10 * ideal.abs_diff(real) <= ideal.max(20),
            "of task {task} {ideal} given up beside a clock that is never late, and {real} here"
        );
    }
}

/// A job that is released while every lane is busy is lost before anybody can look at it. What comes next goes first all the same.
#[test]
fn a_job_that_nobody_saw_in_time_is_lost_once() {
    for policy in [Policy::Redrt, Policy::RedrtLookahead] {
        let sets = [([3, 9].as_slice(), 18, 31), (&[12], 18, 31), (&[12], 14, 20), (&[1, 1, 4], 9, 50)];
        for (nodes_ms, deadline_ms, long_ms) in sets {
            let steer = task("steer", 50, (25, deadline_ms), nodes_ms);
            let long = task("map", 2, (120, 240), &[long_ms]);
            let tasks = vec![steer, long, task("log", 1, (10, 30), &[3])];
            let set = Set { lanes: 1, times: Times::Wcet, tasks };
            let real = ends(&set, policy, 100, LATE_NS, 7).0;
            let on_time = real.get(&(0, "on time")).copied().unwrap_or(0);
            let all = HORIZON_NS / 25_000_000;
            assert!(
                100 * on_time >= 95 * all,
                "{}: {nodes_ms:?} in {deadline_ms} ms beside {long_ms} ms: {on_time} of {all} on time; {real:?}",
                policy.name()
            );
        }
    }
}

/// Every outcome, in its order.
#[derive(Debug, Default, PartialEq)]
struct All(Vec<Outcome>);

impl Watch for All {
    fn ended(&mut self, outcome: &Outcome) {
        self.0.push(*outcome);
    }
}

/// Warnings are told, and decide nothing: a log does not have them, and is replayed all the same.
#[test]
fn a_host_that_takes_no_warnings_has_the_same_jobs() {
    let owed = |floor, task: Task| Task { floor: Some(floor), ..task };
    for (tiny_ms, deep_ms) in [(2, 12), (3, 12), (2, 7), (1, 25)] {
        let tiny = owed((3, 4), task("tiny", 3, (4, 16), &[tiny_ms]));
        let high = owed((1, 2), task("m", 1000, (40, 60), &[14, 14]));
        let tasks = vec![tiny, high, task("deep", 1, (16, 1200), &[deep_ms])];
        let workload = Set { lanes: 1, times: Times::Wcet, tasks }.workload();
        for seed in 0..16 {
            let drive = || Drive::new(&workload, Policy::Redrt.config(), (97, 98), seed).late_by(LATE_NS);
            let [mut listens, mut deaf] = [All::default(), All::default()];
            drive().run(HORIZON_NS, &mut listens);
            drive().deaf().run(HORIZON_NS, &mut deaf);
            assert!(listens.0.len() > 500, "{}", listens.0.len());
            let first = listens.0.iter().zip(&deaf.0).position(|(one, other)| one != other);
            assert_eq!(first, None, "tiny {tiny_ms} ms, deep {deep_ms} ms, seed {seed}");
            assert_eq!(listens.0.len(), deaf.0.len());
        }
    }
}
