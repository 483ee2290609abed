//! Everything that a call of the C ABI may be given, valid.

use red_core::Empty;
use red_ffi::*;
use std::ffi::CStr;
use std::fs;

/// Memory as C lends it.
#[repr(C, align(64))]
pub(crate) struct Lent<const BYTES: usize>(pub(crate) [u8; BYTES]);

impl<const BYTES: usize> Lent<BYTES> {
    pub(crate) fn new() -> Box<Self> {
        Box::new(Self([0; BYTES]))
    }

    pub(crate) fn at(&mut self) -> *mut core::ffi::c_void {
        (&raw mut self.0).cast()
    }
}

/// Structs that may grow, with their heads.
pub(crate) trait Head: Empty {
    fn headed() -> Self;
}

macro_rules! heads {
    ($($name:ident)*) => { $(
        impl Head for $name {
            fn headed() -> Self {
                Self { struct_size: size_of::<Self>() as u32, abi_version: RED_ABI_VERSION, ..Self::EMPTY }
            }
        }
    )* };
}
heads!(
    red_config red_node red_timing red_certificate red_unit red_figures red_executions red_dag_summary red_task_report red_runtime_config
    red_report
);

/// A scheduler with a running unit, a graph, and room for every output.
pub(crate) struct World {
    pub(crate) scheduler_memory: Box<Lent<RED_SCHEDULER_4X16X16_BYTES>>,
    pub(crate) dag_memory: Box<Lent<RED_DAG_4X16X16_BYTES>>,
    pub(crate) free_memory: Box<Lent<RED_SCHEDULER_16X256X64_BYTES>>,
    pub(crate) scheduler: red_scheduler,
    pub(crate) dag: red_dag,
    /// An edit of the task.
    pub(crate) edit_memory: Box<Lent<RED_DAG_4X16X16_BYTES>>,
    pub(crate) edit: red_dag,
    /// What a call opens.
    pub(crate) opened_scheduler: red_scheduler,
    pub(crate) opened_dag: red_dag,
    /// Opened where it is asked for.
    pub(crate) runtime: red_runtime,
    pub(crate) opened_runtime: red_runtime,
    pub(crate) runtime_config: red_runtime_config,
    pub(crate) large_memory: Box<Lent<RED_DAG_16X256X64_BYTES>>,
    pub(crate) large: red_dag,
    pub(crate) callbacks: [red_callback; 2],
    pub(crate) report: red_report,
    pub(crate) text: [i8; 512],
    pub(crate) path: [u8; 64],
    pub(crate) config: red_config,
    pub(crate) node: red_node,
    pub(crate) decoders: [red_node; 2],
    pub(crate) timing: red_timing,
    pub(crate) certificate: red_certificate,
    pub(crate) task_report: red_task_report,
    pub(crate) unit: red_unit,
    pub(crate) figures: red_figures,
    pub(crate) executions: red_executions,
    pub(crate) summary: red_dag_summary,
    pub(crate) action: red_action,
    pub(crate) outcome: red_outcome,
    pub(crate) warning: red_warning,
    pub(crate) lanes: [u32; 2],
    pub(crate) budgets: [u64; 2],
    pub(crate) placed: [red_placed_node; 16],
    pub(crate) levels: [red_level; 16],
    pub(crate) numbers: [u32; 16],
    pub(crate) members: [red_member; 16],
    pub(crate) events: [red_event; 16],
    pub(crate) number: u32,
    pub(crate) wide: u64,
    pub(crate) count: usize,
    pub(crate) task: u32,
    /// The unit that runs.
    pub(crate) running: u64,
}

fn ok(status: red_status) {
    assert_eq!(status, red_status::Ok);
}

extern "C" fn no_body(_user: *mut core::ffi::c_void, _context: *const red_context) -> core::ffi::c_int {
    RED_BODY_DONE
}

impl World {
    /// Opens a runtime of one task of two nodes.
    pub(crate) fn open_runtime(&mut self) {
        let runtime = &raw mut self.runtime;
        ok(red_runtime_open(&raw const self.config, &raw const self.runtime_config, runtime));
        ok(red_dag_open_16x256x64(self.large_memory.at(), RED_DAG_16X256X64_BYTES, &raw mut self.large));
        for _ in 0..2 {
            ok(red_dag_add_node(&raw mut self.large, &raw const self.node, &raw mut self.number));
        }
        let (dag, bodies, timing) = (&raw const self.large, self.callbacks.as_ptr(), &raw const self.timing);
        ok(red_runtime_add_task(runtime, dag, bodies, 2, timing, &raw mut self.task));
    }

    /// Opens one where nothing is set up yet.
    pub(crate) fn open_empty_runtime(&mut self) {
        let runtime = &raw mut self.runtime;
        ok(red_runtime_open(&raw const self.config, &raw const self.runtime_config, runtime));
    }

    /// Asks it to end.
    pub(crate) fn stop_runtime(&mut self) {
        ok(red_runtime_stop(&raw const self.runtime));
    }

