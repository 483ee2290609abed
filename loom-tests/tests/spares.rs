//! *Claim.* A body that is found beyond its bound is failed once or completed once, never both; its lane is then
//! restored once, for a spare; the thread that came back leaves, also where the spare runs its own body by then, and
//! only the spare takes what is handed next. A thread that ended late was not killed, and its lane is lost once; so is
//! that of a spare that was killed before it began.
//!
//! *Threads.* The lane whose body is late, and the watchdog that becomes control thread and spare; then a control
//! thread of its own that becomes the spare, and then another lane that has a turn; then a control thread that finds
//! the late thread ended.
//! *Bound.* None for two; two preemptions for three threads, three with `--deep`.
//! *Sources.* `rt-linux/src/spares.rs`, `rt-linux/src/seat.rs`, `rt-linux/src/slot.rs`
#![cfg(loom)]

use loom::sync::Mutex;
use loom::thread;
use red_core::UnitId;
use red_loom_tests::handler::Work;
use red_loom_tests::model::explore;
use red_loom_tests::seat::Seat;
use red_loom_tests::slot::{Armed, Bound, Slot};
use red_loom_tests::spares::Spares;
use std::sync::Arc;

const SPARE: u64 = 5;
const DEADLINE: u64 = 7;

#[derive(Default)]
struct Host {
    seat: Seat,
    slot: Slot,
    spares: Spares,
    locked: Mutex<Locked>,
}

/// How a late thread leaves.
#[derive(Clone, Copy, PartialEq)]
enum Leaves {
    /// By what its own deadline has become.
    AsBuilt,
    /// Planted: by whom the lane belongs to when it comes back, and then by whatever the slot shows.
    BySeat,
    /// Planted: not at all.
    Never,
}

/// What the scheduler knows of the lane, under its lock.
#[derive(Default)]
struct Locked {
    completed: u32,
    failed: u32,
    restored: u32,
    is_retired: bool,
}

fn unit(number: u64) -> UnitId {
    UnitId::from_bits(number << 16)
}

fn work(number: u64) -> Work {
    Work { unit: unit(number), ..Work::default() }
}

impl Host {
    /// Part of every turn: what ran beyond its bound is failed, and its lane retired.
    fn fail_overdue(&self, locked: &mut Locked) {
        if self.spares.finds_overdue(&self.seat) {
            assert_eq!(self.seat.running(), unit(1), "another unit than the one that ran");
            locked.failed += u32::from(locked.completed == 0);
            locked.is_retired = true;
        }
    }

    /// The lane's thread, from the start of the body on. Whether it goes on.
    fn body_returns(&self, armed: Armed, leaves: Leaves) -> bool {
        let goes_on = match leaves {
            Leaves::AsBuilt => self.slot.disarm(armed) == Bound::Kept,
            Leaves::BySeat => self.seat.is_of(0) && self.slot.reset() == Bound::Kept,
            Leaves::Never => self.slot.disarm(armed) == Bound::Kept || self.seat.is_of(0),
        };
        if goes_on {
            let mut locked = self.locked.lock().unwrap();
            self.fail_overdue(&mut locked);
            locked.completed += u32::from(locked.failed == 0);
        }
        goes_on
    }

    /// Whether the watchdog finds the body beyond its bound.
    fn watch(&self) -> bool {
        let Some(deadline) = self.slot.deadline() else { return false };
        let claimed = self.slot.claim(deadline);
        if claimed {
            self.slot.expire(|_| ());
            self.spares.lose(0, &self.seat);
        }
        claimed
    }

    /// The control thread finds the lane lost, gives it to the spare and lets that begin a body.
    fn replace(&self) {
        if self.spares.take_lost() == 0 {
            return;
        }
        assert_eq!(self.spares.take_lost(), 0, "lost once");
        self.assign(true);
        self.begin();
    }

    /// What the control thread does for a spare that is set up. `resets` is false for a control thread that leaves that
    /// to the spare.
    fn assign(&self, resets: bool) {
        self.spares.assign(0, &self.seat, SPARE);
        if resets {
            let _of_the_late_body = self.slot.reset();
        }
    }

    /// The spare's first turn, and its first body.
    fn begin(&self) {
        let mut locked = self.locked.lock().unwrap();
        self.fail_overdue(&mut locked);
        if self.spares.takes_over(0, &self.seat, SPARE) {
            assert!(locked.is_retired, "restored before it was retired");
            locked.is_retired = false;
            locked.restored += 1;
            self.seat.hand(&work(2));
            drop(locked);
            let _for_ever = self.slot.arm(DEADLINE + 1);
        }
    }
}

/// A body runs, and its lane has been handed nothing else.
fn running() -> (Arc<Host>, Armed) {
    let host = Arc::new(Host::default());
    host.seat.hand(&work(1));
    assert!(host.seat.take().is_some());
    let armed = host.slot.arm(DEADLINE);
    (host, armed)
}

