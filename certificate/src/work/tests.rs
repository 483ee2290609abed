use super::*;
use crate::by_hand::{graph, set};

/// A task on two lanes, with a chain of each graph's nodes one by one.
fn load(costs: &[&[u64]], period: Option<u64>, response: i128) -> Load {
    let set = set(&[2], vec![]);
    let graphs = costs.iter().map(|costs| costs.iter().map(|cost| (*cost, 0)).collect::<Vec<_>>());
    let shapes: Vec<Shape> =
        graphs.map(|nodes| Shape::of(&graph(&nodes, &[]), 100, &set).expect("a graph")).collect();
    let lengths: Vec<Vec<i128>> = shapes.iter().map(|shape| shape.chains(&[0, 1, 2], 0).unwrap()).collect();
    let versions: Vec<_> = shapes.iter().zip(&lengths).map(|(shape, l)| (shape, l.as_slice())).collect();
    Load::of(&versions, (0, 2), period, response)
}

#[test]
fn a_job_does_what_its_chains_and_the_lanes_can() {
    let load = load(&[&[9, 1], &[2, 3, 4]], Some(10), 20);
    assert_eq!(load.chains, [9, 3, 2]);
    assert_eq!([1, 2, 4, 20].map(|time| load.one(time)), [2, 4, 8, 14]);
    // Keys are 100 less the cost.
    assert_eq!(load.groups, [(91, 9), (99, 10), (96, 4), (97, 7), (98, 9)]);
    // 10 in 10, and rounded up: in the time of one response and before and after it.
    assert_eq!(load.rate(1), (1 << 32, 21 + 2 * 10));
}

/// The most that jobs with releases from `from` on do in the window, by trying all.
fn tried(load: &Load, [window, last, cap, rest, from]: [i128; 5]) -> i128 {
    let latest = last.min(window - 1);
    let mut most = 0;
    // Release of a job and the work of those before it.
    let mut open: Vec<(i128, i128)> = (from..=latest).map(|release| (release, 0)).collect();
    while let Some((release, before)) = open.pop() {
        let inside = (release + load.response).min(window) - release.max(0);
        let work = load.one(inside.clamp(0, cap));
        most = most.max(before + work.min(rest));
        open.extend((release + load.period..=latest).map(|next| (next, before + work)));
    }
    most
}

#[test]
fn no_order_of_releases_brings_more_work_into_a_window_and_most_bounds_are_reached() {
    let (mut reached, mut all) = ([0, 0], 0);
    for (costs, period) in [(&[7, 3][..], 5), (&[4], 9), (&[2, 2, 8], 12), (&[9], 4), (&[5, 5], 20)] {
        for response in [9, 13, 20] {
            let load = load(&[costs], Some(period), response);
            for window in [1, 4, 9, 14, 21] {
                for last in [-30, -12, -5, 0, 3, 8, 30] {
                    for (cap, rest) in [(30, FAR), (3, FAR), (6, 2), (30, 3)] {
                        let carried = load.overlapping(window, last, cap, rest);
                        let inside = load.inside(window, last, cap, rest);
                        let tried = |from| tried(&load, [window, last, cap, rest, from]);
                        let (most, most_inside) = (tried(1 - response), tried(0));
                        assert!(
                            carried >= most,
                            "{costs:?} {period} {response} {window} {last} {cap} {rest}"
                        );
                        assert!(inside >= most_inside, "{costs:?} {period} {response} {window} {last} {cap}");
                        reached[0] += i32::from(carried == most);
                        reached[1] += i32::from(inside == most_inside);
                        all += 1;
                    }
                }
            }
        }
    }
    assert!(reached.iter().all(|reached| 10 * reached > 7 * all), "{reached:?} of {all}");
}

#[test]
fn the_last_job_does_no_more_than_the_rest_of_it() {
    let load = load(&[&[6]], Some(10), 10);
    assert_eq!([FAR, 2].map(|rest| load.inside(25, 15, 30, rest)), [12, 6 + 2]);
    // Of the first one 5 are within the window where the last one comes at 15.
    assert_eq!([FAR, 2].map(|rest| load.overlapping(25, 15, 30, rest)), [5 + 6 + 6, 5 + 6 + 2]);
}

#[test]
fn other_jobs_of_a_task_are_counted_one_by_one() {
    let load = load(&[&[6]], Some(10), 25);
    // 15 and 5 of the time of two earlier jobs, 11 and 1 of that of two later ones.
    assert_eq!(load.siblings(21, 30, 94 + 10), (6 + 5 + 6, 1));
    assert_eq!(load.siblings(21, 4, 94 + 20), (4 + 4 + 4 + 1, 0));
    assert_eq!(load.siblings(21, 30, 93), (6 + 5, 6 + 1));
    assert_eq!([93, 94 + 10, 94 + 20].map(|last_key| load.low_siblings(21, last_key)), [2, 1, 0]);
    assert_eq!(load.at_once(), 3);
    let once = self::load(&[&[6]], None, 25);
    assert_eq!((once.siblings(21, 30, 94), once.at_once(), once.rate(9)), ((0, 0), 1, (0, 12)));
}

#[test]
fn nodes_that_hold_lanes_are_the_largest_of_later_keys_of_each_job() {
    let load = load(&[&[9, 1], &[2, 3, 4]], Some(10), 20);
    // Keys 91, 99, 98, 97, 96. Before the release: those above 95 + 1.
    assert_eq!(load.holders(8, 1, 95, -1), [(3, 1), (2, 1), (1, 1)]);
    assert_eq!(load.holders(8, 1, 94, -1), [(4, 1), (3, 1), (2, 1)]);
    assert_eq!(load.holders(2, 1, 94, -1), [(4, 1), (3, 1)]);
    assert_eq!(load.holders(5, 2, 94, -1), [(4, 2), (3, 2), (2, 1)]);
    assert_eq!(load.holders(8, 2, 94, -1), [(4, 2), (3, 2), (2, 2)]);
}
