use super::*;
use core::ffi::CStr;

#[test]
fn a_text_is_taken_whatever_sign_its_bytes_have() {
    let taken = |text: &CStr| take(text.as_ptr());
    assert_eq!(taken(c"größe.redlog"), Ok("größe.redlog".to_owned()));
    for no_text in [c"", c"\xff.redlog"] {
        assert_eq!(taken(no_text), Err(red_status::Text), "{no_text:?}");
    }
    assert_eq!(take(core::ptr::null()), Err(red_status::NullPointer));
}
