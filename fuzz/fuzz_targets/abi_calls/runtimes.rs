//! The functions of runtimes that are set up, and what the others say before a start. No lane is started: what they do
//! depends on the system's clock, and has tests of its own.

pub(crate) mod tasks;

use std::path::Path;

use red_core::{Bytes, Duration, Empty};
use red_ffi::*;

use crate::logs::NOWHERE;
use crate::planted::{Bug, has};
use crate::sizes::More;
use crate::stream::Stream;
use crate::twin::{self, Answer, Large, or};
use crate::values;
use crate::world::{Kind, Open, Thing, World};

/// Lanes at most, and CPUs.
const LANES: usize = 32;
const CPUS: u32 = 1024;
/// What a runtime says of a log at `NOWHERE`.
const NO_FILE: &str =
    "/no folder/red.redlog: No such file or directory (os error 2); fix: choose a file that can be written";

impl World<'_> {
    fn runtime(&mut self, name: &'static str) -> (*mut red_runtime, usize) {
        self.begin(name);
        self.handle(Kind::Runtime)
    }

    /// The call has nothing to say but this.
    fn says(&mut self, status: red_status, said: Answer<()>) {
        let said = self.expected(|_| said);
        self.judge(status, said, None);
    }
}

pub(crate) fn open(w: &mut World<'_>) {
    if !w.has(More::Runtimes) && !w.has(More::Crowd) {
        return;
    }
    w.begin("red_runtime_open");
    let mut policy = red_config { preempt: 0, ..w.any_config() };
    let c = &mut w.choices;
    let mut config = red_runtime_config {
        mode: c.below(2) as u32,
        priority: 1 + c.below(98) as u32,
        duration_ns: c.number(),
        drain_ns: c.number(),
        ..red_runtime_config::EMPTY
    };
    if w.spoils() {
        w.spoil(&mut policy);
    }
    if w.spoils() {
        let number = w.choices.number() as u32;
        if w.choices.chance(128) { config.mode = number } else { config.priority = number }
    }
    if config.mode > 1 || !(1..=98).contains(&config.priority) {
        w.is_wrong(red_status::OutOfRange);
    }
    if policy.preempt == 1 {
        w.is_wrong(red_status::Preempts);
    }
    let known = values::config(&policy, LANES);
    known.err().into_iter().for_each(|wrong| w.join(wrong));
    let (policy, config) = (w.given(&policy), w.given(&config));
    let out = w.out();
    let status = red_runtime_open(policy, config, out.pointer);
    let expected = w.expected(|w| w.may_open(&(0..0)));
    if let (Ok(config), Ok(()), red_status::Ok) = (known, expected, status) {
        let bits = w.handle_in(out);
        let thing = Thing::Runtime(twin::scheduler::<Large>(config), Stream::new(false));
        w.opened(Open { bits, class: 2, lent: 0..0, own: 0..0, thing, is_stale: false });
    }
    w.judge(status, expected, None);
}

pub(crate) fn close(w: &mut World<'_>) {
    let (handle, at) = w.runtime("red_runtime_close");
    let status = red_runtime_close(handle);
    if w.is_right() {
        w.desk.expect_last(&[0; 8]);
        w.closed(at);
    }
    w.judge(status, Ok(()), None);
}

pub(crate) fn state_of(w: &mut World<'_>) {
    let (handle, _) = w.runtime("red_runtime_state_of");
    let out = w.out();
    let status = red_runtime_state_of(handle, out.pointer);
    let said = w.expected(|_| Ok(())).map(|()| w.put(out, &0_u32));
    w.judge(status, said, None);
}

pub(crate) fn message(w: &mut World<'_>) {
    let (handle, at) = w.runtime("red_runtime_message");
    let room = w.room::<u8>(120);
    let status = red_runtime_message(handle, room.pointer.cast(), room.room, room.count.pointer);
    let text = w.expected(|w| Ok([w.twin(at).1.said.as_bytes(), &[0]].concat()));
    let said = text.and_then(|text| w.fill(room, &text));
    w.judge(status, said, None);
}

