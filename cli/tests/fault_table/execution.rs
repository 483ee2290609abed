//! Rows 23 to 28 and 35 to 39: executions and edits, in virtual time and as whole processes.

use crate::alone::alone;
use crate::redrt::{count, jobs, run, summary, workload};
use crate::virtual_time::{MS, Small, at, chain, cost, drain, due, one_task, poll, runs_through};
use red_core::{
    Action, Caps, CommitError, CompleteError, Config, Dag, Duration, EventKind, Instant, Late, NodeId,
    Outcome, ReleaseError, Scheduler, ShedReason, UnitId,
};
use std::collections::BTreeMap;
use std::fs;
use std::os::unix::process::ExitStatusExt;

fn events(scheduler: &mut Scheduler<Small>) -> Vec<EventKind> {
    std::iter::from_fn(|| scheduler.take_event().map(|event| event.kind)).collect()
}

/// One node, and two that wait for it.
fn fork() -> Dag<Small> {
    let mut dag = chain(&[1, 1]);
    let third = dag.add_node(cost(1)).expect("room");
    dag.add_edge(NodeId::new(0), third).expect("no cycle");
    dag
}

#[test]
fn row_23_a_second_completion_is_stale_and_successors_start_once() {
    let (mut scheduler, task) = one_task(Config::REDRT.with_lanes(2), &fork(), due(100));
    scheduler.release(task, at(0)).expect("room");
    let (first, _) = poll(&mut scheduler, at(0));
    assert_eq!(scheduler.complete(first[0].unit, at(1)), Ok(()));
    let before = format!("{scheduler:?}");
    assert_eq!(scheduler.complete(first[0].unit, at(1)), Err(CompleteError::Stale));
    assert_eq!(scheduler.fail(first[0].unit, at(1)), Err(CompleteError::Stale));
    assert_eq!(format!("{scheduler:?}"), before, "nothing changed");
    let (order, ended) = drain(&mut scheduler, at(1));
    assert_eq!(order, [1, 2].map(NodeId::new));
    assert!(matches!(ended[..], [outcome] if outcome.on_time()), "{ended:?}");
}

#[test]
fn row_24_a_completion_of_what_was_not_started_or_of_an_older_job_is_refused() {
    let (mut scheduler, task) = one_task(Config::REDRT.with_lanes(2), &fork(), due(100));
    scheduler.release(task, at(0)).expect("room");
    let (old, _) = poll(&mut scheduler, at(0));
    let old = old[0].unit;
    drain_from(&mut scheduler, old, 1);
    // The next job has the place of the old one, its lane and its node.
    scheduler.release(task, at(10)).expect("room");
    let (new, _) = poll(&mut scheduler, at(10));
    let new = new[0].unit;
    assert_eq!((new.lane(), new.node()), (old.lane(), old.node()));
    let before = format!("{scheduler:?}");
    let beyond = UnitId::from_bits(new.to_bits() + (1 << 16));
    for (unit, error) in [(old, CompleteError::Stale), (beyond, CompleteError::NotRunning)] {
        assert_eq!(scheduler.complete(unit, at(10)), Err(error));
        assert_eq!(scheduler.fail(unit, at(10)), Err(error));
    }
    // The other lane runs nothing; no lane has this number.
    for lane in [1, 200] {
        let elsewhere = UnitId::from_bits(new.to_bits() & !0xff | lane);
        assert!(scheduler.complete(elsewhere, at(10)).is_err());
    }
    assert_eq!(scheduler.complete(UnitId::from_bits(0), at(10)), Err(CompleteError::NotRunning));
    assert_eq!(format!("{scheduler:?}"), before, "ignored");
    drain_from(&mut scheduler, new, 11);
}

/// Completes `unit` and whatever follows; its job ends in time.
fn drain_from(scheduler: &mut Scheduler<Small>, unit: UnitId, ms: u64) {
    scheduler.complete(unit, at(ms)).expect("it runs");
    let (_, ended) = drain(scheduler, at(ms));
    assert!(matches!(ended[..], [outcome] if outcome.on_time()), "{ended:?}");
}

