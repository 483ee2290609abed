use super::*;
use red_workload::model::Body;

#[test]
fn a_time_is_as_far_above_the_best_case_as_the_share_above_nothing() {
    let part = Part {
        wcet_ns: 100,
        bcet_ns: 60,
        body: Body::None,
        pool: 0,
        memory_bytes: 0,
        atomic: false,
        contention_ns: 0,
    };
    assert_eq!([0, 50, 100].map(|share| between(&part, share)), [60, 80, 100]);
    assert_eq!(between(&Part { wcet_ns: 0, bcet_ns: 0, ..part }, 0), 0);
}
