//! The core alone writes no logs.

use crate::machine::Host;
use red_core::{Capacity, Scheduler};

/// What calls are made on.
pub(crate) type Calls<'a, C> = &'a mut Scheduler<C>;

/// Nothing more than a scheduler.
pub(crate) trait Logged {}
impl<C: Capacity> Logged for Host<C> {}

/// No log.
pub(crate) struct Log;

impl Log {
    pub(crate) const NONE: Self = Self;

    /// The scheduler itself.
    #[inline(always)]
    pub(crate) fn calls<'a, C: Capacity>(
        &'a mut self,
        scheduler: &'a mut Scheduler<C>,
    ) -> &'a mut Scheduler<C> {
        scheduler
    }
}
