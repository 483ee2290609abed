use super::*;
use crate::fixtures::{MS, at, node, once, part, sensed, stage, workload, written};
use crate::oracle::Policy;
use red_workload::model::{Part, Task, Work, Workload};

/// `end first-start pools` of the jobs of these tasks, after the events of an instant and before its dispatch.
fn fates(workload: &Workload, now_ms: u64, tasks: &[usize]) -> Vec<String> {
    let now = now_ms * MS;
    let mut sim = Sim::new(workload, Policy::Redrt, u64::MAX);
    while let Some(next) = sim.next_instant().filter(|&next| next < now) {
        sim.step(next);
    }
    sim.complete(now);
    sim.release(now);
    let in_flight = |&task: &usize| sim.jobs.iter().position(|job| job.task == task).expect("in flight");
    let group: Vec<usize> = tasks.iter().map(in_flight).collect();
    let ms = |at: i128| at / i128::from(MS);
    let line = |fate: Fate| {
        let first = fate.first_start.map_or("-".to_owned(), |at| ms(at).to_string());
        format!("{} {first} {:?}", ms(fate.end), fate.pools)
    };
    sim.forward(&group, now).into_iter().map(line).collect()
}

fn chain() -> Vec<red_workload::model::Node> {
    vec![node("a", 10, &[]), node("b", 10, &["a"]), node("c", 10, &["b"])]
}

#[test]
fn nodes_start_by_their_keys() {
    // Both chains have the keys 20, 30 and 40 and take turns.
    let both = workload(1, vec![once("low", 50, chain()), once("high", 50, chain())]);
    assert_eq!(fates(&both, 0, &[0, 1]), ["50 0 [0, 0, 0]", "60 10 [0, 0, 0]"]);
    assert_eq!(fates(&both, 0, &[1]), ["30 0 [0, 0, 0]"]);
    // At 10 the first of low has run, and that of high would be next, but high is late.
    assert_eq!(fates(&both, 10, &[0, 1]), ["30 10 [0, 0]", "60 30 [0, 0, 0]"]);
}

#[test]
fn what_runs_holds_its_lane_whoever_it_is_for() {
    let tasks = vec![once("a", 100, vec![node("n", 10, &[])]), at(once("b", 50, vec![node("n", 4, &[])]), 5)];
    assert_eq!(fates(&workload(1, tasks.clone()), 5, &[0, 1]), ["10 - []", "14 10 [0]"]);
    assert_eq!(fates(&workload(1, tasks.clone()), 5, &[1]), ["14 10 [0]"]);
    assert_eq!(fates(&workload(2, tasks), 5, &[1]), ["9 5 [0]"]);
}

#[test]
fn nodes_that_take_no_time_end_in_their_instant() {
    let nodes = vec![node("a", 0, &[]), node("b", 0, &["a"]), node("c", 3, &["b"])];
    let markers = workload(1, vec![once("t", 3, nodes), once("u", 9, vec![node("n", 4, &[])])]);
    assert_eq!(fates(&markers, 0, &[0, 1]), ["3 0 [0, 0, 0]", "7 3 [0]"]);
}

#[test]
fn a_job_takes_lanes_of_several_pools() {
    let elsewhere = written("b", &["a"], Work::Plain(Part { pool: 1, ..part(5) }));
    let mut two = workload(1, vec![once("t", 100, vec![node("a", 10, &[]), elsewhere])]);
    two.pools.push(red_workload::model::Pool { name: "cpu".to_owned(), ..two.pools[0].clone() });
    assert_eq!(fates(&two, 0, &[0]), ["15 0 [0, 1]"]);
    assert_eq!(fates(&two, 10, &[0]), ["15 10 [1]"]);
}

fn see(name: &str, encoder_ms: u64, decoder_ms: u64) -> Task {
    once(name, 100, vec![stage("see", encoder_ms, &[("dec", decoder_ms)], &[])])
}

#[test]
fn encoders_of_one_frame_wait_without_a_lane() {
    // The keys are 86 and 90: b waits for the encoder of a, on two lanes as on one.
    let apart = vec![see("a", 10, 4), see("b", 4, 6)];
    let shared = sensed(workload(2, apart.clone()), 50);
    assert_eq!(fates(&shared, 0, &[0, 1]), ["14 0 [0, 0]", "16 10 [0]"]);
    assert_eq!(fates(&shared, 0, &[1]), ["10 0 [0, 0]"]);
    // Frames of their own: both run.
    assert_eq!(fates(&workload(2, apart), 0, &[0, 1]), ["14 0 [0, 0]", "10 0 [0, 0]"]);
}

#[test]
fn what_is_computed_or_kept_now_is_there_for_all() {
    let mut c = at(see("c", 10, 1), 5);
    c.nodes = vec![node("pre", 7, &[]), stage("see", 10, &[("dec", 1)], &["pre"])];
    let shared = sensed(workload(2, vec![see("a", 10, 4), at(see("b", 10, 6), 5), c]), 50);
    // The encoder of a runs until 10. That of b waits for it, that of c finds it kept at 12.
    assert_eq!(fates(&shared, 5, &[0, 1, 2]), ["14 10 [0]", "18 12 [0]", "15 5 [0, 0]"]);
    // So it is where a is left out.
    assert_eq!(fates(&shared, 5, &[1, 2]), ["16 10 [0]", "13 5 [0, 0]"]);
}
