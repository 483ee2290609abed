//! The functions of the loop, and what a host may ask.

use red_core::{Action, Instant, NodeId};
use red_ffi::*;

use crate::arguments::Out;
use crate::planted::{Bug, has};
use crate::schedulers;
use crate::values;
use crate::world::{Kind, Thing, World};

impl World<'_> {
    /// A unit that runs, that ran, or that nobody gave out.
    fn unit(&mut self, at: usize) -> u64 {
        let of = |w: &Self, live: bool| match w.open.get(at).map(|open| &open.thing) {
            Some(Thing::Scheduler(_, stream)) => {
                if live {
                    stream.live.clone()
                } else {
                    stream.dead.clone()
                }
            }
            _ => Vec::new(),
        };
        let kind = if self.careful { 0 } else { self.choices.byte() };
        let from = of(self, kind < 224);
        match kind {
            0..248 if !from.is_empty() => from[self.choices.below(from.len())],
            0..248 => 0,
            _ => self.choices.number(),
        }
    }

    /// A lane's number; which ones there are is for the scheduler to say.
    fn lane(&mut self) -> u32 {
        let any = !self.careful && self.choices.chance(16);
        let lane = if any { self.choices.number() as u32 } else { self.choices.below(5) as u32 };
        if lane > 255 {
            self.is_wrong(red_status::UnknownLane);
        }
        lane
    }

    fn put_action(&mut self, out: Out<red_action>, at: usize, action: Option<Action>) {
        let (value, written) = values::of_action(action);
        self.put_some(out, &value, written);
        self.twin(at).1.act(action);
    }

    /// What a scheduler counts is what happened.
    fn count(&mut self, at: usize) {
        if self.is_right() {
            let (twin, stream) = self.twin(at);
            stream.holds(&twin.figures());
        }
    }
}

fn instant(ns: u64) -> Instant {
    Instant::from_nanos(ns)
}

pub(crate) fn release(w: &mut World<'_>) {
    w.begin("red_scheduler_release");
    let (handle, at) = w.handle(Kind::Scheduler);
    let (task, now) = (w.task(at), w.clock());
    let out = w.out();
    let status = red_scheduler_release(handle, task, now, out.pointer);
    let released = w.expected(|w| w.twin(at).0.release(task, instant(now), None, instant(now)));
    let released = released.map(|job| {
        w.put(out, &job);
        w.twin(at).1.released(job, task);
    });
    w.judge(status, released, Some(at));
    w.count(at);
}

pub(crate) fn release_at(w: &mut World<'_>) {
    w.begin("red_scheduler_release_at");
    let (handle, at) = w.handle(Kind::Scheduler);
    let (task, now) = (w.task(at), w.clock());
    let release = match w.choices.byte() {
        earlier @ 0..200 => now.saturating_sub(u64::from(earlier) * 2_000),
        later @ 200..240 => now.saturating_add(u64::from(later)),
        _ => w.choices.number(),
    };
    let capture = if w.choices.chance(100) { w.choices.below(3) as u64 } else { RED_NONE_64 };
    let out = w.out();
    let status = red_scheduler_release_at(handle, task, release, capture, now, out.pointer);
    let of = (capture != RED_NONE_64).then_some(capture);
    let released = w.expected(|w| w.twin(at).0.release(task, instant(release), of, instant(now)));
    let released = released.map(|job| {
        w.put(out, &job);
        w.twin(at).1.released(job, task);
    });
    w.judge(status, released, Some(at));
    w.count(at);
}

pub(crate) fn poll(w: &mut World<'_>) {
    w.begin("red_scheduler_poll");
    let (handle, at) = w.handle(Kind::Scheduler);
    let now = w.clock();
    let out = w.out();
    let status = red_scheduler_poll(handle, now, out.pointer);
    let action = w.expected(|w| Ok(w.twin(at).0.poll(instant(now))));
    let action = action.map(|action| w.put_action(out, at, action));
    w.judge(status, action, Some(at));
    w.count(at);
}

pub(crate) fn poll_on(w: &mut World<'_>) {
    w.begin("red_scheduler_poll_on");
    let (handle, at) = w.handle(Kind::Scheduler);
    let (lane, now) = (w.lane(), w.clock());
    let out = w.out();
    let status = red_scheduler_poll_on(handle, lane, now, out.pointer);
    let action = w.expected(|w| w.twin(at).0.poll_on(lane as u8, instant(now)));
    let action = action.map(|action| w.put_action(out, at, action));
    w.judge(status, action, Some(at));
    w.count(at);
}

pub(crate) fn complete(w: &mut World<'_>) {
    w.begin("red_scheduler_complete");
    let (handle, at) = w.handle(Kind::Scheduler);
    let (unit, now) = (w.unit(at), w.clock());
    let status = red_scheduler_complete(handle, unit, now);
    let told = w.expected(|w| w.twin(at).0.complete(unit, instant(now)));
    w.judge(status, told, Some(at));
    reported(w, at, unit, status);
}

