//! Calls from bytes, as a fuzzer gives them.

use super::{Call, Change};

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
