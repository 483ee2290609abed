use super::*;

#[test]
fn quantiles_are_those_of_the_tables() {
    for (freedom, known) in [(4, 2.776), (9, 2.262), (19, 2.093), (99, 1.984)] {
        let off = (quantile(freedom) / known - 1.0).abs();
        assert!(off < 0.01, "{freedom}: {} for {known}", quantile(freedom));
    }
}

#[test]
fn an_interval_is_that_of_a_textbook() {
    // 1, 2, 3, 4, 5: mean 3, deviation 1.5811, 2.776 * 1.5811 / sqrt(5) = 1.963.
    let five = Estimate::of(&[1.0, 2.0, 3.0, 4.0, 5.0]).unwrap();
    assert!((five.mean - 3.0).abs() < 1e-12 && (five.half_width - 1.963).abs() < 0.01, "{five:?}");
    assert_eq!(Estimate::of(&[]), None);
    assert_eq!(Estimate::of(&[2.0]), Some(Estimate { mean: 2.0, half_width: 0.0, samples: 1 }));
}
