//! What a report says of heap calls is what lanes did: with the allocator of the library that C links.

use core::ffi::{c_int, c_void};
use core::ptr;

use red_core::Empty;
use red_ffi::*;
use red_rt::allocations::arm;

/// Memory for a graph of the runtime's class.
#[repr(C, align(64))]
struct Memory([u8; RED_DAG_16X256X64_BYTES]);

/// What a body may do: a lane's heap calls are counted outside of bodies.
extern "C" fn quiet(_user: *mut c_void, _context: *const red_context) -> c_int {
    drop(core::hint::black_box(Box::new(1)));
    RED_BODY_DONE
}

/// Two heap calls as if they were the lane's own.
extern "C" fn as_a_lane(_user: *mut c_void, _context: *const red_context) -> c_int {
    arm(true);
    drop(core::hint::black_box(Box::new(1)));
    arm(false);
    RED_BODY_DONE
}

fn ok(status: red_status) {
    assert_eq!(status, red_status::Ok);
}

/// A struct with its head.
macro_rules! headed {
    ($name:ident { $($field:ident: $value:expr),* }) => {
        $name {
            struct_size: size_of::<$name>() as u32,
            abi_version: RED_ABI_VERSION,
            $($field: $value,)*
            ..$name::EMPTY
        }
    };
}

/// What a run of one job with this body reports.
fn counted(body: extern "C" fn(*mut c_void, *const red_context) -> c_int) -> u64 {
    let mut policy = headed!(red_config {});
    ok(red_config_preset(red_preset::Redrt as u32, &raw mut policy));
    let mode = red_mode::BestEffort as u32;
    let config = headed!(red_runtime_config { mode: mode, priority: 80, drain_ns: 60_000_000_000 });
    let mut runtime = red_runtime::default();
    ok(red_runtime_open(&raw const policy, &raw const config, &raw mut runtime));

    let mut memory = Box::new(Memory([0; RED_DAG_16X256X64_BYTES]));
    let (mut dag, mut node, mut task) = (red_dag::default(), 0, 0);
    let place = (&raw mut *memory).cast();
    ok(red_dag_open_16x256x64(place, RED_DAG_16X256X64_BYTES, &raw mut dag));
    let one = headed!(red_node { wcet_ns: 1_000_000, sensor: RED_NONE });
    ok(red_dag_add_node(&raw mut dag, &raw const one, &raw mut node));
    let callback = red_callback { node, reserved: 0, body: Some(body), user: ptr::null_mut() };
    let timing = headed!(red_timing { deadline_ns: 60_000_000_000 });
    let added = red_runtime_add_task(
        &raw mut runtime,
        &raw const dag,
        &raw const callback,
        1,
        &raw const timing,
        &raw mut task,
    );
    ok(added);
    ok(red_dag_close(&raw mut dag));

    ok(red_runtime_start(&raw mut runtime));
    ok(red_runtime_release(&raw const runtime, task, RED_NONE_64));
    let mut report = headed!(red_report {});
    while report.on_time == 0 {
        std::thread::yield_now();
        ok(red_runtime_report(&raw const runtime, &raw mut report));
    }
    ok(red_runtime_stop(&raw const runtime));
    ok(red_runtime_wait(&raw const runtime, RED_NONE_64));
    ok(red_runtime_report(&raw const runtime, &raw mut report));
    ok(red_runtime_close(&raw mut runtime));
    report.allocations
}

#[test]
fn heap_calls_of_lanes_are_reported_and_those_of_bodies_are_not() {
    assert_eq!(counted(quiet), 0);
    assert_eq!(counted(as_a_lane), 2);
}
