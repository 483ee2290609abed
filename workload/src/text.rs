//! From bytes to text: UTF-8 with or without a byte order mark, and nothing that is not text.

use crate::error::{Fault, Refusal};

const EXPECTED: &str = "plain text in UTF-8: save the file in that encoding";

const MARK: &[u8] = b"\xef\xbb\xbf";

/// The bytes after a UTF-8 byte order mark, if there is one. Offsets count from there.
pub(crate) fn after_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(MARK).unwrap_or(bytes)
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
    if bytes.starts_with(MARK) {
        return Err(refuse(0, "an unexpected character: a second byte order mark stands here"));
    }
    let is_binary = |byte: &u8| byte.is_ascii_control() && !matches!(byte, b'\t' | b'\n' | b'\r');
    if let Some(at) = bytes.iter().position(is_binary) {
        return Err(refuse(at, "the file is binary: a control character stands here"));
    }
    // YAML takes it for the end of a line and TOML refuses it; editors disagree too.
    let is_lone = |at: &usize| bytes[*at] == b'\r' && bytes.get(at + 1) != Some(&b'\n');
    if let Some(at) = (0..bytes.len()).find(is_lone) {
        let problem = "a carriage return without a line feed stands here";
        return Err(Fault::new(
            at,
            Refusal::Encoding,
            problem,
            "lines that end with a line feed, or with both",
        ));
    }
    std::str::from_utf8(bytes).map_err(|error| refuse(error.valid_up_to(), "this is not UTF-8"))
}

#[cfg(test)]
mod tests;
