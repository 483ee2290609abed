//! The functions of schedulers that set up: opening, pools, sensors, tasks, edits.

use std::ffi::c_void;

use red_core::{Bytes, Capacity, Config, Duration, Empty, Instant};
use red_ffi::*;

use crate::header::Statuses;
use crate::stream::Stream;
use crate::twin::{self, Answer, AnyDag, Large, Medium, Small, Twin, or};
use crate::values;
use crate::world::{Kind, Open, Thing, World};

/// The presets of the header.
const PRESETS: [Config; 6] =
    [Config::EDF, Config::RED_FG, Config::RED_IDA, Config::RED, Config::REDRT, Config::REDRT_LOOKAHEAD];

impl World<'_> {
    pub(crate) fn twin(&mut self, at: usize) -> (&mut dyn Twin, &mut Stream) {
        match &mut self.open[at].thing {
            Thing::Scheduler(twin, stream) | Thing::Runtime(twin, stream) => (&mut **twin, stream),
            Thing::Dag(..) => panic!("place {at} is a graph's"),
        }
    }

    /// A task that was admitted once, or a name that nobody gave out.
    pub(crate) fn task(&mut self, at: usize) -> u32 {
        let tasks = match self.open.get(at).map(|open| &open.thing) {
            Some(Thing::Scheduler(_, stream) | Thing::Runtime(_, stream)) if !stream.tasks.is_empty() => {
                stream.tasks.clone()
            }
            _ => vec![0],
        };
        if !self.careful && self.choices.chance(10) {
            return self.choices.number() as u32;
        }
        // Mostly one of the last: they are there.
        let which = if self.choices.chance(240) {
            self.choices.below(tasks.len().min(3))
        } else {
            self.choices.below(tasks.len())
        };
        tasks[tasks.len() - 1 - which]
    }

    /// Whether a graph is no edit of another scheduler or runtime than this one.
    pub(crate) fn may_change(&self, at: usize, dag: usize) -> Answer<()> {
        match &self.open[dag].thing {
            Thing::Dag(_, begun_on) => or([0, self.open[at].bits].contains(begun_on), red_status::Conflict),
            _ => Ok(()),
        }
    }

    /// A graph's twin apart from a scheduler's.
    pub(crate) fn both<T>(
        &mut self,
        at: usize,
        dag: usize,
        call: impl FnOnce(&mut dyn Twin, &dyn AnyDag) -> T,
    ) -> T {
        let Ok([scheduler, dag]) = self.open.get_disjoint_mut([at, dag]) else {
            panic!("one is a scheduler, one a graph")
        };
        match (&mut scheduler.thing, &dag.thing) {
            (Thing::Scheduler(twin, _) | Thing::Runtime(twin, _), Thing::Dag(dag, _)) => {
                call(&mut **twin, &**dag)
            }
            _ => panic!("places {at} and {} are of other kinds", dag.bits),
        }
    }

    pub(crate) fn any_config(&mut self) -> red_config {
        let preset = PRESETS[self.choices.below(PRESETS.len())];
        let mut config = values::of_config(&preset);
        config.lanes = 1 + self.choices.below(4) as u32;
        // Ticks as short as the runs, so that overload lasts.
        config.overload_tick_ns = 200_000;
        let c = &mut self.choices;
        for _ in 0..c.byte() % 3 {
            let (field, value) = (c.byte(), c.byte());
            let small = u32::from(value % 3);
            match field % 12 {
                0 => config.preempt = small % 2,
                1 => config.late = small % 2,
                2 => config.best_case = small % 2,
                3 => config.admission = small % 2,
                4 => config.frame_cache = small % 2,
                5 => config.memory_bytes = value.into(),
                6 => config.shed = small,
                7 => config.reassign = small,
                8 => config.gate = small % 3,
                9 => config.rule = u32::from(value % 6),
                10 => config.overload_ticks = value.into(),
                _ => config.merge_skew_ns = u64::from(value) * 100_000,
            }
        }
        config
    }

    /// A field of a configuration is any number.
    pub(crate) fn spoil(&mut self, config: &mut red_config) {
        let number = self.choices.number();
        let small = number as u32;
        match self.choices.byte() % 18 {
            0 => config.lanes = small,
            1 => config.rule = small,
            2 => config.gate = small,
            3 => config.reassign = small,
            4 => config.refine = small,
            5 => config.frame_cache = small,
            6 => config.shed = small,
            7 => config.late = small,
            8 => config.best_case = small,
            9 => config.admission = small,
            10 => config.preempt = small,
            11 => config.overload_utilisation_ppm = small,
            12 => config.overload_queue = small,
            13 => config.overload_ticks = small,
            14 => config.overload_tick_ns = number,
            15 => config.memory_bytes = number,
            16 => config.merge_skew_ns = number,
            _ => config.overload_tick_ns = 0,
        }
    }

    pub(crate) fn any_timing(&mut self) -> red_timing {
        let c = &mut self.choices;
        let deadline_ns = if c.chance(20) { c.number() } else { 200_000 + u64::from(c.byte()) * 40_000 };
        let period_ns = if c.chance(128) { 0 } else { u64::from(c.byte()) * 50_000 };
        let (keep, of) = if c.chance(60) { (c.byte() % 6, c.byte() % 5) } else { (0, 0) };
        red_timing {
            deadline_ns,
            period_ns,
            value: u32::from(c.byte() % 4),
            floor_keep: keep.into(),
            floor_of: of.into(),
            ..red_timing::EMPTY
        }
    }

    pub(crate) fn join(&mut self, wrong: Statuses) {
        self.wrong = self.wrong.join(wrong);
    }
}