#[test]
fn row_25_a_completion_after_its_job_was_given_up_is_late_and_counted() {
    for removes in [false, true] {
        let config = Config { late: Late::AbortJob, ..Config::EDF };
        let (mut scheduler, task) = one_task(config, &chain::<Small>(&[1, 1]), due(5));
        scheduler.release(task, at(0)).expect("room");
        let (started, _) = poll(&mut scheduler, at(0));
        let reason = if removes {
            assert!(scheduler.remove_task(task, at(6)));
            ShedReason::Removed
        } else {
            ShedReason::Late
        };
        let (starts, ended) = poll(&mut scheduler, at(6));
        assert!(starts.is_empty() && matches!(ended[..], [Outcome { shed: Some(why), .. }] if why == reason));
        assert_eq!(scheduler.complete(started[0].unit, at(7)), Err(CompleteError::Late));
        assert_eq!(scheduler.counters().late_completions, 1);
        assert_eq!(scheduler.complete(started[0].unit, at(7)), Err(CompleteError::Stale), "once");
        assert_eq!((scheduler.counters().late_completions, scheduler.running_units()), (1, 0));
    }
}

#[test]
fn row_26_a_node_that_never_completes_fails_its_job_and_the_barrier_lets_the_others_through() {
    // Two nodes of the first level, and one behind the level barrier.
    let mut dag = Dag::<Small>::new();
    let [a, b, c] = [1, 1, 1].map(|ms| dag.add_node(cost(ms)).expect("room"));
    dag.add_edge(a, c).expect("no cycle");
    dag.add_edge(b, c).expect("no cycle");
    let (mut scheduler, task) = one_task(Config::RED_FG.with_lanes(2), &dag, due(20));
    let hung = scheduler.release(task, at(0)).expect("room");
    let good = scheduler.release(task, at(0)).expect("room");
    let (starts, _) = poll(&mut scheduler, at(0));
    assert!(starts.iter().all(|start| scheduler.unit(start.unit).is_some_and(|unit| unit.first.job == hung)));
    scheduler.complete(starts[0].unit, at(1)).expect("it runs");
    // One lane is the hung node's until the host gives it up, past ten times its budget.
    let (mut now, mut ended) = (at(1), Vec::new());
    let mut others = poll(&mut scheduler, now).0;
    while let Some(start) = others.pop() {
        assert_eq!(scheduler.unit(start.unit).map(|unit| unit.first.job), Some(good));
        now = now.saturating_add(Duration::from_millis(1));
        scheduler.complete(start.unit, now).expect("it runs");
        let (starts, outcomes) = poll(&mut scheduler, now);
        others.extend(starts);
        ended.extend(outcomes);
    }
    assert!(matches!(ended[..], [outcome] if outcome.job == good && outcome.on_time()), "{ended:?}");
    scheduler.fail(starts[1].unit, at(11)).expect("it runs still");
    let (_, ended) = drain(&mut scheduler, at(11));
    assert!(matches!(ended[..], [outcome] if outcome.job == hung && outcome.shed == Some(ShedReason::Fault)));
    runs_through(&mut scheduler, task, at(12));
    assert_eq!(scheduler.running_units(), 0, "the lane is free again");
}

#[test]
fn row_27_a_node_late_by_a_nanosecond_is_counted_once_and_the_chain_goes_on_by_policy() {
    let late_by = |nanoseconds: u64, late: Late| {
        // The first node has the whole time of the chain.
        let config = Config { late, shed: red_core::Shed::Never, ..Config::REDRT };
        let (mut scheduler, task) = one_task(config, &chain::<Small>(&[5, 0]), due(5));
        scheduler.release(task, at(0)).expect("room");
        let (started, _) = poll(&mut scheduler, at(0));
        let end = Instant::from_nanos(5 * MS + nanoseconds);
        scheduler.complete(started[0].unit, end).expect("it runs");
        let (order, ended) = drain(&mut scheduler, end);
        let [outcome] = ended[..] else { panic!("one job: {ended:?}") };
        let overran = events(&mut scheduler).into_iter().filter(|kind| *kind == EventKind::Overran).count();
        (order.len(), outcome.on_time(), outcome.shed, outcome.lateness().as_nanos(), overran)
    };
    for late in [Late::Continue, Late::AbortJob] {
        assert_eq!(late_by(0, late), (1, true, None, 0, 0), "just in time");
    }
    // A run of REDRT that sheds nothing observes nothing; the miss is told by the outcome, once.
    assert_eq!(late_by(1, Late::Continue), (1, false, None, 1, 0));
    assert_eq!(late_by(1, Late::AbortJob), (0, false, Some(ShedReason::Late), 1, 0));
    // Where executions are observed, the overrun is an event and a count, once.
    let (mut scheduler, task) = one_task(Config::REDRT, &chain::<Small>(&[5, 1]), due(50));
    scheduler.release(task, at(0)).expect("room");
    let (started, _) = poll(&mut scheduler, at(0));
    scheduler.complete(started[0].unit, Instant::from_nanos(5 * MS + 1)).expect("it runs");
    drain(&mut scheduler, at(6));
    let overran = events(&mut scheduler).into_iter().filter(|kind| *kind == EventKind::Overran).count();
    assert_eq!((scheduler.counters().overruns, overran), (1, 1));
}

