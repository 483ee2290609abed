use std::env;
use std::fs::{self, File};
use std::path::PathBuf;
use std::process;
use std::thread;

use super::*;
use crate::onnx::on_lane;

fn model(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../models").join(name).with_extension("onnx")
}

#[test]
fn ports_are_those_of_the_model() {
    let network = Rten.load(&model("whole")).expect("loads");
    assert_eq!(network.inputs(), [Port { name: "image".into(), shape: vec![1, 3, 96, 160] }]);
    let names: Vec<_> = network.outputs().iter().map(|port| port.name.as_str()).collect();
    assert_eq!(names, ["lane", "segment", "detect", "control"]);
    assert_eq!(network.output_len(), (2 + 4) * 48 * 80 + 21 * 12 * 20 + 3);
}

#[test]
fn two_lanes_share_a_network() {
    let network = Rten.load(&model("control")).expect("loads");
    let run = || {
        on_lane(|| {
            let mut instance = network.instance().expect("an instance");
            let input = vec![0.5; network.input_len()];
            let mut output = vec![f32::NAN; network.output_len()];
            for _ in 0..10 {
                instance.run(&input, &mut output).expect("runs");
            }
            output
        })
        .expect("a thread")
    };
    let [one, other] = thread::scope(|scope| {
        [scope.spawn(run), scope.spawn(run)].map(|lane| lane.join().expect("a lane panicked"))
    });
    assert_eq!(one, other);
    assert!(one.iter().all(|value| value.abs() < 1.0), "{one:?}");
}

#[test]
fn a_run_outside_a_lane_or_with_wrong_buffers_is_refused() {
    let network = Rten.load(&model("control")).expect("loads");
    let mut instance = network.instance().expect("an instance");
    let input = vec![0.0; network.input_len()];
    assert!(matches!(instance.run(&input, &mut [0.0; 3]), Err(BodyError::NotOnLane)));
    assert!(matches!(
        instance.run(&input[1..], &mut [0.0; 3]),
        Err(BodyError::Buffer { buffer: "input", expected: 9600, found: 9599 })
    ));
    assert!(matches!(
        instance.run(&input, &mut [0.0; 4]),
        Err(BodyError::Buffer { buffer: "output", expected: 3, found: 4 })
    ));
    on_lane(|| instance.run(&input, &mut [0.0; 3])).expect("a thread").expect("runs");
    assert!(lane::pool().is_err(), "a lane leaves nothing behind on the thread that started it");
}

#[test]
fn a_file_that_is_no_model_is_refused() {
    assert!(matches!(Rten.load(&model("absent")), Err(BodyError::Read { .. })));

    let whole = fs::read(model("control")).expect("the models are committed");
    let path = env::temp_dir().join(format!("red-model-{}.onnx", process::id()));
    let load = |bytes: &[u8]| {
        fs::write(&path, bytes).expect("the temporary directory is writable");
        Rten.load(&path).map(|_| ())
    };
    for bytes in [&b""[..], b"not a model", &whole[..whole.len() / 2], &whole[..100]] {
        assert!(matches!(load(bytes), Err(BodyError::Model { .. })), "{} bytes", bytes.len());
    }
    // Zeros are no model, and of so many only the first is read.
    File::create(&path).and_then(|file| file.set_len(3 << 29)).expect("a sparse file");
    let error = Rten.load(&path).map(|_| ()).expect_err("no model").to_string();
    assert!(error.contains("not an ONNX file"), "{error}");
    File::create(&path).and_then(|file| file.set_len(1 << 40)).expect("a sparse file");
    assert!(matches!(Rten.load(&path), Err(BodyError::TooLarge { .. })));
    fs::remove_file(&path).expect("the file was there");
    assert!(matches!(Rten.load(Path::new("/dev/zero")), Err(BodyError::NotAFile { .. })));
}
