use super::*;
use crate::model::{Graph, Hit, Lane, Node, Pool, Slice, Task};

fn node(pool: usize, height: usize, after: &[usize]) -> Node {
    Node {
        wcet_ns: 10,
        pool,
        height,
        rest_ns: 100 - 10 * height as u64,
        after: after.to_vec(),
        is_encoder: false,
    }
}

fn slice(of: SubJob, lane: usize, start_ns: u64, end_ns: u64, unit: u64) -> Slice {
    Slice { of, lane, start_ns, end_ns, due_ns: None, completed: true, unit }
}

/// A chain of two nodes on one lane; job 0 of task 1 is before it there.
fn run() -> Run {
    let graph = Graph { nodes: [(0, node(0, 0, &[])), (1, node(0, 1, &[0]))].into() };
    let job = |release_ns, end_ns| Job {
        release_ns,
        recorded_ns: release_ns + 2,
        deadline_ns: release_ns + 20,
        end_ns: Some(end_ns),
        counts: true,
        ..Job::default()
    };
    Run {
        tasks: vec![Task::default(), Task::default()],
        lanes: vec![Lane::default()],
        pools: vec![Pool::default()],
        graphs: vec![graph],
        jobs: vec![vec![job(100, 160)], vec![job(90, 130)]],
        slices: vec![
            slice((1, 0, 0), 0, 95, 110, 1),
            slice((0, 0, 0), 0, 111, 126, 2),
            slice((1, 0, 1), 0, 126, 140, 3),
            slice((0, 0, 1), 0, 150, 160, 4),
        ],
        end_ns: 200,
        ..Run::default()
    }
}

fn spans(parts: &[Part]) -> Vec<(Kind, u64, u64)> {
    parts.iter().map(|part| (part.kind, part.from_ns, part.to_ns)).collect()
}

/// What every chain has to be.
fn adds_up(parts: &[Part], from: u64, until: u64) -> bool {
    let joined = parts.windows(2).all(|pair| pair[0].to_ns == pair[1].from_ns);
    let ends = parts.first().map(|part| part.from_ns) == Some(from)
        && parts.last().map(|part| part.to_ns) == Some(until);
    joined && ends && parts.iter().map(Part::ns).sum::<u64>() == until - from
}

#[test]
fn each_nanosecond_of_a_late_job_has_one_reason() {
    let run = run();
    let parts = Blame::new(&run).chain(0, 0, 160);
    let expected = [
        (Kind::Release, 100, 102),
        (Kind::Lane, 102, 110),
        (Kind::Dispatch, 110, 111),
        (Kind::Execution, 111, 121),
        (Kind::Overrun, 121, 126),
        (Kind::Lane, 126, 140),
        (Kind::Dispatch, 140, 150),
        (Kind::Execution, 150, 160),
    ];
    assert_eq!(spans(&parts), expected);
    assert!(adds_up(&parts, 100, 160));
    assert_eq!((parts[1].by, parts[5].by), (Some((1, 0, 0)), Some((1, 0, 1))));
    assert_eq!(longest(&parts), Some((Kind::Lane, Some(1))));
}

#[test]
fn a_chain_with_a_hole_is_found_out() {
    let run = run();
    let mut parts = Blame::new(&run).chain(0, 0, 160);
    parts.remove(3);
    assert!(!adds_up(&parts, 100, 160));
}

#[test]
fn a_free_lane_of_a_pool_with_a_budget_lacked_memory() {
    let mut run = run();
    run.pools[0].is_limited = true;
    assert!(Blame::new(&run).chain(0, 0, 160).contains(&Part {
        kind: Kind::Memory,
        node: Some(1),
        from_ns: 140,
        to_ns: 150,
        by: None
    }));
}

#[test]
fn an_encoder_that_took_a_result_waited_for_the_other() {
    let mut run = run();
    run.slices.remove(1);
    run.hits.push(Hit { of: (0, 0, 0), at_ns: 110, by: Some((1, 0, 0)) });
    let parts = Blame::new(&run).chain(0, 0, 160);
    assert_eq!(spans(&parts)[1], (Kind::Encoder, 102, 110));
    assert!(adds_up(&parts, 100, 160));
}

#[test]
fn a_level_that_is_not_done_has_its_own_part() {
    let mut run = run();
    run.level_gate = true;
    run.graphs[0].nodes.insert(2, node(0, 0, &[]));
    run.slices.insert(3, slice((0, 0, 2), 0, 140, 148, 5));
    let parts = Blame::new(&run).chain(0, 0, 160);
    assert!(spans(&parts).contains(&(Kind::Gate, 126, 148)));
    assert!(adds_up(&parts, 100, 160));
}

#[test]
fn a_job_that_was_given_up_is_explained_up_to_that_instant() {
    let mut run = run();
    run.jobs[0][0].end_ns = Some(145);
    run.jobs[0][0].shed = Some("hopeless".to_owned());
    run.slices.pop();
    let parts = Blame::new(&run).chain(0, 0, 145);
    assert_eq!(spans(&parts)[5..], [(Kind::Lane, 126, 140), (Kind::Dispatch, 140, 145)]);
    assert!(adds_up(&parts, 100, 145));
}

#[test]
fn a_job_that_was_refused_has_no_parts() {
    let run = run();
    assert_eq!(Blame::new(&run).chain(0, 0, 100), []);
    assert_eq!(Blame::new(&run).chain(0, 7, 100), []);
}