#[test]
fn row_28_a_body_that_crashes_ends_the_process_and_a_restart_finds_its_files() {
    let path = workload("row-28", "crashes", 1, "");
    let trace = path.with_extension("json");
    let arguments = ["--best-effort", "--duration", "300ms", "--force", "--trace", trace.to_str().unwrap()];
    let text = fs::read_to_string(&path).expect("UTF-8");
    let _alone = alone();
    // The last good run left a trace.
    fs::write(&path, text.replace("crashes", "good")).expect("the folder takes files");
    summary(&run(&path, &arguments).output().expect("the command starts"), 0);
    let last_good = fs::read(&trace).expect("a trace");
    fs::write(&path, &text).expect("the folder takes files");
    let output = run(&path, &arguments).output().expect("the command starts");
    assert!(output.status.signal().is_some(), "{}: no answer pretends that all is well", output.status);
    assert!(output.stdout.is_empty());
    assert_eq!(fs::read_to_string(&path).expect("UTF-8"), text, "the configuration is there");
    assert_eq!(fs::read(&trace).expect("a trace"), last_good, "and the last good output");
    // What a supervisor does.
    fs::write(&path, text.replace("crashes", "good")).expect("the folder takes files");
    let (again, _) = summary(&run(&path, &arguments).output().expect("the command starts"), 0);
    assert_eq!(jobs(&again), [6, 6, 0]);
}

/// A task whose graph alternates between two, while its jobs run: who runs what.
#[test]
fn row_35_an_edit_while_jobs_run_mixes_no_two_graphs() {
    let mut rng = red_tests::rng::Rng::new(35);
    let mut edits = 0;
    for _ in 0..200 {
        let (mut scheduler, task) =
            one_task::<Small>(Config::EDF.with_lanes(2), &chain(&[1, 1, 1]), due(1_000));
        let mut graphs: Vec<Vec<NodeId>> = vec![scheduler.edit(task).expect("admitted").nodes().collect()];
        // By job: the graph of its release, and what ran of it.
        let mut of_job: BTreeMap<u64, (usize, Vec<NodeId>)> = BTreeMap::new();
        let mut running: Vec<UnitId> = Vec::new();
        let mut ended = Vec::new();
        for ms in 0..60 {
            match rng.index(3) {
                0 if ms < 40 => {
                    if let Ok(job) = scheduler.release(task, at(ms)) {
                        let index = (0..60).find(|i| scheduler.job_id(task, *i) == Some(job));
                        of_job.insert(index.expect("in flight"), (graphs.len() - 1, Vec::new()));
                    }
                }
                1 => {
                    let mut edit = scheduler.edit(task).expect("admitted");
                    let nodes: Vec<NodeId> = edit.nodes().collect();
                    if nodes.len() > 2 {
                        assert!(edit.remove_node(nodes[rng.index(nodes.len())]));
                    } else if let Ok(new) = edit.add_node(cost(1)) {
                        edit.add_edge(nodes[0], new).expect("no cycle");
                    }
                    match scheduler.commit(&edit, at(ms)) {
                        Ok(_) => {
                            edits += 1;
                            graphs.push(edit.nodes().collect());
                        }
                        Err(error) => assert_eq!(error, CommitError::Busy),
                    }
                }
                _ => {}
            }
            if !running.is_empty() && rng.chance(60) {
                let unit = running.swap_remove(rng.index(running.len()));
                scheduler.complete(unit, at(ms)).expect("it runs");
            }
            let (starts, outcomes) = poll(&mut scheduler, at(ms));
            ended.extend(outcomes);
            for start in starts {
                let first = scheduler.unit(start.unit).expect("it was just started").first;
                of_job.get_mut(&first.index).expect("a job that was released").1.push(first.node);
                running.push(start.unit);
            }
        }
        for outcome in ended {
            let (graph, mut ran) = of_job.remove(&outcome.index).expect("it ends once");
            ran.sort();
            assert_eq!(ran, graphs[graph], "job {} ran the graph of its release, whole", outcome.index);
        }
    }
    assert!(edits > 500, "only {edits} edits");
}

