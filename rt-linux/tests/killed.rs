//! Errands where threads of lanes are killed. In a process of its own, which ends without a look back: what a killed
//! thread had in hand is lost, and says so wherever somebody counts.

mod called;

use called::{FAR, Run, setup, wait_for};
use std::env;
use std::process::Command;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, mpsc};
use std::thread;

use red_rt::control::{AskError, Errand};
use red_rt::handler::Work;

const APART: &str = "RED_RT_KILLED_APART";
/// Jobs whose bodies kill their threads: more than there are lanes, so that some were replaced.
const KILLS: [u64; 3] = [5, 55, 105];
static KILLED: AtomicU64 = AtomicU64::new(0);

fn dies(work: &Work) {
    if KILLS.contains(&work.job) {
        KILLED.fetch_add(1, Ordering::Relaxed);
        end_this_thread();
    }
}

/// Past all that Rust knows of it, as a kill of the thread would.
fn end_this_thread() {
    // SAFETY: takes an integer; nothing that the thread owns is freed while somebody else has it.
    unsafe { libc::syscall(libc::SYS_exit, 0) };
}

/// Lanes die in bodies beside errands; then one dies in an errand, and the scheduler's lock with it.
fn killed() {
    let run = Run::start(setup(2, true, dies), |_| ());
    let ran = Arc::new(AtomicU64::new(0));
    let threads: Vec<_> = (0..3)
        .map(|_| {
            let (control, ran) = (run.control.clone(), ran.clone());
            thread::spawn(move || {
                let mut done = 0;
                let mut errand: Errand<_> = Box::new(move |_, _| {
                    ran.fetch_add(1, Ordering::Relaxed);
                });
                while done < 200 || KILLED.load(Ordering::Relaxed) < KILLS.len() as u64 {
                    errand = control.ask(errand).map_err(|e| e.to_string()).expect("the run goes on");
                    done += 1;
                }
                done
            })
        })
        .collect();
    wait_for(|| KILLED.load(Ordering::Relaxed) == KILLS.len() as u64);
    let done: u64 = threads.into_iter().map(|thread| thread.join().expect("it only asks")).sum();
    assert_eq!(ran.load(Ordering::Relaxed), done);
    let report = run.stop();
    assert!(report.threads_died > 0 && report.lanes_lost == 0, "{report:?}");
    println!("{done} errands beside {} deaths that were found", report.threads_died);

    // One lane: glibc ends a process where somebody waited for a lock whose holder died.
    let run = Run::start(setup(1, false, |_: &Work| ()), |_| ());
    run.control.release(run.task, None).expect("the run goes on");
    let (told, answers) = mpsc::channel();
    let asks = |errand: Errand<_>| {
        let (control, told) = (run.control.clone(), told.clone());
        thread::spawn(move || told.send(control.ask(errand).err()));
        answers.recv_timeout(FAR).expect("an answer")
    };
    assert_eq!(asks(Box::new(|_, _| end_this_thread())), Some(AskError::Lost));
    for _ in 0..2 {
        assert_eq!(asks(Box::new(|_, _| panic!("it ran"))), Some(AskError::Over));
    }
}

#[test]
fn no_asker_waits_for_a_thread_that_was_killed() {
    if env::var_os(APART).is_some() {
        killed();
        println!("nobody waits");
        // SAFETY: ends the process at once.
        unsafe { libc::_exit(0) };
    }
    let program = env::current_exe().expect("this program");
    let test = "no_asker_waits_for_a_thread_that_was_killed";
    let output = Command::new(program).args(["--exact", test, "--nocapture"]).env(APART, "1").output();
    let output = output.expect("this program starts");
    let (out, err) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success() && out.contains("nobody waits"), "{}\n{out}\n{err}", output.status);
}
