use super::*;

fn weights(of: &[(u64, u64)]) -> Vec<Option<Weight>> {
    of.iter()
        .map(|(memory_bytes, cost_ns)| Some(Weight { memory_bytes: *memory_bytes, cost_ns: *cost_ns }))
        .collect()
}

#[test]
fn a_mix_has_only_what_runs_on_the_same_device() {
    let mut weights = weights(&[(1, 9), (4, 1), (2, 5)]);
    weights[1] = None;
    assert_eq!(heaviest_mix(&weights, 0, 2), [2, 2]);
    weights[2] = None;
    assert_eq!(heaviest_mix(&weights, 0, 2), [0, 0]);
}

#[test]
fn the_mix_has_the_largest_memory_and_among_equals_the_largest_cost() {
    let weights = weights(&[(1, 9), (4, 1), (2, 5), (2, 7)]);
    assert_eq!(heaviest_mix(&weights, 0, 3), [1, 3, 2]);
    assert_eq!(heaviest_mix(&weights, 1, 1), [3]);
}

#[test]
fn a_mix_is_as_wide_as_the_machine() {
    assert_eq!(heaviest_mix(&weights(&[(1, 1), (2, 1), (3, 1)]), 0, 5), [2, 1, 2, 1, 2]);
    assert_eq!(heaviest_mix(&weights(&[(1, 1)]), 0, 2), [0, 0]);
}
