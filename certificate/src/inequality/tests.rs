use crate::by_hand::{
    ANY, Claims, KEY, certificate, does_not_apply, graph, is_false, is_of, prefix, set, task, verdict,
};
use crate::{Keys, Node, Proof, Rejected, Set, Variant, verify};

/// One lane, and a node of a later key that may just have begun.
fn blocked() -> Set {
    set(&[1], vec![task("job", 20, 1_000, &[1], &[]), task("long", 1_000, 1_000, &[10], &[])])
}

#[test]
fn a_node_that_had_begun_is_counted() {
    assert_eq!(verdict(&blocked(), &[(11, KEY), (11, ANY)]), Ok(()));
    is_false(verdict(&blocked(), &[(10, KEY), (11, ANY)]));
    is_false(verdict(&blocked(), &[(11, KEY), (10, ANY)]));
}

#[test]
fn work_that_jobs_bring_into_the_window_is_counted() {
    let set = set(&[1], vec![task("job", 50, 1_000, &[3], &[]), task("often", 10, 10, &[2], &[])]);
    assert_eq!(verdict(&set, &[(7, ANY), (10, ANY)]), Ok(()));
    // One job of the other overlaps at its end, too; without it 5 would do. 6 is short by half the longest path.
    is_false(verdict(&set, &[(6, ANY), (10, ANY)]));
    is_false(verdict(&set, &[(5, ANY), (10, ANY)]));
}

