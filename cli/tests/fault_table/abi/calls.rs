//! Every function of the header, called with pointers of a [`World`] or with others in their place.

use super::world::World;
use red_ffi::*;
use std::ptr::with_exposed_provenance_mut as at;

/// A function, what its pointers are in a world, and the call with such pointers.
pub(crate) struct Call {
    pub(crate) name: &'static str,
    pub(crate) pointers: fn(&mut World) -> Vec<usize>,
    pub(crate) call: fn(&World, &[usize]) -> red_status,
}

macro_rules! calls {
    ($($name:ident($w:ident; $($pointer:expr),*) |$p:ident| ($($argument:expr),*);)*) => { &[$(
        Call {
            name: stringify!($name),
            pointers: |$w| vec![$((&raw mut $pointer).expose_provenance()),*],
            call: |$w, $p| { let _unused = $w; $name($($argument),*) },
        },
    )*] };
}

const DAG: usize = RED_DAG_4X16X16_BYTES;

/// All functions that take a pointer.
pub(crate) const CALLS: &[Call] = calls! {
    red_config_preset(w; w.config) |p| (4, at(p[0]));
    red_dag_open_4x16x16(w; w.free_memory.0, w.opened_dag) |p| (at(p[0]), DAG, at(p[1]));
    red_dag_open_8x64x32(w; w.free_memory.0, w.opened_dag) |p| (at(p[0]), RED_DAG_8X64X32_BYTES, at(p[1]));
    red_dag_open_16x256x64(w; w.free_memory.0, w.opened_dag) |p| (at(p[0]), RED_DAG_16X256X64_BYTES, at(p[1]));
    red_dag_close(w; w.dag) |p| (at(p[0]));
    red_dag_add_node(w; w.dag, w.node, w.number) |p| (at(p[0]), at(p[1]), at(p[2]));
    red_dag_add_edge(w; w.dag) |p| (at(p[0]), 1, 2);
    red_dag_remove_node(w; w.dag) |p| (at(p[0]), 1);
    red_dag_remove_edge(w; w.dag) |p| (at(p[0]), 0, 1);
    red_dag_refine(w; w.dag, w.node, w.decoders, w.number) |p| (at(p[0]), 1, at(p[1]), at(p[2]), 2, at(p[3]));
    red_dag_summarize(w; w.dag, w.summary) |p| (at(p[0]), at(p[1]));
    red_dag_node(w; w.dag, w.node) |p| (at(p[0]), 1, at(p[1]));
    red_dag_successors(w; w.dag, w.numbers, w.count) |p| (at(p[0]), 0, at(p[1]), 16, at(p[2]));
    red_dag_place(w; w.dag, w.lanes, w.placed, w.count) |p| (at(p[0]), 1, 1_000, at(p[1]), 2, at(p[2]), 16, at(p[3]));
    red_dag_share(w; w.dag, w.lanes, w.levels, w.count) |p| (at(p[0]), 1, 1_000, at(p[1]), 2, at(p[2]), 16, at(p[3]));
    red_dag_prove(w; w.dag, w.lanes, w.budgets, w.certificate) |p| (at(p[0]), 1_000, at(p[1]), at(p[2]), 2, at(p[3]));
    red_scheduler_open_4x16x16(w; w.free_memory.0, w.config, w.opened_scheduler)
        |p| (at(p[0]), RED_SCHEDULER_4X16X16_BYTES, at(p[1]), at(p[2]));
    red_scheduler_open_8x64x32(w; w.free_memory.0, w.config, w.opened_scheduler)
        |p| (at(p[0]), RED_SCHEDULER_8X64X32_BYTES, at(p[1]), at(p[2]));
    red_scheduler_open_16x256x64(w; w.free_memory.0, w.config, w.opened_scheduler)
        |p| (at(p[0]), RED_SCHEDULER_16X256X64_BYTES, at(p[1]), at(p[2]));
    red_scheduler_close(w; w.scheduler) |p| (at(p[0]));
    red_scheduler_add_pool(w; w.scheduler, w.number) |p| (at(p[0]), 1, RED_NONE_64, at(p[1]));
    red_scheduler_add_sensor(w; w.scheduler, w.number) |p| (at(p[0]), 1_000, at(p[1]));
    red_scheduler_config(w; w.scheduler, w.config) |p| (at(p[0]), at(p[1]));
    red_scheduler_memory_used(w; w.scheduler, w.wide) |p| (at(p[0]), 0, at(p[1]));
    red_scheduler_add_task(w; w.scheduler, w.dag, w.timing, w.number) |p| (at(p[0]), at(p[1]), at(p[2]), at(p[3]));
    red_scheduler_remove_task(w; w.scheduler) |p| (at(p[0]), w.task, 2);
    red_scheduler_certificate(w; w.scheduler, w.certificate) |p| (at(p[0]), w.task, at(p[1]));
    red_scheduler_edit(w; w.scheduler, w.free_memory.0, w.opened_dag) |p| (at(p[0]), w.task, at(p[1]), DAG, at(p[2]));
    red_scheduler_commit(w; w.scheduler, w.edit, w.certificate) |p| (at(p[0]), at(p[1]), 2, at(p[2]));
    red_scheduler_release(w; w.scheduler, w.number) |p| (at(p[0]), w.task, 2, at(p[1]));
    red_scheduler_release_at(w; w.scheduler, w.number) |p| (at(p[0]), w.task, 1, 7, 2, at(p[1]));
    red_scheduler_poll(w; w.scheduler, w.action) |p| (at(p[0]), 2, at(p[1]));
    red_scheduler_poll_on(w; w.scheduler, w.action) |p| (at(p[0]), 1, 2, at(p[1]));
    red_scheduler_complete(w; w.scheduler) |p| (at(p[0]), w.running, 2);
    red_scheduler_complete_and_poll(w; w.scheduler, w.action) |p| (at(p[0]), w.running, 2, at(p[1]));
    red_scheduler_fail(w; w.scheduler) |p| (at(p[0]), w.running, 2);
    red_scheduler_take_outcome(w; w.scheduler, w.outcome, w.number) |p| (at(p[0]), at(p[1]), at(p[2]));
    red_scheduler_take_warning(w; w.scheduler, w.warning, w.number) |p| (at(p[0]), at(p[1]), at(p[2]));
    red_scheduler_retire_lane(w; w.scheduler) |p| (at(p[0]), 1);
    red_scheduler_dispatch_ahead(w; w.scheduler) |p| (at(p[0]), 0);
    red_scheduler_lose_pool(w; w.scheduler) |p| (at(p[0]), 0, 2);
    red_scheduler_waits_for(w; w.scheduler, w.wide, w.count) |p| (at(p[0]), w.running, at(p[1]), 1, at(p[2]));
    red_scheduler_poll_at(w; w.scheduler, w.wide) |p| (at(p[0]), at(p[1]));
    red_scheduler_unit(w; w.scheduler, w.unit) |p| (at(p[0]), w.running, at(p[1]));
    red_scheduler_members(w; w.scheduler, w.members, w.count) |p| (at(p[0]), w.running, at(p[1]), 16, at(p[2]));
    red_scheduler_job(w; w.scheduler, w.number) |p| (at(p[0]), w.task, 0, at(p[1]));
    red_scheduler_executions(w; w.scheduler, w.executions) |p| (at(p[0]), w.task, 0, at(p[1]));
    red_scheduler_figures(w; w.scheduler, w.figures) |p| (at(p[0]), at(p[1]));
    red_runtime_open(w; w.config, w.runtime_config, w.opened_runtime) |p| (at(p[0]), at(p[1]), at(p[2]));
    red_runtime_now(w; w.wide) |p| (at(p[0]));
    red_scheduler_take_events(w; w.scheduler, w.events, w.count) |p| (at(p[0]), at(p[1]), 16, at(p[2]));
};

