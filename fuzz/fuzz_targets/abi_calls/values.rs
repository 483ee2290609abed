//! What the structs of the header mean, written down a second time: from the header, not from the library.

use red_core::{
    Action, Admission, BestCase, Bound, Bytes, Certificate, Config, Contention, DeadlineRule, Duration,
    Empty, Event, EventKind, Frame, Gate, Late, Member, Node, Outcome, Overload, PoolId, Ppm, Reassign, Role,
    SensorId, Shed, ShedReason, Timing, Unit, Warning, Wcet,
};
use red_ffi::*;

use crate::header::Statuses;

const RULES: [DeadlineRule; 6] = [
    DeadlineRule::EndToEnd,
    DeadlineRule::LevelSum,
    DeadlineRule::LevelGraham,
    DeadlineRule::PathProportional,
    DeadlineRule::LatestFinish,
    DeadlineRule::LatestStart,
];

pub(crate) fn rule(number: u32) -> Option<DeadlineRule> {
    RULES.get(number as usize).copied()
}

fn budget(bytes: u64) -> Option<Bytes> {
    (bytes != RED_NONE_64).then_some(Bytes(bytes))
}

/// What is wrong with fields that have fewer values than their bits.
struct Fields(Statuses);

impl Fields {
    fn check(&mut self, right: bool, status: red_status) {
        if !right {
            self.0.add(status);
        }
    }

    fn one_of<T: Copy>(&mut self, number: u32, all: &[T]) -> T {
        self.check((number as usize) < all.len(), red_status::OutOfRange);
        all.get(number as usize).copied().unwrap_or(all[0])
    }

    fn end<T>(self, value: T) -> Result<T, Statuses> {
        if self.0.is_empty() { Ok(value) } else { Err(self.0) }
    }
}

/// A configuration for a class of so many lanes.
pub(crate) fn config(c: &red_config, lanes: usize) -> Result<Config, Statuses> {
    let mut fields = Fields(Statuses::NONE);
    fields.check(c.lanes > 0, red_status::NoLane);
    fields.check(c.lanes as usize <= lanes, red_status::PoolsFull);
    fields.check(c.overload_queue < 1 << 16 && c.overload_ticks < 1 << 8, red_status::OutOfRange);
    fields.check(c.overload_tick_ns > 0, red_status::OutOfRange);
    let value = Config {
        lanes: c.lanes as u8,
        memory: budget(c.memory_bytes),
        rule: fields.one_of(c.rule, &RULES),
        gate: fields.one_of(c.gate, &[Gate::Precedence, Gate::Level, Gate::Lookahead]),
        reassign: fields.one_of(c.reassign, &[Reassign::Never, Reassign::OnDispatch, Reassign::OnChange]),
        refine: fields.one_of(c.refine, &[false, true]),
        merge_skew: (c.merge_skew_ns != RED_NONE_64).then_some(Duration::from_nanos(c.merge_skew_ns)),
        frame_cache: fields.one_of(c.frame_cache, &[false, true]),
        shed: fields.one_of(c.shed, &[Shed::Never, Shed::LowestUrgency, Shed::Hopeless]),
        late: fields.one_of(c.late, &[Late::Continue, Late::AbortJob]),
        best_case: fields.one_of(c.best_case, &[BestCase::Observed, BestCase::Declared]),
        overload: Overload {
            utilisation: Ppm(c.overload_utilisation_ppm),
            queue: c.overload_queue as u16,
            ticks: c.overload_ticks as u8,
            tick: Duration::from_nanos(c.overload_tick_ns),
        },
        admission: fields.one_of(c.admission, &[Admission::Report, Admission::Enforce]),
        preempt: fields.one_of(c.preempt, &[false, true]),
    };
    fields.end(value)
}