#[test]
fn row_36_of_two_edits_at_once_one_wins_and_the_other_is_told() {
    let (mut scheduler, task) = one_task::<Small>(Config::REDRT, &chain(&[1, 1]), due(100));
    let [mut one, mut other] = [0, 1].map(|_| scheduler.edit(task).expect("admitted"));
    let new = one.add_node(cost(1)).expect("room");
    assert!(other.remove_node(NodeId::new(1)));
    let _proof = scheduler.commit(&one, at(0)).expect("the first one wins");
    let before = format!("{scheduler:?}");
    assert_eq!(scheduler.commit(&other, at(0)), Err(CommitError::Conflict));
    assert_eq!(scheduler.commit(&one, at(0)), Err(CommitError::Conflict), "nor does the first one win twice");
    assert_eq!(format!("{scheduler:?}"), before);
    let mut ran = runs_through(&mut scheduler, task, at(1));
    ran.sort();
    assert_eq!(ran, [NodeId::new(0), NodeId::new(1), new]);
    // Begun again from the graph as it is.
    let mut again = scheduler.edit(task).expect("admitted");
    assert!(again.remove_node(NodeId::new(1)));
    assert!(scheduler.commit(&again, at(20)).is_ok());
}

#[test]
fn row_37_a_node_that_an_older_job_runs_goes_with_that_job_and_its_place_is_not_reused_before() {
    let (mut scheduler, task) = one_task::<Small>(Config::EDF.with_lanes(2), &chain(&[1, 1]), due(100));
    let removed = NodeId::new(0);
    scheduler.release(task, at(0)).expect("room");
    let (older, _) = poll(&mut scheduler, at(0));
    assert_eq!(older[0].unit.node(), removed);
    let mut edit = scheduler.edit(task).expect("admitted");
    assert!(edit.remove_node(removed));
    let _proof = scheduler.commit(&edit, at(1)).expect("two versions fit");
    let unit = scheduler.unit(older[0].unit).expect("it runs on");
    assert_eq!((unit.first.node, unit.wcet), (removed, Duration::from_millis(1)));
    // Seven other places are free or taken; the removed one is none of them while the job has it.
    let mut next = scheduler.edit(task).expect("admitted");
    let places: Vec<NodeId> = std::iter::from_fn(|| next.add_node(cost(1)).ok()).collect();
    assert!(places.len() == 6 && !places.contains(&removed), "{places:?}");
    assert_eq!(scheduler.commit(&next, at(1)), Err(CommitError::Busy));
    scheduler.complete(older[0].unit, at(2)).expect("it runs");
    let (order, ended) = drain(&mut scheduler, at(2));
    assert_eq!((order, ended.len()), (vec![NodeId::new(1)], 1), "the older job has its whole graph");
    // With that job the node has gone, and its place is anybody's.
    let mut after = scheduler.edit(task).expect("admitted");
    let places: Vec<NodeId> = std::iter::from_fn(|| after.add_node(cost(1)).ok()).collect();
    assert!(places.len() == 7 && places.contains(&removed), "{places:?}");
    assert_eq!(scheduler.complete(older[0].unit, at(3)), Err(CompleteError::Stale));
}

#[test]
fn row_38_a_storm_of_edits_is_limited_by_a_typed_refusal_and_dispatch_never_waits() {
    let (mut scheduler, task) = one_task::<Small>(Config::REDRT.with_lanes(2), &chain(&[2, 2]), due(20));
    let (mut taken, mut busy, mut ended) = (0, 0, Vec::new());
    let mut running: Vec<(u64, UnitId)> = Vec::new();
    const TICKS: u64 = 10_000;
    for ms in 0..TICKS {
        let now = at(ms);
        running.retain(|(end, unit)| {
            let ends = *end == ms;
            if ends {
                scheduler.complete(*unit, now).expect("it runs");
            }
            !ends
        });
        if ms % 10 == 0 {
            scheduler.release(task, now).expect("the table never fills");
        }
        // More than one at each tick.
        for _ in 0..3 {
            let mut edit = scheduler.edit(task).expect("admitted");
            let nodes: Vec<NodeId> = edit.nodes().collect();
            if nodes.len() > 2 {
                assert!(edit.remove_node(nodes[2]));
            } else {
                edit.add_node(cost(1)).expect("room");
            }
            match scheduler.commit(&edit, now) {
                Ok(_) => taken += 1,
                Err(error) => {
                    assert_eq!(error, CommitError::Busy);
                    busy += 1;
                }
            }
        }
        let (starts, outcomes) = poll(&mut scheduler, now);
        ended.extend(outcomes);
        for start in starts {
            let unit = scheduler.unit(start.unit).expect("it was just started");
            running.push((ms + unit.wcet.as_nanos() / MS, start.unit));
        }
        assert!(running.len() == 2 || scheduler.ready_sub_jobs() == 0, "a lane is free and something waits");
    }
    // Each job ended as it would have without an edit: no later than its work, one node after the other.
    assert_eq!(ended.len() as u64, TICKS / 10);
    assert!(ended.iter().all(|outcome| outcome.on_time() && outcome.at.since(outcome.release) <= Duration::from_millis(5)));
    assert!(taken > TICKS / 2 && busy > TICKS / 2, "{taken} taken, {busy} refused");
}

