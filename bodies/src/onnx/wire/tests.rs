use super::*;

/// A field of bytes.
fn field(number: u8, bytes: &[u8]) -> Vec<u8> {
    let len = u16::try_from(bytes.len()).expect("short");
    let mut field = vec![number << 3 | 2, len as u8 & 0x7f | 0x80, (len >> 7) as u8];
    field.extend(bytes);
    field
}

#[test]
fn every_prefix_of_a_field_is_cut_short() {
    let model = field(7, &field(1, &field(5, &field(1, b"axis"))));
    assert_eq!(check(&model), Ok(()));
    for len in 1..model.len() {
        assert!(check(&model[..len]).is_err(), "{len} bytes");
    }
}

#[test]
fn a_long_integer_is_refused_where_it_is_one_and_weights_may_hold_anything() {
    let long = [0xff; 12];
    assert!(check(&long).is_err());
    assert!(check(&field(7, &long)).is_err());
    // Integer data of an initializer, then its raw data and its name.
    for (number, refused) in [(5, true), (7, true), (9, false), (8, false)] {
        let model = field(7, &field(5, &field(number, &long)));
        assert_eq!(check(&model).is_err(), refused, "field {number}");
    }
}

#[test]
fn nesting_is_bounded() {
    let nest = |levels: usize| {
        let inner = (0..levels).fold(Vec::new(), |graph, _| field(1, &field(5, &field(6, &graph))));
        check(&field(7, &inner))
    };
    assert_eq!(nest(5), Ok(()));
    assert_eq!(nest(50), Err("graphs are nested too deeply"));
}

#[test]
fn a_field_without_a_number_is_refused() {
    assert!(check(&[0, 0]).is_err());
    for (first, may) in
        [(0x08, true), (0x3a, true), (0xa2, true), (0x00, false), (0x02, false), (b'n', false)]
    {
        assert_eq!(begins(first), may, "{first:#x}");
    }
}
