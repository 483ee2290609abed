use super::*;
use crate::table::Verdict;

/// At one load on one lane: all else has no samples, so that most promises are not kept.
fn few(seeds: u64) -> Table {
    let points: Vec<Point> = points().into_iter().filter(|p| p.lanes == 1 && p.load == 1.33).collect();
    table(&Run { seeds, progress: &|_, _| {}, is_stopped: &|| false }, &points).unwrap()
}

#[test]
fn sets_have_the_load_that_they_are_drawn_for() {
    for shape in Shape::ALL {
        for Point { lanes, load, times } in points() {
            let set = Set::draw(shape, lanes, load, times, 1);
            let mean = |task: &crate::scoreboard::sets::Task| {
                (task.graph.work() * times.mean_percent() / 100) as f64 / task.period_ns as f64
            };
            let found = set.tasks.iter().map(mean).sum::<f64>() / f64::from(lanes);
            assert!((found / load - 1.0).abs() < 0.001, "{shape:?} {load} {found}");
        }
    }
}

#[test]
fn execution_times_have_the_mean_that_rules_are_told() {
    for times in Times::ALL {
        let set = Set::draw(Shape::Lone, 1, 1.1, times, 1);
        let drawn: u64 = set.jobs().map(|(task, job)| set.work(task, job)).sum();
        let told = set.tasks[0].graph.work() * times.mean_percent() / 100 * set.jobs().count() as u64;
        assert!((drawn as f64 / told as f64 - 1.0).abs() < 0.02, "{times:?} {drawn} {told}");
        let (bound, capacity) = (measures::bound(&set), measures::capacity(&set));
        assert!(
            bound > capacity || times == Times::Wcet && bound == capacity,
            "{times:?} {bound} {capacity}"
        );
    }
}

#[test]
fn a_part_of_a_set_takes_the_times_that_it_takes_in_all_of_it() {
    let set = Set::draw(Shape::Values, 2, 1.5, Times::Uniform, 3);
    let last = set.tasks.len() - 1;
    let part = set.part(&[last], 0).unwrap();
    assert!(
        (0..part.tasks[0].graph.costs.len()).all(|node| part.time(0, 1, node) == set.time(last, 1, node))
    );
    assert!(set.part(&[last], set.tasks[last].deadline_ns).is_none());
}

#[test]
fn every_measure_has_a_row_for_each_rule_and_no_promise_fails_without_its_figures() {
    let table = few(2);
    assert_eq!(table.rows.len(), Measure::ALL.len() * Rule::ALL.len());
    assert!(table.rows.iter().all(|row| row.len() == table.columns.len()));
    for claim in &table.claims {
        assert_ne!(claim.verdict, Verdict::Fails);
        let says_so = claim.ours.starts_with("not kept: promised ") && claim.ours.contains(" %, measured ");
        assert_eq!(says_so, claim.verdict == Verdict::NotKept, "{claim:?}");
    }
    assert!(table.claims.iter().any(|claim| claim.verdict == Verdict::NotKept));
    assert_eq!(table, few(2), "equal seeds give equal tables");
}

#[test]
fn every_group_that_breaks_has_a_row_for_each_task_that_it_met() {
    let table = broken::run(&Run { seeds: 2, progress: &|_, _| {}, is_stopped: &|| false }).unwrap();
    assert!(table.rows.iter().all(|row| row.len() == table.columns.len()));
    let mut groups: Vec<String> = table.rows.iter().map(|row| format!("{:?}", &row[..5])).collect();
    groups.dedup();
    assert!(groups.len() > 1, "{groups:?}");
    assert!(table.claims[0].ours.ends_with(&format!(" of {}", groups.len())), "{:?}", table.claims[0]);
}
