use crate::check::validate;
use crate::fixtures::{MS, at, every, lines, node, once, part, sensed, shed_lines, stage, workload, written};
use crate::oracle::{Policy, Reason, simulate};
use red_workload::model::{Arrival, Node, Part, Pool, Task, Work, Workload};

fn flat(count: usize, cost_ms: u64) -> Vec<Node> {
    (0..count).map(|index| node(&format!("n{index}"), cost_ms, &[])).collect()
}

fn sheds(workload: &Workload, policy: Policy, horizon_ms: u64) -> Vec<String> {
    shed_lines(&simulate(workload, policy, horizon_ms * MS))
}

#[test]
fn a_job_that_cannot_end_in_time_is_aborted_at_the_next_event() {
    let tasks = vec![once("a", 12, vec![node("n", 10, &[])]), once("b", 12, vec![node("n", 10, &[])])];
    let outcome = simulate(&workload(1, tasks), Policy::Redrt, 100 * MS);
    // Nobody else is late: b stays at 0.
    assert_eq!(shed_lines(&outcome), ["b/0 10 hopeless"]);
    assert_eq!(lines(&outcome), ["a/0/n 0 0..10"]);
    assert_eq!((outcome.tasks[0].on_time, outcome.tasks[1].missed), (1, 1));
}

#[test]
fn a_job_that_may_just_end_in_time_runs() {
    let tasks = vec![once("a", 10, vec![node("n", 10, &[])]), once("b", 20, vec![node("n", 10, &[])])];
    assert!(sheds(&workload(1, tasks), Policy::Redrt, 100).is_empty());
}

#[test]
fn the_least_urgent_job_goes_until_the_queue_is_short() {
    let tasks = vec![once("a", 100, flat(6, 50)), once("b", 1000, flat(6, 50))];
    let outcome = simulate(&workload(1, tasks), Policy::Red, 400 * MS);
    // Queues of 12, 11, 11 at 0, 5, 10. Dropping b leaves 5, and later ticks see U = 1: a goes at the third.
    assert_eq!(shed_lines(&outcome), ["b/0 10 urgency", "a/0 25 urgency"]);
    // What runs is not stopped.
    assert_eq!(lines(&outcome), ["a/0/n0 0 0..50"]);
}

#[test]
fn the_others_never_shed_but_what_finds_no_room() {
    let tasks = vec![every(once("a", 10, vec![node("n", 1000, &[])]), 1)];
    for policy in [Policy::Edf, Policy::RedFg, Policy::RedIda] {
        let outcome = simulate(&workload(1, tasks.clone()), policy, 66 * MS);
        assert_eq!(shed_lines(&outcome), ["a/64 64 full", "a/65 65 full"]);
        assert_eq!((outcome.tasks[0].released, outcome.tasks[0].missed), (66, 58));
    }
}

#[test]
fn a_floor_keeps_jobs_of_any_window() {
    let floor = |floor| Task { floor, ..every(once("a", 1000, flat(9, 100)), 20) };
    let at_most_one_of_two = sheds(&workload(1, vec![floor(Some((1, 2)))]), Policy::Red, 60);
    let none = sheds(&workload(1, vec![floor(Some((2, 2)))]), Policy::Red, 60);
    let all = sheds(&workload(1, vec![floor(None)]), Policy::Red, 60);
    assert!(none.is_empty());
    // Without a floor each third tick under load drops whatever is there.
    assert_eq!(all[..2], ["a/0 10 urgency", "a/1 25 urgency"]);
    // With it the neighbours of a dropped job stay.
    assert_eq!(at_most_one_of_two, ["a/0 10 urgency", "a/2 40 urgency"]);
}

#[test]
fn jobs_that_were_late_use_up_what_a_floor_can_spare() {
    // Job 0 ends at 20. From 30 on twelve nodes of w wait, for the third tick at 40, and w is spared by its floor.
    let drops = |due_ms: u64| {
        let a = Task { floor: Some((1, 2)), ..every(once("a", due_ms, flat(3, 10)), 30) };
        let w = Task { floor: Some((1, 1)), ..at(once("w", 1000, flat(12, 50)), 30) };
        sheds(&workload(2, vec![a, w]), Policy::Red, 55)
    };
    assert_eq!(drops(20), ["a/1 40 urgency"]);
    assert!(drops(19).is_empty());
}