pub(crate) fn of_config(c: &Config) -> red_config {
    let at = |place: Option<usize>| place.expect("one of the header's") as u32;
    red_config {
        struct_size: 0,
        abi_version: 0,
        lanes: c.lanes.into(),
        rule: at(RULES.iter().position(|rule| *rule == c.rule)),
        gate: c.gate as u32,
        reassign: match c.reassign {
            Reassign::Never => 0,
            Reassign::OnDispatch => 1,
            Reassign::OnChange => 2,
        },
        refine: c.refine.into(),
        frame_cache: c.frame_cache.into(),
        shed: match c.shed {
            Shed::Never => 0,
            Shed::LowestUrgency => 1,
            Shed::Hopeless => 2,
        },
        late: u32::from(c.late == Late::AbortJob),
        best_case: u32::from(c.best_case == BestCase::Declared),
        admission: u32::from(c.admission == Admission::Enforce),
        preempt: c.preempt.into(),
        overload_utilisation_ppm: c.overload.utilisation.0,
        overload_queue: c.overload.queue.into(),
        overload_ticks: c.overload.ticks.into(),
        overload_tick_ns: c.overload.tick.as_nanos(),
        memory_bytes: c.memory.map_or(RED_NONE_64, |bytes| bytes.0),
        merge_skew_ns: c.merge_skew.map_or(RED_NONE_64, Duration::as_nanos),
    }
}

pub(crate) fn node(n: &red_node) -> Result<Node, Statuses> {
    let mut fields = Fields(Statuses::NONE);
    let wcet = Wcet::from_nanos(n.wcet_ns);
    let sensor = (n.sensor != RED_NONE).then_some(SensorId::new(n.sensor as u8));
    let frame = Frame { weights: n.weights as u16, frame: n.frame as u16, sensor };
    if n.role == 1 {
        fields.check(n.weights < 1 << 16 && n.frame < 1 << 16, red_status::OutOfRange);
        fields.check(n.sensor == RED_NONE || n.sensor < 256, red_status::UnknownSensor);
    }
    let kinds = [Node::new(wcet), Node::shared_encoder(wcet, frame), Node::decoder(wcet)];
    let node = fields.one_of(n.role, &kinds);
    let is_atomic = fields.one_of(n.atomic, &[false, true]);
    fields.check(n.contention_ns == 0 || n.atomic != 0, red_status::OutOfRange);
    fields.check(n.pool < 256, red_status::UnknownPool);
    let node = if is_atomic { node.atomic(Contention::from_nanos(n.contention_ns)) } else { node };
    let node = node.best_case(Duration::from_nanos(n.bcet_ns)).memory(Bytes(n.memory_bytes));
    fields.end(node.in_pool(PoolId::new(n.pool as u8)))
}

pub(crate) fn of_node(n: &Node) -> red_node {
    let (role, frame) = match n.role() {
        Role::Ordinary => (0, None),
        Role::SharedEncoder(frame) => (1, Some(frame)),
        Role::Decoder => (2, None),
    };
    red_node {
        struct_size: 0,
        abi_version: 0,
        wcet_ns: n.wcet().as_nanos(),
        bcet_ns: n.best().as_nanos(),
        contention_ns: n.cost() - n.wcet().as_nanos(),
        memory_bytes: n.footprint().0,
        pool: n.pool().index() as u32,
        atomic: n.is_atomic().into(),
        role,
        weights: frame.map_or(0, |frame| frame.weights.into()),
        frame: frame.map_or(0, |frame| frame.frame.into()),
        sensor: frame.and_then(|frame| frame.sensor).map_or(RED_NONE, |sensor| sensor.index() as u32),
    }
}

pub(crate) fn timing(t: &red_timing) -> Result<Timing, Statuses> {
    let mut fields = Fields(Statuses::NONE);
    fields.check(t.floor_keep <= t.floor_of, red_status::OutOfRange);
    let value = Timing::new(Duration::from_nanos(t.deadline_ns)).value(t.value);
    let value = if t.period_ns > 0 { value.every(Duration::from_nanos(t.period_ns)) } else { value };
    let floor = t.floor_of > 0 && t.floor_keep <= t.floor_of;
    fields.end(if floor { value.floor(t.floor_keep, t.floor_of) } else { value })
}

fn shed(reason: Option<ShedReason>) -> u32 {
    match reason {
        None => 0,
        Some(ShedReason::Hopeless) => 1,
        Some(ShedReason::Overload) => 2,
        Some(ShedReason::Urgency) => 3,
        Some(ShedReason::Full) => 4,
        Some(ShedReason::Late) => 5,
        Some(ShedReason::Fault) => 6,
        Some(ShedReason::Removed) => 7,
    }
}

pub(crate) fn of_outcome(o: &Outcome) -> red_outcome {
    red_outcome {
        job: o.job.to_bits(),
        task: o.task.to_bits(),
        index: o.index,
        release_ns: o.release.as_nanos(),
        deadline_ns: o.deadline.as_nanos(),
        at_ns: o.at.as_nanos(),
        shed: shed(o.shed),
        reserved: 0,
    }
}

