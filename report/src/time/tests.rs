use super::*;

#[test]
fn three_digits_are_shown() {
    let shown = [999, 1_234, 12_345_678, 312_000_000, 2_500_000_000].map(time);
    assert_eq!(shown, ["999 ns", "1.23 µs", "12.3 ms", "312 ms", "2.50 s"]);
}

#[test]
fn steps_of_an_axis_are_round() {
    assert_eq!(
        [step(100, 10), step(101, 10), step(3_000, 10), step(7, 10), step(999, 2)],
        [10, 20, 500, 1, 500]
    );
}
