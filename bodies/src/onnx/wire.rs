//! Refuses files whose protobuf framing is broken, before the engine reads them.
//!
//! *Background.* rten 0.27 reads on for ever at an integer of more than ten bytes, and descends without limit into
//! graphs within graphs. Weights may hold any bytes, so only a walk along the fields tells the one from the other.
//!
//! *Rule.* The walk descends exactly where rten does; what rten skips is skipped by its length.

/// Messages within messages: a graph in an attribute of a node of a graph takes three.
const MAX_DEPTH: usize = 32;

/// What a field of bytes holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Content {
    Model,
    Graph,
    Node,
    Attribute,
    Tensor,
    ValueInfo,
    Type,
    Sequence,
    TensorType,
    Shape,
    /// A message whose fields are all plain.
    Record,
    /// Integers, one after the other.
    Integers,
    /// Bytes that are not looked into.
    Opaque,
}

impl Content {
    /// What the field `number` of this message holds, by onnx.proto.
    const fn field(self, number: u64) -> Self {
        match (self, number) {
            (Self::Model, 7) | (Self::Attribute, 6) => Self::Graph,
            (Self::Model, 8 | 14) | (Self::Tensor, 13) | (Self::Shape, 1) => Self::Record,
            (Self::Graph, 1) => Self::Node,
            (Self::Graph, 5) | (Self::Attribute, 5) => Self::Tensor,
            (Self::Graph, 11..=13) => Self::ValueInfo,
            (Self::Node, 5) => Self::Attribute,
            (Self::Tensor, 5 | 7) => Self::Integers,
            (Self::ValueInfo, 2) | (Self::Sequence, 1) => Self::Type,
            (Self::Type, 1) => Self::TensorType,
            (Self::Type, 4) => Self::Sequence,
            (Self::TensorType, 2) => Self::Shape,
            _ => Self::Opaque,
        }
    }
}

/// What is said of a file that is something else.
pub(super) const NO_MODEL: &str = "not an ONNX file, or damaged";

/// Whether a model may begin with this byte: the tag of an integer or of bytes. No field has the number 0.
pub(super) const fn begins(first: u8) -> bool {
    first >> 3 != 0 && matches!(first & 7, 0 | 2)
}

/// Checks the framing of an ONNX file.
pub(super) fn check(file: &[u8]) -> Result<(), &'static str> {
    walk(file, Content::Model, 0)
}

fn walk(mut bytes: &[u8], content: Content, depth: usize) -> Result<(), &'static str> {
    if depth > MAX_DEPTH {
        return Err("graphs are nested too deeply");
    }
    while content != Content::Opaque && !bytes.is_empty() {
        let tag = integer(&mut bytes)?;
        match tag & 7 {
            _ if content == Content::Integers => {}
            _ if tag >> 3 == 0 => return Err(NO_MODEL),
            0 => drop(integer(&mut bytes)?),
            1 => drop(take(&mut bytes, 8)?),
            2 => {
                let len = integer(&mut bytes)?;
                walk(take(&mut bytes, len)?, content.field(tag >> 3), depth + 1)?;
            }
            5 => drop(take(&mut bytes, 4)?),
            _ => return Err(NO_MODEL),
        }
    }
    Ok(())
}

/// Takes an integer of one to ten bytes from the front.
fn integer(bytes: &mut &[u8]) -> Result<u64, &'static str> {
    let mut value = 0;
    for index in 0..10 {
        let byte = take(bytes, 1)?[0];
        value |= u64::from(byte & 0x7f) << (7 * index);
        if byte < 0x80 {
            return Ok(value);
        }
    }
    Err(NO_MODEL)
}

/// Takes `len` bytes from the front.
fn take<'a>(bytes: &mut &'a [u8], len: u64) -> Result<&'a [u8], &'static str> {
    let len = usize::try_from(len).map_err(|_| "the file is cut short")?;
    let (front, rest) = bytes.split_at_checked(len).ok_or("the file is cut short")?;
    *bytes = rest;
    Ok(front)
}

#[cfg(test)]
mod tests;
