#![allow(unsafe_code, reason = "what C gives to bodies")]
//! A runtime before it starts, and what its lanes use of it. The interpreter has no CPUs to run lanes on.

use super::bodies::{Bodies, Calls};
use super::called::engine;
use super::notes::{Notes, Teller};
use super::text;
use crate::tests::{Block, headed, ok};
use crate::*;
use core::ffi::{c_char, c_int, c_void};
use core::ptr;
use core::sync::atomic::Ordering;
use red_core::{Empty, Event, Outcome, TaskId, UnitId};
use red_rt::handler::{Failed, Handler, Work};
use red_rt::timeline::Host;
use std::sync::Arc;
use std::thread;

const ROUNDS: u64 = if cfg!(miri) { 5 } else { 100_000 };

/// Bodies that know what comes with them.
extern "C" fn first(user: *mut c_void, _context: *const red_context) -> c_int {
    is(user, 1)
}

extern "C" fn second(user: *mut c_void, context: *const red_context) -> c_int {
    // SAFETY: the runtime says that there is one.
    let context = unsafe { context.read() };
    if context.struct_size as usize == size_of::<red_context>() { is(user, 2) } else { RED_BODY_THREW }
}

fn is(user: *mut c_void, number: u32) -> c_int {
    // SAFETY: every test gives a number.
    if unsafe { user.cast::<u32>().read() } == number { RED_BODY_DONE } else { RED_BODY_THREW }
}

fn callback(node: u32, body: red_body, user: &mut u32) -> red_callback {
    red_callback { node, body, user: ptr::from_mut(user).cast(), ..red_callback::EMPTY }
}

fn open() -> red_runtime {
    let mut policy = headed!(red_config {});
    ok(red_config_preset(red_preset::Edf as u32, &raw mut policy));
    let mode = red_mode::BestEffort as u32;
    let config = headed!(red_runtime_config { mode: mode, priority: 80 });
    let mut runtime = red_runtime::default();
    ok(red_runtime_open(&raw const policy, &raw const config, &raw mut runtime));
    runtime
}

#[test]
fn a_runtime_is_set_up_and_closed() {
    let mut runtime = open();
    let at = &raw mut runtime;
    let (mut pool, mut sensor, mut state, mut now) = (0, 0, 7, 0);
    ok(red_runtime_now(&raw mut now));
    ok(red_runtime_add_pool(at, 1, RED_NONE_64, &raw mut pool));
    ok(red_runtime_add_sensor(at, 33, &raw mut sensor));
    let cpus = Block::holding(&[0_u32, 1]);
    ok(red_runtime_pin(at, cpus.pointer(), 2));
    ok(red_runtime_state_of(at, &raw mut state));
    assert_eq!((pool, sensor, state), (1, 0, red_runtime_state::SetUp as u32));
    for refused in [
        red_runtime_release(at, 0, RED_NONE_64),
        red_runtime_stop(at),
        red_runtime_wait(at, 1),
        red_runtime_every(at, 0, 0, 0),
    ] {
        assert!(matches!(refused, red_status::Idle | red_status::UnknownTask), "{refused:?}");
    }
    let (text, mut count) = (Block::<c_char>::of(1), 7);
    ok(red_runtime_message(at, text.pointer(), 1, &raw mut count));
    assert_eq!((text.get(0), count), (0, 1));
    let (outcomes, events) = (Block::<red_outcome>::of(1), Block::<red_event>::of(1));
    ok(red_runtime_take_outcomes(at, outcomes.pointer(), 1, &raw mut count));
    ok(red_runtime_take_events(at, events.pointer(), 1, &raw mut count));
    let mut report = headed!(red_report {});
    ok(red_runtime_report(at, &raw mut report));
    assert_eq!((count, report.released, report.units), (0, 0, RED_NONE_64));
    let (mut stale, notes) = (runtime, engine(runtime.bits).map(|engine| engine.notes.clone()));
    ok(red_runtime_close(&raw mut runtime));
    assert_eq!(runtime, red_runtime::default());
    assert_eq!(notes.map(Arc::into_inner).map(|last| last.is_some()), Ok(true), "all of it is freed");
    assert_eq!(red_runtime_close(&raw mut stale), red_status::Closed);
}

#[test]
fn a_runtime_that_is_closed_is_there_for_calls_that_go_on() {
    for _ in 0..if cfg!(miri) { 3 } else { 100 } {
        let (mut mine, copy) = (open(), |runtime: &red_runtime| red_runtime { bits: runtime.bits });
        let mut theirs = copy(&mine);
        let calls = thread::spawn(move || {
            let mut state = 7;
            while red_runtime_state_of(&raw const theirs, &raw mut state) == red_status::Ok {}
            red_runtime_close(&raw mut theirs)
        });
        ok(red_runtime_close(&raw mut mine));
        assert_eq!(calls.join().expect("no panic"), red_status::Closed);
    }
}

