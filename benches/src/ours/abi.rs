//! One lane through the C ABI: the same calls as `one_lane`, behind pointers.

mod functions;

use red_core::Empty;
use red_core::{Action, Caps, Config, Instant, PoolId, Scheduler};
use red_ffi::{
    RED_ABI_VERSION, RED_ALIGN, RED_DAG_16X256X64_BYTES, RED_SCHEDULER_16X256X64_BYTES, red_action,
    red_action_kind, red_config, red_dag, red_node, red_preset, red_role, red_scheduler, red_status,
    red_timing,
};

use super::{DEADLINE, WCET, admit, dag};
use crate::measure::{Runner, fill};
use crate::not_run::NotRun;
use crate::peers::Setup;
use functions::Functions;

/// The largest class of the ABI.
pub(super) type Class = Caps<16, 256, 64, 32, 32, 4, 1024>;

/// What both run: the default.
const CONFIG: Config = Config::REDRT;

/// Memory that a caller lends.
#[repr(C, align(64))]
struct Lent<const BYTES: usize>([u8; BYTES]);
const _: () = assert!(align_of::<Lent<1>>() == RED_ALIGN, "aligned as the header says");

impl<const BYTES: usize> Lent<BYTES> {
    fn new() -> Box<Self> {
        Box::new(Self([0; BYTES]))
    }
}

/// A scheduler that is closed at the end.
struct Open {
    red: Functions,
    scheduler: red_scheduler,
    _memory: Box<Lent<RED_SCHEDULER_16X256X64_BYTES>>,
}

impl Open {
    /// What calls take. A call, so that a closure keeps all of this and not a copy of the handle.
    fn handle(&mut self) -> *mut red_scheduler {
        &raw mut self.scheduler
    }
}

impl Drop for Open {
    fn drop(&mut self) {
        assert_eq!((self.red.close)(&raw mut self.scheduler), red_status::Ok, "closed once");
    }
}

fn ok(status: red_status) -> Result<(), NotRun> {
    if status == red_status::Ok { Ok(()) } else { Err(NotRun::Failed(format!("RED: {:?}", status.text()))) }
}

/// The head of a struct.
const fn size<T>() -> u32 {
    size_of::<T>() as u32
}

fn open(red: Functions, setup: &Setup<'_>) -> Result<(Open, u32), NotRun> {
    let abi_version = RED_ABI_VERSION;
    let mut config = red_config { struct_size: size::<red_config>(), abi_version, ..red_config::EMPTY };
    ok((red.preset)(red_preset::Redrt as u32, &raw mut config))?;
    let mut memory = Lent::new();
    let mut scheduler = red_scheduler::default();
    let at = (&raw mut *memory).cast();
    ok((red.open)(at, RED_SCHEDULER_16X256X64_BYTES, &raw const config, &raw mut scheduler))?;
    let mut open = Open { red, scheduler, _memory: memory };

    let mut memory = Lent::<RED_DAG_16X256X64_BYTES>::new();
    let mut dag = red_dag::default();
    ok((red.dag_open)((&raw mut *memory).cast(), RED_DAG_16X256X64_BYTES, &raw mut dag))?;
    let node = red_node {
        struct_size: size::<red_node>(),
        abi_version,
        wcet_ns: WCET.as_nanos(),
        role: red_role::Ordinary as u32,
        ..red_node::EMPTY
    };
    let mut number = 0;
    for _ in 0..setup.graph.nodes() {
        ok((red.add_node)(&raw mut dag, &raw const node, &raw mut number))?;
    }
    for (from, list) in setup.graph.successors.iter().enumerate() {
        for &to in list {
            ok((red.add_edge)(&raw mut dag, from as u32, to))?;
        }
    }
    let timing = red_timing {
        struct_size: size::<red_timing>(),
        abi_version,
        deadline_ns: DEADLINE.as_nanos(),
        value: 1,
        ..red_timing::EMPTY
    };
    let mut task = 0;
    ok((red.add_task)(&raw mut open.scheduler, &raw const dag, &raw const timing, &raw mut task))?;
    ok((red.dag_close)(&raw mut dag))?;
    Ok((open, task))
}

/// The calls of a host that asks for no events, which then cost a count.
pub(super) fn from_rust(setup: &Setup<'_>) -> Result<Runner, NotRun> {
    let mut scheduler = Box::new(Scheduler::<Class>::new(CONFIG));
    let task = admit(&mut scheduler, &dag(setup.graph, |_| PoolId::new(0))?)?;
    let (body, call) = (setup.body, setup.body.behind_pointer());
    let mut now = 0;
    Ok(Box::new(move |runs, samples| {
        let mut completed = true;
        fill(samples, || {
            for _ in 0..runs {
                now += 1;
                let at = Instant::from_nanos(now);
                completed &= scheduler.release(task, at).is_ok();
                let mut action = Ok(scheduler.poll(at));
                while let Ok(Some(Action::Dispatch(next))) = action {
                    call(body, next.unit.node().index());
                    now += 1;
                    action = scheduler.complete_and_poll(next.unit, Instant::from_nanos(now));
                }
                completed &= matches!(action, Ok(Some(Action::Ended(job))) if job.on_time());
            }
        });
        if completed { Ok(()) } else { Err(NotRun::Failed("RED left a job undone".to_owned())) }
    }))
}

/// The same calls through the C ABI, of this program's build.
pub(super) fn linked(setup: &Setup<'_>) -> Result<Runner, NotRun> {
    run(Functions::linked(), setup)
}

/// The same calls of the shared library.
pub(super) fn loaded(setup: &Setup<'_>) -> Result<Runner, NotRun> {
    run(Functions::loaded()?, setup)
}

fn run(red: Functions, setup: &Setup<'_>) -> Result<Runner, NotRun> {
    let (mut open, task) = open(red, setup)?;
    let (body, call) = (setup.body, setup.body.behind_pointer());
    let Functions { release, poll, complete_and_poll, .. } = red;
    let mut now = 0;
    Ok(Box::new(move |runs, samples| {
        let mut completed = true;
        fill(samples, || {
            let scheduler = open.handle();
            for _ in 0..runs {
                now += 1;
                let (mut job, mut action) = (0, red_action::EMPTY);
                completed &= release(scheduler, task, now, &raw mut job) == red_status::Ok;
                let mut status = poll(scheduler, now, &raw mut action);
                while status == red_status::Ok && action.kind == red_action_kind::Dispatch as u32 {
                    call(body, (action.unit >> 8 & 0xff) as usize);
                    now += 1;
                    status = complete_and_poll(scheduler, action.unit, now, &raw mut action);
                }
                completed &= action.kind == red_action_kind::Ended as u32 && action.outcome.shed == 0;
            }
        });
        if completed { Ok(()) } else { Err(NotRun::Failed("RED left a job undone".to_owned())) }
    }))
}
