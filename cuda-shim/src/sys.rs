//! `red_cuda.h` and `red_nvml.h`, as Rust declares them.
#![allow(unsafe_code, reason = "names of C")]

use core::ffi::{c_char, c_int, c_void};
use core::marker::{PhantomData, PhantomPinned};

/// What a handle of the driver points to.
macro_rules! opaque {
    ($($name:ident)*) => {$(
        #[repr(C)]
        pub(crate) struct $name {
            _data: [u8; 0],
            _marker: PhantomData<(*mut u8, PhantomPinned)>,
        }
    )*};
}

opaque!(Context Stream Event Module Function Graph GraphExec);

pub(crate) type Status = i32;

pub(crate) const OK: Status = 0;
pub(crate) const NO_LIBRARY: Status = -1;
pub(crate) const NOT_READY: Status = 600;
/// Ours alone: the driver answered success and gave no handle.
pub(crate) const NO_HANDLE: Status = -4;

unsafe extern "C" {
    pub(crate) fn red_nvml_open(bus_id: *const c_char, device: *mut *mut c_void) -> Status;
    pub(crate) fn red_nvml_utilisation(device: *mut c_void, percent: *mut u32) -> Status;

    pub(crate) fn red_cuda_load(words: *mut c_char, size: usize) -> Status;
    pub(crate) fn red_cuda_init() -> Status;
    pub(crate) fn red_cuda_driver_version(version: *mut i32) -> Status;
    pub(crate) fn red_cuda_error_name(error: Status, name: *mut *const c_char) -> Status;
    pub(crate) fn red_cuda_error_text(error: Status, text: *mut *const c_char) -> Status;

    pub(crate) fn red_cuda_device_count(count: *mut i32) -> Status;
    pub(crate) fn red_cuda_device_get(ordinal: i32, device: *mut i32) -> Status;
    pub(crate) fn red_cuda_device_name(device: i32, name: *mut c_char, size: usize) -> Status;
    pub(crate) fn red_cuda_device_bus_id(device: i32, id: *mut c_char, size: usize) -> Status;
    pub(crate) fn red_cuda_device_attribute(device: i32, attribute: u32, value: *mut i32) -> Status;
    pub(crate) fn red_cuda_context_retain(device: i32, context: *mut *mut Context) -> Status;
    pub(crate) fn red_cuda_context_release(device: i32) -> Status;
    pub(crate) fn red_cuda_context_enter(context: *mut Context) -> Status;
    pub(crate) fn red_cuda_context_synchronize() -> Status;
    pub(crate) fn red_cuda_context_priorities(least: *mut i32, greatest: *mut i32) -> Status;

    pub(crate) fn red_cuda_stream_create(priority: i32, stream: *mut *mut Stream) -> Status;
    pub(crate) fn red_cuda_stream_destroy(stream: *mut Stream) -> Status;
    pub(crate) fn red_cuda_stream_wait(stream: *mut Stream, event: *mut Event) -> Status;
    pub(crate) fn red_cuda_stream_call(
        stream: *mut Stream,
        function: extern "C" fn(*mut c_void),
        argument: *mut c_void,
    ) -> Status;
    pub(crate) fn red_cuda_stream_begin_capture(stream: *mut Stream) -> Status;
    pub(crate) fn red_cuda_stream_end_capture(stream: *mut Stream, graph: *mut *mut Graph) -> Status;
    pub(crate) fn red_cuda_event_create(timed: c_int, event: *mut *mut Event) -> Status;
    pub(crate) fn red_cuda_event_destroy(event: *mut Event) -> Status;
    pub(crate) fn red_cuda_event_record(event: *mut Event, stream: *mut Stream) -> Status;
    pub(crate) fn red_cuda_event_query(event: *mut Event) -> Status;
    pub(crate) fn red_cuda_event_elapsed(from: *mut Event, to: *mut Event, milliseconds: *mut f32) -> Status;

    pub(crate) fn red_cuda_module_load(
        image: *const c_void,
        words: *mut c_char,
        size: usize,
        module: *mut *mut Module,
    ) -> Status;
    pub(crate) fn red_cuda_module_unload(module: *mut Module) -> Status;
    pub(crate) fn red_cuda_module_function(
        module: *mut Module,
        name: *const c_char,
        function: *mut *mut Function,
    ) -> Status;
    pub(crate) fn red_cuda_launch(
        function: *mut Function,
        grid: *const u32,
        block: *const u32,
        stream: *mut Stream,
        arguments: *mut *mut c_void,
    ) -> Status;
    pub(crate) fn red_cuda_graph_instantiate(graph: *mut Graph, executable: *mut *mut GraphExec) -> Status;
    pub(crate) fn red_cuda_graph_launch(executable: *mut GraphExec, stream: *mut Stream) -> Status;
    pub(crate) fn red_cuda_graph_exec_destroy(executable: *mut GraphExec) -> Status;
    pub(crate) fn red_cuda_graph_destroy(graph: *mut Graph) -> Status;

    pub(crate) fn red_cuda_memory_info(free: *mut usize, total: *mut usize) -> Status;
    pub(crate) fn red_cuda_memory_allocate(bytes: usize, address: *mut u64) -> Status;
    pub(crate) fn red_cuda_memory_free(address: u64) -> Status;
    pub(crate) fn red_cuda_memory_set(address: u64, value: u8, bytes: usize, stream: *mut Stream) -> Status;
    pub(crate) fn red_cuda_host_allocate(bytes: usize, address: *mut *mut c_void) -> Status;
    pub(crate) fn red_cuda_host_free(address: *mut c_void) -> Status;
    pub(crate) fn red_cuda_copy_to_device(
        to: u64,
        from: *const c_void,
        bytes: usize,
        stream: *mut Stream,
    ) -> Status;
    pub(crate) fn red_cuda_copy_to_host(
        to: *mut c_void,
        from: u64,
        bytes: usize,
        stream: *mut Stream,
    ) -> Status;
}
