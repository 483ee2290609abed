//! Rows 12 to 22: numbers and time.

use crate::alone::alone;
use crate::apart::apart;
use crate::process::file;
use crate::redrt::{run, summary, workload};
use crate::refusal::refused;
use crate::rights::{need_root, not_run};
use crate::virtual_time::{MS, Small, at, chain, cost, drain, due, one_task, poll, runs_through};
use red_core::{
    AddTaskError, Admission, Caps, CommitError, Config, Contention, Dag, DeadlineRule, Duration, Instant,
    Levels, Node, NodeError, NodeId, Outcome, PoolError, ReleaseError, Scheduler, SubDeadlines, TaskId, Wcet,
    shares,
};
use red_rt::clock::suspended_ns;
use red_tests::rng::Rng;
use red_traces::RULES;

const D: u64 = 100 * MS;

fn assigned(dag: &Dag<Small>, rule: DeadlineRule) -> Vec<i64> {
    let due = SubDeadlines::assign(&Levels::of(dag), rule, Duration::from_nanos(D), &[1]);
    dag.nodes().map(|node| due.sub_deadline(node)).collect()
}

#[test]
fn row_12_a_cost_of_zero_is_legal_for_one_node_and_for_all() {
    let none = chain::<Small>(&[0, 0, 0, 0]);
    // One weight a level; and every node of a path without a cost is due at the end.
    let quarters = [1, 2, 3, 4].map(|quarter| (quarter * D / 4) as i64);
    assert_eq!(assigned(&none, DeadlineRule::LevelSum), quarters);
    assert_eq!(assigned(&none, DeadlineRule::LevelGraham), quarters);
    assert_eq!(assigned(&none, DeadlineRule::PathProportional), [D as i64; 4]);
    let one = chain::<Small>(&[1, 0, 3]);
    assert_eq!(assigned(&one, DeadlineRule::LevelSum), [25, 25, 100].map(|part| part * (D / 100) as i64));
    for dag in [none, one] {
        for config in [Config::EDF, Config::RED_FG, Config::RED_IDA, Config::RED, Config::REDRT] {
            let (mut scheduler, task) = one_task(config, &dag, due(100));
            assert_eq!(runs_through(&mut scheduler, task, at(0)).len(), dag.len());
        }
    }
}

#[test]
fn row_13_costs_and_deadlines_at_the_integer_maximum_are_refused_before_a_sum_wraps() {
    let endless = Node::new(Wcet::from_nanos(u64::MAX));
    let mut dag = Dag::<Small>::new();
    assert_eq!(dag.add_node(endless.atomic(Contention::from_nanos(1))), Err(NodeError::WorkOverflow));
    let only = dag.add_node(endless).expect("one cost fits 64 bits");
    assert_eq!(dag.add_node(Node::new(Wcet::from_nanos(1))), Err(NodeError::WorkOverflow));
    assert_eq!((dag.len(), dag.work()), (1, u64::MAX));
    for rule in RULES {
        let ends = assigned(&dag, rule);
        assert!(ends[0] <= D as i64, "{rule:?}: {ends:?}");
    }
    let mut scheduler = Scheduler::<Small>::new(Config::REDRT);
    for ns in [(1 << 62) + 1, u64::MAX] {
        let timing = red_core::Timing::new(Duration::from_nanos(ns));
        assert_eq!(scheduler.add_task(&dag, timing), Err(AddTaskError::Deadline));
    }
    // The largest of both is taken, and says that it does not fit.
    let longest = red_core::Timing::new(Duration::from_nanos(1 << 62));
    let task = scheduler.add_task(&dag, longest).expect("it is in range");
    let proof = scheduler.certificate(task).expect("it is admitted");
    assert!(!proof.fits() && proof.critical_path.as_nanos() == u64::MAX, "{proof:?}");
    assert!(dag.remove_node(only));
    assert_eq!(dag.work(), 0);
    // In a file the sum is refused with its place.
    let most = "9223372036854775807ns";
    let text = task_of(&format!(
        "name = 'a', wcet = '{most}' }}, {{ name = 'b', wcet = '{most}' }}, {{ name = 'c', wcet = '2ns'"
    ));
    refuses("row-13.toml", &text, &["row-13.toml:"]);
}

