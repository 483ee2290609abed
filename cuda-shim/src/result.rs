//! The calls of `red_cuda.h` as `Result`, over handles that only this file makes and ends.
//!
//! A handle is what the driver gave, not yet destroyed; that is what every SAFETY below rests on. The driver checks
//! contexts and answers an error, and its calls may come from any thread.
#![allow(unsafe_code, reason = "calls of C")]

use crate::error::CudaError;
use crate::sys::{self, Status};
use core::ffi::{CStr, c_char, c_void};
use core::mem::MaybeUninit;
use core::ptr::NonNull;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

pub(crate) mod memory;
pub(crate) mod nvml;

pub(crate) type Result<T> = core::result::Result<T, CudaError>;

/// Whether nothing is given back any more.
static LEFT: AtomicBool = AtomicBool::new(false);

/// Leaves all that there is to the driver until the process ends.
pub(crate) fn leave() {
    LEFT.store(true, Ordering::Relaxed);
}

pub(crate) fn is_left() -> bool {
    LEFT.load(Ordering::Relaxed)
}

/// A handle of the driver's, and the call that ends it. What that answers, such as that the context is spent, nobody can
/// do anything about.
macro_rules! handles {
    ($($name:ident $(ends by $end:ident)?;)*) => {$(
        #[derive(Debug)]
        pub(crate) struct $name(NonNull<sys::$name>);

        // SAFETY: the driver's handles belong to no thread.
        unsafe impl Send for $name {}
        // SAFETY: the driver's calls on one handle may come from several threads at once.
        unsafe impl Sync for $name {}

        $(impl Drop for $name {
            fn drop(&mut self) {
                if !is_left() {
                    // SAFETY: a live handle, which ends here.
                    let _unheard = unsafe { sys::$end(self.0.as_ptr()) };
                }
            }
        })?
    )*};
}

handles! {
    Stream ends by red_cuda_stream_destroy;
    Event ends by red_cuda_event_destroy;
    Module ends by red_cuda_module_unload;
    // Ends with its module.
    Function;
    Graph ends by red_cuda_graph_destroy;
    GraphExec ends by red_cuda_graph_exec_destroy;
}

fn done(call: &'static str, code: Status) -> Result<()> {
    if code == sys::OK { Ok(()) } else { Err(CudaError { call, code }) }
}

/// An output of a call that writes it on success.
fn made<T>(call: &'static str, make: impl FnOnce(*mut T) -> Status) -> Result<T> {
    let mut out = MaybeUninit::uninit();
    done(call, make(out.as_mut_ptr()))?;
    // SAFETY: outputs are written on success.
    Ok(unsafe { out.assume_init() })
}

/// A handle out of such an output; no driver answers success and none.
fn handle<T>(call: &'static str, make: impl FnOnce(*mut *mut T) -> Status) -> Result<NonNull<T>> {
    NonNull::new(made(call, make)?).ok_or(CudaError { call, code: sys::NO_HANDLE })
}

/// Text that a call writes into a buffer, with its NUL.
fn text(buffer: &[u8]) -> String {
    CStr::from_bytes_until_nul(buffer).map(|text| text.to_string_lossy().into_owned()).unwrap_or_default()
}

/// Why there is no driver: [`sys::NO_LIBRARY`] or that entry points are missing, and the words for it.
pub(crate) fn load() -> core::result::Result<(), (Status, String)> {
    let mut words = [0_u8; 1024];
    // SAFETY: the buffer is as long as said. Whoever may call this holds the lock of `Driver::load`.
    let status = unsafe { sys::red_cuda_load(words.as_mut_ptr().cast::<c_char>(), words.len()) };
    if status == sys::OK { Ok(()) } else { Err((status, text(&words))) }
}

pub(crate) fn init() -> Result<()> {
    // SAFETY: it takes nothing.
    done("cuInit", unsafe { sys::red_cuda_init() })
}

pub(crate) fn driver_version() -> Result<i32> {
    // SAFETY: the place is live.
    made("cuDriverGetVersion", |out| unsafe { sys::red_cuda_driver_version(out) })
}

/// The name of an error and what it means, where the driver knows it.
pub(crate) fn error_words(code: Status) -> (Option<&'static str>, Option<&'static str>) {
    let word = |call: unsafe extern "C" fn(Status, *mut *const c_char) -> Status| {
        // SAFETY: the place is live.
        let text = made("cuGetErrorName", |out| unsafe { call(code, out) }).ok();
        let text = text.filter(|text| !text.is_null())?;
        // SAFETY: the driver's texts are static.
        unsafe { CStr::from_ptr(text) }.to_str().ok()
    };
    (word(sys::red_cuda_error_name), word(sys::red_cuda_error_text))
}

pub(crate) fn device_count() -> Result<i32> {
    // SAFETY: the place is live.
    made("cuDeviceGetCount", |out| unsafe { sys::red_cuda_device_count(out) })
}

pub(crate) fn device_get(ordinal: i32) -> Result<i32> {
    // SAFETY: the place is live.
    made("cuDeviceGet", |out| unsafe { sys::red_cuda_device_get(ordinal, out) })
}

