use super::*;

#[test]
fn a_port_has_a_fixed_size_that_fits_in_memory() {
    let port = |sizes: &[Option<usize>]| Port::new(Path::new("m.onnx"), "image", sizes.iter().copied());
    assert_eq!(port(&[Some(1), Some(3), Some(4)]).expect("fixed").len(), 12);
    assert_eq!(port(&[]).expect("a scalar").len(), 1);
    for (sizes, part) in [
        (&[None, Some(3)][..], "left open"),
        (&[Some(1 << 29)], "larger than 1 GiB"),
        (&[Some(usize::MAX), Some(2)], "larger than 1 GiB"),
    ] {
        let error = port(sizes).expect_err("refused").to_string();
        assert!(error.contains(part) && error.contains("`m.onnx`") && error.contains("`image`"), "{error}");
    }
}
