//! From bytes to text: UTF-8 with or without a byte order mark, and nothing that is not text.

use crate::error::{Fault, Refusal};

const EXPECTED: &str = "plain text in UTF-8: save the file in that encoding";

/// The bytes after a UTF-8 byte order mark, if there is one. Offsets count from there.
pub(crate) fn after_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

/// The text of a file without its byte order mark.
pub(crate) fn decode(bytes: &[u8]) -> Result<&str, Fault> {
    let refuse = |at, problem: &str| Fault::new(at, Refusal::Encoding, problem, EXPECTED);
    if bytes.iter().all(u8::is_ascii_whitespace) {
        let expected = "a workload with at least one pool and one task";
        return Err(Fault::new(0, Refusal::Empty, "the file is empty", expected));
    }
    // ASCII text in UTF-16 has a zero byte in each character, so also without a mark.
    let is_utf16 = matches!(bytes, [0xff, 0xfe, ..] | [0xfe, 0xff, ..] | [0, 1..=255, ..] | [1..=255, 0, ..]);
    if is_utf16 {
        return Err(refuse(0, "the file looks like UTF-16"));
    }
    let is_binary = |byte: &u8| byte.is_ascii_control() && !matches!(byte, b'\t' | b'\n' | b'\r');
    if let Some(at) = bytes.iter().position(is_binary) {
        return Err(refuse(at, "the file is binary: a control character stands here"));
    }
    std::str::from_utf8(bytes).map_err(|error| refuse(error.valid_up_to(), "this is not UTF-8"))
}

#[cfg(test)]
mod tests;