#[test]
fn a_long_queue_without_a_late_job_sheds_nothing_under_redrt() {
    assert!(sheds(&workload(1, vec![once("wide", 1000, flat(40, 20))]), Policy::Redrt, 900).is_empty());
}

fn chain(costs_ms: &[u64]) -> Vec<Node> {
    let name = |index: usize| format!("n{index}");
    let after = |index: usize| index.checked_sub(1).map(name);
    let nodes = costs_ms.iter().enumerate();
    nodes
        .map(|(at, &cost)| node(&name(at), cost, &after(at).iter().map(String::as_str).collect::<Vec<_>>()))
        .collect()
}

#[test]
fn the_job_of_less_value_goes_before_it_makes_another_late() {
    // The chains would take turns, low until 50 and high until 60. Low goes three times. From 150 on it has lost
    // three, and goes a fourth time. From 200 on it waits for high: now it is late itself, costs nobody anything, and stays until
    // that is known.
    let of = |name: &str, value: u32, floor: Option<(u32, u32)>| Task {
        value,
        floor,
        ..every(once(name, 50, chain(&[10, 10, 10])), 50)
    };
    let both = workload(1, vec![of("low", 1, None), of("high", 10, None)]);
    assert_eq!(
        sheds(&both, Policy::Redrt, 300),
        [
            "low/0 0 overload",
            "low/1 50 overload",
            "low/2 100 overload",
            "low/3 150 overload",
            "low/4 230 hopeless",
            "low/5 280 hopeless"
        ]
    );
    // The values of the others do not matter where a floor cannot spare a job. Nobody below high is in its way, it
    // harms nobody else, and stays behind low until it is known to be late. The next one would make low late.
    let floored = workload(1, vec![of("low", 1, Some((1, 1))), of("high", 10, None)]);
    assert_eq!(sheds(&floored, Policy::Redrt, 51), ["high/0 30 hopeless", "high/1 50 overload"]);
    // One node each, in the order of the keys 13 and 15.
    let single = |name: &str, due_ms: u64, value: u32| Task {
        value,
        ..every(once(name, due_ms, vec![node("n", 25, &[])]), 40)
    };
    let both = workload(1, vec![single("low", 38, 1), single("high", 40, 1000)]);
    assert_eq!(sheds(&both, Policy::Redrt, 80), ["low/0 0 overload", "low/1 40 overload"]);
}

#[test]
fn as_many_jobs_go_as_the_lanes_cannot_carry() {
    // 40 ms of work come every 30 ms and have 60: those of 0 end by 40, of 30 by 80, of 60 by 120, all in time, and
    // of 90 by 160. Without the last of low there is 20 ms less: those of 120 end by 180, in time, and of 150 by 220. So
    // every other job of low goes, and there is as much work as time.
    let of = |name: &str, value: u32| Task { value, ..every(once(name, 60, chain(&[4; 5])), 30) };
    for tasks in [vec![of("high", 100), of("low", 1)], vec![of("low", 1), of("high", 100)]] {
        let outcome = simulate(&workload(1, tasks), Policy::Redrt, 240 * MS);
        assert_eq!(shed_lines(&outcome), ["low/3 90 overload", "low/5 150 overload", "low/7 210 overload"]);
    }
}

/// 40 ms of work.
fn pipeline() -> Vec<Node> {
    vec![
        node("a", 1, &[]),
        node("b", 9, &["a"]),
        node("c", 12, &["a"]),
        node("d", 5, &["b"]),
        node("e", 4, &["b"]),
        node("g", 3, &["b"]),
        node("p", 6, &["c", "d", "e", "g"]),
    ]
}

#[test]
fn two_lanes_do_as_much_as_they_can() {
    // In 20 s they carry 1,000 jobs, of which the last is on its way.
    for floor in [None, Some((2, 3))] {
        for period_ms in [15, 17, 19] {
            let t = Task { floor, ..every(once("t", 66, pipeline()), period_ms) };
            let outcome = simulate(&workload(2, vec![t]), Policy::Redrt, 20_000 * MS);
            assert_eq!(outcome.tasks[0].on_time, 999, "every {period_ms} ms, floor {floor:?}");
        }
    }
}