pub(crate) fn complete_and_poll(w: &mut World<'_>) {
    w.begin("red_scheduler_complete_and_poll");
    let (handle, at) = w.handle(Kind::Scheduler);
    let (unit, now) = (w.unit(at), w.clock());
    let out = w.out();
    let status = red_scheduler_complete_and_poll(handle, unit, now, out.pointer);
    let action = w.expected(|w| w.twin(at).0.complete_and_poll(unit, instant(now)));
    if w.is_right() {
        // Before what is polled in the same call.
        w.twin(at).1.reported(unit, status);
    }
    let action = action.map(|action| w.put_action(out, at, action));
    w.judge(status, action, Some(at));
    w.count(at);
}

pub(crate) fn fail(w: &mut World<'_>) {
    w.begin("red_scheduler_fail");
    let (handle, at) = w.handle(Kind::Scheduler);
    let (unit, now) = (w.unit(at), w.clock());
    let status = red_scheduler_fail(handle, unit, now);
    let told = w.expected(|w| w.twin(at).0.fail(unit, instant(now)));
    w.judge(status, told, Some(at));
    reported(w, at, unit, status);
}

fn reported(w: &mut World<'_>, at: usize, unit: u64, status: red_status) {
    if w.is_right() {
        w.twin(at).1.reported(unit, status);
    }
    w.count(at);
}

pub(crate) fn take_outcome(w: &mut World<'_>) {
    w.begin("red_scheduler_take_outcome");
    let (handle, at) = w.handle(Kind::Scheduler);
    let (out, count) = (w.out(), w.out());
    let status = red_scheduler_take_outcome(handle, out.pointer, count.pointer);
    let taken = w.expected(|w| Ok(w.twin(at).0.take_outcome()));
    let taken = taken.map(|taken| {
        w.put(count, &u32::from(taken.is_some()));
        if let Some(taken) = taken {
            w.put(out, &values::of_outcome(&taken));
            w.twin(at).1.ended(&taken);
        }
    });
    w.judge(status, taken, Some(at));
}

pub(crate) fn take_warning(w: &mut World<'_>) {
    w.begin("red_scheduler_take_warning");
    let (handle, at) = w.handle(Kind::Scheduler);
    let (out, count) = (w.out(), w.out());
    let status = red_scheduler_take_warning(handle, out.pointer, count.pointer);
    let taken = w.expected(|w| Ok(w.twin(at).0.take_warning()));
    let taken = taken.map(|taken| {
        w.put(count, &u32::from(taken.is_some()));
        if let Some(taken) = taken {
            w.put(out, &taken);
        }
    });
    w.judge(status, taken, Some(at));
}

pub(crate) fn retire_lane(w: &mut World<'_>) {
    w.begin("red_scheduler_retire_lane");
    let (handle, at) = w.handle(Kind::Scheduler);
    let lane = w.lane();
    let status = red_scheduler_retire_lane(handle, lane);
    let retired = w.expected(|w| {
        let twin = w.twin(at).0;
        let said = twin.retire(lane as u8);
        if has(Bug::Lane) && said.is_ok() {
            let _stays = twin.restore(lane as u8);
        }
        said
    });
    let retired = retired.map(|()| w.twin(at).1.retire(lane as u8));
    w.judge(status, retired, Some(at));
}

pub(crate) fn restore_lane(w: &mut World<'_>) {
    w.begin("red_scheduler_restore_lane");
    let (handle, at) = w.handle(Kind::Scheduler);
    let lane = w.lane();
    let status = red_scheduler_restore_lane(handle, lane);
    let restored = w.expected(|w| w.twin(at).0.restore(lane as u8));
    let restored = restored.map(|()| w.twin(at).1.restore(lane as u8));
    w.judge(status, restored, Some(at));
}

pub(crate) fn poll_at(w: &mut World<'_>) {
    w.begin("red_scheduler_poll_at");
    let (handle, at) = w.handle(Kind::Scheduler);
    let out = w.out();
    let status = red_scheduler_poll_at(handle, out.pointer);
    let said = w.expected(|w| Ok(w.twin(at).0.poll_at().map_or(RED_NONE_64, Instant::as_nanos)));
    let said = said.map(|ns| w.put(out, &ns));
    w.judge(status, said, None);
}

pub(crate) fn unit(w: &mut World<'_>) {
    w.begin("red_scheduler_unit");
    let (handle, at) = w.handle(Kind::Scheduler);
    let unit = w.unit(at);
    let out = w.out_growing();
    let status = red_scheduler_unit(handle, unit, out.pointer);
    let said = w.expected(|w| w.twin(at).0.unit(unit));
    let said = said.map(|unit| w.put_growing(out, &values::of_unit(&unit)));
    w.judge(status, said, None);
}