/// Those that only work after another one.
pub(crate) const RESTORE: Call = Call {
    name: "red_scheduler_restore_lane",
    pointers: |w| {
        assert_eq!(red_scheduler_retire_lane(&raw mut w.scheduler, 1), red_status::Ok);
        vec![(&raw mut w.scheduler).expose_provenance()]
    },
    call: |_, p| red_scheduler_restore_lane(at(p[0]), 1),
};

/// The functions of the runtime, each in the state that it needs.
macro_rules! on_runtime {
    ($($name:ident($w:ident; $prepare:expr; $($pointer:expr),*) |$p:ident| ($($argument:expr),*);)*) => { &[$(
        Call {
            name: stringify!($name),
            pointers: |$w| {
                $prepare;
                vec![$((&raw mut $pointer).expose_provenance()),*]
            },
            call: |$w, $p| { let _unused = $w; $name($($argument),*) },
        },
    )*] };
}

/// A file for the log of a world.
fn named(w: &mut World) {
    let name = std::env::temp_dir().join(format!("red-abi-{}.redlog", std::process::id()));
    let name = name.to_str().expect("a name in UTF-8").as_bytes();
    w.path[..name.len()].copy_from_slice(name);
}

/// A log of a scheduler that was just opened.
fn logged(w: &mut World) {
    named(w);
    let (memory, opened) = (w.free_memory.at(), &raw mut w.scheduler);
    assert_eq!(red_scheduler_close(opened), red_status::Ok);
    let bytes = RED_SCHEDULER_16X256X64_BYTES;
    assert_eq!(red_scheduler_open_16x256x64(memory, bytes, &raw const w.config, opened), red_status::Ok);
}

