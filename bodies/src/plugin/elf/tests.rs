use std::fs;
use std::io::Cursor;

use super::*;
use crate::plugin::tests::{build, nobody};
use crate::{BodyError, plugin::Plugin};

fn checked(bytes: &[u8]) -> Result<(), &'static str> {
    check(&mut Cursor::new(bytes), bytes.len() as u64)
}

/// Numbers without a pattern.
fn random(state: &mut u64) -> u64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    *state >> 33
}

#[test]
fn what_is_cut_short_is_refused_and_the_rest_loads() {
    let path = build("truncated", "int step(void) { return 0; }");
    let whole = fs::read(&path).expect("it was built");
    assert_eq!(checked(&whole), Ok(()));
    let shortest = (0..whole.len()).find(|len| checked(&whole[..*len]).is_ok()).unwrap_or(whole.len());
    for len in 0..whole.len() {
        assert_eq!(checked(&whole[..len]).is_ok(), len >= shortest, "{len} bytes");
    }
    // Behind the segments are only tables for debuggers. What was loaded may not be written to.
    for (len, loads) in [(0, false), (64, false), (shortest - 1, false), (shortest, true)] {
        fs::write(&path, &whole[..len]).expect("the temporary directory is writable");
        match Plugin::load(&path, "step", &nobody()) {
            Ok(_) => assert!(loads, "{len} bytes"),
            Err(error) => {
                assert!(!loads && matches!(error, BodyError::Plugin { .. }), "{len} bytes: {error}");
            }
        }
    }
    fs::remove_file(path).expect("the object was there");
}

#[test]
fn any_bytes_have_an_answer() {
    let path = build("random", "int step(void) { return 0; }");
    let whole = fs::read(&path).expect("it was built");
    fs::remove_file(path).expect("the object was there");
    let state = &mut 1;
    for round in 0..20_000 {
        let mut bytes = whole[..1024].to_vec();
        for _ in 0..=round % 8 {
            let at = random(state) as usize % bytes.len();
            bytes[at] = random(state) as u8;
        }
        let _answer = check(&mut Cursor::new(&bytes), random(state) << (random(state) % 32));
        let noise: Vec<u8> = (0..random(state) % 200).map(|_| random(state) as u8).collect();
        assert!(checked(&noise).is_err());
    }
}

#[test]
fn other_machines_and_kinds_are_told_apart() {
    let path = build("kinds", "int step(void) { return 0; }");
    let whole = fs::read(&path).expect("it was built");
    fs::remove_file(path).expect("the object was there");
    for (at, byte, words) in [
        (0, b'M', "no ELF file"),
        (4, 1, "64 bits"),
        (5, 3 - BYTE_ORDER, "byte order"),
        (16, 2, "no shared object"),
        (18, 40, "another kind of processor"),
        (54, 32, "damaged"),
        (39, 0x80, "cut short"),
        (56, 0, "nothing to link"),
    ] {
        let mut bytes = whole.clone();
        bytes[at] = byte;
        let reason = checked(&bytes).expect_err(words);
        assert!(reason.contains(words), "byte {at}: {reason}");
    }
}
