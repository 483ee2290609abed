//! Errands: what threads that are no lanes have done under the scheduler's lock while lanes run, and what becomes of them
//! when lanes hang or the run ends.

mod called;

use called::{Counted, FAR, Run, Small, setup, wait_for};
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, OnceLock, mpsc};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use red_core::{Instant, Node, Scheduler, Wcet};
use red_record::Recorder;
use red_rt::allocations::CountingAllocator;
use red_rt::control::{AskError, Control, Errand, Refused};
use red_rt::handler::Work;
use red_rt::report::{Stopped, Surrender};
use red_rt::runtime::{Setup, run};

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

/// Asks on a thread of its own, so that a test that waits for ever fails.
fn ask(control: &Arc<dyn Control<Small>>, errand: Errand<Small>) -> Result<Errand<Small>, AskError> {
    let (told, answer) = mpsc::channel();
    let control = control.clone();
    thread::spawn(move || told.send(control.ask(errand)));
    answer.recv_timeout(FAR).expect("an answer")
}

/// What the errand leaves behind.
fn look<T: Send + 'static>(
    control: &Arc<dyn Control<Small>>,
    mut errand: impl FnMut(&mut Recorder<'_, Small>, Instant) -> T + Send + 'static,
) -> Result<T, AskError> {
    let result = Arc::new(Mutex::new(None));
    let place = result.clone();
    let errand: Errand<Small> = Box::new(move |scheduler, now| {
        let result = errand(scheduler, now);
        let before = place.lock().expect("nobody panicked").replace(result);
        assert!(before.is_none(), "it ran before");
    });
    drop(ask(control, errand)?);
    let found = result.lock().expect("nobody panicked").take();
    Ok(found.expect("it ran"))
}

fn count(of: &AtomicU64, more: u64) {
    of.fetch_add(more, Ordering::Relaxed);
}

#[test]
fn a_node_that_an_errand_adds_to_a_running_task_runs() {
    let ran = Arc::new([const { AtomicU64::new(0) }; 2]);
    let notes = ran.clone();
    let run = Run::start(
        setup(2, true, move |work: &Work| {
            notes[work.node.index()].fetch_add(1, Ordering::Relaxed);
        }),
        |_| (),
    );
    wait_for(|| ran[0].load(Ordering::Relaxed) > 3);
    let task = run.task;
    let edit = move |scheduler: &mut Scheduler<Small>, now| {
        let mut dag = scheduler.edit(task).expect("it was admitted");
        dag.add_node(Node::new(Wcet::from_millis(1))).expect("there is room");
        scheduler.commit(&dag, now).map(drop)
    };
    let committed = look(&run.control, move |scheduler, now| scheduler.edit(0, now, |s| edit(s, now)));
    assert_eq!(committed, Ok(Ok(())));
    wait_for(|| ran[1].load(Ordering::Relaxed) > 3);
    // Counters of a run that goes on, its time, and a task that is taken away.
    let before = run.control.now_ns();
    let (units, at) = look(&run.control, |s, now| (s.counters().units, now)).expect("it runs");
    assert!(units > 6 && before <= at.as_nanos() && at.as_nanos() <= run.control.now_ns(), "{units} {at:?}");
    assert_eq!(look(&run.control, move |s, now| s.remove_task(task, now)), Ok(true));
    let report = run.stop();
    assert_eq!((report.stopped_by, report.failed), (Some(Stopped::Caller), 0));
}

#[test]
fn what_an_errand_makes_ready_is_dispatched_in_the_same_turn() {
    let ran = Arc::new(AtomicU64::new(0));
    let notes = ran.clone();
    // Nothing else happens in it: no lane has another turn.
    let run = Run::start(setup(2, false, move |_: &Work| count(&notes, 1)), |_| ());
    for job in 1..=20 {
        let task = run.task;
        let released = look(&run.control, move |s, now| s.release_at(task, now, None, now).is_ok());
        assert_eq!(released, Ok(true));
        wait_for(|| ran.load(Ordering::Relaxed) == job);
    }
    assert_eq!(run.stop().failed, 0);
}

#[test]
fn who_could_wait_for_himself_is_refused() {
    static RUNNING: OnceLock<Arc<dyn Control<Small>>> = OnceLock::new();
    let refused = Arc::new(Mutex::new(Vec::new()));
    let nothing = || -> Errand<Small> { Box::new(|_, _| panic!("it ran")) };
    let from_body = refused.clone();
    let body = move |_: &Work| {
        if let Some(control) = RUNNING.get() {
            from_body.lock().expect("nobody panicked").push(control.ask(nothing()).err());
        }
    };
    let from_start = refused.clone();
    let run = Run::start(setup(1, true, body), move |(control, _)| {
        from_start.lock().expect("nobody panicked").push(control.ask(nothing()).err());
    });
    let control = run.control.clone();
    let nested = look(&run.control, move |_, _| control.ask(nothing()).err());
    assert_eq!(nested, Ok(Some(AskError::OnLane)));
    assert!(RUNNING.set(run.control.clone()).is_ok());
    wait_for(|| refused.lock().expect("nobody panicked").len() > 3);
    let report = run.stop();
    assert_eq!((report.failed, report.hung), (0, 0), "{:?}", report.panics);
    assert!(refused.lock().expect("nobody panicked").iter().all(|e| *e == Some(AskError::OnLane)));
}

