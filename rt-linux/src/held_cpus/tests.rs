use super::{Choosing, HeldCpus, choose_free};
use crate::setup::SetupError;
use std::sync::Barrier;
use std::thread;

// CPUs that no machine has, so that tests of other files do not meet these.

#[test]
fn a_cpu_has_lanes_of_one_run_until_that_ends() {
    let first = HeldCpus::hold(&[2_001, 2_002]).expect("nobody has them");
    assert_eq!(choose_free(2, &[2_000, 2_001, 2_002, 2_003]), Ok(vec![2_000, 2_003]));
    let too_few = choose_free(3, &[2_000, 2_001, 2_002, 2_003]);
    assert_eq!(too_few, Err(SetupError::CpusHeld { cpus: vec![2_001, 2_002] }));
    let all = choose_free(5, &[2_000, 2_001, 2_002, 2_003]);
    assert!(matches!(all, Err(SetupError::MoreLanesThanCpus { lanes: 5, usable }) if usable.len() == 4));
    let refused = HeldCpus::hold(&[2_002, 2_003]).expect_err("one is taken");
    assert_eq!(refused, SetupError::CpusHeld { cpus: vec![2_002] });
    assert!(refused.to_string().contains("[2002]"), "{refused}");
    // A refusal takes nothing.
    let third = HeldCpus::hold(&[2_003]).expect("nobody has it");
    drop(first);
    assert_eq!(choose_free(2, &[2_001, 2_002, 2_003]), Ok(vec![2_001, 2_002]));
    drop(third);
    drop(HeldCpus::hold(&[2_001, 2_002, 2_003]).expect("nobody has them any more"));
}

#[test]
fn of_two_that_choose_at_once_each_has_what_the_other_one_left() {
    let all_have = Barrier::new(2);
    let choose = || {
        // Looked at in the end: who ends before would leave the other one waiting.
        let mut refused = 0;
        for _ in 0..20 {
            let choosing = Choosing::begin();
            let cpus = choose_free(1, &[3_001, 3_002]);
            thread::yield_now();
            let held = cpus.and_then(|cpus| HeldCpus::hold(&cpus));
            drop(choosing);
            all_have.wait();
            refused += u32::from(held.is_err());
            drop(held);
            all_have.wait();
        }
        refused
    };
    let both = thread::scope(|threads| {
        let other = threads.spawn(choose);
        [choose(), other.join().expect("no panic")]
    });
    assert_eq!(both, [0, 0], "there are two");
}