#[test]
fn later_keys_are_told_apart_by_node_and_not_by_job() {
    // At most 31 of the other are of no later key. Its node of 20 has one, although another of the job may not.
    let other = task("other", 100, 1_000, &[1, 30, 20], &[(0, 1)]);
    let set = set(&[1], vec![task("job", 70, 1_000, &[1], &[]), other]);
    let verdict = |response| {
        let claims: [Claims<'_>; 2] = [&[(&[0], Some((response, KEY)))], &[(&[0, 0, 1], Some((52, ANY)))]];
        verify(&certificate(&set, &claims), &set)
    };
    assert_eq!(verdict(52), Ok(()));
    is_false(verdict(51));
    is_false(verdict(32));
}

#[test]
fn a_job_of_a_later_key_that_began_beside_the_first_node_delays_the_second() {
    // Two lows hold both lanes until 19. A third begins with the first node, which ends at 24, when `high` takes its lane
    // until 30: the response time is 35. What ran at the release alone would make it 33.
    let low = |name: &str| task(name, 9_000, 10_000, &[20], &[]);
    let mut tasks = vec![task("job", 100, 10_000, &[5, 5], &[(0, 1)]), task("high", 60, 10_000, &[6], &[])];
    tasks.extend(["low1", "low2", "low3"].map(low));
    let set = set(&[2], tasks);
    let verdict = |job| verdict(&set, &[(job, KEY), (60, ANY), (200, ANY), (200, ANY), (200, ANY)]);
    assert_eq!(verdict(43), Ok(()));
    is_false(verdict(42));
    is_false(verdict(33));
}

#[test]
fn two_jobs_of_one_task_hold_two_lanes() {
    let tasks = vec![
        task("job", 300, 400, &[1], &[]),
        task("high", 250, 400, &[12], &[]),
        task("late", 1_000, 12, &[20], &[]),
    ];
    let set = set(&[2], tasks);
    assert_eq!(verdict(&set, &[(27, KEY), (32, KEY), (131, KEY)]), Ok(()));
    is_false(verdict(&set, &[(17, KEY), (32, KEY), (131, KEY)]));
}

#[test]
fn other_jobs_of_the_task_count_where_its_deadline_is_beyond_its_period() {
    let of = |period, response| {
        let set = set(&[1], vec![task("job", 30, period, &[6, 6], &[])]);
        verify(&certificate(&set, &[&[(&[0, 1], Some((response, ANY)))]]), &set)
    };
    assert_eq!(of(13, 12), Ok(()));
    // It is more than the lane can do, whatever time it has.
    for response in [12, 20, 30] {
        is_false(of(10, response));
    }
}

#[test]
fn what_a_job_does_beside_its_critical_chain_is_counted() {
    // Longest path 10, shortest 2, 4 beside the longest.
    let job = || task("job", 60, 1_000, &[5, 5, 2, 2], &[(0, 1)]);
    let a = Proof::A0 { keys: Keys::Any, variant: Variant::A };
    let b = Proof::A0 { keys: Keys::Any, variant: Variant::B };
    let of = |lanes, other: &[u64], response, proof: &Proof| {
        let mut tasks = vec![job()];
        let mut claims: Vec<Claims<'_>> = Vec::new();
        let mine = [(&[0, 0, 1, 2][..], Some((response, proof.clone())))];
        let theirs = [(&[0][..], Some((60, ANY)))];
        claims.push(&mine);
        if !other.is_empty() {
            tasks.push(task("other", 1_000, 1_000, other, &[]));
            claims.push(&theirs);
        }
        let set = set(&[lanes], tasks);
        verify(&certificate(&set, &claims), &set)
    };
    // All 4 may fall into so short a wait.
    assert_eq!(of(2, &[], 12, &b), Ok(()));
    is_false(of(2, &[], 11, &b));
    // Of a longer one, the 4 and what a shorter critical chain leaves spread over it.
    assert_eq!(of(1, &[5], 22, &b), Ok(()));
    is_false(of(1, &[5], 21, &b));
    // Others count in as much waiting as the shortest path would have.
    assert_eq!(of(2, &[30], 22, &a), Ok(()));
    is_false(of(2, &[30], 21, &a));
}

#[test]
fn prefix_has_to_hold_in_each_segment_and_beyond_the_last() {
    let verdict =
        |response, segments: &[u64]| verdict(&blocked(), &[(response, prefix(segments)), (11, ANY)]);
    assert_eq!(verdict(11, &[0, 24]), Ok(()));
    assert_eq!(verdict(11, &[0, 7, 24]), Ok(()));
    is_false(verdict(11, &[0, 23]));
    is_false(verdict(11, &[0]));
    // In the segment, and not beyond.
    is_false(verdict(10, &[0, 60]));
    // Too long a segment: the next job of the other is in it.
    is_false(verdict(11, &[0, 3_000]));
    does_not_apply(verdict(11, &[1, 24]), "begin with 0");
    does_not_apply(verdict(11, &[]), "begin with 0");
    does_not_apply(verdict(11, &[0, 24, 24]), "begin with 0");
    does_not_apply(verdict(11, &[0, 24, 12]), "begin with 0");
}

#[test]
fn prefix_is_for_tasks_in_one_cluster_with_deadlines_within_their_periods() {
    let mut set =
        set(&[1, 1], vec![task("job", 20, 1_000, &[1], &[]), task("long", 1_000, 1_000, &[10], &[])]);
    let verdict = |set: &Set| verdict(set, &[(11, prefix(&[0, 24])), (11, ANY)]);
    assert_eq!(verdict(&set), Ok(()));
    set.tasks[1].period_ns = Some(999);
    does_not_apply(verdict(&set), "within the periods");
    set.tasks[1].period_ns = Some(1_000);
    // Another node of it elsewhere.
    set.tasks[1].versions[0].nodes.push(Node { name: "m".to_owned(), cost_ns: 1, cluster: 1 });
    does_not_apply(verdict(&set), "in it alone");
}

#[test]
fn prefix_counts_earlier_jobs_of_the_task_and_no_more_load_than_lanes() {
    let set = set(&[1], vec![task("job", 10, 10, &[6], &[])]);
    assert_eq!(verdict(&set, &[(6, prefix(&[0, 10, 20, 30, 40, 50]))]), Ok(()));
    is_false(verdict(&set, &[(6, prefix(&[0, 11, 20, 30, 40, 50]))]));
    is_false(verdict(&set, &[(6, prefix(&[0, 10, 20, 30, 40, 47]))]));
    let full = crate::by_hand::set(&[1], vec![task("job", 10, 10, &[10], &[])]);
    is_false(verdict(&full, &[(10, prefix(&[0, 1 << 60]))]));
    is_false(verdict(&full, &[(10, prefix(&[0, u64::MAX]))]));
}

#[test]
fn chains_alone_are_the_longest_path_and_others_beside_it() {
    let of = |lanes, period, chain_of: &[usize], response, chains| {
        let set = set(&[lanes], vec![task("job", 30, period, &[4, 4, 3, 2], &[(0, 1)])]);
        let proof = Proof::Paths { chains };
        verify(&certificate(&set, &[&[(chain_of, Some((response, proof)))]]), &set)
    };
    assert_eq!(of(2, 30, &[0, 0, 1, 2], 11, 0), Ok(()));
    is_false(of(2, 30, &[0, 0, 1, 2], 10, 0));
    assert_eq!(of(2, 30, &[0, 0, 1, 2], 10, 1), Ok(()));
    is_false(of(2, 30, &[0, 0, 1, 2], 9, 1));
    assert_eq!(of(3, 30, &[0, 0, 1, 2], 8, 2), Ok(()));
    does_not_apply(of(2, 30, &[0, 0, 1, 2], 11, 2), "chains, and lanes");
    does_not_apply(of(9, 30, &[0, 0, 1, 2], 11, 3), "chains, and lanes");
    does_not_apply(of(2, 30, &[0, 0, 1, 2], 11, usize::MAX), "chains, and lanes");
    does_not_apply(of(4, 30, &[0, 3, 1, 2], 11, 1), "longest path");
    does_not_apply(of(2, 10, &[0, 0, 1, 2], 11, 0), "within its period");
    let both = set(&[4], vec![task("a", 30, 30, &[4], &[]), task("b", 30, 30, &[4], &[])]);
    does_not_apply(verdict(&both, &[(4, Proof::Paths { chains: 0 }), (30, ANY)]), "no other task");
}

#[test]
fn several_clusters_have_a_wait_each() {
    let mut job = task("job", 60, 100, &[], &[]);
    job.versions = vec![graph(&[(2, 0), (3, 1), (4, 0)], &[(0, 1), (1, 2)])];
    let mut set = set(&[1, 1, 1], vec![job, task("long", 1_000, 1_000, &[10], &[])]);
    let verdict = |set: &Set, response, keys, waits: &[u64]| {
        verdict(set, &[(response, Proof::Several { keys, waits_ns: waits.to_vec() }), (40, ANY)])
    };
    // In the first cluster it may meet all of `long` once; by keys it could at each of its two entries.
    assert_eq!(verdict(&set, 19, Keys::Key, &[10, 0, 0]), Ok(()));
    is_false(verdict(&set, 18, Keys::Key, &[9, 0, 0]));
    is_false(verdict(&set, 18, Keys::Any, &[8, 1, 0]));
    does_not_apply(verdict(&set, 20, Keys::Key, &[10, 0, 0]), "make up");
    does_not_apply(verdict(&set, 20, Keys::Key, &[10, 0, 1]), "without a node");
    does_not_apply(verdict(&set, 19, Keys::Key, &[10, 0]), "each cluster");
    does_not_apply(verdict(&set, 19, Keys::Key, &[10, u64::MAX, u64::MAX]), "make up");
    does_not_apply(crate::by_hand::verdict(&set, &[(19, KEY), (40, ANY)]), "one cluster");
    set.tasks[0].period_ns = Some(59);
    does_not_apply(verdict(&set, 19, Keys::Key, &[10, 0, 0]), "within the period");
}

#[test]
fn each_entry_into_a_cluster_may_meet_a_node_of_a_later_key() {
    let mut job = task("job", 60, 1_000, &[], &[]);
    job.versions = vec![graph(&[(2, 0), (3, 1), (4, 0)], &[(0, 1), (1, 2)])];
    let low = |name: &str| task(name, 1_000, 1_000, &[10], &[]);
    let set = set(&[1, 1], vec![job, low("low1"), low("low2"), low("low3")]);
    let of = |response, wait| {
        let several = Proof::Several { keys: Keys::Key, waits_ns: vec![wait, 0] };
        verdict(&set, &[(response, several), (100, ANY), (100, ANY), (100, ANY)])
    };
    assert_eq!(of(29, 20), Ok(()));
    is_false(of(28, 19));
    is_false(of(19, 10));
}

#[test]
fn every_graph_of_a_task_counts_against_others() {
    let mut changes = task("changes", 100, 1_000, &[2], &[]);
    changes.versions.push(graph(&[(9, 0)], &[]));
    let set = set(&[1], vec![task("job", 50, 1_000, &[1], &[]), changes]);
    let of = |job| {
        let claims: [Claims<'_>; 2] =
            [&[(&[0], Some((job, ANY)))], &[(&[0], Some((3, ANY))), (&[0], Some((10, ANY)))]];
        verify(&certificate(&set, &claims), &set)
    };
    assert_eq!(of(10), Ok(()));
    is_false(of(9));
}

#[test]
fn an_unproved_task_works_until_its_largest_node_ends_after_its_deadline() {
    // Within its deadline it could not reach into the window a second time.
    let mut set = set(&[1], vec![task("job", 90, 1_000, &[1], &[]), task("cut", 60, 100, &[40], &[])]);
    let of = |set: &Set, job, cut| {
        let claims: [Claims<'_>; 2] = [&[(&[0], Some((job, ANY)))], &[(&[0], cut)]];
        verify(&certificate(set, &claims), set)
    };
    assert_eq!(of(&set, 41, Some((41, ANY))), Ok(()));
    is_false(of(&set, 41, None));
    assert_eq!(of(&set, 85, None), Ok(()));
    // Its jobs have to have room, too: 1 + 1 where it is cut.
    set.most_jobs = 3;
    assert_eq!(of(&set, 85, None), Ok(()));
    set.most_jobs = 2;
    assert_eq!(of(&set, 41, Some((41, ANY))), Ok(()));
    is_of(of(&set, 85, None), "jobs at once");
}

#[test]
fn nodes_within_a_cluster_of_several_may_meet_later_keys_on_all_lanes_but_one() {
    let mut job = task("job", 60, 1_000, &[], &[]);
    job.versions = vec![graph(&[(2, 0), (3, 0), (1, 1)], &[(0, 1), (1, 2)])];
    let low = |name: &str| task(name, 1_000, 1_000, &[10], &[]);
    let set = set(&[2, 1], vec![job, low("low1"), low("low2"), low("low3"), low("low4")]);
    let of = |response, wait| {
        let several = Proof::Several { keys: Keys::Key, waits_ns: vec![wait, 0] };
        verdict(&set, &[(response, several), (100, ANY), (100, ANY), (100, ANY), (100, ANY)])
    };
    assert_eq!(of(21, 15), Ok(()));
    is_false(of(20, 14));
}

#[test]
fn a_job_in_several_clusters_waits_for_its_own_nodes_too() {
    let mut job = task("job", 60, 1_000, &[], &[]);
    job.versions = vec![graph(&[(2, 0), (6, 0), (1, 1)], &[(0, 2)])];
    let set = set(&[1, 1], vec![job]);
    let of = |response, wait| {
        let several = Proof::Several { keys: Keys::Any, waits_ns: vec![wait, 0] };
        verify(&certificate(&set, &[&[(&[0, 1, 0], Some((response, several)))]]), &set)
    };
    assert_eq!(of(12, 6), Ok(()));
    is_false(of(11, 5));
}

#[test]
fn later_jobs_of_the_task_itself_delay_its_chain_where_deadlines_exceed_periods() {
    let high = |name: &str| task(name, 30, 1_000, &[30], &[]);
    let set = set(&[2], vec![task("job", 100, 12, &[5, 5], &[(0, 1)]), high("high1"), high("high2")]);
    let of = |response| {
        let claims: [Claims<'_>; 3] = [&[(&[0, 0], Some((response, KEY)))], &[(&[0], None)], &[(&[0], None)]];
        verify(&certificate(&set, &claims), &set)
    };
    assert_eq!(of(64), Ok(()));
    is_false(of(63));
}

/// Segments of one nanosecond.
fn each(end: u64, keys: Keys) -> Proof {
    Proof::Prefix { keys, variant: Variant::B, segments_ns: (0..=end).collect() }
}

#[test]
fn prefix_counts_what_one_task_less_than_there_are_lanes_carries_in() {
    let often = |name: &str| task(name, 11, 20, &[8], &[]);
    let set = set(&[2], vec![task("job", 40, 40, &[1], &[]), often("a"), often("b"), often("c")]);
    let of = |response| {
        let claims: [Claims<'_>; 4] = [
            &[(&[0], Some((response, each(150, Keys::Any))))],
            &[(&[0], None)],
            &[(&[0], None)],
            &[(&[0], None)],
        ];
        verify(&certificate(&set, &claims), &set)
    };
    assert_eq!(of(17), Ok(()));
    is_false(of(16));
}

#[test]
fn prefix_counts_what_the_task_itself_carries_in() {
    let late = |name: &str| task(name, 19, 1_000, &[3], &[]);
    let wide = task("job", 15, 15, &[5, 5, 5, 5], &[]);
    let set = set(&[2], vec![wide, late("a"), late("b"), late("c")]);
    let claims: [Claims<'_>; 4] = [
        &[(&[0, 1, 2, 3], Some((15, each(200, Keys::Key))))],
        &[(&[0], None)],
        &[(&[0], None)],
        &[(&[0], None)],
    ];
    // Six before the release it is 12 of an earlier job, and 9 of the others that are of no later key from there.
    let verdict = verify(&certificate(&set, &claims), &set);
    let at_six = Rejected::Inequality {
        place: "task job, version 0, a segment of PREFIX".to_owned(),
        done: 34,
        there_is: 36,
    };
    assert_eq!(verdict, Err(at_six));
}

#[test]
fn prefix_counts_later_keys_at_each_node_and_at_the_begin_of_its_windows() {
    let low = |name: &str| task(name, 9_000, 10_000, &[20], &[]);
    let mut tasks = vec![task("job", 100, 10_000, &[5, 5], &[(0, 1)]), task("high", 60, 10_000, &[6], &[])];
    tasks.extend(["low1", "low2", "low3"].map(low));
    let set = set(&[2], tasks);
    let verdict =
        |job, end| verdict(&set, &[(job, prefix(&[0, end])), (60, ANY), (200, ANY), (200, ANY), (200, ANY)]);
    assert_eq!(verdict(43, 75), Ok(()));
    is_false(verdict(43, 74));
    is_false(verdict(42, 200));
    is_false(verdict(33, 200));
    // Where a window begins, the key is a later one; where the segment ends, it is no more, and the job is not yet inside.
    is_false(crate::by_hand::verdict(&blocked(), &[(10, prefix(&[0, 971])), (11, ANY)]));
}

#[test]
fn the_largest_numbers_that_there_can_be_neither_overflow_nor_hang() {
    let most = 1 << 42;
    let low = |name: &str| task(name, most, 1 << 41, &[most / 2, most / 2], &[(0, 1)]);
    let set = set(&[u32::MAX], vec![low("a"), low("b"), low("c")]);
    for keys in [Keys::Any, Keys::Key] {
        let any = Proof::A0 { keys, variant: Variant::B };
        let claims = [(most, any.clone()), (most, any.clone()), (most, any)];
        assert_eq!(verdict(&set, &claims), Ok(()));
    }
    let alone = crate::by_hand::set(&[u32::MAX], vec![task("job", most, u64::MAX, &[most], &[])]);
    assert_eq!(verdict(&alone, &[(most, prefix(&[0, u64::MAX - (1 << 43)]))]), Ok(()));
    let mut constrained = set.clone();
    constrained.tasks.iter_mut().for_each(|task| task.period_ns = Some(u64::MAX));
    for segments in [vec![0], vec![0, u64::MAX], vec![0, 1, u64::MAX - 1, u64::MAX]] {
        let claims = [(most, prefix(&segments)), (most, KEY), (most, KEY)];
        let _ = verdict(&constrained, &claims);
    }
}