#[test]
fn an_errand_after_the_end_is_dropped_and_not_run() {
    let (mut setup, task) = setup(1, true, |_: &Work| ());
    // By the clock, and not by a stop.
    (setup.duration_ns, setup.drain_ns) = (20_000_000, 1 << 62);
    let run = Run::start((setup, task), |_| ());
    let report = run.ended().1;
    assert_eq!(report.stopped_by, None);
    let held = Arc::new(());
    for _ in 0..3 {
        let captured = held.clone();
        let errand: Errand<Small> = Box::new(move |_, _| panic!("it ran: {captured:?}"));
        assert_eq!(ask(&run.control, errand).err(), Some(AskError::Over));
        assert_eq!(Arc::strong_count(&held), 1, "nothing of it is left");
    }
}

#[test]
fn a_panic_of_an_errand_is_the_askers_and_leaves_lane_and_lock_whole() {
    let ran = Arc::new(AtomicU64::new(0));
    let notes = ran.clone();
    let run = Run::start(setup(1, true, move |_: &Work| count(&notes, 1)), |_| ());
    for number in 0..3 {
        let panics: Errand<Small> = Box::new(move |_, _| panic!("number {number}"));
        assert_eq!(ask(&run.control, panics).err(), Some(AskError::Panicked(format!("number {number}"))));
        let before = ran.load(Ordering::Relaxed);
        assert_eq!(look(&run.control, |s, _| s.lanes()), Ok(1));
        wait_for(|| ran.load(Ordering::Relaxed) > before);
    }
    let report = run.stop();
    assert_eq!((report.threads_died, report.lanes_lost, report.hung, report.failed), (0, 0, 0, 0));
}

#[test]
fn no_lane_takes_or_gives_memory_for_an_errand() {
    let run = Run::start(setup(2, true, |_: &Work| ()), |_| ());
    let counted = Arc::new(AtomicU64::new(0));
    let counts = counted.clone();
    // The same box again and again, and a new one each time.
    let mut errand: Errand<Small> = Box::new(move |_, _| count(&counts, 1));
    for _ in 0..200 {
        errand = run.control.ask(errand).map_err(|e| e.to_string()).expect("it runs");
        let counts = counted.clone();
        let large = [1_u64; 32];
        let other: Errand<Small> = Box::new(move |_, _| count(&counts, large[0]));
        drop(run.control.ask(other).map_err(|e| e.to_string()).expect("it runs"));
    }
    let report = run.stop();
    assert_eq!((counted.load(Ordering::Relaxed), report.allocations), (400, 0));
}

/// What asking threads did: errands that ran, those that came back done, and those that were refused.
#[derive(Default)]
struct Tried {
    ran: AtomicUsize,
    done: AtomicUsize,
    over: AtomicUsize,
}

/// Asks again and again until the run is over.
fn pester(run: &Run, tried: &Arc<Tried>, held: &Arc<()>) -> JoinHandle<()> {
    let (control, tried, held) = (run.control.clone(), tried.clone(), held.clone());
    thread::spawn(move || {
        loop {
            let (runs, captured, mut times) = (tried.clone(), held.clone(), 0);
            let errand: Errand<Small> = Box::new(move |scheduler, _| {
                let _held = &captured;
                times += 1;
                assert_eq!((times, scheduler.jobs_in_flight() <= 16), (1, true), "an errand runs once");
                runs.ran.fetch_add(1, Ordering::Relaxed);
            });
            match control.ask(errand) {
                Ok(_) => tried.done.fetch_add(1, Ordering::Relaxed),
                Err(error) => {
                    assert_eq!(error, AskError::Over);
                    tried.over.fetch_add(1, Ordering::Relaxed);
                    break;
                }
            };
        }
    })
}

/// Waits for threads, and not for ever.
fn join(asking: Vec<JoinHandle<()>>) {
    wait_for(|| asking.iter().all(JoinHandle::is_finished));
    asking.into_iter().for_each(|thread| thread.join().expect("it only asks"));
}

