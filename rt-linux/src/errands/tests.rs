use super::{Errands, Undone};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

#[test]
fn an_errand_goes_to_a_lane_and_back_and_the_next_one_too() {
    let errands = Errands::<u32>::default();
    thread::scope(|threads| {
        threads.spawn(|| {
            for expected in [1, 2] {
                let taken = loop {
                    match errands.take(7) {
                        Some(taken) => break taken,
                        None => thread::yield_now(),
                    }
                };
                assert_eq!((taken, errands.take(7)), (expected, None));
                errands.answer(taken * 10);
                errands.ring();
            }
        });
        for errand in [1, 2] {
            let answer = errands.ask(errand, || (), |_| panic!("it answers at once, or within a look"));
            assert!(matches!(answer, Ok(answer) if answer == errand * 10), "{answer:?}");
        }
    });
}

#[test]
fn an_errand_that_nobody_takes_comes_back_when_the_run_is_over() {
    let errands = Errands::<u32>::default();
    // Before, and for every later one.
    errands.close();
    for errand in [1, 2] {
        let answer = errands.ask(errand, || (), |_| false);
        assert!(matches!(answer, Err(Undone::Over(back)) if back == errand), "{answer:?}");
        assert_eq!(errands.take(7), None, "it was taken back");
    }
    // While it waits.
    let errands = Errands::<u32>::default();
    let answer = errands.ask(3, || errands.close(), |_| false);
    assert!(matches!(answer, Err(Undone::Over(3))), "{answer:?}");
}

#[test]
fn an_errand_that_was_taken_is_waited_for_also_after_the_end_unless_its_thread_has_ended() {
    let errands = Errands::<u32>::default();
    let was_asked = AtomicBool::new(false);
    let taken = || assert_eq!(errands.take(7), Some(1));
    let has_ended = |thread| {
        assert_eq!(thread, 7);
        // Before, it is alive, and the end of the run changes nothing.
        was_asked.swap(true, Ordering::Relaxed)
    };
    let answer = errands.ask(1, || [taken(), errands.close()][0], has_ended);
    assert!(matches!(answer, Err(Undone::Lost)), "{answer:?}");
    assert!(was_asked.into_inner());
    let answer = errands.ask(2, || (), |_| false);
    assert!(matches!(answer, Err(Undone::Over(2))), "the lock is lost, too: {answer:?}");
}

#[test]
fn an_answer_is_found_where_its_thread_has_ended_and_nobody_rang() {
    let errands = Errands::<u32>::default();
    let taken = || assert_eq!(errands.take(7), Some(1));
    let has_ended = |_| {
        errands.answer(2);
        true
    };
    let answer = errands.ask(1, taken, has_ended);
    assert!(matches!(answer, Ok(2)), "{answer:?}");
}