#[test]
fn a_late_job_that_costs_nobody_anything_stays_until_it_is_hopeless() {
    let hold = Task { value: 2, ..once("hold", 30, vec![node("n", 25, &[])]) };
    let t = once("t", 34, vec![node("n", 10, &[])]);
    assert_eq!(sheds(&workload(1, vec![hold, t]), Policy::Redrt, 100), ["t/0 25 hopeless"]);
}

#[test]
fn a_late_job_that_would_make_the_next_one_late_goes_before_it_starts() {
    // 40 ms of work come every 30 ms and have 66. Job 3 would start at 120 and end at 160, due at 156; job 4 comes at 120 and has
    // to start at 146.
    let t = Task { floor: Some((2, 3)), ..every(once("t", 66, pipeline()), 30) };
    let outcome = simulate(&workload(1, vec![t]), Policy::Redrt, 360 * MS);
    assert_eq!(shed_lines(&outcome), ["t/3 90 overload", "t/7 210 overload", "t/11 330 overload"]);
    assert_eq!((outcome.tasks[0].on_time, outcome.busy_ns[0]), (8, 360 * MS));
}

#[test]
fn equal_tasks_take_turns() {
    // One of two has its place. At 40 b lost its last job and a did not, so that b goes first; at 80 both lost one.
    let of = |name: &str| every(once(name, 40, vec![node("n", 25, &[])]), 40);
    let both = workload(1, vec![of("a"), of("b")]);
    let expected = ["b/0 25 hopeless", "a/1 65 hopeless", "b/2 105 hopeless", "a/3 145 hopeless"];
    assert_eq!(sheds(&both, Policy::Redrt, 160), expected);
}

#[test]
fn who_left_for_nothing_comes_back() {
    // The keys are 4, 4 and 5. Without a, c ends at 30, without b at 22.
    let of = |name: &str, value: u32, due_ms: u64, cost_ms: u64| Task {
        value,
        ..once(name, due_ms, vec![node("n", cost_ms, &[])])
    };
    let three = workload(1, vec![of("a", 1, 6, 2), of("b", 2, 14, 10), of("c", 3, 25, 20)]);
    let outcome = simulate(&three, Policy::Redrt, 100 * MS);
    assert_eq!(shed_lines(&outcome), ["b/0 0 overload"]);
    assert_eq!(lines(&outcome), ["a/0/n 0 0..2", "c/0/n 0 2..22"]);
}

/// A task of one node, released once.
fn single(name: &str, value: u32, at_ms: u64, cost_ms: u64, due_ms: u64) -> Task {
    Task { value, ..at(once(name, due_ms - at_ms, vec![node("n", cost_ms, &[])]), at_ms) }
}

#[test]
fn nobody_goes_for_a_job_that_would_be_late_all_the_same() {
    // The keys are 1, 2 and 5. Without l, x would start at 10 and end at 20.
    let of = |due_ms: u64| {
        let three = [single("l", 1, 0, 2, 3), single("h", 3, 0, 10, 12), single("x", 2, 0, 10, due_ms)];
        sheds(&workload(1, three.to_vec()), Policy::Redrt, 100)
    };
    assert_eq!(of(15), ["x/0 12 hopeless"]);
    assert_eq!(of(20), ["l/0 0 overload"]);
}

#[test]
fn of_those_in_the_way_as_many_go_as_have_to() {
    // The keys are 0, 0 and 2 or more; x ends at 20, 15 or 10.
    let of = |due_ms: u64| {
        let three = [single("l", 1, 0, 5, 5), single("m", 1, 0, 5, 5), single("x", 2, 0, 10, due_ms)];
        sheds(&workload(1, three.to_vec()), Policy::Redrt, 100)
    };
    assert_eq!(of(12), ["l/0 0 overload", "m/0 0 overload"]);
    assert_eq!(of(16), ["m/0 0 overload"]);
    assert_eq!(of(20), ["m/0 5 hopeless"]);
}

#[test]
fn a_late_job_goes_for_another_that_may_be_in_time() {
    // At 5 the lane is busy until 10. x would end at 20, y at 30; without x, y ends at 20.
    let of = |x_value: u32, y_due_ms: u64| {
        let r = single("r", 9, 0, 10, 10);
        let three = [r, single("x", x_value, 5, 10, 17), single("y", 5, 5, 10, y_due_ms)];
        sheds(&workload(1, three.to_vec()), Policy::Redrt, 100)
    };
    // So it is where x is of more value: it is late in any case.
    for x_value in [1, 9] {
        assert_eq!(of(x_value, 29), ["x/0 5 overload"]);
        assert_eq!(of(x_value, 30), ["x/0 10 hopeless"]);
    }
}

