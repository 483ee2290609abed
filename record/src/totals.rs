//! How much was recorded: a part of a log that is written last, in place.

use crate::error::LogError;

/// Bytes of the totals.
pub(crate) const TOTALS: usize = 24;
/// A log grows to so many bytes and then drops.
pub(crate) const LARGEST: u64 = 1 << 32;

/// How much was recorded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Totals {
    /// Inputs in the log.
    pub entries: u64,
    /// Inputs that are not in the log, all of them after those that are.
    pub dropped: u64,
    /// Why there are such inputs.
    pub cut: Option<Cut>,
    /// Bytes of the file.
    pub bytes: u64,
}

/// Why the last inputs of a run are not in its log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cut {
    /// The disk did not keep up.
    Slow,
    /// The file could not be written.
    Failed,
    /// The file reached its largest size.
    TooLarge,
    /// The writer had a defect.
    Panicked,
}

/// What a log's state says: it is open, whole, or closed without its last inputs.
const OPEN: u32 = 0;
const WHOLE: u32 = u32::from_le_bytes(*b"DONE");
const CUTS: [(Cut, u32); 4] = [
    (Cut::Slow, u32::from_le_bytes(*b"SLOW")),
    (Cut::Failed, u32::from_le_bytes(*b"FAIL")),
    (Cut::TooLarge, u32::from_le_bytes(*b"LONG")),
    (Cut::Panicked, u32::from_le_bytes(*b"LOST")),
];

impl Totals {
    /// As a closed log has them; `None` is a log that is not closed yet.
    pub(crate) fn to_bytes(totals: Option<Self>) -> Vec<u8> {
        let state = totals.map_or(OPEN, |totals| {
            let known = CUTS.iter().find(|(cut, _)| totals.cut == Some(*cut));
            known.map_or(WHOLE, |(_, state)| *state)
        });
        let totals = totals.unwrap_or_default();
        let mut bytes = Vec::with_capacity(TOTALS);
        bytes.extend(totals.entries.to_le_bytes());
        bytes.extend(totals.dropped.to_le_bytes());
        bytes.extend(state.to_le_bytes());
        bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
        bytes
    }

    /// Those of a log; `None`: it is not closed. `at` is where they lie.
    pub(crate) fn from_bytes(bytes: &[u8; TOTALS], at: u64) -> Result<Option<Self>, LogError> {
        let damaged = LogError::Damaged { at, what: "the totals" };
        let long = |from: usize| {
            let mut word = [0; 8];
            word.iter_mut().zip(bytes.iter().skip(from)).for_each(|(place, byte)| *place = *byte);
            u64::from_le_bytes(word)
        };
        let (entries, dropped, state, crc) = (long(0), long(8), long(16) as u32, (long(16) >> 32) as u32);
        if crc != crc32fast::hash(bytes.get(..TOTALS - 4).unwrap_or_default()) {
            return Err(damaged);
        }
        let cut = CUTS.iter().find(|(_, of)| *of == state).map(|(cut, _)| *cut);
        match (state, cut) {
            (OPEN, _) => Ok(None),
            (WHOLE, _) | (_, Some(_)) if cut.is_some() || dropped == 0 => {
                Ok(Some(Self { entries, dropped, cut, bytes: 0 }))
            }
            _ => Err(damaged),
        }
    }
}