fn logging(w: &mut World) {
    logged(w);
    assert_eq!(red_record_begin(&raw mut w.scheduler, w.path.as_ptr().cast()), red_status::Ok);
}

const LARGE: usize = RED_DAG_16X256X64_BYTES;

pub(crate) const RUNTIME: &[Call] = on_runtime! {
    red_runtime_close(w; w.open_runtime(); w.runtime) |p| (at(p[0]));
    red_runtime_state_of(w; w.open_runtime(); w.runtime, w.number) |p| (at(p[0]), at(p[1]));
    red_runtime_message(w; w.open_runtime(); w.runtime, w.text, w.count) |p| (at(p[0]), at(p[1]), 512, at(p[2]));
    red_runtime_report(w; w.open_runtime(); w.runtime, w.report) |p| (at(p[0]), at(p[1]));
    red_runtime_add_pool(w; w.open_runtime(); w.runtime, w.number) |p| (at(p[0]), 1, RED_NONE_64, at(p[1]));
    red_runtime_add_cuda_pool(w; w.open_runtime(); w.runtime, w.number) |p| (at(p[0]), 0, 1, RED_NONE_64, at(p[1]));
    red_runtime_add_sensor(w; w.open_runtime(); w.runtime, w.number) |p| (at(p[0]), 1_000, at(p[1]));
    red_runtime_pin(w; w.open_runtime(); w.runtime, w.lanes) |p| (at(p[0]), at(p[1]), 2);
    red_runtime_every(w; w.open_runtime(); w.runtime) |p| (at(p[0]), w.task, 0, 1_000_000);
    red_runtime_record(w; { w.open_empty_runtime(); named(w) }; w.runtime, w.path) |p| (at(p[0]), at(p[1]));
    red_record_begin(w; logged(w); w.scheduler, w.path) |p| (at(p[0]), at(p[1]));
    red_record_end(w; logging(w); w.scheduler, w.wide) |p| (at(p[0]), 1, at(p[1]));
    red_runtime_add_task(w; w.open_runtime(); w.runtime, w.large, w.callbacks, w.timing, w.number)
        |p| (at(p[0]), at(p[1]), at(p[2]), 2, at(p[3]), at(p[4]));
    red_runtime_remove_task(w; w.start_runtime(); w.runtime) |p| (at(p[0]), w.task);
    red_runtime_certificate(w; w.start_runtime(); w.runtime, w.certificate) |p| (at(p[0]), w.task, at(p[1]));
    red_runtime_edit(w; w.start_runtime(); w.runtime, w.free_memory.0, w.opened_dag)
        |p| (at(p[0]), w.task, at(p[1]), LARGE, at(p[2]));
    red_runtime_commit(w; { w.start_runtime(); w.edit_runtime() }; w.runtime, w.large, w.callbacks, w.certificate)
        |p| (at(p[0]), at(p[1]), at(p[2]), 1, at(p[3]));
    red_runtime_start(w; w.open_runtime(); w.runtime) |p| (at(p[0]));
    red_runtime_release(w; w.start_runtime(); w.runtime) |p| (at(p[0]), w.task, RED_NONE_64);
    red_runtime_stop(w; w.start_runtime(); w.runtime) |p| (at(p[0]));
    red_runtime_wait(w; { w.start_runtime(); w.stop_runtime() }; w.runtime) |p| (at(p[0]), 10_000_000_000);
    red_runtime_figures(w; w.start_runtime(); w.runtime, w.figures) |p| (at(p[0]), at(p[1]));
    red_runtime_take_outcomes(w; w.start_runtime(); w.runtime, w.outcome, w.count)
        |p| (at(p[0]), at(p[1]), 1, at(p[2]));
    red_runtime_task_report(w; w.start_runtime(); w.runtime, w.task_report) |p| (at(p[0]), w.task, at(p[1]));
    red_runtime_take_warnings(w; w.start_runtime(); w.runtime, w.warning, w.count)
        |p| (at(p[0]), at(p[1]), 1, at(p[2]));
    red_runtime_take_events(w; w.start_runtime(); w.runtime, w.events, w.count)
        |p| (at(p[0]), at(p[1]), 16, at(p[2]));
};

