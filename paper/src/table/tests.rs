use super::*;

#[test]
fn a_change_is_reproduced_by_direction_and_size() {
    for (paper, ours, verdict) in [
        (-24.7, -22.0, Verdict::Reproduced),
        (-24.7, -12.8, Verdict::ShapeOnly),
        (-24.7, 3.0, Verdict::NotReproducible),
        (-24.7, -0.2, Verdict::NotReproducible),
        (0.0, 0.4, Verdict::Reproduced),
        (0.2, 9.0, Verdict::NotReproducible),
        (40.0, 80.0, Verdict::ShapeOnly),
    ] {
        assert_eq!(Verdict::of_change(paper, ours), verdict, "{paper} {ours}");
    }
}

#[test]
fn a_value_is_judged_beside_its_baseline() {
    assert_eq!(Verdict::of_value(14.2, 15.0, 27.9, 27.0), Verdict::Reproduced);
    assert_eq!(Verdict::of_value(14.2, 19.5, 27.9, 25.9), Verdict::ShapeOnly);
    assert_eq!(Verdict::of_value(14.2, 27.0, 27.9, 25.9), Verdict::NotReproducible);
}
