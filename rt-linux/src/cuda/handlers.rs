//! The handlers of lanes that have streams, which cannot be made once lanes run: that would have the device wait.

use crate::handler::{Failed, Handler, Work};
use std::fmt;
use std::sync::{Mutex, PoisonError};

type Place = Mutex<Option<Box<dyn Handler>>>;

/// The handlers of lanes, each taken once.
pub struct Handlers {
    by_lane: Vec<(usize, Place)>,
}

impl Handlers {
    pub(super) fn new(by_lane: Vec<(usize, Box<dyn Handler>)>) -> Self {
        Self {
            by_lane: by_lane.into_iter().map(|(lane, handler)| (lane, Mutex::new(Some(handler)))).collect(),
        }
    }

    /// That of a lane; `None`: its lane has no stream. A lane that asks again, because its body never returned and a spare
    /// thread has taken it over, gets one that fails everything: the stream is with that body.
    pub fn take(&self, lane: usize) -> Option<Box<dyn Handler>> {
        let (_, place) = self.by_lane.iter().find(|(other, _)| *other == lane)?;
        let taken = place.lock().unwrap_or_else(PoisonError::into_inner).take();
        Some(taken.unwrap_or_else(|| Box::new(Spent)))
    }
}

impl fmt::Debug for Handlers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.by_lane.iter().map(|(lane, _)| lane)).finish()
    }
}

struct Spent;

impl Handler for Spent {
    fn run(&mut self, _: &Work) -> Result<(), Failed> {
        Err(Failed)
    }
}