pub(crate) fn report(w: &mut World<'_>) {
    let (handle, _) = w.runtime("red_runtime_report");
    let out = w.out_growing();
    let status = red_runtime_report(handle, out.pointer);
    let at_the_end = RED_NONE_64;
    let nothing = red_report {
        failed: at_the_end,
        overruns: at_the_end,
        hung: at_the_end,
        lanes_lost: at_the_end,
        threads_died: at_the_end,
        nodes_missed: at_the_end,
        units: at_the_end,
        encoder_runs_saved: at_the_end,
        allocations: at_the_end,
        page_faults: at_the_end,
        standstills: at_the_end,
        longest_standstill_ns: at_the_end,
        overhead_ns_per_unit: at_the_end,
        dispatch_p50_ns: at_the_end,
        dispatch_p99_ns: at_the_end,
        dispatch_max_ns: at_the_end,
        log_dropped: at_the_end,
        event_waits_issued: at_the_end,
        event_waits_avoided: at_the_end,
        submissions_ahead: at_the_end,
        late_memory_bytes: at_the_end,
        device_error: at_the_end,
        ..red_report::EMPTY
    };
    let said = w.expected(|_| Ok(())).map(|()| w.put_growing(out, &nothing));
    w.judge(status, said, None);
}

/// Only as it is refused. Where handles are not compared, lanes would come up, and panic beside what is to be found.
pub(crate) fn start(w: &mut World<'_>) {
    let (handle, _) = w.runtime("red_runtime_start");
    if !w.is_right() && !has(Bug::Generation) {
        let status = red_runtime_start(handle);
        w.judge(status, Ok(()), None);
    }
}

pub(crate) fn release(w: &mut World<'_>) {
    let (handle, at) = w.runtime("red_runtime_release");
    let (task, capture) = (w.task(at), w.choices.number());
    let status = red_runtime_release(handle, task, capture);
    w.says(status, Err(red_status::Idle));
}

pub(crate) fn stop(w: &mut World<'_>) {
    let (handle, _) = w.runtime("red_runtime_stop");
    let status = red_runtime_stop(handle);
    w.says(status, Err(red_status::Idle));
}

pub(crate) fn wait(w: &mut World<'_>) {
    let (handle, _) = w.runtime("red_runtime_wait");
    let status = red_runtime_wait(handle, w.choices.number());
    w.says(status, Err(red_status::Idle));
}

pub(crate) fn figures(w: &mut World<'_>) {
    let (handle, at) = w.runtime("red_runtime_figures");
    let out = w.out_growing();
    let status = red_runtime_figures(handle, out.pointer);
    let said = w.expected(|w| Ok(w.twin(at).0.figures())).map(|figures| w.put_growing(out, &figures));
    w.judge(status, said, None);
}

pub(crate) fn take_outcomes(w: &mut World<'_>) {
    let (handle, _) = w.runtime("red_runtime_take_outcomes");
    let room = w.room::<red_outcome>(20);
    let status = red_runtime_take_outcomes(handle, room.pointer, room.room, room.count.pointer);
    let said = w.expected(|_| Ok(())).map(|()| w.take(room, &[]));
    w.judge(status, said, None);
}

pub(crate) fn take_warnings(w: &mut World<'_>) {
    let (handle, _) = w.runtime("red_runtime_take_warnings");
    let room = w.room::<red_warning>(20);
    let status = red_runtime_take_warnings(handle, room.pointer, room.room, room.count.pointer);
    let said = w.expected(|_| Ok(())).map(|()| w.take(room, &[]));
    w.judge(status, said, None);
}

pub(crate) fn take_events(w: &mut World<'_>) {
    let (handle, _) = w.runtime("red_runtime_take_events");
    let room = w.room::<red_event>(20);
    let status = red_runtime_take_events(handle, room.pointer, room.room, room.count.pointer);
    let said = w.expected(|_| Ok(())).map(|()| w.take(room, &[]));
    w.judge(status, said, None);
}

