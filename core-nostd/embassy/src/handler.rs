//! A task of embassy, by the word that embassy knows it by.

use core::task::Context;

use embassy_executor::raw::{TaskRef, task_from_waker, wake_task};
use red_core::Empty;

/// Who to wake; nobody at first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Handler(Option<TaskRef>);

impl Empty for Handler {
    const EMPTY: Self = Self(None);
}

impl Handler {
    /// The task that is being polled. It must be one of embassy's, and not a part of one that brings its own waker.
    pub(crate) fn current(context: &Context<'_>) -> Self {
        Self(Some(task_from_waker(context.waker())))
    }

    pub(crate) fn wake(self) {
        if let Self(Some(task)) = self {
            wake_task(task);
        }
    }

    pub(crate) const fn is_there(self) -> bool {
        self.0.is_some()
    }
}