#[test]
fn row_39_a_burst_of_minutes_keeps_the_queue_bounded_the_floor_and_an_exact_count() {
    type Burst = Caps<2, 4, 64, 1, 1, 1, 512>;
    // Three minutes at 180 % of one lane, with deadlines that several jobs of both tasks fit into.
    const HORIZON_MS: u64 = 180_000;
    let mut scheduler = Box::new(Scheduler::<Burst>::new(Config::REDRT));
    let valuable = scheduler.add_task(&chain(&[20]), due(500).value(10).floor(1, 1)).expect("room");
    let cheap = scheduler.add_task(&chain(&[35]), due(500).value(1)).expect("room");
    let size = Scheduler::<Burst>::SIZE;
    let (mut running, mut released, mut refused) = (None::<(u64, UnitId)>, [0, 0], [0, 0]);
    let mut why = BTreeMap::<_, u64>::new();
    let (mut on_time, mut shed, mut late) = ([0, 0], [0, 0], [0, 0]);
    for ms in 0..HORIZON_MS + 1_000 {
        let now = at(ms);
        if let Some((_, unit)) = running.take_if(|(end, _)| *end == ms) {
            // `Late` frees the lane too.
            let _lane_is_free = scheduler.complete(unit, now);
        }
        for (i, (task, period)) in [(valuable, 50), (cheap, 25)].into_iter().enumerate() {
            if ms % period == 0 && ms < HORIZON_MS {
                released[i] += 1;
                refused[i] += u64::from(scheduler.release(task, now) == Err(ReleaseError::Full));
            }
        }
        while let Some(action) = scheduler.poll(now) {
            match action {
                Action::Dispatch(start) => {
                    let unit = scheduler.unit(start.unit).expect("it was just started");
                    // Every fourth execution takes a millisecond: what is late at worst case may still be in time.
                    let took = if unit.first.index.is_multiple_of(4) { 1 } else { unit.wcet.as_nanos() / MS };
                    running = Some((ms + took, start.unit));
                }
                Action::Ended(outcome) => {
                    let of = if outcome.on_time() {
                        &mut on_time
                    } else if outcome.shed.is_some() {
                        &mut shed
                    } else {
                        &mut late
                    };
                    of[outcome.task.index()] += 1;
                    *why.entry((outcome.task.index(), outcome.shed.map(|r| r.name()))).or_insert(0) += 1;
                }
                other => panic!("nobody asked for {other:?}"),
            }
        }
        while scheduler.take_event().is_some() {}
        assert!(scheduler.jobs_in_flight() <= 64);
    }
    assert_eq!((Scheduler::<Burst>::SIZE, scheduler.events_dropped()), (size, 0), "the state has one size");
    for task in [0, 1] {
        let told = on_time[task] + shed[task] + late[task] + refused[task];
        assert_eq!(told, released[task], "every job once: {on_time:?} {shed:?} {late:?} {refused:?}");
    }
    // By floor and value the cheap task is below the valuable one: nothing of that one goes for others. A job that no
    // order could save does.
    let by_choice = |task: usize| why.get(&(task, Some("overload"))).copied().unwrap_or(0);
    assert_eq!(by_choice(0), 0);
    assert!(by_choice(1) > released[1] / 4, "the cheap task pays: {why:?}");
    assert!(on_time[0] * 100 > released[0] * 95, "the valuable one is kept: {why:?} of {released:?}");
    // The same on real threads, for half a second.
    let burst = "[[task]]\nname = \"burst\"\nperiod = \"1ms\"\ndeadline = \"1ms\"\n\
                 node = [{ name = \"b\", wcet = \"20ms\", body = { spin = \"20ms\" } }]\n";
    let path = workload("row-39", "good", 1, burst);
    let _alone = alone();
    let output = run(&path, &["--best-effort", "--duration", "500ms"]).output().expect("the command starts");
    let (real, _) = summary(&output, 0);
    let task = &real["tasks"][1];
    assert_eq!(count(task, "released"), 500);
    assert_eq!(count(task, "on_time") + count(task, "missed"), 500, "{task}");
    assert!(count(task, "shed") > 0, "{task}");
    assert_eq!(real["allocations"], 0);
}