fn is_replaced_once(threads: usize, leaves: Leaves) {
    let (host, armed) = running();
    let watchdog = {
        let host = host.clone();
        thread::spawn(move || {
            let is_lost = host.watch();
            if is_lost {
                host.replace();
            }
            is_lost
        })
    };
    let other = (threads > 2).then(|| {
        let host = host.clone();
        thread::spawn(move || {
            let mut locked = host.locked.lock().unwrap();
            host.fail_overdue(&mut locked);
        })
    });
    let goes_on = host.body_returns(armed, leaves);
    let late = if goes_on { host.seat.take() } else { None };
    let is_lost = watchdog.join().unwrap();
    other.into_iter().for_each(|other| other.join().unwrap());
    let locked = host.locked.lock().unwrap();
    assert!(late.is_none(), "the thread that was replaced took what was handed to its spare");
    assert_eq!((goes_on, locked.completed), (!is_lost, u32::from(!is_lost)));
    assert_eq!((locked.failed, locked.restored), (u32::from(is_lost), u32::from(is_lost)));
    assert_eq!(host.seat.take().is_some(), is_lost, "the spare takes the next unit");
}

#[test]
fn a_late_body_is_failed_once_and_its_lane_restored_once() {
    explore(2, || is_replaced_once(2, Leaves::AsBuilt));
}

#[test]
fn the_spare_retires_the_lane_before_it_takes_over() {
    explore(3, || {
        let (host, armed) = running();
        let control = {
            let host = host.clone();
            thread::spawn(move || host.replace())
        };
        let late = {
            let host = host.clone();
            thread::spawn(move || host.body_returns(armed, Leaves::AsBuilt))
        };
        let is_lost = host.watch();
        control.join().unwrap();
        assert_eq!(late.join().unwrap(), !is_lost);
        host.replace();
        let locked = host.locked.lock().unwrap();
        assert_eq!((locked.failed, locked.restored), (u32::from(is_lost), u32::from(is_lost)));
    });
}

#[test]
fn another_lane_may_fail_the_late_body() {
    explore(3, || is_replaced_once(3, Leaves::AsBuilt));
}

#[test]
#[should_panic(expected = "the thread that was replaced took what was handed to its spare")]
fn a_late_thread_that_goes_on_is_caught() {
    explore(2, || is_replaced_once(2, Leaves::Never));
}

#[test]
#[should_panic(expected = "the thread that was replaced took what was handed to its spare")]
fn a_late_thread_that_asks_the_seat_and_then_the_slot_is_caught() {
    explore(2, || is_replaced_once(2, Leaves::BySeat));
}

/// The thread ends, killed or not, and the control thread finds it ended. With whether it keeps what became of a body
/// that came back late.
fn is_buried(is_killed: bool, keeps: bool) {
    let (host, armed) = running();
    let watchdog = {
        let host = host.clone();
        thread::spawn(move || host.watch())
    };
    let is_gone = is_killed || host.slot.disarm(armed) == Bound::Passed;
    if is_gone && !keeps {
        let _forgotten = host.slot.reset();
    }
    let has_died = is_gone && host.slot.reset() == Bound::Kept;
    if has_died {
        host.spares.lose(0, &host.seat);
    }
    let is_late = watchdog.join().unwrap();
    assert_eq!(has_died, is_killed && !is_late, "lost twice, or taken for killed");
    assert_eq!(host.spares.take_lost() != 0, is_gone);
}

#[test]
fn a_thread_that_was_killed_is_lost_once() {
    explore(2, || is_buried(true, true));
}

#[test]
fn a_thread_that_came_back_late_is_not_taken_for_killed() {
    explore(2, || is_buried(false, true));
}

/// The lane of a late body goes to a spare, which is killed before it begins anything, while that body comes back.
fn is_lost_again(resets: bool) {
    let (host, armed) = running();
    assert!(host.watch());
    let late = {
        let host = host.clone();
        thread::spawn(move || host.body_returns(armed, Leaves::AsBuilt))
    };
    assert_ne!(host.spares.take_lost(), 0);
    host.assign(resets);
    // The control thread finds the spare ended.
    let has_died = host.slot.reset() == Bound::Kept;
    assert!(has_died, "nobody says that the lane is lost");
    assert!(!late.join().unwrap());
}

#[test]
fn a_spare_that_is_killed_before_it_begins_is_told() {
    explore(2, || is_lost_again(true));
}

#[test]
#[should_panic(expected = "nobody says that the lane is lost")]
fn a_spare_that_frees_the_slot_itself_is_caught() {
    explore(2, || is_lost_again(false));
}

#[test]
#[should_panic(expected = "lost twice, or taken for killed")]
fn a_late_thread_that_frees_its_slot_is_caught() {
    explore(2, || is_buried(false, false));
}
