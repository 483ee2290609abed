//! Calls, and calls from bytes, as a fuzzer gives them.

use super::Change;

/// One call, or what goes before it. Numbers are taken modulo what there is.
#[derive(Clone, Copy, Debug)]
pub enum Call {
    /// Time goes on by so many microseconds.
    Wait(u64),
    /// Time goes on by 2^n nanoseconds.
    Leap(u8),
    /// From now on one host's clock says an earlier time, by so many microseconds.
    StepBack(u64),
    /// A release of this task.
    Release(usize),
    /// A release with a capture number, which was so many microseconds ago.
    Capture(usize, u64, u64),
    /// A running unit is reported.
    Complete(usize),
    /// The same, with the next action in one call.
    CompleteAndPoll(usize),
    /// A running unit failed.
    Fail(usize),
    /// A unit that was reported already is reported again.
    Again(usize),
    /// Handles that nobody gave out.
    Stranger(u64),
    /// A task is removed, and admitted anew.
    Remove(usize),
    /// An edit of this task is begun, or goes on.
    Edit(usize, Change),
    /// The edit is committed.
    Commit,
    /// A lane is lost.
    Retire(u8),
    /// A lane is there again.
    Restore(u8),
    /// An ended job is taken without a poll.
    Take,
    /// Until there is nothing to do.
    Poll,
    /// Once, for this lane.
    PollOn(u8),
}

impl Call {
    /// The next call in `bytes`; every sequence of bytes is one of calls.
    pub fn read(bytes: &mut impl Iterator<Item = u8>) -> Option<Self> {
        let kind = bytes.next()?;
        let mut small = || bytes.next().unwrap_or(0);
        Some(match kind % 32 {
            0..=2 => Self::Wait(u64::from(small()) * 16),
            3 => Self::Leap(small()),
            4 => Self::StepBack(u64::from(small()) * 32),
            5..=7 => Self::Release(kind.into()),
            8 | 9 => Self::Capture(kind.into(), small().into(), u64::from(small()) * 16),
            10..=12 => Self::Complete((kind >> 5).into()),
            13 => Self::CompleteAndPoll((kind >> 5).into()),
            14 => Self::Fail((kind >> 5).into()),
            15 => Self::Again(small().into()),
            16 => Self::Stranger(u64::from_le_bytes([0; 8].map(|_: u8| small()))),
            17 => Self::Remove((kind >> 5).into()),
            18 => Self::Edit((kind >> 5).into(), Change::Add(small(), small(), small())),
            19 => Self::Edit((kind >> 5).into(), Change::Remove(small())),
            20 => Self::Edit((kind >> 5).into(), Change::Link(small(), small())),
            21 => Self::Edit((kind >> 5).into(), Change::Unlink(small(), small())),
            22 => Self::Commit,
            23 => Self::Retire(kind >> 6),
            24 => Self::Restore(kind >> 6),
            25 => Self::Take,
            26 => Self::PollOn(kind >> 6),
            _ => Self::Poll,
        })
    }
}
