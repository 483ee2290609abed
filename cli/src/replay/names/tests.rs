use super::*;
use red_core::{Instant, LaneId, TaskId};

#[test]
fn a_replay_of_any_length_keeps_the_same_few_names() {
    let mut names = Names {
        tasks: vec!["t".into()],
        nodes: Some(Vec::new()),
        released: vec![0],
        jobs: Vec::new(),
        units: VecDeque::new(),
    };
    let now = Instant::ZERO;
    for n in 0..1_000 {
        // Eight places whose jobs come one after the other.
        let job = JobId::from_bits(((n / 8) << 16) | (n % 8));
        let call = Call::Release { task: TaskId::from_bits(0), at: now, capture: None };
        names.watch(&Entry { now, call, answer: Answer::Released(Ok(job)) });
        let unit = UnitId::from_bits(u64::from(n + 1) << 16);
        let answer = Answer::Started(Started { unit, job, members: None });
        names.watch(&Entry { now, call: Call::Poll(Some(LaneId::new(0))), answer });
        assert_eq!(names.units.front(), Some(&(unit, (0, u64::from(n)))));
        assert_eq!(names.job(job), Some((0, u64::from(n))));
    }
    assert_eq!((names.units.len(), names.jobs.len()), (UNITS, 8));
    assert_eq!(names.job(JobId::from_bits(0)), None, "its place is another's");
}
