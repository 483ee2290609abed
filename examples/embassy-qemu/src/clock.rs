//! embassy's clock: microseconds of a 32-bit counter that wraps every 171 s.

use core::cell::RefCell;
use core::task::Waker;

use critical_section::{CriticalSection, Mutex};
use embassy_time_driver::{Driver, TICK_HZ};
use embassy_time_queue_utils::Queue;
use red_embassy::TickExtension;

use crate::board;

/// Counts of the board in one tick of embassy.
const COUNTS: u64 = board::HZ as u64 / TICK_HZ;

struct Clock {
    counts: TickExtension,
    queue: Mutex<RefCell<Queue>>,
}

embassy_time_driver::time_driver_impl!(static CLOCK: Clock = Clock {
    counts: TickExtension::new(),
    queue: Mutex::new(RefCell::new(Queue::new())),
});

impl Driver for Clock {
    fn now(&self) -> u64 {
        self.counts.extend(board::counter) / COUNTS
    }

    fn schedule_wake(&self, at: u64, waker: &Waker) {
        critical_section::with(|cs| {
            if self.queue.borrow_ref_mut(cs).schedule_wake(at, waker) {
                self.wake_due(cs);
            }
        });
    }
}

impl Clock {
    /// Wakes who is due, and sets the alarm for the next.
    fn wake_due(&self, cs: CriticalSection<'_>) {
        let now = self.now();
        let next = self.queue.borrow_ref_mut(cs).next_expiration(now);
        if next < u64::MAX {
            // One that is too far away is set again when the alarm has come.
            let counts = (next - now).saturating_mul(COUNTS).min(u32::MAX.into());
            board::set_alarm(counts as u32);
        }
    }
}

/// The alarm has come.
pub(crate) fn alarm() {
    critical_section::with(|cs| CLOCK.wake_due(cs));
}

/// The counter has wrapped: who asks now counts it.
pub(crate) fn count_wrap() {
    let _now = CLOCK.now();
}

/// Ends after that many microseconds, and lets others run meanwhile.
pub(crate) async fn wait(micros: u64) {
    let end = CLOCK.now() + micros;
    core::future::poll_fn(|context| {
        if CLOCK.now() >= end {
            return core::task::Poll::Ready(());
        }
        CLOCK.schedule_wake(end, context.waker());
        core::task::Poll::Pending
    })
    .await;
}

/// Computes for that many microseconds.
pub(crate) fn compute(micros: u64) {
    let end = CLOCK.now() + micros;
    while CLOCK.now() < end {}
}
