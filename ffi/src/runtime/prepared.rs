//! What a runtime starts with.

use super::on_device::OnDevice;
use red_core::Scheduler;
use red_record::class::Large;
use red_record::{Recorder, Tape, Writer};
use red_rt::timeline::Releases;

/// What is started.
pub(crate) struct SetUp {
    pub(crate) scheduler: Box<Scheduler<Large>>,
    pub(crate) tape: Option<Tape>,
    pub(crate) writer: Option<Writer>,
    /// Whether anything was set up, so that a log would not have it.
    pub(crate) is_begun: bool,
    pub(crate) releases: Vec<Releases>,
    /// By lane; where there are none, they are chosen.
    pub(crate) cpus: Vec<usize>,
    pub(crate) device: Option<OnDevice>,
}

impl SetUp {
    /// Makes a call on the scheduler, which is in the log if there is one; a refused call leaves nothing behind.
    pub(crate) fn call<T, E>(
        &mut self,
        call: impl FnOnce(&mut Recorder<'_, Large>) -> Result<T, E>,
    ) -> Result<T, E> {
        let made = call(&mut Recorder::new(&mut self.scheduler, self.tape.as_mut()))?;
        self.is_begun = true;
        Ok(made)
    }
}