pub(crate) fn preset(w: &mut World<'_>) {
    w.begin("red_config_preset");
    let preset =
        if w.choices.chance(40) { w.choices.number() as u32 } else { w.choices.below(PRESETS.len()) as u32 };
    if preset as usize >= PRESETS.len() {
        w.is_wrong(red_status::OutOfRange);
    }
    let out = w.out_growing();
    let status = red_config_preset(preset, out.pointer);
    let said = w.expected(|_| Ok(values::of_config(&PRESETS[preset as usize])));
    let said = said.map(|config| w.put_growing(out, &config));
    w.judge(status, said, None);
}

fn open<C: Capacity>(
    w: &mut World<'_>,
    class: usize,
    open: extern "C" fn(*mut c_void, usize, *const red_config, *mut red_scheduler) -> red_status,
    size: usize,
) {
    w.begin(
        ["red_scheduler_open_4x16x16", "red_scheduler_open_8x64x32", "red_scheduler_open_16x256x64"][class],
    );
    let lent = w.memory(Kind::Scheduler, class, size);
    let mut config = w.any_config();
    if w.spoils() {
        w.spoil(&mut config);
    }
    let known = values::config(&config, C::LANES);
    let given = w.given(&config);
    known.err().into_iter().for_each(|wrong| w.join(wrong));
    let out = w.out();
    let status = open(lent.pointer, lent.bytes, given, out.pointer);
    let expected = w.expected(|w| w.may_open(&lent.range));
    if let (Ok(config), Ok(()), red_status::Ok) = (known, expected, status) {
        let bits = w.handle_in(out);
        let own = lent.range.start..lent.range.start + size;
        let thing = Thing::Scheduler(twin::scheduler::<C>(config), Stream::new(config.preempt));
        w.opened(Open { bits, class, lent: lent.range, own, thing, is_stale: false });
    }
    w.judge(status, expected, None);
}

pub(crate) fn open_small(w: &mut World<'_>) {
    open::<Small>(w, 0, red_scheduler_open_4x16x16, red_scheduler_bytes_4x16x16());
}

pub(crate) fn open_medium(w: &mut World<'_>) {
    if w.classes() > 1 {
        open::<Medium>(w, 1, red_scheduler_open_8x64x32, red_scheduler_bytes_8x64x32());
    }
}

