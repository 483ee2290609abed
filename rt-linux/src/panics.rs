//! Panics of node bodies, kept for the report instead of printed.
//!
//! Printing waits for whoever holds standard error, and with `RUST_BACKTRACE=1` it takes longer than the bounds of
//! most bodies: a body that panics would count as hung.
//!
//! # The hook is the process's
//!
//! There is one panic hook for all threads. The first run of the process that takes its signals as well
//! ([`StopBy::Signals`](crate::stop::StopBy)) wraps the hook that it finds, and the wrapper stays, so that runs may
//! overlap. It keeps panics inside node bodies and errands from being printed, unless they end the process, and passes
//! every other one on: those of threads that a body starts, and all of them while nothing runs. A program that wants a
//! hook of its own sets it before the first run; one that is set later replaces the wrapper, and then sees the panics of
//! bodies too. Runs that only their callers stop leave the hook alone: it sees their panics, whose words are kept as well,
//! without the place in the source.

use red_core::NodeId;
use std::any::Any;
use std::cell::{Cell, RefCell};
use std::panic::{self, AssertUnwindSafe, catch_unwind};
use std::sync::Once;

/// A body that panicked.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BodyPanic {
    /// The task, in the order of admission.
    pub task: usize,
    /// The node.
    pub node: NodeId,
    /// The how-manieth job of its task, from 0.
    pub job: u64,
    /// What the panic said, and where in the source.
    pub message: String,
}

static INSTALLED: Once = Once::new();

thread_local! {
    static IN_BODY: Cell<bool> = const { Cell::new(false) };
    static MESSAGE: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// Wraps the panic hook, once for the process.
pub(crate) fn keep_of_bodies() {
    INSTALLED.call_once(|| {
        let others = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            // Where panics abort, nothing is left to tell them later.
            if !IN_BODY.get() || cfg!(panic = "abort") {
                others(info);
            } else if let Some(first) = MESSAGE.take() {
                // Panics while the first one unwinds, or where it must not, end the process.
                eprintln!("{first}");
                others(info);
            } else {
                let said = info.payload_as_str().unwrap_or("no message");
                let message = match info.location() {
                    Some(place) => format!("{said} (at {place})"),
                    None => said.to_owned(),
                };
                MESSAGE.set(Some(message));
            }
        }));
    });
}

/// Runs a body, or an errand; its panic is the message. A panic is the body's own: no other one sees what it left behind.
pub(crate) fn caught<T>(body: impl FnOnce() -> T) -> Result<T, String> {
    // The body before may have caught a panic of its own.
    MESSAGE.set(None);
    IN_BODY.set(true);
    let result = catch_unwind(AssertUnwindSafe(body));
    IN_BODY.set(false);
    // Nothing is kept where there is no hook of ours, or a later one took its place.
    result.map_err(|payload| MESSAGE.take().unwrap_or_else(|| words(&*payload).to_owned()))
}

/// What a panic said.
fn words(payload: &(dyn Any + Send)) -> &str {
    let said = payload.downcast_ref::<&'static str>().copied();
    said.or_else(|| payload.downcast_ref::<String>().map(String::as_str)).unwrap_or("see what was printed")
}
