//! Early warning, with random sets: whoever does not end in time was told of before, once.

use super::sets::{Set, Times, Wish};
use super::{LOADS, VALUES};
use red_core::{Outcome, ShedReason, Warning};
use red_tests::drive::{Drive, Watch};
use red_workload::policy::Policy;
use std::collections::BTreeMap;

const HORIZON_NS: u64 = 2_000_000_000;

/// How often a job was told of, by task and index, and jobs that did not end in time.
#[derive(Debug, Default)]
struct Told {
    told: BTreeMap<(usize, u64), u64>,
    lost: Vec<(usize, u64, Option<ShedReason>)>,
}

impl Watch for Told {
    fn ended(&mut self, outcome: &Outcome) {
        if !outcome.on_time() && outcome.shed != Some(ShedReason::Full) {
            self.lost.push((outcome.task.index(), outcome.index, outcome.shed));
        }
    }

    fn warned(&mut self, warning: &Warning) {
        *self.told.entry((warning.task.index(), warning.index)).or_default() += 1;
    }
}

#[test]
fn who_does_not_end_in_time_was_told_of_once() {
    let (mut lost, mut told) = (0, 0);
    for policy in [Policy::Redrt, Policy::RedrtLookahead] {
        for (seed, load_percent) in (0..40).zip(LOADS.into_iter().cycle()) {
            for lanes in [1, 2, 4] {
                let wish = Wish {
                    tasks: (2, 5),
                    lanes,
                    load_percent,
                    times: Times::Wcet,
                    values: VALUES,
                    floors: true,
                };
                let set = Set::draw(seed, wish);
                let mut all = Told::default();
                Drive::new(&set.workload(), policy.config(), (100, 100), seed).run(HORIZON_NS, &mut all);
                let context = || format!("{} seed {seed}, {lanes} lanes", policy.name());
                for (job, times) in &all.told {
                    assert_eq!(*times, 1, "{}: {job:?} was told of {times} times", context());
                }
                for (task, index, shed) in &all.lost {
                    let was_told = all.told.contains_key(&(*task, *index));
                    assert!(was_told, "{}: task {task} job {index} {shed:?} was not told of", context());
                }
                lost += all.lost.len();
                told += all.told.len();
            }
        }
    }
    assert!(lost > 10_000 && told < 2 * lost, "{lost} lost, {told} told of");
}