pub(crate) fn open_large(w: &mut World<'_>) {
    if w.classes() > 2 {
        open::<Large>(w, 2, red_scheduler_open_16x256x64, red_scheduler_bytes_16x256x64());
    }
}

pub(crate) fn close(w: &mut World<'_>) {
    w.begin("red_scheduler_close");
    let (handle, at) = w.handle(Kind::Scheduler);
    let status = red_scheduler_close(handle);
    if w.is_right() {
        w.forget_log(at);
        w.desk.expect_last(&[0; 8]);
        w.closed(at);
    }
    w.judge(status, Ok(()), None);
}

pub(crate) fn add_pool(w: &mut World<'_>) {
    w.begin("red_scheduler_add_pool");
    let (handle, at) = w.handle(Kind::Scheduler);
    let lanes = if w.choices.chance(24) { w.choices.number() as u32 } else { 1 + w.choices.below(2) as u32 };
    if lanes > 255 {
        w.is_wrong(red_status::PoolsFull);
    }
    let memory = if w.choices.chance(60) { w.choices.number() } else { RED_NONE_64 };
    let out = w.out();
    let status = red_scheduler_add_pool(handle, lanes, memory, out.pointer);
    let budget = (memory != RED_NONE_64).then_some(Bytes(memory));
    let added = w.expected(|w| w.twin(at).0.add_pool(lanes as u8, budget)).map(|id| w.put(out, &id));
    w.judge(status, added, Some(at));
}

fn pool(w: &mut World<'_>) -> u32 {
    if w.choices.chance(24) { w.choices.number() as u32 } else { w.choices.below(3) as u32 }
}

pub(crate) fn dispatch_ahead(w: &mut World<'_>) {
    w.begin("red_scheduler_dispatch_ahead");
    let (handle, at) = w.handle(Kind::Scheduler);
    let pool = pool(w);
    let status = red_scheduler_dispatch_ahead(handle, pool);
    let said = w.expected(|w| w.twin(at).0.dispatch_ahead(pool)).map(|()| w.twin(at).1.goes_ahead());
    w.judge(status, said, Some(at));
}

pub(crate) fn lose_pool(w: &mut World<'_>) {
    w.begin("red_scheduler_lose_pool");
    let (handle, at) = w.handle(Kind::Scheduler);
    let (pool, now) = (pool(w), w.clock());
    let status = red_scheduler_lose_pool(handle, pool, now);
    let said = w.expected(|w| w.twin(at).0.lose_pool(pool, Instant::from_nanos(now)));
    w.judge(status, said, Some(at));
}

pub(crate) fn add_sensor(w: &mut World<'_>) {
    w.begin("red_scheduler_add_sensor");
    let (handle, at) = w.handle(Kind::Scheduler);
    let period = if w.choices.chance(60) { w.choices.number() } else { u64::from(w.choices.byte()) * 50_000 };
    let out = w.out();
    let status = red_scheduler_add_sensor(handle, period, out.pointer);
    let added =
        w.expected(|w| w.twin(at).0.add_sensor(Duration::from_nanos(period))).map(|id| w.put(out, &id));
    w.judge(status, added, Some(at));
}

pub(crate) fn config(w: &mut World<'_>) {
    w.begin("red_scheduler_config");
    let (handle, at) = w.handle(Kind::Scheduler);
    let out = w.out_growing();
    let status = red_scheduler_config(handle, out.pointer);
    let said = w.expected(|w| Ok(w.twin(at).0.config()));
    let said = said.map(|config| w.put_growing(out, &values::of_config(&config)));
    w.judge(status, said, None);
}

pub(crate) fn memory_used(w: &mut World<'_>) {
    w.begin("red_scheduler_memory_used");
    let (handle, at) = w.handle(Kind::Scheduler);
    let pool = pool(w);
    let out = w.out();
    let status = red_scheduler_memory_used(handle, pool, out.pointer);
    let said = w.expected(|w| w.twin(at).0.memory_used(pool)).map(|bytes| w.put(out, &bytes));
    w.judge(status, said, None);
}

