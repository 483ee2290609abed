//! A host whose clock is never a round number, beside one that is on time to the nanosecond.

use crate::sets::{Set, Task, Times, Wish};
use crate::{LOADS, VALUES};
use red_core::Outcome;
use red_tests::drive::{Drive, Watch};
use red_workload::policy::Policy;
use std::collections::{BTreeMap, BTreeSet};

const HORIZON_NS: u64 = 3_000_000_000;
/// How late a thread may be that sleeps until an instant.
const LATE_NS: (u64, u64) = (1, 60_000);

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

fn ends(set: &Set, policy: Policy, late_ns: (u64, u64), seed: u64) -> Ends {
    let mut ends = Ends::default();
    let workload = set.workload();
    Drive::new(&workload, policy.config(), (100, 100), seed).late_by(late_ns).run(HORIZON_NS, &mut ends);
    ends
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
            let [ideal, real] = [(0, 0), LATE_NS].map(|late| ends(&set, policy, late, seed).0);
            let all: u64 = ideal.values().sum();
            for key in ideal.keys().chain(real.keys()) {
                let [ideal, real] = [&ideal, &real].map(|ends| ends.get(key).copied().unwrap_or(0));
                assert!(
                    10 * ideal.abs_diff(real) <= all,
                    "{}, {lanes} lanes, seed {seed}: of {all} jobs, task {} has {ideal} {} beside a clock that is \
                     never late, and {real} here",
                    policy.name(),
                    key.0,
                    key.1
                );
                seen.insert(key.1);
            }
        }
        let must = match policy {
            Policy::Red => &["urgency"] as &[_],
            Policy::Redrt | Policy::RedrtLookahead => &["overload", "hopeless"],
            _ => &["late"],
        };
        assert!(must.iter().all(|end| seen.contains(end)), "{}: {seen:?}", policy.name());
    }
}
