//! Rows 47 and 48: texts, and from where calls come.

use super::world::World;
use red_core::Empty;
use red_ffi::*;
use std::ffi::c_char;
use std::ptr::null_mut;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::sync::{Barrier, Mutex};
use std::time::{Duration, Instant};

/// Memory of one page that ends where nothing may be read.
fn page(fill: u8) -> *mut u8 {
    let (read_write, none) = (libc::PROT_READ | libc::PROT_WRITE, libc::PROT_NONE);
    let kind = libc::MAP_PRIVATE | libc::MAP_ANONYMOUS;
    // SAFETY: new memory, wherever the kernel likes.
    let two = unsafe { libc::mmap(null_mut(), 8192, none, kind, -1, 0) };
    assert_ne!(two, libc::MAP_FAILED);
    // SAFETY: the first of the two pages.
    assert_eq!(unsafe { libc::mprotect(two, 4096, read_write) }, 0);
    // SAFETY: all of that page, which may be written now.
    unsafe { two.cast::<u8>().write_bytes(fill, 4096) };
    two.cast()
}

#[test]
fn row_47_a_text_that_is_empty_not_utf_8_or_without_an_end_is_told_and_never_read_further() {
    let mut world = World::new();
    world.open_empty_runtime();
    let runtime = &raw mut world.runtime;
    let record = |text: *const c_char| red_runtime_record(runtime, text);
    assert_eq!(record(c"".as_ptr()), red_status::Text);
    for wrong in [c"\xff", c"a\xc3", c"\xed\xa0\x80", c"a/\xf8\x88\x80\x80\x80"] {
        assert_eq!(record(wrong.as_ptr()), red_status::Text, "{wrong:?}");
    }
    // No end, with nothing to be read behind it: 4,096 bytes are the most that is looked at.
    assert_eq!(record(page(b'a').cast()), red_status::Text);
    // Ten million bytes before its end, of which no more is read.
    let long = std::ffi::CString::new(vec![b'a'; 10_000_000]).expect("no end inside");
    assert_eq!(record(long.as_ptr()), red_status::Text);
    // A name is all right, and there is no such place; or one too long for a file.
    assert_eq!(record(c"/nowhere/at/all/x.redlog".as_ptr()), red_status::LogFile);
    let (name, last) = (page(b'a'), 4095);
    // SAFETY: the last byte of the page.
    unsafe { name.wrapping_add(last).write(0) };
    assert_eq!(record(name.cast()), red_status::LogFile);
    // Nothing was begun by all this.
    let mut report = world.report;
    assert_eq!(red_runtime_report(runtime, &raw mut report), red_status::Ok);
    assert_eq!(report.state, red_runtime_state::SetUp as u32);
    let (scheduler, text) = (&raw mut world.scheduler, page(b'a'));
    assert_eq!(red_record_begin(scheduler, text.cast()), red_status::Text);
    assert_eq!(red_record_begin(scheduler, c"x.redlog".as_ptr()), red_status::LogLate);
}

/// The scheduler that the handler calls, and what it was answered.
static HANDLE: AtomicU64 = AtomicU64::new(0);
static BUSY: AtomicU32 = AtomicU32::new(0);
static DONE: AtomicU32 = AtomicU32::new(0);
static OTHER: AtomicU32 = AtomicU32::new(0);
/// Interrupted calls come within the first milliseconds.
const LONG: Duration = Duration::from_secs(60);

extern "C" fn interrupts(_signal: i32) {
    let mut handle = red_scheduler { bits: HANDLE.load(Ordering::Relaxed) };
    let mut action = red_action::EMPTY;
    match red_scheduler_poll(&raw mut handle, 0, &raw mut action) {
        red_status::Busy => BUSY.fetch_add(1, Ordering::Relaxed),
        red_status::Ok => DONE.fetch_add(1, Ordering::Relaxed),
        _ => OTHER.fetch_add(1, Ordering::Relaxed),
    };
}

