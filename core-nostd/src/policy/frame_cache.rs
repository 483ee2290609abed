//! What an encoder's result may be shared for, and where results are.
//!
//! *Background.* The paper merges encoders of one stage; here all that read the same capture share. *Rule.* Two
//! encoders share a result iff weights, frame name and capture are equal. A ready encoder whose key is running
//! waits for it without a lane, and is then a hit; one whose key is kept is a hit at once. A result lives while an
//! uncompleted decoder or a not-started encoder of its key is in flight; its bytes count against its pool.

use crate::graph::Frame;

crate::capacity::values! {
    /// (weights, frame name, capture).
    pub(crate) struct FrameKey {
        number: u64,
        weights: u16,
        frame: u16,
        source: CaptureSource,
    }

    /// Who numbers the captures of a frame.
    pub(crate) enum CaptureSource {
        /// Every job has its own; the number is the job's, unique over the scheduler's life.
        Job,
        /// The sensor's n-th.
        Sensor,
        /// The host gave the number at release.
        Host,
    }

    /// One result: being computed, or kept. The key is in parts, between the others: 24 bytes instead of 32.
    pub(crate) struct Output {
        number: u64,
        /// Bytes it holds of its pool once it is kept.
        pub(crate) bytes: u64,
        weights: u16,
        frame: u16,
        source: CaptureSource,
        pub(crate) pool: u8,
        pub(crate) state: OutputState,
    }

    pub(crate) enum OutputState {
        Free,
        /// The unit on this lane computes it.
        Running(u8),
        Kept,
        /// Nobody in flight needs it, but a unit of a job that was given up still reads it.
        Draining,
    }
}

impl FrameKey {
    pub(crate) const fn new(frame: Frame, source: CaptureSource, number: u64) -> Self {
        Self { number, weights: frame.weights, frame: frame.frame, source }
    }
}

impl Output {
    /// A result that is being computed.
    pub(crate) const fn new(key: FrameKey, pool: u8, state: OutputState) -> Self {
        let FrameKey { number, weights, frame, source } = key;
        Self { number, bytes: 0, weights, frame, source, pool, state }
    }

    pub(crate) const fn key(&self) -> FrameKey {
        FrameKey { number: self.number, weights: self.weights, frame: self.frame, source: self.source }
    }
}