#[test]
fn one_that_is_late_goes_instead_of_the_least() {
    // The cpu is busy until 12, so that second ends at 26. On the gpu the keys are 6, 7 or 8, and 8: x ends at 19, and
    // in time without either of the others. The least is most, which has most work and ends at 25. The npu is filled, so
    // that x could not be whole, and does not go first by its deadline.
    let of = |second_value: u32, second_due_ms: u64| {
        let on = |name: &str, after: &[&str], pool: usize, cost_ms: u64| {
            written(name, after, Work::Plain(Part { pool, ..part(cost_ms) }))
        };
        let task = |name: &str, value: u32, due_ms: u64, nodes: Vec<Node>| Task {
            value,
            ..once(name, due_ms, nodes)
        };
        let tasks = vec![
            task("busy", 9, 12, vec![on("n", &[], 1, 12)]),
            task("full", 9, 12, vec![on("n", &[], 3, 12)]),
            task("most", 1, 31, vec![on("a", &[], 0, 5), on("b", &["a"], 2, 20)]),
            task("second", second_value, second_due_ms, vec![on("a", &[], 0, 4), on("b", &["a"], 1, 14)]),
            task("x", 3, 18, vec![on("n", &[], 0, 10), on("m", &[], 3, 1)]),
        ];
        let mut four = workload(1, tasks);
        for name in ["cpu", "dsp", "npu"] {
            four.pools.push(Pool { name: name.to_owned(), ..four.pools[0].clone() });
        }
        sheds(&four, Policy::Redrt, 100)
    };
    assert_eq!(of(1, 25), ["second/0 0 overload"]);
    // It is in time, or of another rank.
    assert_eq!(of(1, 26), ["most/0 0 overload"]);
    assert_eq!(of(2, 25), ["most/0 0 overload", "second/0 10 hopeless"]);
}

#[test]
fn a_chain_of_a_load_beyond_two_lanes_loses_nothing_that_it_began() {
    // 40 ms of work come every 18.181 ms, and two lanes carry 185 of them in 3.7 s.
    let t = once("t", 66, chain(&[2, 9, 3, 4, 5, 14, 3]));
    let t = Task { arrival: Arrival::Periodic { period_ns: 18_181_000 }, ..t };
    let outcome = simulate(&workload(2, vec![t]), Policy::Redrt, 3700 * MS);
    assert_eq!((outcome.tasks[0].released, outcome.tasks[0].on_time), (204, 184));
    assert!(outcome.sheds.iter().all(|shed| shed.reason == Reason::Overload));
}

#[test]
fn who_left_comes_back_where_that_is_of_no_use() {
    // Two lanes are busy until 6. Then both of l run until 16, and both nodes of x until 26: late by 2. Without l they
    // end at 16. So l/1 goes, but then the floor cannot spare l/0, which is not below x any more, and x is late.
    let r = |name: &str| once(name, 6, vec![node("n", 6, &[])]);
    let l = |floor| Task { floor, ..every(once("l", 17, vec![node("n", 10, &[])]), 5) };
    let x = Task { value: 2, ..at(once("x", 19, flat(2, 10)), 5) };
    let of = |floor| sheds(&workload(2, vec![r("r"), r("s"), l(floor), x.clone()]), Policy::Redrt, 10);
    assert!(of(Some((1, 2))).is_empty());
    assert_eq!(of(None), ["l/0 5 overload", "l/1 5 overload"]);
}

#[test]
fn who_takes_lanes_elsewhere_is_not_in_the_way() {
    let of = |name: &str, value: u32, pool: usize| {
        let there = written("n", &[], Work::Plain(Part { pool, ..part(10) }));
        Task { value, ..once(name, 15, vec![there]) }
    };
    let mut two = workload(1, vec![of("a", 0, 1), of("b", 1, 0), of("c", 2, 0)]);
    two.pools.push(Pool { name: "cpu".to_owned(), ..two.pools[0].clone() });
    assert_eq!(sheds(&two, Policy::Redrt, 100), ["b/0 0 overload"]);
}

