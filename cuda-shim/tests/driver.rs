//! The shim over a driver that is not there, one that will not do, and the stand-in.

use red_cuda::{Arguments, Called, CudaError, Device, Driver, Kind, LoadError, ModuleError};
use red_cuda_stand_in::{DRIVER, LACKING, with, with_driver};
use std::ffi::CString;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::thread;
use std::time::Duration;

const PTX: &[u8] =
    b".version 6.0\n.target sm_53\n.visible .entry step(.param .u32 n) { ret; }\n.entry next() { ret; }\n";

fn device() -> Device {
    let driver = Driver::load().expect("the stand-in");
    Device::open(driver, 0).expect("one device")
}

fn kernel(device: &Device, name: &str) -> red_cuda::Kernel {
    let name = CString::new(name).expect("no NUL in it");
    device.module(PTX).expect("PTX").kernel(&name, [4, 1, 1], [32, 1, 1]).expect("it is there")
}

fn wait(is_done: impl Fn() -> Result<bool, CudaError>) {
    while !is_done().expect("a sound context") {
        thread::sleep(Duration::from_micros(50));
    }
}

/// Where a line of the log is.
fn at(log: &[String], line: &str) -> usize {
    log.iter().position(|l| l == line).unwrap_or_else(|| panic!("no `{line}` in {log:#?}"))
}

#[test]
fn without_a_driver_it_is_said_and_how_to_get_one() {
    // A folder without a driver first in the search path changes nothing where none is anywhere else.
    let Err(error) = Driver::load() else {
        println!("this machine has a driver");
        return;
    };
    assert!(matches!(error, LoadError::NoLibrary(_) | LoadError::Failed(_)), "{error:?}");
    assert!(error.to_string().contains("CUDA driver"), "{error}");
}

#[test]
fn a_driver_that_lacks_entry_points_is_refused_with_their_names() {
    with_driver(Path::new(LACKING), "", || {
        let Err(LoadError::NoEntry(names)) = Driver::load() else { panic!("it lacks some") };
        assert_eq!(names, "cuStreamWaitEvent, cuGraphLaunch, cuGraphInstantiate");
    });
}

#[test]
fn a_driver_that_is_too_old_is_refused_with_its_version() {
    with("version 10010", || {
        let error = Driver::load().expect_err("too old");
        assert_eq!(error, LoadError::TooOld(10_010));
        assert!(error.to_string().contains("CUDA 10.1"), "{error}");
    });
}

#[test]
fn a_driver_without_a_device_is_refused_with_what_to_look_at() {
    with("devices 0", || {
        let error = Driver::load().expect_err("no device");
        assert!(matches!(&error, LoadError::Failed(e) if e.kind() == Kind::Lost), "{error:?}");
        assert!(error.to_string().contains("nvidia-smi"), "{error}");
    });
}

#[test]
fn a_stream_keeps_its_order_and_another_waits_by_an_event() {
    let log = with("takes step 2000", || {
        let device = device();
        let [first, second] = [-1, 0].map(|priority| device.stream(priority).expect("a stream"));
        let (step, next) = (kernel(&device, "step"), kernel(&device, "next"));
        let [stepped, done] = [(); 2].map(|()| device.event().expect("an event"));
        assert!(stepped.is_done().expect("sound"), "what was never recorded is done");
        let mut arguments = Arguments::new(1);
        arguments.set(0, 7);
        first.launch(&step, &mut arguments).expect("sound");
        first.record(&stepped).expect("sound");
        second.wait_for(&stepped).expect("sound");
        second.launch(&next, &mut Arguments::new(0)).expect("sound");
        second.record(&done).expect("sound");
        assert!(!done.is_done().expect("sound"), "the call waited");
        wait(|| done.is_done());
        assert!(stepped.is_done().expect("sound"));
    });
    let Some(log) = log else { return };
    assert!(at(&log, "end 1 step") < at(&log, "begin 2 next"), "{log:#?}");
    assert!(log.contains(&"call cuStreamWaitEvent 2 event1 = 0".to_owned()), "{log:#?}");
    // Whoever keeps a context alive lets go of it.
    assert!(log.contains(&"call cuDevicePrimaryCtxRelease_v2 = 0".to_owned()), "{log:#?}");
}

#[test]
fn memory_goes_to_the_device_and_back_in_order() {
    with("memory 4096", || {
        let device = device();
        let stream = device.stream(0).expect("a stream");
        let mut here = device.pinned(64).expect("room");
        let there = device.buffer(64).expect("room");
        let mut back = device.pinned(64).expect("room");
        here.bytes_mut().copy_from_slice(&[7; 64]);
        stream.upload(&here, &there).expect("sound");
        stream.download(&there, &mut back).expect("sound");
        stream.clear(&there).expect("sound");
        device.synchronize().expect("sound");
        assert_eq!(back.bytes(), [7; 64]);
        assert_eq!(device.memory().expect("sound"), (4096 - 64, 4096));
        let refused = device.buffer(4096).expect_err("more than there is");
        assert_eq!(refused.kind(), Kind::OutOfMemory);
        assert_eq!(refused.to_string(), "cuMemAlloc: CUDA_ERROR_OUT_OF_MEMORY (2): as the script says");
        assert_eq!((device.highest_bytes(), device.late()), (64, 0));
        device.seal();
        drop(there);
        drop(device.buffer(4096).expect("after some was given back"));
        assert_eq!((device.highest_bytes(), device.late()), (4096, 1));
    });
}

