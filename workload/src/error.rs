//! What is wrong with a workload file, where, and what would be right.

use std::fmt;
use std::path::Path;

/// Longest piece of foreign text in a message, in characters.
const SHOWN_CHARACTERS: usize = 64;

/// Why a workload file is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// The operating system does not give the file out.
    Unreadable,
    /// A directory, a FIFO, a device or a socket.
    NotAFile,
    /// More bytes than a workload file may have.
    TooLarge,
    /// Nothing but white space.
    Empty,
    /// Not UTF-8 text: binary or UTF-16.
    Encoding,
    /// Not TOML or YAML, or a part of these that workload files leave out.
    Syntax,
    /// Nested too deeply.
    Nesting,
    /// One key twice in one table.
    DuplicateKey,
    /// A key that the table does not have.
    UnknownKey,
    /// A required key or entry is not there.
    Missing,
    /// Keys of which exactly one must be there, or that may not stand together.
    Conflict,
    /// A value of the wrong type.
    Type,
    /// A time or an amount of memory that is not a whole number with a unit.
    Quantity,
    /// A value out of its range.
    Range,
    /// More of something than the scheduler has room for.
    Limit,
    /// A name with other characters than the allowed ones, or too long.
    Name,
    /// A name that is taken.
    Duplicate,
    /// A name of something that does not exist, at least not at that time.
    Reference,
    /// A path that leads out of the workload file's folder.
    Path,
    /// A footprint above its pool's budget.
    Memory,
    /// Precedence constraints that form a cycle.
    Cycle,
    /// A sum that does not fit its integer.
    Overflow,
}

/// A place in a file. Lines end at each line feed; a byte order mark takes no column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Line, counted from 1.
    pub line: u32,
    /// Column, counted from 1 in characters.
    pub column: u32,
}

impl Place {
    /// The place of the byte at offset `at` of `text`, or of its end.
    pub(crate) fn of(text: &[u8], at: usize) -> Self {
        let before = &text[..at.min(text.len())];
        let line_start = before.iter().rposition(|byte| *byte == b'\n').map_or(0, |feed| feed + 1);
        let is_character_start = |byte: &&u8| **byte & 0xc0 != 0x80;
        let feeds = before.iter().filter(|byte| **byte == b'\n').count();
        let characters = before[line_start..].iter().filter(is_character_start).count();
        Self { line: ordinal(feeds), column: ordinal(characters) }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.line, self.column)
    }
}

/// A count of what comes before, as a number that starts at 1. Files have far less than 4 GiB.
fn ordinal(before: usize) -> u32 {
    u32::try_from(before).unwrap_or(u32::MAX).saturating_add(1)
}

/// A refused workload file. `Display` gives one line of at most 2,000 characters in which foreign text is escaped
/// and cut.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LoadError {
    /// The file as the caller named it, escaped; a long path keeps its end.
    pub file: String,
    /// Where in the file, unless the file as a whole is at fault.
    pub place: Option<Place>,
    /// The kind of refusal.
    pub refusal: Refusal,
    /// What is wrong.
    pub problem: String,
    /// What would be right: the cure.
    pub expected: String,
    /// The valid name nearest to the one that is unknown.
    pub nearest: Option<Nearest>,
}

/// A valid name, the one that is most like an unknown one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Nearest {
    /// The valid name.
    pub name: String,
    /// Whether it is so like the unknown one that it was probably meant.
    pub is_like: bool,
}

impl LoadError {
    /// A refusal of the whole file `name`.
    pub(crate) fn whole(name: &str, refusal: Refusal, problem: String, expected: String) -> Self {
        Self { file: shown_path(name.as_ref()), place: None, refusal, problem, expected, nearest: None }
    }

    /// A refusal inside the file `name` with this text.
    pub(crate) fn inside(name: &str, text: &[u8], fault: Fault) -> Self {
        Self {
            file: shown_path(name.as_ref()),
            place: Some(Place::of(text, fault.at)),
            refusal: fault.refusal,
            problem: fault.problem,
            expected: fault.expected,
            nearest: fault.nearest,
        }
    }
}

impl fmt::Display for LoadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { file, place, refusal: _, problem, expected, nearest } = self;
        write!(f, "{file}:")?;
        if let Some(place) = place {
            write!(f, "{place}:")?;
        }
        write!(f, " {problem}; expected {expected}")?;
        match nearest {
            Some(Nearest { name, is_like: true }) => write!(f, "; did you mean `{name}`?"),
            Some(Nearest { name, is_like: false }) => write!(f, "; the nearest name is `{name}`"),
            None => Ok(()),
        }
    }
}

impl std::error::Error for LoadError {}

/// A refusal at a byte offset of the text, before it is known which file the text comes from.
#[derive(Debug)]
pub(crate) struct Fault {
    pub(crate) at: usize,
    pub(crate) refusal: Refusal,
    problem: String,
    expected: String,
    nearest: Option<Nearest>,
}

impl Fault {
    pub(crate) fn new(
        at: usize,
        refusal: Refusal,
        problem: impl Into<String>,
        expected: impl Into<String>,
    ) -> Self {
        Self { at, refusal, problem: problem.into(), expected: expected.into(), nearest: None }
    }

    /// Adds the candidate that is most like `wanted`.
    pub(crate) fn with_nearest<'c>(
        mut self,
        wanted: &str,
        candidates: impl IntoIterator<Item = &'c str>,
    ) -> Self {
        // What was written may be megabytes long; the distance costs its length times the candidates'.
        let wanted = wanted.chars().take(SHOWN_CHARACTERS).collect::<String>().to_lowercase();
        let distance = |candidate: &str| strsim::osa_distance(&wanted, &candidate.to_lowercase());
        let nearest = candidates.into_iter().map(|candidate| (distance(candidate), candidate)).min();
        self.nearest = nearest.map(|(distance, candidate)| Nearest {
            name: candidate.to_owned(),
            is_like: 3 * distance <= candidate.len().max(wanted.len()),
        });
        self
    }
}

/// Foreign text for a message: control, bidirectional and other invisible characters escaped, cut in the end to 64
/// characters.
#[must_use]
pub fn shown(foreign: &str) -> String {
    cut(foreign.chars(), |pieces| pieces.concat(), |kept| format!("{kept}…"))
}

/// As [`shown`], but cut in the beginning: a path's end tells more.
#[must_use]
pub fn shown_path(path: &Path) -> String {
    let path = path.to_string_lossy();
    let from_end = |mut pieces: Vec<String>| {
        pieces.reverse();
        pieces.concat()
    };
    cut(path.chars().rev(), from_end, |kept| format!("…{kept}"))
}

fn cut(
    characters: impl Iterator<Item = char>,
    join: impl Fn(Vec<String>) -> String,
    mark: impl Fn(String) -> String,
) -> String {
    let mut pieces = Vec::new();
    let mut length = 0;
    for character in characters {
        let piece = match character {
            '"' | '\'' => character.to_string(),
            _ => character.escape_debug().to_string(),
        };
        length += piece.chars().count();
        pieces.push(piece);
        if length > SHOWN_CHARACTERS {
            while length >= SHOWN_CHARACTERS {
                length -= pieces.pop().map_or(length, |piece| piece.chars().count());
            }
            return mark(join(pieces));
        }
    }
    join(pieces)
}

#[cfg(test)]
mod tests;
