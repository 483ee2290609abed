use super::*;

#[test]
fn ranks_order_by_key_then_release_then_fortune_then_task_then_job() {
    let rank = Rank::new;
    let sorted = [
        rank(-5, 9, 5, 1, 9),
        rank(0, 1, 5, 1, 9),
        rank(0, 2, 4, 1, 9),
        rank(0, 2, 5, 0, 7),
        rank(0, 2, 5, 1, 3),
        rank(0, 2, 5, 1, 4),
    ];
    assert!(sorted.windows(2).all(|w| w[0] < w[1]));
}