#[test]
fn a_graph_runs_what_was_captured() {
    let log = with("", || {
        let device = device();
        let stream = device.stream(0).expect("a stream");
        let step = kernel(&device, "step");
        let graph = stream
            .capture(|stream| {
                stream.launch(&step, &mut Arguments::new(1))?;
                stream.launch(&step, &mut Arguments::new(1))
            })
            .expect("both can be captured");
        device.synchronize().expect("sound");
        let nothing = stream.capture(|_| Err(device.buffer(usize::MAX).map(drop).expect_err("too much")));
        assert_eq!(nothing.expect_err("what submits refused").kind(), Kind::OutOfMemory);
        stream.launch_graph(&graph).expect("sound");
        device.synchronize().expect("sound");
    });
    let Some(log) = log else { return };
    let launched = at(&log, "call cuGraphLaunch 1 = 0");
    let begins: Vec<usize> = (0..log.len()).filter(|line| log[*line] == "begin 1 step").collect();
    assert!(begins.len() == 2 && begins[0] > launched, "{log:#?}");
}

#[test]
fn an_error_of_a_kernel_is_sticky_and_so_said() {
    with("fault step 2 700", || {
        let device = device();
        let stream = device.stream(0).expect("a stream");
        let step = kernel(&device, "step");
        let done = device.event().expect("an event");
        for _ in 0..2 {
            stream.launch(&step, &mut Arguments::new(1)).expect("both are submitted before the second runs");
        }
        stream.record(&done).expect("sound still, or not");
        let error = loop {
            if let Err(error) = done.is_done() {
                break error;
            }
        };
        assert!(error.is_sticky() && error.kind() == Kind::Poisoned, "{error}");
        assert_eq!(device.event().expect_err("spent").code(), 700);
        assert_eq!(device.memory().expect_err("spent").call(), "cuMemGetInfo");
    });
}

#[derive(Default)]
struct Counter(AtomicU32);

impl Called for Counter {
    fn called(&self) {
        self.0.fetch_add(1, Ordering::Relaxed);
        // The driver does not see it.
        panic!("planted");
    }
}

#[test]
fn a_stream_calls_back_in_its_order() {
    let log = with("takes step 1000", || {
        let device = device();
        let stream = device.stream(0).expect("a stream");
        stream.launch(&kernel(&device, "step"), &mut Arguments::new(1)).expect("sound");
        let counter = Arc::new(Counter::default());
        stream.call(counter.clone()).expect("sound");
        assert_eq!(counter.0.load(Ordering::Relaxed), 0, "the stream has not come to it");
        device.synchronize().expect("sound");
        assert_eq!((counter.0.load(Ordering::Relaxed), Arc::strong_count(&counter)), (1, 1));
    });
    assert!(log.is_none_or(|log| log.contains(&"call cuLaunchHostFunc 1 = 0".to_owned())));
}

#[test]
fn what_is_no_module_is_refused_before_the_driver_sees_it() {
    let whole = elf(&[(64, 16)]);
    with("", move || {
        let device = device();
        let format = |image: &[u8]| matches!(device.module(image), Err(ModuleError::Format(_)));
        for image in [&b""[..], b"abc", b".version\0 6.0", b"\x7fELF\x02\x01 and no more"] {
            assert!(format(image), "{image:?}");
        }
        // The driver follows the tables, so they have to be whole.
        assert!(!format(&whole) && format(&elf(&[(64, 1 << 40)])) && format(&elf(&[(u64::MAX, 1)])));
        for end in 6..whole.len() {
            assert!(format(&whole[..end]), "cut at {end}");
        }
        let error =
            device.module(b"// .versio\n.version").expect("to the stand-in").kernel(c"gone", [1; 3], [1; 3]);
        assert_eq!(error.expect_err("no such kernel").code(), 500);
    });
    assert!(Path::new(DRIVER).join("libcuda.so.1").is_file());
}

/// An ELF file of sections at these places with these sizes.
fn elf(sections: &[(u64, u64)]) -> Vec<u8> {
    let mut file = vec![0_u8; 80 + 64 * sections.len()];
    file[..6].copy_from_slice(b"\x7fELF\x02\x01");
    file[40..48].copy_from_slice(&80_u64.to_le_bytes());
    file[58..60].copy_from_slice(&64_u16.to_le_bytes());
    file[60..62].copy_from_slice(&(sections.len() as u16).to_le_bytes());
    for ((at, bytes), header) in sections.iter().zip(file[80..].chunks_mut(64)) {
        header[4] = 1;
        header[24..32].copy_from_slice(&at.to_le_bytes());
        header[32..40].copy_from_slice(&bytes.to_le_bytes());
    }
    file
}
