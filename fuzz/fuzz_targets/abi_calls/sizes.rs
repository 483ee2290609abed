//! How large executions are.

use std::cell::Cell;

/// Executions between two that cost much.
const SELDOM: u32 = 31;

thread_local! {
    static SINCE: Cell<u32> = const { Cell::new(SELDOM) };
}

/// How large an execution is.
#[derive(Clone, Copy)]
pub(crate) struct Sizes {
    /// Classes that take part, from the smallest on.
    pub(crate) classes: usize,
    /// What is out of the ordinary.
    pub(crate) more: More,
}

/// What costs too much for every execution.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum More {
    Nothing,
    /// Memory for more graphs than handles.
    Crowd,
    /// Runtimes, and graphs of their class.
    Runtimes,
    /// A log of the first scheduler.
    Log,
}

impl Sizes {
    /// What costs as much as ten executions is made small if the last of that kind was not long ago. An input that is run
    /// alone is as large as it says.
    pub(crate) fn affordable(self) -> Self {
        let since = SINCE.get();
        let is_dear = self.classes > 2 || self.more != More::Nothing;
        SINCE.set(if is_dear && since >= SELDOM { 0 } else { since.saturating_add(1) });
        if is_dear && since < SELDOM { Self { classes: 1, more: More::Nothing } } else { self }
    }
}