#[test]
fn a_look_that_lets_many_go_is_followed_by_another() {
    // Four of 24 jobs have time. 16 leave in one look and three in the next; the last is in nobody's way.
    let names: Vec<String> = (0..24).map(|index| format!("t{index:02}")).collect();
    let tasks = names.iter().map(|name| once(name, 40, vec![node("n", 10, &[])])).collect();
    let mut expected: Vec<String> = names[4..23].iter().map(|name| format!("{name}/0 0 overload")).collect();
    expected.push("t23/0 40 hopeless".to_owned());
    assert_eq!(sheds(&workload(1, tasks), Policy::Redrt, 100), expected);
}

#[test]
fn a_release_of_higher_rank_takes_the_place_of_the_least() {
    let a = every(once("a", 200_000, vec![node("n", 1000, &[])]), 1);
    let full = |value: u32, policy: Policy| {
        let b = Task { value, ..at(once("b", 2000, vec![node("n", 10, &[])]), 64) };
        let both = workload(1, vec![a.clone(), b]);
        let outcome = simulate(&both, policy, 65 * MS);
        assert_eq!(validate(&both, policy, 65 * MS, &outcome.rows, &outcome.sheds), Ok(()));
        shed_lines(&outcome)
    };
    // Of the 64 of a the last one that came goes; job 64 has the same rank as they.
    assert_eq!(full(2, Policy::Redrt), ["a/63 64 full", "a/64 64 full"]);
    // An equal that has none takes a place of the one that has all, and one of less value none.
    assert_eq!(full(1, Policy::Redrt), ["a/63 64 full", "a/64 64 full"]);
    assert_eq!(full(0, Policy::Redrt), ["a/64 64 full", "b/0 64 full"]);
    assert_eq!(full(2, Policy::Edf), ["a/64 64 full", "b/0 64 full"]);
}

#[test]
fn a_result_of_the_replaced_job_goes_before_the_new_one_comes() {
    // The encoder of low ends at 1, hold runs until 101, and at 64 new takes the place of low.
    let perceive = |name: &str, value: u32, at_ms: u64| Task {
        value,
        ..at(once(name, 1000, vec![stage("see", 1, &[("dec", 10)], &[])]), at_ms)
    };
    let rows_of_new = |third: bool| {
        let mut tasks = vec![
            perceive("low", 1, 0),
            perceive("new", 3, 64),
            Task { value: 3, ..at(once("hold", 500, vec![node("n", 100, &[])]), 1) },
        ];
        if third {
            tasks.push(perceive("third", 3, 1));
        }
        let fill = Task { value: 2, ..every(once("fill", 9000, vec![node("n", 1, &[])]), 1) };
        tasks.push(at(fill, if third { 3 } else { 2 }));
        let full = sensed(workload(1, tasks), 1000);
        let outcome = simulate(&full, Policy::Redrt, 110 * MS);
        assert_eq!(validate(&full, Policy::Redrt, 110 * MS, &outcome.rows, &outcome.sheds), Ok(()));
        assert!(shed_lines(&outcome).contains(&"low/0 64 full".to_owned()));
        let mut rows = lines(&outcome);
        rows.retain(|row| row.starts_with("new"));
        rows
    };
    assert_eq!(rows_of_new(false)[0], "new/0/see.encoder 0 101..102");
    assert_eq!(rows_of_new(true)[0], "new/0/see.encoder - 64..64");
}

#[test]
fn a_full_table_starves_nobody_of_higher_value() {
    let spin = |name: &str, cost_us: u64| {
        written(name, &[], Work::Plain(Part { wcet_ns: cost_us * 1000, ..part(0) }))
    };
    let imu = every(once("imu", 200, vec![spin("filter", 1500)]), 1);
    let brake =
        Task { value: 1000, floor: Some((1, 1)), ..every(once("brake", 20, vec![spin("act", 500)]), 20) };
    let both = workload(1, vec![imu, brake]);
    let outcome = simulate(&both, Policy::Redrt, 1000 * MS);
    assert_eq!(validate(&both, Policy::Redrt, 1000 * MS, &outcome.rows, &outcome.sheds), Ok(()));
    assert_eq!((outcome.tasks[1].released, outcome.tasks[1].on_time), (50, 50));
    assert!(outcome.sheds.iter().any(|shed| shed.at_ns.is_multiple_of(20 * MS)));
    assert!(outcome.sheds.iter().all(|shed| shed.reason == Reason::Full && shed.task == "imu"));
}
