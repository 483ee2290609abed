//! A run leaves the process as it was. Of the whole process, so this test has one of its own. Needs the rights of
//! `with_rights`, and fails without.

mod called;

use called::{Counted, Run, Small, setup, wait_for};
use std::fs;
use std::hint::black_box;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use red_core::TaskId;
use red_rt::handler::Work;
use red_rt::placement::usable_cpus;
use red_rt::runtime::{Mode, Setup, run};
use red_rt::setup::lock_memory;
use red_rt::usage::Usage;

/// KiB that this process has locked.
fn locked() -> u64 {
    let status = fs::read_to_string("/proc/self/status").expect("every process has one");
    let line = status.lines().find(|line| line.starts_with("VmLck:")).expect("Linux has it");
    line.split_whitespace().nth(1).expect("a number").parse().expect("a number")
}

/// Page faults of a block that is large enough for a mapping of its own, where there was one before.
fn faults() -> u64 {
    let mut used = Usage::of_thread();
    for _ in 0..2 {
        used = Usage::of_thread();
        black_box(vec![1_u8; 24 << 20]);
    }
    Usage::of_thread().since(used).minor_faults
}

/// What is locked while a run lasts, and faults meanwhile.
fn during(mode: Mode) -> (u64, u64) {
    let ran = Arc::new(AtomicU64::new(0));
    let count = ran.clone();
    let (setup, task): (Setup<Small>, TaskId) = setup(1, false, move |_: &Work| {
        count.fetch_add(1, Ordering::Relaxed);
    });
    let run = Run::start((Setup { mode, ..setup }, task), |_| ());
    run.control.release(run.task, None).expect("nothing else asked");
    wait_for(|| ran.load(Ordering::Relaxed) > 0);
    let found = (locked(), faults());
    run.stop();
    found
}

#[test]
fn memory_is_locked_and_kept_as_long_as_a_run_in_real_time_lasts() {
    let cpu = *usable_cpus().expect("an affinity mask").last().expect("at least one CPU");
    let in_real_time = |cpu| Mode::RealTime { priority: 40, cpus: vec![cpu] };

    let (kib, anew) = during(Mode::BestEffort);
    assert!(kib == 0 && anew > 1_000, "best effort: {kib} KiB locked, {anew} faults");

    let (kib, anew) = during(in_real_time(cpu));
    assert!(kib > 1_000 && anew < 10, "{kib} KiB locked, {anew} faults");
    let (kib, anew) = (locked(), faults());
    assert!(kib == 0 && anew > 1_000, "afterwards: {kib} KiB locked, {anew} faults");

    let refused = Setup { mode: in_real_time(1_000), ..setup(1, true, |_: &Work| ()).0 };
    let refused = run(refused, Counted::default(), |_| (), |_| ()).err();
    let (kib, anew) = (locked(), faults());
    assert!(refused.is_some() && kib == 0 && anew > 1_000, "{refused:?}: {kib} KiB locked, {anew} faults");

    lock_memory().expect("it was permitted before");
    during(in_real_time(cpu));
    assert!(locked() > 1_000, "what the program had locked is not");
}
