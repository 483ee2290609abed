use super::*;
use red_core::{Empty, Scheduler};
use red_workload::build;

#[test]
fn every_workload_can_be_admitted_and_all_its_edits_apply_in_their_order() {
    let mut edits = 0;
    for seed in 0..200 {
        let drawn = Drawn::of(seed, 1_500_000_000, 4, true);
        let mut scheduler: Box<Scheduler<crate::judge::Robot>> = Box::new(Scheduler::EMPTY);
        let (plan, tasks) =
            build::admit(&mut scheduler, &drawn.workload, drawn.policy.config()).expect("valid");
        for change in &plan.changes {
            let applied = build::apply(&mut scheduler, change, tasks[change.task], change.at);
            assert_eq!(applied, Ok(()), "seed {seed}");
            edits += 1;
        }
    }
    assert!(edits > 1_000, "{edits}");
}

#[test]
fn equal_seeds_give_equal_workloads_and_eight_in_a_row_have_every_kind() {
    let texts = |seeds: std::ops::Range<u64>| seeds.map(|seed| Drawn::of(seed, 1_000_000, 1, true).text);
    assert!(texts(0..20).eq(texts(0..20)));
    let realtime = |cpus| (0..8).filter(move |seed| Drawn::of(*seed, 1_000_000, cpus, true).realtime).count();
    assert_eq!((realtime(1), realtime(0)), (3, 0));
    assert!((0..20).all(|seed| Drawn::of(seed, 1_000_000, 1, false).workload.events.is_empty()));
}