#[test]
fn row_14_a_deadline_of_zero_is_refused_and_one_below_the_critical_path_does_not_fit() {
    let dag = chain::<Small>(&[6, 6]);
    let enforcing = Config { admission: Admission::Enforce, ..Config::REDRT };
    let mut scheduler = Scheduler::<Small>::new(enforcing);
    assert_eq!(scheduler.add_task(&dag, due(0)), Err(AddTaskError::Deadline));
    assert_eq!(scheduler.add_task(&dag, due(11)), Err(AddTaskError::Unschedulable));
    let task = scheduler.add_task(&dag, due(12)).expect("it just fits");
    let mut edit = scheduler.edit(task).expect("it is admitted");
    edit.add_node(cost(13)).expect("there is room");
    assert_eq!(scheduler.commit(&edit, at(0)), Err(CommitError::Unschedulable));
    runs_through(&mut scheduler, task, at(1));
    // Reporting instead of enforcing: admitted with the flag.
    let (scheduler, task) = one_task(Config::REDRT, &dag, due(11));
    let proof = scheduler.certificate(task).expect("it is admitted");
    assert!(!proof.fits() && proof.margin().as_nanos() == -(MS as i64), "{proof:?}");
}

#[test]
fn row_15_a_release_whose_deadline_lies_beyond_64_bits_is_refused() {
    let (mut scheduler, task) = one_task::<Small>(Config::REDRT, &chain(&[1]), due(1));
    let last = Instant::from_nanos(i64::MAX as u64 - MS);
    for late in [last.saturating_add(Duration::from_nanos(1)), Instant::MAX] {
        let before = format!("{scheduler:?}");
        assert_eq!(scheduler.release_at(task, late, None, at(0)), Err(ReleaseError::Overflow));
        assert_eq!(format!("{scheduler:?}"), before);
    }
    runs_through(&mut scheduler, task, at(0));
    assert!(scheduler.release_at(task, last, None, at(5)).is_ok(), "the last one that can be written");
}

/// A workload of one node that says `words` of itself.
fn task_of(words: &str) -> String {
    format!(
        "pool = [{{ name = 'p', lanes = 1 }}]\n[[task]]\nname = 't'\nperiod = '10ms'\ndeadline = '10ms'\n\
         node = [{{ {words} }}]\n"
    )
}

/// `plan` refuses the file with these words.
fn refuses(name: &str, text: &str, words: &[&str]) {
    let path = file(name, text.as_bytes());
    refused(crate::process::run(&["plan", path.to_str().unwrap()]), 2, words);
}

#[test]
fn row_16_floats_and_what_looks_like_one_are_refused_with_the_name_of_the_field() {
    const LOOKS: [&str; 12] =
        ["nan", "inf", "-inf", "-1", "-0.0", "-0", "1e400", "5e-324", "0.5", "'nan'", "'-1ms'", "'1e400ms'"];
    for look in LOOKS {
        refuses(
            "row-16.toml",
            &task_of(&format!("name = 'a', wcet = {look}")),
            &["row-16.toml:6:", "`wcet` is "],
        );
        let text = task_of("name = 'a', wcet = '1ms'");
        let deadline = text.replace("deadline = '10ms'", &format!("deadline = {look}"));
        refuses("row-16.toml", &deadline, &["row-16.toml:5:", "`deadline` is "]);
        let value = text.replace("name = 't'", &format!("name = 't'\nvalue = {look}"));
        if look != "-0" {
            refuses("row-16.toml", &value, &["row-16.toml:4:", "`value` is "]);
        }
        let horizon = format!("--horizon={}", look.trim_matches('\''));
        let path = file("row-16-good.toml", text.as_bytes());
        refused(crate::process::run(&["sim", path.to_str().unwrap(), &horizon]), 2, &["--horizon"]);
    }
}

#[test]
fn row_17_a_pool_of_less_than_one_lane_is_refused() {
    let mut scheduler = Scheduler::<Small>::new(Config::REDRT);
    assert_eq!(scheduler.add_pool(0, None), Err(PoolError::NoLane));
    for lanes in ["0", "-1", "0.5", "0.999", "nan", "'1'"] {
        let text = task_of("name = 'a', wcet = '1ms'").replace("lanes = 1", &format!("lanes = {lanes}"));
        refuses("row-17.toml", &text, &["row-17.toml:1:", "`lanes` is "]);
    }
}

