//! The RED scheduler on a microcontroller: lanes and dispatcher are tasks of embassy.
//!
//! ```text
//! type Robot = Caps<2, 8, 4>;
//! static RED: Dispatcher<Robot> = Dispatcher::new();                    // all zero: it lies in .bss
//!
//! #[embassy_executor::task]
//! async fn dispatcher() { RED.run(|job| log(job)).await }                // polls, sleeps until `poll_at`
//!
//! #[embassy_executor::task]
//! async fn lane() { RED.run_lane(LaneId::new(0), |unit| async move { step(unit).await }).await; }
//!
//! #[interrupt]
//! fn CAMERA_READY() { let _ = RED.release_from_interrupt(PERCEPTION); }  // one letter, one wake
//!
//! #[embassy_executor::main]
//! async fn main(spawner: Spawner) {
//!     RED.configure(Config::REDRT.with_lanes(1));
//!     RED.with(|scheduler| scheduler.add_task(&dag(), Timing::new(Duration::from_millis(20)))).unwrap();
//!     spawner.spawn(dispatcher().unwrap());
//!     spawner.spawn(lane().unwrap());
//! }
//! ```
//!
//! **Who runs first.** embassy polls the woken task with the least deadline (`scheduler-deadline`). The dispatcher
//! and lanes without a unit have deadline 0, so scheduling goes before all bodies. A lane that takes a unit sets its
//! deadline to the unit's sub-deadline, wakes itself and gives way: so it stands in embassy's queue by that deadline
//! before the body begins, and bodies that are ready at once run in the order of their sub-deadlines. Deadlines are in
//! ticks, as those that other tasks give themselves.
//!
//! **Why a task writes its own deadline only.** embassy keeps a deadline in two words of 32 bits and compares it while
//! it sorts woken tasks, without a critical section. A write from elsewhere could fall between the two reads, or change
//! a task that is sorted in already. The task itself runs only while it is in no queue.
//!
//! **Interrupts** post into a mailbox and wake the dispatcher; they never wait for the scheduler, except that each call
//! on it is a critical section, whose length the capacities bound.
//!
//! **Executors.** Dispatcher and lanes may be tasks of one executor or of several with different priorities.
#![no_std]
#![forbid(unsafe_code)]

mod clock;
mod dispatcher;
mod handler;
mod lane;

pub use clock::{TickExtension, from_ticks, now, ticks_until};
pub use dispatcher::{Dispatcher, PostError};
pub use lane::{Fault, LaneError};
