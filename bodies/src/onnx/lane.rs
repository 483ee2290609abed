//! Threads on which the engine computes in place.
//!
//! *Background.* rten always computes inside a thread pool, and a run from a foreign thread is handed over to a
//! worker of that pool: another priority, another CPU, and two context switches.
//!
//! *Rule.* A lane's thread is itself the only worker of a pool. Inside, rten finds that it is already where it wants
//! to be, and every parallel loop of its operators has one thread to run on: this one.

use std::cell::RefCell;
use std::sync::Arc;
use std::thread;

use rten::ThreadPool;

use crate::BodyError;

thread_local! {
    static POOL: RefCell<Option<Arc<ThreadPool>>> = const { RefCell::new(None) };
}

/// Runs `main` on a new thread where networks run in place, and returns its result.
///
/// `main` is the whole life of a lane: what it sets for itself (name, CPU, priority) holds for the inference. The
/// calling thread only waits. Panics of `main` come out here.
///
/// # Errors
/// The system starts no more threads; `main` did not run.
///
/// # Example
/// ```
/// let sum = red_bodies::onnx::on_lane(|| 1 + 2)?;
/// assert_eq!(sum, 3);
/// # Ok::<(), red_bodies::BodyError>(())
/// ```
pub fn on_lane<R: Send>(main: impl FnOnce() -> R + Send) -> Result<R, BodyError> {
    let pool = Arc::new(ThreadPool::with_num_threads(1));
    let caller = thread::current().id();
    let handle = Arc::clone(&pool);
    pool.run(move || {
        // A pool whose thread did not start calls back on the spot.
        if thread::current().id() == caller {
            return Err(BodyError::Thread);
        }
        POOL.set(Some(handle));
        let _leave = Leave;
        Ok(main())
    })
}

/// The pool whose worker the calling thread is.
pub(super) fn pool() -> Result<Arc<ThreadPool>, BodyError> {
    POOL.with_borrow(Clone::clone).ok_or(BodyError::NotOnLane)
}

/// Drops the thread's handle on its pool, also when `main` panics: a worker that held it would never end.
struct Leave;

impl Drop for Leave {
    fn drop(&mut self) {
        POOL.set(None);
    }
}
