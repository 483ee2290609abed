use super::Lanes;
use core::sync::atomic::{AtomicU32, Ordering};
use red_core::TaskId;
use red_record::class::Large;
use red_rt::control::{AskError, Control, Errand, Refused};
use std::sync::Arc;
use std::thread;

/// Counts stops.
#[derive(Default)]
struct Counts(AtomicU32);

impl Control<Large> for Counts {
    fn release(&self, _task: TaskId, _capture: Option<u64>) -> Result<(), Refused> {
        Err(Refused::Over)
    }

    fn ask(&self, _errand: Errand<Large>) -> Result<Errand<Large>, AskError> {
        Err(AskError::Over)
    }

    fn stop(&self) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }

    fn now_ns(&self) -> u64 {
        0
    }

    fn origin_ns(&self) -> u64 {
        0
    }
}

fn stops(counts: &Counts) -> u32 {
    counts.0.load(Ordering::Relaxed)
}

#[test]
fn a_stop_waits_for_lanes_that_are_started() {
    let (lanes, counts) = (Lanes::new(), Arc::new(Counts::default()));
    assert!(!lanes.stop(), "nobody starts them");
    lanes.begin();
    assert!(lanes.get().is_none() && lanes.stop() && lanes.stop());
    lanes.come(counts.clone());
    assert_eq!(stops(&counts), 1);
    assert!(lanes.get().is_some() && lanes.stop());
    assert_eq!(stops(&counts), 2);
}

#[test]
fn lanes_that_come_are_not_stopped_by_what_came_before_they_were_started() {
    let (lanes, counts) = (Lanes::new(), Arc::new(Counts::default()));
    assert!(!lanes.stop());
    lanes.begin();
    lanes.come(counts.clone());
    assert_eq!(stops(&counts), 0);
}

#[test]
fn what_does_not_come_is_not_stopped() {
    let lanes = Lanes::<Large>::new();
    lanes.begin();
    assert!(lanes.stop());
    lanes.fail();
    assert!(!lanes.stop());
}

#[test]
fn no_stop_is_lost_between() {
    for _ in 0..if cfg!(miri) { 20 } else { 2_000 } {
        let (lanes, counts) = (Lanes::new(), Arc::new(Counts::default()));
        lanes.begin();
        thread::scope(|scope| {
            scope.spawn(|| lanes.come(counts.clone()));
            assert!(lanes.stop());
        });
        assert_eq!(stops(&counts), 1);
    }
}
