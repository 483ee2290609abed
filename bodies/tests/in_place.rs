//! An inference takes CPU time of the thread that asked for it, and of no other thread of the process.
//! Alone in its file, because every other thread must be idle.

use std::collections::HashMap;
use std::fs;
use std::path::Path;

use red_bodies::onnx::{Engine, Inference, Rten, on_lane};
use red_bodies::{Body, Call};

/// CPU time in nanoseconds of each thread of the process.
fn cpu_times() -> HashMap<String, u64> {
    fs::read_dir("/proc/self/task")
        .expect("Linux has /proc/self/task")
        .map(|entry| {
            let path = entry.expect("a thread").path();
            let schedstat =
                fs::read_to_string(path.join("schedstat")).expect("the kernel has CONFIG_SCHED_INFO");
            let time = schedstat.split(' ').next().and_then(|time| time.parse().ok());
            (path.file_name().expect("a thread id").display().to_string(), time.expect("a time"))
        })
        .collect()
}

#[test]
fn inference_stays_on_the_calling_thread() {
    let model = Path::new(env!("CARGO_MANIFEST_DIR")).join("../models/encoder.onnx");
    let (thread, before, after) = on_lane(|| {
        let network = Rten.load(&model).expect("the model loads");
        let mut body = Inference::new(&*network).expect("an instance");
        body.run(&Call::default()).expect("runs");
        // Threads that the engine started while loading are asleep again once this thread has slept.
        std::thread::sleep(std::time::Duration::from_millis(50));
        let thread = fs::read_link("/proc/thread-self").expect("Linux has /proc/thread-self");
        let before = cpu_times();
        for _ in 0..20 {
            body.run(&Call::default()).expect("runs");
        }
        (thread.file_name().expect("a thread id").display().to_string(), before, cpu_times())
    })
    .expect("a thread");

    let spent = |id: &String| after[id] - before[id];
    let own = spent(&thread);
    let others: u64 = before.keys().filter(|&id| *id != thread).map(spent).sum();
    assert_eq!(before.len(), after.len(), "an inference started a thread");
    assert!(before.len() >= 2, "the harness's own thread is there");
    assert!(own > 10_000_000, "{own} ns on the lane");
    assert_eq!(others, 0, "CPU time on other threads while the lane spent {own} ns");
}
