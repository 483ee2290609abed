use std::cell::RefCell;
use std::rc::Rc;

use super::*;

fn fixed(name: &str, nanoseconds: u64, log: &Rc<RefCell<String>>) -> Entry {
    let (mark, log) = (name.to_owned(), Rc::clone(log));
    let runner: Runner = Box::new(move |runs, samples| {
        log.borrow_mut().push_str(&mark);
        samples.fill(nanoseconds * runs as u64);
        Ok(())
    });
    Entry { name: name.to_owned(), ours: false, runner: Ok(runner) }
}

#[test]
fn contestants_take_turns_and_the_warm_up_is_not_kept() {
    let log = Rc::default();
    let plan = Plan { rounds: 2, samples: 3, runs: 5, units: 4 };
    let rows = interleave(vec![fixed("A", 40, &log), fixed("B", 20, &log)], &plan);
    assert_eq!(*log.borrow(), "ABABAB");
    assert_eq!(rows[0].rounds.as_deref().ok(), Some(&[10.0, 10.0][..]));
    assert_eq!(ratio(&rows[0], &rows[1]), Some(2.0));
}

#[test]
fn one_that_breaks_off_keeps_its_reason_and_the_others_their_figures() {
    let broken: Runner = Box::new(|_, _| Err(NotRun::Failed("gone".to_owned())));
    let entries = vec![
        Entry { name: "broken".to_owned(), ours: false, runner: Ok(broken) },
        Entry { name: "absent".to_owned(), ours: false, runner: Err(NotRun::Missing("valgrind")) },
        fixed("A", 8, &Rc::default()),
    ];
    let rows = interleave(entries, &Plan { rounds: 1, samples: 1, runs: 1, units: 1 });
    assert!(matches!(rows[0].rounds, Err(NotRun::Failed(_))));
    assert!(matches!(rows[1].rounds, Err(NotRun::Missing(_))));
    assert_eq!(rows[2].rounds.as_deref().ok(), Some(&[8.0][..]));
    assert_eq!(ratio(&rows[0], &rows[2]), None);
}

#[test]
fn ratio_pairs_the_rounds_before_it_takes_the_median() {
    let row = |rounds: &[f64]| Row { name: String::new(), ours: false, rounds: Ok(rounds.to_vec()) };
    // The machine is ten times slower in the second round, for both.
    assert_eq!(ratio(&row(&[2.0, 20.0, 2.0]), &row(&[1.0, 10.0, 1.0])), Some(2.0));
}