pub(crate) fn device_name(device: i32) -> Result<String> {
    let mut name = [0_u8; 256];
    let at = name.as_mut_ptr().cast::<c_char>();
    // SAFETY: the buffer is as long as said.
    done("cuDeviceGetName", unsafe { sys::red_cuda_device_name(device, at, name.len()) })?;
    Ok(text(&name))
}

pub(crate) fn device_bus_id(device: i32) -> Result<String> {
    let mut id = [0_u8; 32];
    let at = id.as_mut_ptr().cast::<c_char>();
    // SAFETY: the buffer is as long as said.
    done("cuDeviceGetPCIBusId", unsafe { sys::red_cuda_device_bus_id(device, at, id.len()) })?;
    Ok(text(&id))
}

pub(crate) fn device_attribute(device: i32, attribute: u32) -> Result<i32> {
    // SAFETY: the place is live.
    made("cuDeviceGetAttribute", |out| unsafe { sys::red_cuda_device_attribute(device, attribute, out) })
}

/// A device's primary context, retained.
#[derive(Debug)]
pub(crate) struct Context {
    handle: NonNull<sys::Context>,
    device: i32,
}

// SAFETY: the driver's handles belong to no thread.
unsafe impl Send for Context {}
// SAFETY: the driver's calls on one handle may come from several threads at once.
unsafe impl Sync for Context {}

impl Drop for Context {
    fn drop(&mut self) {
        if !is_left() {
            // SAFETY: retained once, and released here.
            let _unheard = unsafe { sys::red_cuda_context_release(self.device) };
        }
    }
}

pub(crate) fn context_retain(device: i32) -> Result<Context> {
    // SAFETY: the place is live.
    let retain = |out| unsafe { sys::red_cuda_context_retain(device, out) };
    handle("cuDevicePrimaryCtxRetain", retain).map(|handle| Context { handle, device })
}

pub(crate) fn context_enter(context: &Context) -> Result<()> {
    // SAFETY: a live handle.
    done("cuCtxSetCurrent", unsafe { sys::red_cuda_context_enter(context.handle.as_ptr()) })
}

pub(crate) fn context_synchronize() -> Result<()> {
    // SAFETY: it takes nothing.
    done("cuCtxSynchronize", unsafe { sys::red_cuda_context_synchronize() })
}

/// The least and the greatest priority of streams.
pub(crate) fn context_priorities() -> Result<(i32, i32)> {
    let mut greatest = 0;
    // SAFETY: both places are live.
    let least = |out| unsafe { sys::red_cuda_context_priorities(out, &raw mut greatest) };
    Ok((made("cuCtxGetStreamPriorityRange", least)?, greatest))
}

pub(crate) fn stream_create(priority: i32) -> Result<Stream> {
    // SAFETY: the place is live.
    let create = |out| unsafe { sys::red_cuda_stream_create(priority, out) };
    handle("cuStreamCreateWithPriority", create).map(Stream)
}

/// The stream as C has it, for callbacks that submit to it.
pub(crate) fn stream_as_ptr(stream: &Stream) -> *mut c_void {
    stream.0.as_ptr().cast()
}

pub(crate) fn stream_wait(stream: &Stream, event: &Event) -> Result<()> {
    // SAFETY: live handles.
    done("cuStreamWaitEvent", unsafe { sys::red_cuda_stream_wait(stream.0.as_ptr(), event.0.as_ptr()) })
}

/// What a stream calls when it comes to that.
pub trait Called: Send + Sync + 'static {
    /// On a thread of the driver's: it must not call CUDA, nor block. It sets a flag or rings a bell.
    fn called(&self);
}

extern "C" fn called<T: Called>(argument: *mut c_void) {
    // SAFETY: of the `into_raw` below, once.
    let called = unsafe { Arc::from_raw(argument.cast::<T>()) };
    // No panic leaves for the driver.
    let _said = catch_unwind(AssertUnwindSafe(|| called.called()));
}

/// Has it called once, whenever the driver's thread comes.
pub(crate) fn stream_call<T: Called>(stream: &Stream, argument: Arc<T>) -> Result<()> {
    let argument = Arc::into_raw(argument);
    let raw = argument.cast_mut().cast();
    // SAFETY: a live handle; the argument is one that `called` takes back.
    let code = unsafe { sys::red_cuda_stream_call(stream.0.as_ptr(), called::<T>, raw) };
    if code != sys::OK {
        // SAFETY: nobody calls it.
        drop(unsafe { Arc::from_raw(argument) });
    }
    done("cuLaunchHostFunc", code)
}

pub(crate) fn stream_begin_capture(stream: &Stream) -> Result<()> {
    // SAFETY: a live handle.
    done("cuStreamBeginCapture", unsafe { sys::red_cuda_stream_begin_capture(stream.0.as_ptr()) })
}

pub(crate) fn stream_end_capture(stream: &Stream) -> Result<Graph> {
    // SAFETY: a live handle and a live place.
    let end = |out| unsafe { sys::red_cuda_stream_end_capture(stream.0.as_ptr(), out) };
    handle("cuStreamEndCapture", end).map(Graph)
}

