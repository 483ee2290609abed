//! A board for one thread: embassy's executor polled by hand, and a 32-bit counter that a test moves.

use std::cell::{Cell, RefCell};
use std::future::Future;
use std::ptr;
use std::rc::Rc;
use std::task::Waker;

use embassy_executor::raw::{Executor, TaskStorage};
use embassy_time_driver::Driver;
use embassy_time_queue_utils::Queue;
use red_core::{Capacity, Outcome};
use red_embassy::{Dispatcher, TickExtension};

/// Each test has its thread, and each thread its clock.
struct Clock {
    counter: Cell<u32>,
    ticks: TickExtension,
    queue: RefCell<Queue>,
}

thread_local! {
    static CLOCK: Clock = const {
        Clock { counter: Cell::new(0), ticks: TickExtension::new(), queue: RefCell::new(Queue::new()) }
    };
}

struct ByHand;

impl Driver for ByHand {
    fn now(&self) -> u64 {
        CLOCK.with(|clock| clock.ticks.extend(|| clock.counter.get()))
    }

    fn schedule_wake(&self, at: u64, waker: &Waker) {
        CLOCK.with(|clock| clock.queue.borrow_mut().schedule_wake(at, waker));
    }
}

embassy_time_driver::time_driver_impl!(static DRIVER: ByHand = ByHand);

/// The executor's request to be polled. It needs no answer: the test polls.
#[unsafe(export_name = "__pender")]
fn pender(_context: *mut ()) {}

pub(crate) struct Board {
    executor: &'static Executor,
}

impl Board {
    pub(crate) fn new() -> Self {
        Self { executor: Box::leak(Box::new(Executor::new(ptr::null_mut()))) }
    }

    /// Starts a task, which lives as long as the test program.
    pub(crate) fn spawn<F: Future + 'static>(&self, task: impl FnOnce() -> F) {
        let storage: &'static TaskStorage<F> = Box::leak(Box::new(TaskStorage::new()));
        self.executor.spawner().spawn(storage.spawn(task).expect("a storage of its own"));
    }

    /// Starts the dispatcher; what ended is in the list.
    pub(crate) fn dispatcher<C: Capacity, const D: usize>(
        &self,
        red: &'static Dispatcher<C, D>,
    ) -> Rc<RefCell<Vec<Outcome>>> {
        let ended = Rc::new(RefCell::new(Vec::new()));
        let list = Rc::clone(&ended);
        self.spawn(move || async move { red.run(|outcome| list.borrow_mut().push(*outcome)).await });
        ended
    }

    /// Runs every task that is awake.
    pub(crate) fn poll(&self) {
        // SAFETY: only tests poll, never from inside a task.
        unsafe { self.executor.poll() };
    }

    /// Lets time pass tick by tick, and polls whenever a timer is due.
    pub(crate) fn pass(&self, ticks: u32) {
        for _ in 0..ticks {
            CLOCK.with(|clock| clock.counter.set(clock.counter.get().wrapping_add(1)));
            let now = DRIVER.now();
            CLOCK.with(|clock| clock.queue.borrow_mut().next_expiration(now));
            self.poll();
        }
    }
}

/// Sets the counter, before anything reads it.
pub(crate) fn begin_at(counter: u32) {
    CLOCK.with(|clock| clock.counter.set(counter));
}

/// Ends after that many ticks.
pub(crate) async fn wait(ticks: u64) {
    let end = DRIVER.now() + ticks;
    std::future::poll_fn(|context| {
        if DRIVER.now() >= end {
            return std::task::Poll::Ready(());
        }
        DRIVER.schedule_wake(end, context.waker());
        std::task::Poll::Pending
    })
    .await;
}