/// All of them.
pub(crate) fn all() -> impl Iterator<Item = &'static Call> {
    CALLS.iter().chain([&RESTORE]).chain(RUNTIME)
}

/// What a pointer of the header is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A handle, by its type.
    Handle(&'static str),
    /// A struct that begins with its size and version, and whether it is only read.
    Growing { is_read: bool },
    /// Bytes, which may lie anywhere.
    Text,
    /// Anything else.
    Plain,
}

/// Of every function of the header that takes a pointer: what its pointers are for.
pub(crate) fn header() -> Vec<(String, Vec<Kind>)> {
    let text = include_str!("../../../../ffi/include/red.h");
    let is_growing = |name: &str| {
        let before = text.split_once(&format!("}} {name};")).map(|(before, _)| before);
        let body = before.and_then(|before| before.rsplit("typedef struct").next());
        body.is_some_and(|body| body.contains("uint32_t struct_size;"))
    };
    let kind = |parameter: &str| {
        let is_read = parameter.trim().starts_with("const ");
        let parameter = parameter.trim().trim_start_matches("const ");
        let of = parameter.split_once('*')?.0.trim();
        Some(match of {
            "red_scheduler" => Kind::Handle("red_scheduler"),
            "red_dag" => Kind::Handle("red_dag"),
            "red_runtime" => Kind::Handle("red_runtime"),
            "char" => Kind::Text,
            _ if is_growing(of) => Kind::Growing { is_read },
            _ => Kind::Plain,
        })
    };
    let functions = text.split(';').filter_map(|piece| {
        let (_, prototype) = piece.rsplit_once("red_status red_")?;
        let (name, parameters) = prototype.split_once('(')?;
        let kinds: Vec<Kind> = parameters.trim_end_matches(')').split(',').filter_map(kind).collect();
        (!kinds.is_empty()).then(|| (format!("red_{name}"), kinds))
    });
    functions.collect()
}
