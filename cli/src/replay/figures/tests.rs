use super::*;
use crate::session::Robot;
use red_core::{Action, Empty, LaneId};
use red_workload::build;
use red_workload::policy::Policy;
use red_workload::{Format, Source};
use std::path::Path;

const FILE: &str = "pool = [{ name = 'p', lanes = 1 }]\n[[task]]\nname = 't'\nperiod = '10ms'\ndeadline = '10ms'\n\
                    node = [{ name = 'a', wcet = '1ms' }]\n";

#[test]
fn a_unit_that_failed_runs_no_more() {
    let source = Source::parse(FILE.as_bytes(), Format::Toml, Path::new("t.toml")).unwrap();
    let mut scheduler: Box<Scheduler<Robot>> = Box::new(Scheduler::EMPTY);
    let (plan, tasks) = build::admit(&mut scheduler, &source.workload, Policy::Redrt.config()).unwrap();
    let mut figures = Figures::new(&source.workload, plan.nodes);
    let lane = LaneId::new(0);
    let (begin, end) = (Instant::ZERO, Instant::from_nanos(300));
    let job = scheduler.release_at(tasks[0], begin, None, begin).unwrap();
    let Some(Action::Dispatch(dispatch)) = scheduler.poll_on(lane, begin) else { panic!("the lane is free") };
    let unit = dispatch.unit;
    let answer = Answer::Started(Started { unit, job, members: None });
    figures.watch(&scheduler, &Entry { now: begin, call: Call::Poll(Some(lane)), answer }, &[]);
    assert_eq!(figures.running.len(), 1);
    let answer = Answer::Reported(scheduler.fail(unit, end));
    figures.watch(&scheduler, &Entry { now: end, call: Call::Fail(unit), answer }, &[]);
    assert!(figures.running.is_empty());
    assert_eq!(figures.busy_ns[0], 300);
}