#[test]
fn hundreds_of_errands_from_three_threads_run_once_each_whatever_the_lanes_do() {
    const ERRANDS: usize = 600;
    /// Jobs whose bodies go on beyond their bounds.
    const HANGS: [u64; 2] = [5, 40];
    let may_end = Arc::new(AtomicBool::new(false));
    let (waits, bodies) = (may_end.clone(), Arc::new(AtomicU64::new(0)));
    let counts = bodies.clone();
    let run = Run::start(
        setup(2, true, move |work: &Work| {
            counts.fetch_add(1, Ordering::Relaxed);
            if HANGS.contains(&work.job) {
                wait_for(|| waits.load(Ordering::Relaxed));
            }
        }),
        |_| (),
    );
    let (tried, held) = (Arc::new(Tried::default()), Arc::new(()));
    let asking: Vec<_> = (0..3).map(|_| pester(&run, &tried, &held)).collect();
    let releasing = {
        let (control, task) = (run.control.clone(), run.task);
        thread::spawn(move || {
            let mut taken = 0;
            loop {
                match control.release(task, Some(taken)) {
                    Ok(()) => taken += 1,
                    Err(Refused::Over) => break taken,
                    Err(_) => {}
                }
                thread::sleep(Duration::from_micros(500));
            }
        })
    };
    // Also after both lanes have got other threads.
    wait_for(|| tried.done.load(Ordering::Relaxed) >= ERRANDS && bodies.load(Ordering::Relaxed) > 100);
    let report = run.stop();
    join(asking);
    assert!(releasing.join().expect("it only releases") > 0);
    may_end.store(true, Ordering::Relaxed);
    let [ran, done, over] = [&tried.ran, &tried.done, &tried.over].map(|count| count.load(Ordering::Relaxed));
    assert_eq!((ran, over), (done, 3), "what came back done ran, and nothing else did");
    assert_eq!(Arc::strong_count(&held), 1, "no errand is left anywhere");
    assert_eq!((report.hung, report.lanes_lost, report.allocations), (2, 0, 0), "{:?}", report.panics);
    assert_eq!((report.failed, report.threads_died), (0, 0));
}

#[test]
fn errands_and_stops_that_meet_leave_nobody_waiting() {
    for round in 0..40 {
        let run = Run::start(setup(1 + round % 2, round % 3 == 0, |_: &Work| ()), |_| ());
        let (tried, held) = (Arc::new(Tried::default()), Arc::new(()));
        let asking: Vec<_> = (0..3).map(|_| pester(&run, &tried, &held)).collect();
        wait_for(|| tried.done.load(Ordering::Relaxed) >= usize::from(round));
        let report = run.stop();
        join(asking);
        let [ran, done] = [&tried.ran, &tried.done].map(|count| count.load(Ordering::Relaxed));
        assert_eq!((ran, Arc::strong_count(&held)), (done, 1));
        assert_eq!((report.threads_died, report.lanes_lost), (0, 0));
    }
}

#[test]
fn who_waits_for_lanes_that_are_all_lost_is_told_when_the_run_gives_up() {
    let is_over = Arc::new(AtomicBool::new(false));
    let (over, has_begun, made) = (is_over.clone(), Arc::new(AtomicBool::new(false)), AtomicUsize::new(0));
    let begins = has_begun.clone();
    let (setup, task) = setup(1, true, move |_: &Work| {
        begins.store(true, Ordering::Relaxed);
        wait_for(|| over.load(Ordering::Relaxed));
    });
    let first = setup.handlers.clone();
    let handlers = move |lane| {
        assert_eq!(made.fetch_add(1, Ordering::Relaxed), 0, "of the spare");
        first(lane)
    };
    let run = Run::start((Setup { handlers: Arc::new(handlers), ..setup }, task), |_| ());
    wait_for(|| has_begun.load(Ordering::Relaxed));
    let held = Arc::new(());
    let captured = held.clone();
    let errand: Errand<Small> = Box::new(move |_, _| panic!("it ran: {captured:?}"));
    assert_eq!(ask(&run.control, errand).err(), Some(AskError::Over));
    assert_eq!(Arc::strong_count(&held), 1);
    let report = run.ended().1;
    is_over.store(true, Ordering::Relaxed);
    assert_eq!((report.gave_up, report.stopped_by), (Some(Surrender::NoLane), None));
}

#[test]
fn a_panic_as_the_run_starts_lets_who_waits_go() {
    let (told, answer) = mpsc::channel();
    let (setup, _) = setup(1, true, |_: &Work| ());
    let starts = thread::spawn(move || {
        let started = |control: Arc<dyn Control<Small>>| {
            let asks = control.clone();
            let (is_asking, asking) = mpsc::channel();
            thread::spawn(move || {
                is_asking.send(()).expect("somebody waits");
                told.send(asks.ask(Box::new(|_, _| panic!("it ran"))).err()).expect("somebody waits");
            });
            asking.recv().expect("it asks");
            panic!("of the caller");
        };
        run(setup, Counted::default(), started, |_| ()).map(|(_, report)| report)
    });
    assert!(starts.join().is_err());
    assert_eq!(answer.recv_timeout(FAR), Ok(Some(AskError::Over)));
}