pub(crate) fn members(w: &mut World<'_>) {
    w.begin("red_scheduler_members");
    let (handle, at) = w.handle(Kind::Scheduler);
    let unit = w.unit(at);
    let room = w.room(20);
    let status = red_scheduler_members(handle, unit, room.pointer, room.room, room.count.pointer);
    let said = w.expected(|w| w.twin(at).0.members(unit));
    let said = said.and_then(|members| w.fill(room, &members));
    w.judge(status, said, None);
}

pub(crate) fn waits_for(w: &mut World<'_>) {
    w.begin("red_scheduler_waits_for");
    let (handle, at) = w.handle(Kind::Scheduler);
    let unit = w.unit(at);
    let room = w.room(8);
    let status = red_scheduler_waits_for(handle, unit, room.pointer, room.room, room.count.pointer);
    let said = w.expected(|w| w.twin(at).0.waits_for(unit));
    let said = said.and_then(|units| w.fill(room, &units));
    w.judge(status, said, None);
}

pub(crate) fn job(w: &mut World<'_>) {
    w.begin("red_scheduler_job");
    let (handle, at) = w.handle(Kind::Scheduler);
    let (task, index) = (w.task(at), w.choices.number());
    let out = w.out();
    let status = red_scheduler_job(handle, task, index, out.pointer);
    let said = w.expected(|w| w.twin(at).0.job(task, index)).map(|job| w.put(out, &job));
    w.judge(status, said, None);
}

pub(crate) fn executions(w: &mut World<'_>) {
    w.begin("red_scheduler_executions");
    let (handle, at) = w.handle(Kind::Scheduler);
    let (task, node) = (w.task(at), w.node_number());
    let out = w.out_growing();
    let status = red_scheduler_executions(handle, task, node, out.pointer);
    let said = w.expected(|w| w.twin(at).0.executions(task, NodeId::new(node as u8)));
    let said = said.map(|executions| w.put_growing(out, &executions));
    w.judge(status, said, None);
}

pub(crate) fn figures(w: &mut World<'_>) {
    w.begin("red_scheduler_figures");
    let (handle, at) = w.handle(Kind::Scheduler);
    let out = w.out_growing();
    let status = red_scheduler_figures(handle, out.pointer);
    let said = w.expected(|w| Ok(w.twin(at).0.figures())).map(|figures| w.put_growing(out, &figures));
    w.judge(status, said, None);
}

pub(crate) fn take_events(w: &mut World<'_>) {
    w.begin("red_scheduler_take_events");
    let (handle, at) = w.handle(Kind::Scheduler);
    let room = w.room(20);
    let status = red_scheduler_take_events(handle, room.pointer, room.room, room.count.pointer);
    let events = w.expected(|w| {
        let mut next = || w.twin(at).0.take_event();
        Ok((0..room.room).map_while(|_| next()).map(|event| values::of_event(&event)).collect::<Vec<_>>())
    });
    let events = events.map(|events| w.take(room, &events));
    w.judge(status, events, Some(at));
}

/// Lets everything end that goes on in a scheduler: nothing is forgotten, and nothing is left.
pub(crate) fn let_end(w: &mut World<'_>, at: usize) {
    let twin = w.twin(at).0;
    let lanes = twin.figures().lanes;
    for lane in 0..lanes {
        w.begin("red_scheduler_restore_lane");
        let (handle, _) = w.handle(Kind::Scheduler);
        let status = red_scheduler_restore_lane(handle, lane);
        let restored = w.twin(at).0.restore(lane as u8).map(|()| w.twin(at).1.restore(lane as u8));
        w.judge(status, restored, Some(at));
    }
    let before = w.twin(at).0.figures().evictions;
    run_down(w, at);
    let (twin, stream) = w.twin(at);
    if !stream.is_over() && twin.figures().evictions > before + 1_000 {
        // Results take each other's memory, and nothing is given up: decision 0005. Jobs end with their tasks.
        let tasks = stream.tasks.clone();
        tasks.into_iter().for_each(|task| schedulers::remove(w, task));
        run_down(w, at);
    }
    let (twin, stream) = w.twin(at);
    assert!(stream.is_over(), "a job never ends: {:?}", twin.figures());
    for pool in 0.. {
        let Ok(bytes) = w.twin(at).0.memory_used(pool) else { break };
        assert_eq!(bytes, 0, "memory is held when nothing is left");
    }
}

/// Time stands still, so that nothing is given up; each round ends a unit, or takes an action. Only where lanes wait on purpose,
/// under lookahead or for a higher rank, time goes on to when they look again.
fn run_down(w: &mut World<'_>, at: usize) {
    for _ in 0..40_000 {
        let before = w.twin(at).1.live.len();
        poll(w);
        let (twin, stream) = w.twin(at);
        if stream.live.is_empty() && twin.figures().jobs_in_flight == 0 && stream.is_over() {
            break;
        }
        if stream.live.len() <= before && !stream.live.is_empty() {
            complete(w);
        } else if stream.live.is_empty() && twin.figures().can_dispatch == 0 {
            let again = twin.poll_at().map_or(0, Instant::as_nanos);
            w.pass_until(again);
        }
    }
}