pub(crate) fn event_create(timed: bool) -> Result<Event> {
    // SAFETY: the place is live.
    let create = |out| unsafe { sys::red_cuda_event_create(i32::from(timed), out) };
    handle("cuEventCreate", create).map(Event)
}

pub(crate) fn event_record(event: &Event, stream: &Stream) -> Result<()> {
    // SAFETY: live handles.
    done("cuEventRecord", unsafe { sys::red_cuda_event_record(event.0.as_ptr(), stream.0.as_ptr()) })
}

/// Whether what the event recorded last is done.
pub(crate) fn event_query(event: &Event) -> Result<bool> {
    // SAFETY: a live handle.
    match unsafe { sys::red_cuda_event_query(event.0.as_ptr()) } {
        sys::NOT_READY => Ok(false),
        code => done("cuEventQuery", code).map(|()| true),
    }
}

pub(crate) fn event_elapsed(from: &Event, to: &Event) -> Result<f32> {
    // SAFETY: live handles and a live place.
    let elapsed = |out| unsafe { sys::red_cuda_event_elapsed(from.0.as_ptr(), to.0.as_ptr(), out) };
    made("cuEventElapsedTime", elapsed)
}

/// Loads an image; what the driver's assembler found wrong with it comes with the error. The image ends with a NUL.
pub(crate) fn module_load(image: &CStr) -> core::result::Result<Module, (CudaError, String)> {
    module_load_at(image.as_ptr().cast())
}

/// Loads a cubin, which says itself how long it is.
pub(crate) fn module_load_binary(image: &[u8]) -> core::result::Result<Module, (CudaError, String)> {
    module_load_at(image.as_ptr().cast())
}

fn module_load_at(image: *const c_void) -> core::result::Result<Module, (CudaError, String)> {
    let mut words = vec![0_u8; 4096];
    let at = words.as_mut_ptr().cast::<c_char>();
    let size = words.len();
    // SAFETY: the buffer is as long as said, the place is live, and the image is whole: text to its NUL, or an ELF file
    // whose tables lie within it.
    let load = |out| unsafe { sys::red_cuda_module_load(image, at, size, out) };
    handle("cuModuleLoadDataEx", load).map(Module).map_err(|error| (error, text(&words)))
}

pub(crate) fn module_function(module: &Module, name: &CStr) -> Result<Function> {
    // SAFETY: a live handle, text with its NUL, and a live place.
    let find = |out| unsafe { sys::red_cuda_module_function(module.0.as_ptr(), name.as_ptr(), out) };
    handle("cuModuleGetFunction", find).map(Function)
}

/// Parameters of a kernel that any device takes: 4 KiB of them, of one byte at least; CUDA 12.1 takes more on newer ones.
const MOST_PARAMETERS: usize = 4096;
const MOST_PARAMETER_BYTES: usize = 32_768;

/// Arguments of a kernel. The driver reads as many, and of each as much, as the kernel says that it has; whatever that
/// is, it reads what lies here: beyond the last argument there are zeros.
#[derive(Debug)]
pub(crate) struct Arguments {
    /// Eight bytes each.
    values: Box<[u64]>,
    places: Box<[*mut c_void]>,
}

// SAFETY: the pointers lead into the value itself.
unsafe impl Send for Arguments {}

impl Arguments {
    pub(crate) fn new(count: usize) -> Self {
        let mut values = vec![0; count + MOST_PARAMETER_BYTES / size_of::<u64>()].into_boxed_slice();
        let start = values.as_mut_ptr();
        let place = |at: usize| start.wrapping_add(at.min(count)).cast::<c_void>();
        let places = (0..MOST_PARAMETERS.max(count)).map(place).collect();
        Self { values, places }
    }

    /// The bits of one, of at most eight bytes; those of a shorter one come first.
    pub(crate) fn set(&mut self, at: usize, bits: u64) {
        self.values[at] = bits;
    }
}

pub(crate) fn launch(
    function: &Function,
    grid: [u32; 3],
    block: [u32; 3],
    stream: &Stream,
    arguments: &mut Arguments,
) -> Result<()> {
    let (grid, block) = (grid.as_ptr(), block.as_ptr());
    let (function, stream, arguments) =
        (function.0.as_ptr(), stream.0.as_ptr(), arguments.places.as_mut_ptr());
    // SAFETY: live handles, three extents each, and arguments as `Arguments` says.
    done("cuLaunchKernel", unsafe { sys::red_cuda_launch(function, grid, block, stream, arguments) })
}

pub(crate) fn graph_instantiate(graph: &Graph) -> Result<GraphExec> {
    // SAFETY: a live handle and a live place.
    let instantiate = |out| unsafe { sys::red_cuda_graph_instantiate(graph.0.as_ptr(), out) };
    handle("cuGraphInstantiate", instantiate).map(GraphExec)
}

pub(crate) fn graph_launch(executable: &GraphExec, stream: &Stream) -> Result<()> {
    let (executable, stream) = (executable.0.as_ptr(), stream.0.as_ptr());
    // SAFETY: live handles.
    done("cuGraphLaunch", unsafe { sys::red_cuda_graph_launch(executable, stream) })
}
