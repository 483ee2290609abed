use super::{HeldCpus, choose_free};
use crate::setup::SetupError;

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