pub(crate) fn add_pool(w: &mut World<'_>) {
    let (handle, at) = w.runtime("red_runtime_add_pool");
    let lanes = if w.choices.chance(24) { w.choices.number() as u32 } else { 1 + w.choices.below(2) as u32 };
    if lanes > 255 {
        w.is_wrong(red_status::PoolsFull);
    }
    let memory = if w.choices.chance(60) { w.choices.number() } else { RED_NONE_64 };
    let out = w.out();
    let status = red_runtime_add_pool(handle, lanes, memory, out.pointer);
    let budget = (memory != RED_NONE_64).then_some(Bytes(memory));
    let added = w.expected(|w| w.twin(at).0.add_pool(lanes as u8, budget)).map(|id| w.put(out, &id));
    w.judge(status, added, None);
}

/// Only as it is refused before a driver is looked for.
pub(crate) fn add_cuda_pool(w: &mut World<'_>) {
    let (handle, _) = w.runtime("red_runtime_add_cuda_pool");
    let lanes = w.choices.below(300) as u32;
    let out = w.out::<u32>();
    let status = red_runtime_add_cuda_pool(handle, u32::MAX, lanes, RED_NONE_64, out.pointer);
    w.says(status, Err(if lanes > 255 { red_status::PoolsFull } else { red_status::OutOfRange }));
}

pub(crate) fn add_sensor(w: &mut World<'_>) {
    let (handle, at) = w.runtime("red_runtime_add_sensor");
    let period = w.choices.number();
    let out = w.out();
    let status = red_runtime_add_sensor(handle, period, out.pointer);
    let added =
        w.expected(|w| w.twin(at).0.add_sensor(Duration::from_nanos(period))).map(|id| w.put(out, &id));
    w.judge(status, added, None);
}

pub(crate) fn pin(w: &mut World<'_>) {
    let (handle, _) = w.runtime("red_runtime_pin");
    let count = w.choices.below(6);
    let cpus: Vec<u32> = (0..count)
        .map(|_| match w.choices.byte() {
            cpu @ 0..250 => u32::from(cpu) * 4,
            _ => w.choices.number() as u32,
        })
        .collect();
    if cpus.iter().any(|cpu| *cpu >= CPUS) {
        w.is_wrong(red_status::OutOfRange);
    }
    let given = w.numbers(&cpus);
    let count = w.length(count, LANES);
    let status = red_runtime_pin(handle, given, count);
    w.says(status, Ok(()));
}

pub(crate) fn every(w: &mut World<'_>) {
    let (handle, at) = w.runtime("red_runtime_every");
    let (task, first, period) = (w.task(at), w.choices.number(), w.choices.number());
    let status = red_runtime_every(handle, task, first, period);
    let said = w.expected(|w| w.twin(at).0.certificate(task).map(drop));
    w.judge(status, said, None);
}

pub(crate) fn record(w: &mut World<'_>) {
    let (handle, at) = w.runtime("red_runtime_record");
    let nobody_reads_it = "/dev/null";
    let is_somewhere = w.choices.chance(200);
    let path = w.path(Path::new(if is_somewhere { nobody_reads_it } else { NOWHERE }));
    w.may_log();
    let status = red_runtime_record(handle, path);
    let begun = w.expected(|w| {
        let (twin, stream) = w.twin(at);
        or(twin.is_new() && stream.log.is_none(), red_status::LogLate)?;
        stream.said = if is_somewhere { "" } else { NO_FILE };
        or(is_somewhere, red_status::LogFile)?;
        stream.log = Some(nobody_reads_it.into());
        Ok(())
    });
    w.judge(status, begun, None);
}

pub(crate) fn now(w: &mut World<'_>) {
    w.begin("red_runtime_now");
    let out = w.out();
    let status = red_runtime_now(out.pointer);
    if w.is_right() {
        let _time = w.handle_in(out);
    }
    w.says(status, Ok(()));
}
