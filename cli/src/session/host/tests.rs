use super::*;
use red_core::{Action, Empty, Scheduler};
use red_workload::Format;
use red_workload::policy::Policy;

type Small = red_core::Caps<2, 8, 8, 4>;

/// Both tasks change at 10 and 20 ns; the edits come in the order t, t, u, u.
const FILE: &str = "
pool = [{ name = 'cpu', lanes = 2 }]
[[task]]
name = 't'
once = true
deadline = '1s'
node = [{ name = 'a', wcet = '1ms' }]
[[task]]
name = 'u'
once = true
deadline = '1s'
node = [{ name = 'a', wcet = '1ms' }]
[[event]]
at = '10ns'
task = 't'
add = [{ name = 'b', wcet = '1ms' }]
[[event]]
at = '20ns'
task = 't'
add = [{ name = 'c', wcet = '1ms' }]
[[event]]
at = '20ns'
task = 'u'
add = [{ name = 'd', wcet = '1ms' }]
[[event]]
at = '30ns'
task = 'u'
remove = ['d']
";

fn at(ns: u64) -> Instant {
    Instant::from_nanos(ns)
}

fn scheduler_and_notes() -> (Box<Scheduler<Small>>, Notes, Vec<TaskId>) {
    let workload = red_workload::parse(FILE.replace('\'', "\"").as_bytes(), Format::Toml, "test").unwrap();
    let mut scheduler: Box<Scheduler<Small>> = Box::new(Scheduler::EMPTY);
    let (plan, tasks) = build::admit(&mut scheduler, &workload, Policy::Redrt.config()).unwrap();
    let notes =
        Notes::new(tasks.clone(), vec![0; 2], plan.changes, &[8, 8], 0, Costs::default(), Live::new(2));
    (scheduler, notes, tasks)
}

fn nodes(scheduler: &Scheduler<Small>, task: TaskId) -> usize {
    scheduler.edit(task).unwrap().len()
}

#[test]
fn an_edit_that_waits_holds_back_its_own_task_alone_and_comes_when_the_job_has_ended() {
    let (mut scheduler, mut notes, tasks) = scheduler_and_notes();
    scheduler.release(tasks[0], at(0)).unwrap();
    let Some(Action::Dispatch(running)) = scheduler.poll(at(0)) else { panic!("the job starts") };
    for now in [0, 10, 20] {
        notes.due(&mut Recorder::new(&mut scheduler, None), at(now));
    }
    assert_eq!((nodes(&scheduler, tasks[0]), nodes(&scheduler, tasks[1])), (2, 2), "t waits, u does not");
    scheduler.complete(running.unit, at(25)).unwrap();
    assert!(scheduler.take_outcome().is_some());
    notes.due(&mut Recorder::new(&mut scheduler, None), at(25));
    assert_eq!((nodes(&scheduler, tasks[0]), nodes(&scheduler, tasks[1])), (3, 2));
}

#[test]
fn an_edit_that_waits_is_not_asked_for_by_the_clock() {
    let (mut scheduler, mut notes, tasks) = scheduler_and_notes();
    let next = |notes: &Notes| Host::<Small>::next_at(notes);
    scheduler.release(tasks[0], at(0)).unwrap();
    assert_eq!(next(&notes), Some(10));
    notes.due(&mut Recorder::new(&mut scheduler, None), at(10));
    assert_eq!(next(&notes), Some(20));
    notes.due(&mut Recorder::new(&mut scheduler, None), at(20));
    assert_eq!(next(&notes), Some(30), "the edit of 20 ns waits");
    notes.due(&mut Recorder::new(&mut scheduler, None), at(30));
    assert_eq!(next(&notes), None);
}
