use super::*;
use red_core::{Empty, NodeId, Scheduler};
use red_workload::Format;
use red_workload::policy::Policy;

type Small = red_core::Caps<1, 4, 8>;

const FILE: &str = "
pool = [{ name = 'cpu', lanes = 1 }]
[[task]]
name = 't'
once = true
deadline = '1s'
node = [{ name = 'a', wcet = '1ms' }, { name = 'b', wcet = '1ms' }]
";

/// What is told of jobs 1 and 2, which failed while nodes `a` and `b` ran, and of jobs 3 and 4, of which nothing did.
fn told(idle: &[(usize, u64)], run: Happened<'_>) -> Vec<String> {
    let jobs = vec![(0, 1, [Some(0), None]), (0, 2, [Some(1), None])];
    let faults = Faults { running: Vec::new(), jobs, idle: idle.to_vec(), more: 0 };
    let workload = red_workload::parse(FILE.as_bytes(), Format::Toml, "w.toml").expect("a workload");
    let mut scheduler: Box<Scheduler<Small>> = Box::new(Scheduler::EMPTY);
    let (plan, _) =
        red_workload::build::admit(&mut scheduler, &workload, Policy::Edf.config()).expect("it fits");
    faults.words(&Names { tasks: &["t".to_owned()], nodes: &plan.nodes }, &[], &run)
}

fn words(panicked: &[u64], hung: u64) -> Vec<String> {
    let panic =
        |job: &u64| BodyPanic { task: 0, node: NodeId::new(1), job: *job, message: "oh\n".to_owned() };
    let panics: Vec<BodyPanic> = panicked.iter().map(panic).collect();
    told(&[], Happened { panics: &panics, hung, ..Happened::default() })
}

#[test]
fn jobs_of_a_lost_pool_are_counted_and_nobody_is_told_to_mend_their_bodies() {
    let lost = told(&[(0, 3), (0, 4)], Happened { pools_lost: 1, ..Happened::default() });
    assert_eq!(lost, ["4 jobs that needed what was lost were given up"]);
    let hang = [StreamHang { lane: 0, task: 0, node: NodeId::new(1), job: 2 }];
    let hung = told(&[], Happened { hung: 1, stream_hangs: &hang, ..Happened::default() });
    assert_eq!(hung, ["job 1: the body of node `t.a` panicked; mend the body"]);
}

#[test]
fn a_panic_has_one_line_and_a_body_that_hung_another() {
    let hung = "job 1: the body of node `t.a` did not return within its bound; mend the body";
    assert_eq!(words(&[2], 1), [hung, r"job 2: node `t.b` panicked: oh\n"]);
}

#[test]
fn without_words_of_a_panic_the_watchdog_decides() {
    let told = |hung, how: &str| {
        words(&[], hung).iter().all(|line| line.ends_with(&format!("` {how}; mend the body")))
    };
    assert!(told(0, "panicked"));
    assert!(told(1, "panicked or did not return within its bound"));
    assert!(told(2, "did not return within its bound"));
}

#[test]
fn a_panic_in_a_job_that_was_given_up_before_is_told_too() {
    assert_eq!(words(&[1, 2, 7], 0)[2], r"job 7: node `t.b` panicked: oh\n");
}
