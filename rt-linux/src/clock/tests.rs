use super::now_ns;

#[test]
fn the_clock_never_goes_back() {
    let mut previous = now_ns();
    for _ in 0..1_000 {
        let next = now_ns();
        assert!(next >= previous, "{next} after {previous}");
        previous = next;
    }
}
