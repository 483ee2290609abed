use std::sync::{Arc, mpsc};
use std::time::Duration;

use super::{Bound, Expiry, Slot, Watchdog, demote};
use crate::clock::now_ns;
use crate::slot::LATEST;

/// Long enough that reaching it means that the watchdog does not work.
const FAR: Duration = Duration::from_secs(20);

fn slots(count: usize) -> Arc<[Slot]> {
    (0..count).map(|_| Slot::new()).collect()
}

#[test]
fn a_body_that_returns_in_time_is_left_alone() {
    let slots = slots(2);
    let (sender, expired) = mpsc::channel();
    let watchdog = Watchdog::start(slots.clone(), None, move |index, _| {
        let _ = sender.send(index);
    })
    .expect("an ordinary thread");
    slots[1].adopt();
    for _ in 0..100 {
        let armed = slots[1].arm(now_ns() + 60_000_000_000);
        assert_eq!(slots[1].disarm(armed), Bound::Kept);
    }
    drop(watchdog);
    assert_eq!(expired.try_iter().count(), 0);
}

#[test]
fn a_body_past_its_bound_is_reported_once_and_learns_of_it() {
    let slots = slots(3);
    let (sender, expired) = mpsc::channel();
    let _watchdog = Watchdog::start(slots.clone(), None, move |index, expiry| {
        let _ = sender.send((index, expiry));
    })
    .expect("an ordinary thread");
    let lane = std::thread::spawn(move || {
        slots[2].adopt();
        let armed = slots[2].arm(now_ns());
        let report = expired.recv_timeout(FAR);
        let bound = slots[2].disarm(armed);
        let next = slots[2].arm(now_ns() + 60_000_000_000);
        (report, bound, slots[2].disarm(next), expired.try_iter().count())
    });
    let (report, bound, again, further) = lane.join().expect("the lane ends");
    assert_eq!(report, Ok((2, Expiry::Reported)));
    assert_eq!((bound, again, further), (Bound::Passed, Bound::Kept, 0));
}

#[test]
fn disarming_waits_for_a_demotion_under_way() {
    // On a thread of its own, because it stays demoted.
    let lane = std::thread::spawn(|| {
        let slot = Slot::new();
        slot.adopt();
        let armed = slot.arm(5);
        assert!(slot.claim(5));
        std::thread::scope(|scope| {
            let watchdog = scope.spawn(|| slot.expire(|thread| demote(thread, true)));
            assert_eq!(slot.disarm(armed), Bound::Passed);
            watchdog.join().expect("one call")
        })
    });
    assert_eq!(lane.join().expect("no panic"), Expiry::Demoted);
}

#[test]
fn a_demotion_that_the_kernel_refuses_is_told() {
    let slot = Slot::new();
    // No thread adopted it, and no thread has this number.
    slot.adopt_thread(i32::MAX);
    let armed = slot.arm(5);
    assert!(slot.claim(5));
    let expiry = slot.expire(|thread| demote(thread, true));
    assert_eq!(expiry, Expiry::Refused(nix::errno::Errno::ESRCH));
    assert_eq!(slot.disarm(armed), Bound::Passed);
}

#[test]
fn a_claim_fails_once_the_body_has_returned() {
    let slot = Slot::new();
    let armed = slot.arm(5);
    assert_eq!(slot.disarm(armed), Bound::Kept);
    assert!(!slot.claim(5));
}

#[test]
fn a_late_body_takes_no_deadline_of_the_next_thread_away() {
    let slot = Slot::new();
    let late = slot.arm(5);
    assert!(slot.claim(5));
    slot.expire(|_| ());
    assert_eq!(slot.reset(), Bound::Passed);
    let next = slot.arm(9);
    assert_eq!(slot.disarm(late), Bound::Passed);
    assert_eq!(slot.deadline(), Some(9));
    assert_eq!(slot.disarm(next), Bound::Kept);
}

#[test]
fn no_deadline_is_taken_for_a_state() {
    let slot = Slot::new();
    for (deadline, seen) in [(0, 1), (7, 7), (u64::MAX, LATEST), (u64::MAX - 1, LATEST)] {
        let armed = slot.arm(deadline);
        assert_eq!(slot.deadline(), Some(seen));
        assert_eq!(slot.disarm(armed), Bound::Kept);
        assert_eq!(slot.deadline(), None);
    }
}
