//! C functions of a shared object as bodies. `include/red_plugin.h` is the contract; this file keeps its Rust side.

mod elf;

use std::ffi::{c_int, c_void};
use std::fs;
use std::mem;
use std::path::{Path, PathBuf};
use std::ptr;
use std::sync::{Arc, Mutex, PoisonError};

use libloading::Library;

use crate::{Body, BodyError, Call, body_file};

/// Version of the interface: `RED_PLUGIN_ABI`.
pub const ABI: u32 = 1;

/// Size of the largest shared object, in bytes. Before it is loaded, only its tables are read.
const MAX_BYTES: u64 = 1 << 30;

/// `red_plugin_context`.
#[repr(C)]
struct Context {
    size: u32,
    abi: u32,
    now_ns: u64,
    release_ns: u64,
    deadline_ns: u64,
    job: u64,
    task: u32,
    lane: u32,
    host: *mut c_void,
    release: unsafe extern "C" fn(host: *mut c_void, task: u32) -> c_int,
    stream: *mut c_void,
}

type Step = unsafe extern "C" fn(user: *mut c_void, context: *const Context) -> c_int;
type Open = unsafe extern "C" fn(lane: u32, user: *mut *mut c_void) -> c_int;
type Close = unsafe extern "C" fn(user: *mut c_void);

/// What plugins may ask of the runtime.
pub struct Host {
    release: Box<dyn Fn(u32) -> bool + Send + Sync>,
}

impl Host {
    /// A host that releases a job of the given task with `release`, which answers whether the release was taken.
    ///
    /// `release` is called from any thread, lanes included: it must not wait, allocate or panic, and must answer
    /// `false` once the run is over.
    pub fn new(release: impl Fn(u32) -> bool + Send + Sync + 'static) -> Arc<Self> {
        Arc::new(Self { release: Box::new(release) })
    }
}

/// Hosts that plugins may use for good, where a leak checker finds them.
static HOSTS: Mutex<Vec<&'static Arc<Host>>> = Mutex::new(Vec::new());

/// The `release` of every context.
unsafe extern "C" fn release(host: *mut c_void, task: u32) -> c_int {
    // SAFETY: the contract has the plugin pass the context's `host`, which `Plugin::load` keeps alive for good.
    let host = unsafe { &*host.cast::<Host>() };
    if (host.release)(task) { 0 } else { -1 }
}

/// A step function of a loaded shared object, shared by the lanes.
pub struct Plugin {
    path: PathBuf,
    symbol: String,
    step: Step,
    open: Option<Open>,
    close: Option<Close>,
    host: &'static Host,
}

impl Plugin {
    /// Loads the shared object at `path` and looks up `symbol` in it, and `symbol`'s `_open` and `_close`. Not for
    /// real time.
    ///
    /// The shared object and `host` stay in memory until the process ends: a plugin may have threads of its own.
    ///
    /// # Errors
    /// There is no such file, it is not a regular one of at most 1 GiB, it is not whole or does not load, or it has no
    /// such function.
    pub fn load(path: &Path, symbol: &str, host: &Arc<Host>) -> Result<Self, BodyError> {
        // A full path, because the dynamic linker looks for a bare name elsewhere.
        let full = fs::canonicalize(path).map_err(|reason| BodyError::Read { path: path.into(), reason })?;
        let refused = |reason| BodyError::Plugin { path: path.into(), reason };
        let (mut file, size) = body_file::open(&full, MAX_BYTES)?;
        elf::check(&mut file, size).map_err(|reason| refused(reason.to_owned()))?;
        // SAFETY: loading runs the object's initialisers. Whoever wrote the workload file chose this code.
        let library = unsafe { Library::new(&full) }.map_err(|error| {
            // The linker begins with the path, which the message has already.
            let (reason, full) = (error.to_string(), format!("{}: ", full.display()));
            refused(reason.strip_prefix(&full).unwrap_or(&reason).to_owned())
        })?;
        // SAFETY: `red_plugin.h` gives a function of this name this type.
        let step = unsafe { library.get::<Step>(symbol) }.map(|step| *step);
        // SAFETY: as above.
        let open = unsafe { library.get::<Open>(format!("{symbol}_open")) }.map(|open| *open).ok();
        // SAFETY: as above.
        let close = unsafe { library.get::<Close>(format!("{symbol}_close")) }.map(|close| *close).ok();
        let step = step.map_err(|_| BodyError::Symbol { path: path.into(), symbol: symbol.into() })?;
        mem::forget(library);
        let host: &'static Arc<Host> = Box::leak(Box::new(Arc::clone(host)));
        HOSTS.lock().unwrap_or_else(PoisonError::into_inner).push(host);
        Ok(Self { path: path.into(), symbol: symbol.into(), step, open, close, host })
    }

    /// Makes what `lane` runs. Not for real time: calls the plugin's `_open`.
    ///
    /// # Errors
    /// `_open` refused.
    pub fn instance(&self, lane: u32) -> Result<PluginBody, BodyError> {
        let mut user = ptr::null_mut();
        if let Some(open) = self.open {
            // SAFETY: the object is never unloaded, and `user` is a live pointer to write to.
            let code = unsafe { open(lane, &raw mut user) };
            if code != 0 {
                let symbol = format!("{}_open", self.symbol);
                return Err(BodyError::Open { path: self.path.clone(), symbol, code });
            }
        }
        Ok(PluginBody { step: self.step, close: self.close, user, host: self.host })
    }
}

/// A plugin's step as one lane runs it.
pub struct PluginBody {
    step: Step,
    close: Option<Close>,
    user: *mut c_void,
    host: &'static Host,
}

// SAFETY: `user` is the plugin's own; the contract says that its calls never overlap, not that one thread makes them.
unsafe impl Send for PluginBody {}

impl Body for PluginBody {
    fn run(&mut self, call: &Call) -> Result<(), BodyError> {
        self.step(call, ptr::null_mut())
    }
}

impl PluginBody {
    /// As [`Body::run`], and the step submits its work to a CUDA stream, as C has it.
    ///
    /// # Errors
    /// As there.
    pub fn submit(&mut self, call: &Call, stream: *mut c_void) -> Result<(), BodyError> {
        self.step(call, stream)
    }

    fn step(&mut self, call: &Call, stream: *mut c_void) -> Result<(), BodyError> {
        let context = Context {
            size: size_of::<Context>() as u32,
            abi: ABI,
            now_ns: call.now_ns,
            release_ns: call.release_ns,
            deadline_ns: call.deadline_ns,
            job: call.job,
            task: call.task,
            lane: call.lane,
            host: ptr::from_ref(self.host).cast_mut().cast(),
            release,
            stream,
        };
        // SAFETY: the object is never unloaded, `user` is what it gave to this lane, and the context is whole.
        let code = unsafe { (self.step)(self.user, &raw const context) };
        if code == 0 { Ok(()) } else { Err(BodyError::Returned { code }) }
    }
}

impl Drop for PluginBody {
    fn drop(&mut self) {
        if let Some(close) = self.close {
            // SAFETY: the object is never unloaded, and no step follows.
            unsafe { close(self.user) };
        }
    }
}

#[cfg(test)]
mod tests;