#[test]
fn row_48_a_call_from_below_another_one_is_busy_and_a_child_of_fork_is_told() {
    // A signal handler that calls in the middle of calls: told, or done where none goes on.
    let mut world = World::new();
    HANDLE.store(world.scheduler.bits, Ordering::Relaxed);
    // SAFETY: the handler makes calls that say of themselves that they may come from anywhere.
    unsafe { libc::signal(libc::SIGUSR2, interrupts as extern "C" fn(i32) as libc::sighandler_t) };
    // SAFETY: this thread's own number.
    let me = unsafe { libc::pthread_self() };
    let is_over = AtomicBool::new(false);
    let mut refused = None;
    std::thread::scope(|scope| {
        scope.spawn(|| {
            while !is_over.load(Ordering::Relaxed) {
                // SAFETY: that thread waits for this one.
                unsafe { libc::pthread_kill(me, libc::SIGUSR2) };
                std::thread::yield_now();
            }
        });
        let begin = Instant::now();
        let waits = || BUSY.load(Ordering::Relaxed) == 0 || DONE.load(Ordering::Relaxed) == 0;
        while waits() && begin.elapsed() < LONG {
            for _ in 0..1_000 {
                let mut count = 0;
                let taken =
                    red_scheduler_take_events(&raw mut world.scheduler, null_mut(), 0, &raw mut count);
                refused = refused.or((taken != red_status::Ok).then_some(taken));
            }
        }
        is_over.store(true, Ordering::Relaxed);
    });
    let answers = [&BUSY, &DONE, &OTHER].map(|answer| answer.load(Ordering::Relaxed));
    assert!(answers[0] > 0 && answers[1] > 0, "busy, done, other: {answers:?}");
    assert_eq!((answers[2], refused), (0, None), "no other answer, and none to who was interrupted");
    // From other threads: one after the other, wherever they are; looks at once.
    let (all_looked, turn) = (Barrier::new(4), Mutex::new(()));
    std::thread::scope(|scope| {
        let (handle, all_looked, turn) = (world.scheduler, &all_looked, &turn);
        for _ in 0..4 {
            scope.spawn(move || {
                let (mut handle, mut at_ns, mut count) = (handle, 0, 0);
                for _ in 0..1_000 {
                    assert_eq!(red_scheduler_poll_at(&raw const handle, &raw mut at_ns), red_status::Ok);
                }
                all_looked.wait();
                for _ in 0..1_000 {
                    let _mine = turn.lock().expect("no panic");
                    let taken = red_scheduler_take_events(&raw mut handle, null_mut(), 0, &raw mut count);
                    assert_eq!(taken, red_status::Ok);
                }
            });
        }
    });
    // A child of fork has the runtime's memory, and none of its threads.
    world.start_runtime();
    // SAFETY: the child makes a few calls that take no lock and allocate nothing, and ends.
    let child = unsafe { libc::fork() };
    if child == 0 {
        let runtime = &raw mut world.runtime;
        let told = [
            red_runtime_release(runtime, world.task, RED_NONE_64),
            red_runtime_stop(runtime),
            red_runtime_wait(runtime, 0),
            red_runtime_close(runtime),
        ];
        let all = told.iter().all(|status| *status == red_status::Forked);
        // The scheduler is memory, and works.
        let works = red_scheduler_complete(&raw mut world.scheduler, world.running, 9) == red_status::Ok;
        // SAFETY: ends the child, and nothing of this program runs in it any more.
        unsafe { libc::_exit(if all && works { 0 } else { 1 }) };
    }
    let mut status = 0;
    // SAFETY: a child of this process, and a place for how it ended.
    assert_eq!(unsafe { libc::waitpid(child, &raw mut status, 0) }, child);
    assert_eq!(status, 0, "the child was told");
    assert_eq!(red_runtime_release(&raw const world.runtime, world.task, RED_NONE_64), red_status::Ok);
}
