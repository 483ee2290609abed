//! The checks for a machine with a CUDA device, as far as they run `redrt`, on a stand-in for its driver.

use red_cuda_stand_in::with;
use red_gpu_tests::{Bench, CHECKS, Failure, Figures};
use red_rt::cuda;

fn check(name: &str) -> Result<Figures, Failure> {
    let check = CHECKS.iter().find(|check| check.name == name).expect("there is one");
    let device = cuda::open(0).expect("the stand-in has one");
    (check.run)(&Bench { device, redrt: env!("CARGO_BIN_EXE_redrt").into() })
}

#[test]
fn the_scene_runs_under_both_policies() {
    with("computes 1", || {
        let figures = check("scene").expect("it runs");
        assert!(figures[0].starts_with("edf") && figures[1].starts_with("redrt"), "{figures:?}");
        assert!(figures.iter().all(|line| line.contains("of 182 jobs on time")), "{figures:?}");
    });
}

#[test]
fn a_scene_whose_device_is_lost_does_not_hold() {
    with("computes 1\nfault red_spin 40 719", || {
        let why = check("scene").expect_err("it cannot").to_string();
        assert!(why.contains("exit status Some(3)"), "{why}");
    });
}

#[test]
fn an_illegal_access_ends_a_run_as_documented() {
    with("fault strike 10 700", || {
        let figures = check("illegal").expect("it does");
        assert!(figures[1].contains("of 30 on the CPU"), "{figures:?}");
    });
}

#[test]
fn an_access_that_does_no_harm_is_seen() {
    with("", || {
        let why = check("illegal").expect_err("nothing was wrong").to_string();
        assert!(why.contains("exit status Some(0)"), "{why}");
    });
}