pub(crate) fn add_task(w: &mut World<'_>) {
    w.begin("red_scheduler_add_task");
    let (handle, at) = w.handle(Kind::Scheduler);
    let (graph, dag) = w.handle(Kind::Dag);
    let timing = w.any_timing();
    let known = values::timing(&timing);
    known.err().into_iter().for_each(|wrong| w.join(wrong));
    let timing = w.given(&timing);
    let out = w.out();
    let status = red_scheduler_add_task(handle, graph, timing, out.pointer);
    let added = w.expected(|w| {
        let timing = known.map_err(|_| red_status::OutOfRange)?;
        w.both(at, dag, |twin, dag| twin.add_task(dag, timing))
    });
    let added = added.map(|task| {
        w.twin(at).1.tasks.push(task);
        w.put(out, &task);
    });
    w.judge(status, added, Some(at));
}

pub(crate) fn remove_task(w: &mut World<'_>) {
    w.begin("red_scheduler_remove_task");
    let (handle, at) = w.handle(Kind::Scheduler);
    let (task, now) = (w.task(at), w.clock());
    let status = red_scheduler_remove_task(handle, task, now);
    let removed = w.expected(|w| w.twin(at).0.remove_task(task, Instant::from_nanos(now)));
    w.judge(status, removed, Some(at));
}

/// Removes this task, if it is there.
pub(crate) fn remove(w: &mut World<'_>, task: u32) {
    w.begin("red_scheduler_remove_task");
    let ((handle, at), now) = (w.handle(Kind::Scheduler), w.clock());
    let status = red_scheduler_remove_task(handle, task, now);
    let removed = w.twin(at).0.remove_task(task, Instant::from_nanos(now));
    w.judge(status, removed, Some(at));
}

pub(crate) fn certificate(w: &mut World<'_>) {
    w.begin("red_scheduler_certificate");
    let (handle, at) = w.handle(Kind::Scheduler);
    let task = w.task(at);
    let out = w.out_growing();
    let status = red_scheduler_certificate(handle, task, out.pointer);
    let proof = w.expected(|w| w.twin(at).0.certificate(task));
    let proof = proof.map(|proof| w.put_growing(out, &values::of_certificate(&proof)));
    w.judge(status, proof, None);
}

pub(crate) fn edit(w: &mut World<'_>) {
    w.begin("red_scheduler_edit");
    let (handle, at) = w.handle(Kind::Scheduler);
    let task = w.task(at);
    let class = w.open.get(at).map_or(0, |open| open.class);
    let lent = w.memory(Kind::Dag, class, 128);
    let out = w.out();
    let status = red_scheduler_edit(handle, task, lent.pointer, lent.bytes, out.pointer);
    let begun = w.expected(|w| {
        let dag = w.twin(at).0.edit(task)?;
        w.may_open(&lent.range)?;
        Ok(dag)
    });
    let begun = begun.map(|dag| {
        if status == red_status::Ok {
            let bits = w.handle_in(out);
            let begun_on = w.open[at].bits;
            w.opened_dag(bits, class, lent.range, (dag, begun_on));
        }
    });
    w.judge(status, begun, None);
}

pub(crate) fn commit(w: &mut World<'_>) {
    w.begin("red_scheduler_commit");
    let (handle, at) = w.handle(Kind::Scheduler);
    let (graph, dag) = w.handle(Kind::Dag);
    let now = w.clock();
    let out = w.out_growing();
    let status = red_scheduler_commit(handle, graph, now, out.pointer);
    let proof = w.expected(|w| {
        let of_this = w.may_change(at, dag);
        w.both(at, dag, |twin, dag| {
            twin.takes(dag)?;
            of_this?;
            twin.commit(dag, Instant::from_nanos(now))
        })
    });
    let proof = proof.map(|proof| w.put_growing(out, &values::of_certificate(&proof)));
    w.judge(status, proof, Some(at));
}