#[test]
fn row_18_level_shares_sum_to_the_deadline_exactly() {
    let mut rng = Rng::new(18);
    for round in 0..2_000 {
        let mut dag = Dag::<Small>::new();
        let nodes: Vec<NodeId> = (0..rng.within(1, 8))
            .map(|_| {
                let wcet = if rng.chance(20) { 0 } else { rng.bits() >> rng.within(3, 60) };
                dag.add_node(Node::new(Wcet::from_nanos(wcet))).expect("eight of 61 bits fit")
            })
            .collect();
        for to in 1..nodes.len() {
            (0..to).filter(|_| rng.chance(40)).for_each(|from| {
                dag.add_edge(nodes[from], nodes[to]).expect("edges go upwards");
            });
        }
        let deadline = (rng.bits() >> rng.within(2, 62)).max(1);
        let levels = Levels::of(&dag);
        for rule in [DeadlineRule::LevelSum, DeadlineRule::LevelGraham] {
            let lanes = rng.within(1, 4) as u8;
            let of_levels = shares(&levels, rule, Duration::from_nanos(deadline), &[lanes]);
            let of_levels = &of_levels.as_ref()[..levels.count()];
            let told = || format!("round {round}, {rule:?}: {of_levels:?} of {deadline}");
            let sum: u128 = of_levels.iter().map(|level| u128::from(level.share)).sum();
            assert_eq!(sum, deadline.into(), "{}", told());
            assert_eq!(of_levels.last().map(|level| level.end), Some(deadline), "{}", told());
            assert!(of_levels.is_sorted_by_key(|level| level.end), "{}", told());
        }
    }
}

#[test]
fn row_19_a_step_back_of_the_clock_is_held_and_counted_and_keeps_the_order() {
    // Two jobs, of which the first is due first.
    let run = |back: &[Duration]| {
        let (mut scheduler, task) = one_task::<Small>(Config::REDRT, &chain(&[2, 2]), due(100));
        let start = at(2 * 3_600_000);
        scheduler.release(task, start).expect("room");
        let (first, _) = poll(&mut scheduler, start);
        scheduler.release(task, start.saturating_add(Duration::from_millis(1))).expect("room");
        for step in back {
            let earlier = Instant::from_nanos(start.as_nanos() - step.as_nanos());
            assert!(poll(&mut scheduler, earlier).0.is_empty(), "the lane is busy");
        }
        let end = start.saturating_add(Duration::from_millis(2));
        let after = if back.is_empty() { end } else { start };
        scheduler.complete(first[0].unit, after).expect("it runs");
        let (order, ended) = drain(&mut scheduler, end);
        let indices: Vec<u64> = ended.iter().map(|outcome| outcome.index).collect();
        assert!(ended.iter().all(|outcome| outcome.at >= outcome.release), "{ended:?}");
        (order, indices, scheduler.counters().clock_steps_back)
    };
    let (order, ended, none) = run(&[]);
    assert_eq!((none, &ended[..]), (0, &[0, 1][..]));
    let steps = [Duration::from_nanos(1), Duration::from_secs(3_600)];
    // Both polls, each asked until it says nothing, and the completion at an instant that has passed.
    assert_eq!(run(&steps), (order, ended, 3));
}

/// Every job of a task is reported once, completed or given up; units that were started.
fn after_a_jump(config: Config, releases: u64) -> (Vec<Outcome>, u64, u64) {
    let (mut scheduler, task) = one_task::<Small>(config, &chain(&[1]), due(5));
    let (_, mut ended) = {
        scheduler.release(task, at(0)).expect("room");
        drain(&mut scheduler, at(0))
    };
    let before = scheduler.counters().units;
    // The host wakes up an hour later, and tells of every release that it slept through.
    let now = at(3_600_000);
    let mut refused = 0;
    for job in 1..=releases {
        let release = Instant::from_nanos(now.as_nanos() - (releases - job) * 10 * MS);
        match scheduler.release_at(task, release, None, now) {
            Ok(_) => {}
            Err(ReleaseError::Full) => refused += 1,
            Err(other) => panic!("{other}"),
        }
    }
    ended.extend(drain(&mut scheduler, now).1);
    (ended, refused, scheduler.counters().units - before)
}

#[test]
fn row_20_after_a_jump_of_an_hour_every_late_job_is_reported_once_and_no_storm_follows() {
    const SLEPT: u64 = 3_600_000 / 10;
    for config in [Config::EDF, Config::RED, Config::REDRT] {
        let (ended, refused, started) = after_a_jump(config, SLEPT);
        assert_eq!(ended.len() as u64 + refused, SLEPT + 1, "each job once");
        let mut indices: Vec<u64> = ended.iter().map(|outcome| outcome.index).collect();
        indices.sort_unstable();
        indices.dedup();
        assert_eq!(indices.len(), ended.len(), "none twice");
        // What is made up for is bounded by the table, and not by how long the host was away.
        assert!(started <= 4, "{started} units after the jump");
    }
    // Of all that was slept through only the release at the wake is still in time: it takes the place of a lost one.
    let (ended, _, started) = after_a_jump(Config::REDRT, SLEPT);
    let on_time: Vec<u64> =
        ended.iter().filter(|outcome| outcome.on_time()).map(|outcome| outcome.index).collect();
    assert_eq!((on_time, started), (vec![0, SLEPT], 1), "nothing is executed for what is lost");
    // On Linux the run's clock stands still while the machine sleeps; what it leaves out is told. A machine that slept
    // for an hour is one whose clock of boot time is an hour ahead.
    need_root();
    let before = suspended_ns();
    let slept = ["unshare", "--time", "--boottime", "3600", "--fork", "--"];
    let Some(output) = apart(&slept, || println!("slept {}", suspended_ns())) else { return };
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    let slept: Option<u64> =
        said.split("slept ").nth(1).and_then(|rest| rest.split_whitespace().next()?.parse().ok());
    let slept =
        slept.unwrap_or_else(|| not_run("needs time namespaces (CONFIG_TIME_NS, and unshare of util-linux)"));
    // To the minute: both clocks are read one after the other.
    assert_eq!((slept - before + 30_000_000_000) / 60_000_000_000, 60, "{slept} ns");
    let path = workload("row-20", "good", 1, "");
    let _alone = alone();
    let output = run(&path, &["--best-effort", "--duration", "100ms"]).output().expect("the command starts");
    let awake = summary(&output, 0).0["suspended_ns"].as_u64();
    assert!(awake.is_some_and(|ns| ns < 1_000_000_000), "it did not sleep: {awake:?}");
}