    /// Starts it.
    pub(crate) fn start_runtime(&mut self) {
        self.open_runtime();
        ok(red_runtime_start(&raw mut self.runtime));
    }

    /// Makes of the large graph an edit of its task, with another node.
    pub(crate) fn edit_runtime(&mut self) {
        let dag = &raw mut self.large;
        ok(red_dag_close(dag));
        let memory = self.large_memory.at();
        ok(red_runtime_edit(&raw mut self.runtime, self.task, memory, RED_DAG_16X256X64_BYTES, dag));
        ok(red_dag_add_node(dag, &raw const self.node, &raw mut self.number));
        self.callbacks[0].node = self.number;
    }

    pub(crate) fn new() -> Box<Self> {
        let mut w = Box::new(Self {
            scheduler_memory: Lent::new(),
            dag_memory: Lent::new(),
            free_memory: Lent::new(),
            scheduler: red_scheduler::default(),
            dag: red_dag::default(),
            edit_memory: Lent::new(),
            edit: red_dag::default(),
            opened_scheduler: red_scheduler::default(),
            opened_dag: red_dag::default(),
            runtime: red_runtime::default(),
            opened_runtime: red_runtime::default(),
            runtime_config: red_runtime_config {
                mode: red_mode::BestEffort as u32,
                priority: 80,
                drain_ns: 1_000_000_000,
                ..red_runtime_config::headed()
            },
            large_memory: Lent::new(),
            large: red_dag::default(),
            callbacks: [0, 1].map(|node| red_callback { node, body: Some(no_body), ..red_callback::EMPTY }),
            report: red_report::headed(),
            text: [0; 512],
            path: [0; 64],
            config: red_config::headed(),
            node: red_node { wcet_ns: 1_000, sensor: RED_NONE, ..red_node::headed() },
            decoders: [red_node { role: red_role::Decoder as u32, wcet_ns: 100, ..red_node::headed() }; 2],
            timing: red_timing { deadline_ns: 1_000_000, value: 1, ..red_timing::headed() },
            certificate: red_certificate::headed(),
            task_report: red_task_report::headed(),
            unit: red_unit::headed(),
            figures: red_figures::headed(),
            executions: red_executions::headed(),
            summary: red_dag_summary::headed(),
            action: red_action::EMPTY,
            outcome: red_outcome::EMPTY,
            warning: red_warning::EMPTY,
            lanes: [1, 2],
            budgets: [RED_NONE_64; 2],
            placed: [red_placed_node::EMPTY; 16],
            levels: [red_level::EMPTY; 16],
            numbers: [0; 16],
            members: [red_member::EMPTY; 16],
            events: [red_event::EMPTY; 16],
            number: 0,
            wide: 0,
            count: 0,
            task: 0,
            running: 0,
        });
        ok(red_config_preset(red_preset::Redrt as u32, &raw mut w.config));
        w.config.lanes = 2;
        let memory = w.scheduler_memory.at();
        let (scheduler, dag, number) = (&raw mut w.scheduler, &raw mut w.dag, &raw mut w.number);
        ok(red_scheduler_open_4x16x16(memory, RED_SCHEDULER_4X16X16_BYTES, &raw const w.config, scheduler));
        ok(red_dag_open_4x16x16(w.dag_memory.at(), RED_DAG_4X16X16_BYTES, dag));
        for _ in 0..3 {
            ok(red_dag_add_node(dag, &raw const w.node, number));
        }
        ok(red_dag_add_edge(dag, 0, 1));
        ok(red_scheduler_add_task(scheduler, dag, &raw const w.timing, &raw mut w.task));
        ok(red_scheduler_release(scheduler, w.task, 1, number));
        ok(red_scheduler_poll(scheduler, 1, &raw mut w.action));
        w.running = w.action.unit;
        let memory = w.edit_memory.at();
        ok(red_scheduler_edit(scheduler, w.task, memory, RED_DAG_4X16X16_BYTES, &raw mut w.edit));
        w
    }

    /// The state of everything that is open.
    pub(crate) fn state(&self) -> Vec<u8> {
        [&self.scheduler_memory.0[..], &self.dag_memory.0, &self.edit_memory.0].concat()
    }
}

impl Drop for World {
    fn drop(&mut self) {
        // Some were closed by the call that was tried.
        for runtime in [&mut self.runtime, &mut self.opened_runtime] {
            let _closed = red_runtime_close(runtime);
        }
        for dag in [&mut self.dag, &mut self.edit, &mut self.opened_dag, &mut self.large] {
            let _closed = red_dag_close(dag);
        }
        for scheduler in [&mut self.scheduler, &mut self.opened_scheduler] {
            let _closed = red_scheduler_close(scheduler);
        }
        // Calls that were refused made none.
        let log = CStr::from_bytes_until_nul(&self.path).ok().and_then(|log| log.to_str().ok());
        let _removed = log.map(fs::remove_file);
    }
}