/// What was known at this instant.
pub(crate) fn of_warning(w: &Warning, now: u64) -> red_warning {
    let (task, index) = w.because.map_or((u32::MAX, u64::MAX), |(task, index)| (task.to_bits(), index));
    red_warning {
        job: w.job.to_bits(),
        task: w.task.to_bits(),
        index: w.index,
        deadline_ns: w.deadline.as_nanos(),
        at_ns: now,
        by_ns: w.by.as_nanos(),
        because_index: index,
        because_task: task,
        reserved: 0,
    }
}

/// An action, and how many of its bytes are written.
pub(crate) fn of_action(action: Option<Action>) -> (red_action, usize) {
    let head = size_of::<red_action>() - size_of::<red_outcome>();
    let (kind, unit) = match action {
        None => (0, None),
        Some(Action::Dispatch(unit)) => (1, Some(unit)),
        Some(Action::Preempt(unit)) => (2, Some(unit)),
        Some(Action::Ahead(unit)) => (4, Some(unit)),
        Some(Action::Ended(outcome)) => {
            let outcome = of_outcome(&outcome);
            return (red_action { kind: 3, lane: 0, unit: 0, outcome }, size_of::<red_action>());
        }
        Some(other) => panic!("an action that the header has not: {other:?}"),
    };
    let (lane, unit) = unit.map_or((0, 0), |unit| (unit.lane.index() as u32, unit.unit.to_bits()));
    (red_action { kind, lane, unit, outcome: red_outcome::EMPTY }, head)
}

pub(crate) fn of_member(m: &Member) -> red_member {
    red_member {
        job: m.job.to_bits(),
        task: m.task.to_bits(),
        node: m.node.index() as u32,
        reserved: 0,
        index: m.index,
        release_ns: m.release.as_nanos(),
        deadline_ns: m.deadline.as_nanos(),
        sub_deadline_ns: m.sub_deadline.as_nanos(),
    }
}

pub(crate) fn of_unit(u: &Unit) -> red_unit {
    red_unit {
        struct_size: 0,
        abi_version: 0,
        first: of_member(&u.first),
        lane: u.lane.index() as u32,
        pool: u.pool.index() as u32,
        output: u.output.map_or(RED_NONE, u32::from),
        reserved: 0,
        started_ns: u.started.as_nanos(),
        wcet_ns: u.wcet.as_nanos(),
    }
}

pub(crate) fn of_certificate(c: &Certificate) -> red_certificate {
    let (bound, paths) = match c.bound {
        Bound::Graham => (0, 0),
        Bound::LongPath { paths } => (1, paths.into()),
        Bound::SeveralPools => (2, 0),
        other => panic!("a bound that the header has not: {other:?}"),
    };
    red_certificate {
        struct_size: 0,
        abi_version: 0,
        bound,
        paths,
        lanes: c.lanes.into(),
        fits: (c.response <= c.limit).into(),
        memory_holds: c.memory_holds.into(),
        reserved: 0,
        work_ns: c.work.as_nanos(),
        critical_path_ns: c.critical_path.as_nanos(),
        response_ns: c.response.as_nanos(),
        limit_ns: c.limit.as_nanos(),
        margin_ns: c.margin().as_nanos(),
    }
}

pub(crate) fn of_event(e: &Event) -> red_event {
    let (kind, shed) = match e.kind {
        EventKind::Released => (1, 0),
        EventKind::Refused => (2, 0),
        EventKind::Started => (3, 0),
        EventKind::Completed => (4, 0),
        EventKind::Hit => (5, 0),
        EventKind::Preempted => (6, 0),
        EventKind::Overran => (7, 0),
        EventKind::Ended => (8, 0),
        EventKind::Shed(reason) => (9, shed(Some(reason))),
        EventKind::Edited => (10, 0),
        EventKind::Evicted => (11, 0),
        EventKind::Warned => (12, 0),
        other => panic!("an event that the header has not: {other:?}"),
    };
    red_event {
        at_ns: e.at.as_nanos(),
        job: e.job,
        kind,
        shed,
        task: e.task.to_bits(),
        node: e.node.index() as u32,
        lane: e.lane.index() as u32,
        reserved: 0,
    }
}