/// The instants of a run that starts at `origin`, relative to it.
fn story(origin: u64) -> Vec<(u64, u64, u64)> {
    let (mut scheduler, task) = one_task::<Small>(Config::REDRT, &chain(&[3, 2]), due(40));
    let on = |ms: u64| Instant::from_nanos(origin + ms * MS);
    let mut told = Vec::new();
    let mut running = Vec::new();
    for ms in 0..60 {
        let now = on(ms);
        running.retain(|(end, unit)| {
            let ends = *end == now;
            if ends {
                scheduler.complete(*unit, now).expect("it runs");
            }
            !ends
        });
        if ms % 4 == 0 && ms < 40 {
            let _full_is_told_too = scheduler.release(task, now);
        }
        for start in poll(&mut scheduler, now).0 {
            let unit = scheduler.unit(start.unit).expect("it was just started");
            running.push((now.saturating_add(unit.wcet), start.unit));
        }
        while let Some(event) = scheduler.take_event() {
            told.push((event.at.as_nanos() - origin, event.job, event.node.index() as u64));
        }
    }
    told
}

#[test]
fn row_21_a_32_bit_tick_may_wrap_in_the_middle_of_a_job() {
    // 2^32 ticks of 1 ns, 1 us and 1 ms, and the end of what 63 bits of nanoseconds can say; 17 ms into the story.
    let wraps = [1 << 32, (1 << 32) * 1_000, (1 << 32) * MS, i64::MAX as u64 - 200 * MS];
    // Aligned to the ticks of the monitor, which are the same story only then.
    let origins = wraps.map(|wrap: u64| (wrap - 17 * MS) / (5 * MS) * (5 * MS));
    let expected = story(0);
    assert!(expected.len() > 20, "something happens");
    for origin in origins {
        assert_eq!(story(origin), expected, "from {origin} ns on");
    }
}

#[test]
fn row_22_equal_deadlines_are_ordered_by_release_task_job_and_node_and_that_can_be_repeated() {
    type Four = Caps<2, 4, 8, 1, 1, 1, 256>;
    let run = |config: Config| {
        let mut scheduler = Box::new(Scheduler::<Four>::new(config));
        let wide = || {
            let mut dag = Dag::<Four>::new();
            (0..3).for_each(|_| assert!(dag.add_node(cost(1)).is_ok()));
            dag
        };
        let tasks: [TaskId; 2] = [0, 1].map(|_| scheduler.add_task(&wide(), due(50)).expect("room"));
        // The later task first, so that the order of calls is not the rule.
        for task in [tasks[1], tasks[0], tasks[1]] {
            scheduler.release(task, at(0)).expect("room");
        }
        let mut order = Vec::new();
        let mut now = at(0);
        while let [start] = poll(&mut scheduler, now).0[..] {
            let member = scheduler.unit(start.unit).expect("it was just started").first;
            order.push((member.task.index(), member.index, member.node.index()));
            now = now.saturating_add(Duration::from_millis(1));
            scheduler.complete(start.unit, now).expect("it runs");
        }
        order
    };
    for config in [Config::EDF, Config::RED_FG, Config::REDRT] {
        let order = run(config);
        let jobs: Vec<_> = order.iter().map(|(task, job, _)| (*task, *job)).collect();
        assert_eq!(jobs, [[(0, 0); 3], [(1, 0); 3], [(1, 1); 3]].concat());
        assert!(order.chunks(3).all(|job| job.iter().map(|(.., node)| *node).eq(0..3)), "{order:?}");
        assert_eq!(run(config), order, "the same again");
    }
}
