use crate::Refusal::{Empty, Encoding, Missing};
use crate::fixtures::{EXAMPLE_TOML, EXAMPLE_YAML, refused_as};
use crate::{Format, Place, parse};

#[test]
fn a_mark_and_crlf_change_nothing() {
    for (text, format) in [(EXAMPLE_TOML, Format::Toml), (EXAMPLE_YAML, Format::Yaml)] {
        let dos = format!("\u{feff}{}", text.replace('\n', "\r\n"));
        assert_eq!(parse(dos.as_bytes(), format, "w"), parse(text.as_bytes(), format, "w"));
    }
}

#[test]
fn places_are_right_after_a_mark_and_with_crlf() {
    let at = |line, column| Some(Place { line, column });
    let toml = "\u{feff}# ä\r\n[[pool]]\r\nname = \"é\"\r\n";
    assert_eq!(refused_as(toml.as_bytes(), Format::Toml).place, at(3, 8));
    let toml = "\u{feff}lanes = 2\r\n";
    assert_eq!(refused_as(toml.as_bytes(), Format::Toml).place, at(1, 1));
    let yaml = "\u{feff}# ä\r\npool:\r\n  - {lanes: 1, name: é}\r\n";
    assert_eq!(refused_as(yaml.as_bytes(), Format::Yaml).place, at(3, 22));
    let broken = "\u{feff}# ä\r\nname = \"é\" \"\r\n";
    assert_eq!(refused_as(broken.as_bytes(), Format::Toml).place, at(2, 12));
}

#[test]
fn what_is_not_text_is_refused() {
    let utf16 =
        |text: &str, bytes: fn(u16) -> [u8; 2]| -> Vec<u8> { text.encode_utf16().flat_map(bytes).collect() };
    for format in [Format::Toml, Format::Yaml] {
        for empty in [&b""[..], b"\xef\xbb\xbf", b" \r\n\t\n", b"\xef\xbb\xbf\n"] {
            assert_eq!(refused_as(empty, format).refusal, Empty, "{empty:?}");
        }
        let binary = [
            utf16(EXAMPLE_TOML, u16::to_le_bytes),
            utf16(EXAMPLE_TOML, u16::to_be_bytes),
            utf16("\u{feff}pool", u16::to_le_bytes),
            utf16("\u{feff}pool", u16::to_be_bytes),
            b"\x7fELF\x02\x01\x01".to_vec(),
            b"pool = \"a\0b\"".to_vec(),
            b"# \x1b[31m".to_vec(),
            b"# latin-1: \xe4".to_vec(),
            b"# cut: \xc3".to_vec(),
            b"\xef\xbb\xbf\xef\xbb\xbfpool: 1".to_vec(),
        ];
        for bytes in binary {
            assert_eq!(refused_as(&bytes, format).refusal, Encoding, "{bytes:?}");
        }
        for lone in ["# a\r# b\rx: 1\n", "# a\r\r\nx: 1\n", "# a\r"] {
            let error = refused_as(lone.as_bytes(), format);
            assert_eq!(
                (error.refusal, error.place),
                (Encoding, Some(Place { line: 1, column: 4 })),
                "{lone:?}"
            );
        }
        assert_eq!(refused_as(b"# only a comment\n", format).refusal, Missing);
    }
}
