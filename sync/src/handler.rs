//! The handler state cell: the paper's local synchronizer (section 4.4, Fig. 6b).
//!
//! ```text
//! Idle -> Ready -> Running -> Done -> Idle
//! Running <-> Io                                    a transfer
//! Running, Io -> OutOfMemory -> Ready, or Done      memory came, or the handler failed
//! ```
//!
//! One thread drives the handler, others watch it. Only legal transitions happen.

use crate::primitive::{AtomicU8, Ordering, constructor};

/// Where a handler is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum HandlerState {
    /// Nothing to do.
    Idle,
    /// May be given a lane.
    Ready,
    /// Its body runs.
    Running,
    /// It waits for a transfer.
    Io,
    /// It waits for memory.
    OutOfMemory,
    /// Its body ended; the result may be read.
    Done,
}

impl HandlerState {
    const ALL: [Self; 6] = [Self::Idle, Self::Ready, Self::Running, Self::Io, Self::OutOfMemory, Self::Done];

    const fn may_become(self, next: Self) -> bool {
        match self {
            Self::Idle => matches!(next, Self::Ready),
            Self::Ready => matches!(next, Self::Running),
            Self::Running => matches!(next, Self::Io | Self::OutOfMemory | Self::Done),
            Self::Io => matches!(next, Self::Running | Self::OutOfMemory),
            Self::OutOfMemory => matches!(next, Self::Ready | Self::Done),
            Self::Done => matches!(next, Self::Idle),
        }
    }
}

/// A transition was refused; the handler is where it was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum TransitionError {
    /// No handler may go that way: the caller erred.
    Illegal,
    /// The handler is not in the state that the caller thought; somebody else moved it.
    Elsewhere,
}

impl core::fmt::Display for TransitionError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Illegal => "No handler may go that way: the caller erred.",
            Self::Elsewhere => {
                "The handler is not in the state that the caller thought; somebody else moved it."
            }
        })
    }
}

impl core::error::Error for TransitionError {}

/// A handler's state, shared by the thread that drives it and those that watch.
///
/// ```
/// use red_sync::{HandlerCell, HandlerState::*, TransitionError};
/// let handler = HandlerCell::new();
/// assert_eq!(handler.go(Idle, Ready), Ok(()));
/// assert_eq!(handler.go(Ready, Done), Err(TransitionError::Illegal));
/// assert_eq!(handler.state(), Ready);
/// ```
#[derive(Debug)]
pub struct HandlerCell(AtomicU8);

impl HandlerCell {
    constructor! {
        /// An idle handler.
        #[expect(clippy::new_without_default, reason = "nothing is generic over it")]
        pub fn new() -> Self {
            Self(AtomicU8::new(HandlerState::Idle as u8))
        }
    }

    /// Goes from one state to another. Time bound: O(1), no waiting. Errors: [`TransitionError`].
    pub fn go(&self, from: HandlerState, to: HandlerState) -> Result<(), TransitionError> {
        if !from.may_become(to) {
            return Err(TransitionError::Illegal);
        }
        // Release: what the handler wrote is there for who sees the new state (Acquire in `state`). Acquire: the
        // driver sees what the one before it wrote.
        let moved = self.0.compare_exchange(from as u8, to as u8, Ordering::AcqRel, Ordering::Relaxed);
        moved.map(drop).map_err(|_| TransitionError::Elsewhere)
    }

    /// Where the handler is.
    pub fn state(&self) -> HandlerState {
        // Acquire: pairs with the Release in `go`.
        let state = usize::from(self.0.load(Ordering::Acquire));
        HandlerState::ALL.get(state).copied().unwrap_or(HandlerState::Idle)
    }
}

#[cfg(test)]
mod tests;