#[test]
fn tasks_of_a_runtime_come_with_their_bodies() {
    let mut runtime = open();
    let at = &raw mut runtime;
    let memory = Block::aligned(RED_DAG_16X256X64_BYTES, RED_ALIGN);
    let (mut dag, mut number, mut task) = (red_dag::default(), 0, RED_NONE);
    ok(red_dag_open_16x256x64(memory.lent(0), memory.bytes(), &raw mut dag));
    let node = headed!(red_node { wcet_ns: 5, sensor: RED_NONE });
    ok(red_dag_add_node(&raw mut dag, &raw const node, &raw mut number));
    let timing = headed!(red_timing { deadline_ns: 50, value: 1 });
    let (mut one, mut two) = (1, 2);
    let mut add = |dag: &red_dag, body| {
        let bodies = Block::holding(&[callback(0, body, &mut one)]);
        red_runtime_add_task(at, dag, bodies.pointer(), 1, &raw const timing, &raw mut task)
    };
    assert_eq!(add(&dag, None), red_status::NoBody);
    ok(add(&dag, Some(first)));
    ok(red_runtime_every(at, task, 1, 2));
    ok(red_dag_close(&raw mut dag));

    ok(red_runtime_edit(at, task, memory.lent(0), memory.bytes(), &raw mut dag));
    ok(red_dag_add_node(&raw mut dag, &raw const node, &raw mut number));
    let mut proof = headed!(red_certificate {});
    let without = red_runtime_commit(at, &raw const dag, ptr::null(), 0, &raw mut proof);
    assert_eq!(without, red_status::NoBody);
    let bodies = Block::holding(&[callback(number, Some(second), &mut two)]);
    ok(red_runtime_commit(at, &raw const dag, bodies.pointer(), 1, &raw mut proof));
    ok(red_runtime_certificate(at, task, &raw mut proof));
    assert_eq!(proof.work_ns, 10);
    ok(red_runtime_remove_task(at, task));
    assert_eq!(red_runtime_remove_task(at, task), red_status::UnknownTask);
    let mut figures = headed!(red_figures {});
    ok(red_runtime_figures(at, &raw mut figures));
    assert_eq!(figures.lanes, 1);
    ok(red_runtime_close(at));
    ok(red_dag_close(&raw mut dag));
}

#[test]
fn a_body_is_called_with_what_came_with_it_while_another_takes_its_place() {
    let (bodies, task) = (Bodies::new(), TaskId::from_bits(0));
    let work = Work { unit: UnitId::from_bits(1 << 16), ..Work::default() };
    let (mut one, mut two) = (1, 2);
    let both = Block::holding(&[callback(0, Some(first), &mut one), callback(0, Some(second), &mut two)]);
    let mut calls = Calls::new(bodies.clone());
    assert_eq!(calls.run(&work), Err(Failed), "there is none yet");
    thread::scope(|scope| {
        let sets = scope.spawn(|| (0..ROUNDS).for_each(|i| bodies.set(task, 0, &[both.get(i as usize % 2)])));
        calls.begin(7);
        while !sets.is_finished() {
            // It is called, or not where the other one comes between.
            let _ran = calls.run(&work);
        }
    });
    assert_eq!(calls.run(&work), Ok(()));
    assert_eq!(bodies.threw.load(Ordering::Relaxed), 0, "a body had what belongs to another");
}

#[test]
fn outcomes_and_events_reach_who_takes_them() {
    let notes = Notes::new();
    notes.origin_ns.store(1_000, Ordering::Relaxed);
    let mut teller = Teller::new(notes.clone());
    let tells = thread::spawn(move || {
        for i in 0..ROUNDS {
            teller.ended(&Outcome { index: i, ..Outcome::EMPTY });
            teller.event(&Event { job: i, ..Event::EMPTY });
        }
    });
    let (mut outcomes, mut events) = (Vec::new(), Vec::new());
    let mut take = || {
        outcomes.extend(std::iter::from_fn(|| notes.take_outcome()));
        events.extend(std::iter::from_fn(|| notes.take_event()));
    };
    while !tells.is_finished() {
        take();
        thread::yield_now();
    }
    tells.join().expect("no panic");
    take();
    assert!(outcomes.iter().map(|outcome| outcome.index).is_sorted());
    assert!(events.iter().all(|event| event.at_ns == 1_000));
    let dropped = [&notes.outcomes_dropped, &notes.events_dropped].map(|of| of.load(Ordering::Relaxed));
    assert_eq!([outcomes.len() as u64, events.len() as u64], dropped.map(|dropped| ROUNDS - dropped));
}

#[test]
fn of_a_text_nothing_behind_its_end_is_read() {
    let take = |bytes: &[u8]| text::take(Block::holding(bytes).pointer().cast());
    assert_eq!(take(b"a log\0").as_deref(), Ok("a log"));
    for wrong in [&b"\0"[..], b"\xff\0", &[b'a'; 4096]] {
        assert_eq!(take(wrong), Err(red_status::Text));
    }
    assert_eq!(text::take(ptr::null()), Err(red_status::NullPointer));
}
