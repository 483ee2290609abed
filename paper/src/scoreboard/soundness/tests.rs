use super::*;

/// Certificates that say a nanosecond less than was proved.
#[test]
fn bounds_that_are_too_short_are_found() {
    let (mut shorter, mut true_bounds) = (Score::default(), Score::default());
    for seed in 0..200 {
        let rng = &mut Rng::of(&[2, seed]);
        let set = draw(rng, 2, Layout::Pool);
        let certificate = prove(&set);
        let mut planted = certificate.clone();
        for task in &mut planted.tasks {
            task.response_ns = task.response_ns.map(|ns| ns.saturating_sub(1));
        }
        true_bounds.add(&put_to_the_test(&mut rng.clone(), &set, &certificate, WORLDS).unwrap());
        shorter.add(&put_to_the_test(rng, &set, &planted, WORLDS).unwrap());
    }
    assert_eq!(true_bounds.violations(), 0, "{true_bounds:?}");
    assert_eq!(shorter.above, true_bounds.exact);
    assert!(shorter.above > 20 && shorter.rejected > 100, "{shorter:?}");
}

#[test]
fn a_lane_that_is_not_there_is_found() {
    let mut score = Score::default();
    for seed in 0..300 {
        let rng = &mut Rng::of(&[3, seed]);
        let set = draw(rng, 4, Layout::Pool);
        let mut narrower = set.clone();
        narrower.clusters[0].lanes = 1;
        score.add(&put_to_the_test(rng, &narrower, &prove(&set), WORLDS).unwrap());
    }
    assert!(score.above > 0 && score.missed > 0, "{score:?}");
}

#[test]
fn every_layout_has_sets_that_are_accepted() {
    for (lanes, layout) in rows() {
        let score = score(lanes, layout, 1).unwrap();
        assert_eq!(score.violations(), 0, "{score:?}");
        assert!(score.accepted > 0 && score.exact > 0, "{lanes} {layout:?}: {score:?}");
    }
}
