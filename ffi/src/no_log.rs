//! The core alone writes no logs.

use crate::machine::Host;
use core::convert::Infallible;
use red_core::{Capacity, Scheduler};

/// What calls are made on: the scheduler itself.
#[inline(always)]
pub(crate) const fn calls<C: Capacity>(
    scheduler: &mut Scheduler<C>,
    _tape: Option<Infallible>,
) -> &mut Scheduler<C> {
    scheduler
}

/// Nothing more than a scheduler.
pub(crate) trait Logged {
    /// There is none to drop.
    fn drop_log(&mut self) {}
}
impl<C: Capacity> Logged for Host<C> {}

/// No log.
pub(crate) struct Log;

impl Log {
    pub(crate) const NONE: Self = Self;

    /// Nowhere.
    #[inline(always)]
    #[expect(clippy::unused_self, reason = "a log has one")]
    pub(crate) const fn tape(&mut self) -> Option<Infallible> {
        None
    }
}
