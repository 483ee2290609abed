//! Time, heap calls and page faults of each network on one lane:
//! `taskset -c 1 cargo run --release -p red-bodies --example measure -- models 200`
//!
//! With the feature `ort`, a third argument names a `libonnxruntime.so` to measure instead.

use std::alloc::{GlobalAlloc, Layout, System};
use std::env;
use std::error::Error;
use std::mem;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use red_bodies::onnx::{Engine, Inference, Rten, on_lane};
use red_bodies::scene::Scene;
use red_bodies::{Body, BodyError, Call};

static CALLS: AtomicUsize = AtomicUsize::new(0);
static BYTES: AtomicUsize = AtomicUsize::new(0);

/// The system's allocator, counted.
struct Counting;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

// SAFETY: every call goes to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        CALLS.fetch_add(1, Ordering::Relaxed);
        BYTES.fetch_add(layout.size(), Ordering::Relaxed);
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps the contract of `dealloc`.
        unsafe { System.dealloc(pointer, layout) };
    }
}

/// Page faults of this thread that needed no disk.
fn faults() -> i64 {
    // SAFETY: all bits zero is a valid rusage.
    let mut usage: libc::rusage = unsafe { mem::zeroed() };
    // SAFETY: `usage` is a live rusage.
    unsafe { libc::getrusage(libc::RUSAGE_THREAD, &raw mut usage) };
    usage.ru_minflt
}

fn measure(engine: &dyn Engine, model: &Path, runs: usize) -> Result<(), BodyError> {
    let network = engine.load(model)?;
    let mut body = Inference::new(&*network)?;
    let scene = Scene::new(160, 96);
    if body.input_mut().len() == scene.len() {
        scene.draw(0, true, body.input_mut())?;
    }
    let mut times = vec![0.0; runs];
    let call = Call::default();
    for _ in 0..20 {
        body.run(&call)?;
    }
    let (calls, bytes) = (CALLS.load(Ordering::Relaxed), BYTES.load(Ordering::Relaxed));
    let faulted = faults();
    for time in &mut times {
        let start = Instant::now();
        body.run(&call)?;
        *time = start.elapsed().as_secs_f64() * 1e3;
    }
    let (calls, bytes) = (CALLS.load(Ordering::Relaxed) - calls, BYTES.load(Ordering::Relaxed) - bytes);
    let faulted = faults() - faulted;
    times.sort_by(f64::total_cmp);
    println!(
        "{:10} p50 {:.3} ms  p99 {:.3} ms  max {:.3} ms  heap calls {}  bytes {}  page faults {} in all",
        model.file_stem().unwrap_or_default().display(),
        times[runs / 2],
        times[runs * 99 / 100],
        times[runs - 1],
        calls / runs,
        bytes / runs,
        faulted,
    );
    Ok(())
}

#[cfg(feature = "ort")]
fn engine() -> Result<Box<dyn Engine>, BodyError> {
    match env::args().nth(3) {
        Some(library) => Ok(Box::new(red_bodies::onnx::Ort::new(Path::new(&library))?)),
        None => Ok(Box::new(Rten)),
    }
}

#[cfg(not(feature = "ort"))]
fn engine() -> Result<Box<dyn Engine>, BodyError> {
    Ok(Box::new(Rten))
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(env::args().nth(1).ok_or("usage: measure FOLDER RUNS")?);
    let runs = env::args().nth(2).ok_or("usage: measure FOLDER RUNS")?.parse()?;
    let engine = engine()?;
    on_lane(|| {
        ["encoder", "lane", "segment", "detect", "control", "whole"]
            .into_iter()
            .try_for_each(|name| measure(&*engine, &folder.join(name).with_extension("onnx"), runs))
    })??;
    Ok(())
}
