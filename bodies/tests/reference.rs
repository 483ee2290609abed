//! The committed models give the numbers that a second engine gave, in parts and as a whole.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

use red_bodies::BodyError;
use red_bodies::onnx::{Engine, Rten, on_lane};
use red_bodies::scene::Scene;
use serde_json::Value;

const HEADS: [&str; 4] = ["lane", "segment", "detect", "control"];

type Tensors = HashMap<String, Vec<f32>>;

fn models() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../models")
}

/// Runs one model, and names its outputs.
fn run(engine: &dyn Engine, model: &str, input: &[f32]) -> Result<Tensors, BodyError> {
    let network = engine.load(&models().join(model).with_extension("onnx"))?;
    let mut output = vec![f32::NAN; network.output_len()];
    network.instance()?.run(input, &mut output)?;
    let mut rest = &output[..];
    let split = |port: &red_bodies::onnx::Port| {
        let values;
        (values, rest) = rest.split_at(port.len());
        (port.name.clone(), values.to_vec())
    };
    Ok(network.outputs().iter().map(split).collect())
}

/// `found` is `expected` up to 1e-4 of the tensor's largest value.
fn assert_close(what: &str, found: &[f32], expected: &[f32]) {
    assert_eq!(found.len(), expected.len(), "{what}");
    let scale = expected.iter().fold(0.0_f32, |scale, value| scale.max(value.abs()));
    for (index, (found, expected)) in found.iter().zip(expected).enumerate() {
        assert!((found - expected).abs() <= 1e-4 * scale, "{what}[{index}]: {found}, not {expected}");
    }
}

fn numbers(value: &Value) -> Vec<f32> {
    value
        .as_array()
        .expect("an array")
        .iter()
        .map(|number| number.as_f64().expect("a number") as f32)
        .collect()
}

fn hold_to_reference(engine: &dyn Engine) -> Result<(), BodyError> {
    let text =
        fs::read_to_string(models().join("reference.json")).expect("models/reference.json is committed");
    let reference: Value = serde_json::from_str(&text).expect("reference.py wrote JSON");
    let scene = Scene::new(160, 96);
    let mut image = vec![0.0; scene.len()];
    for frame in reference["frames"].as_array().expect("frames") {
        let file = frame["file"].as_str().expect("a file name");
        let index = frame["frame"].as_u64().expect("a frame index");
        scene.draw(index, frame["obstacle"].as_bool().expect("a flag"), &mut image)?;
        let bytes = fs::read(models().join(file)).expect("the frames are committed");
        let pixels: Vec<f32> = bytes.into_iter().map(|byte| f32::from(byte) / 255.0).collect();
        assert!(image == pixels, "{file} is not frame {index} of the scene: run the example `frames`");

        let mut parts = run(engine, "encoder", &image)?;
        for head in HEADS {
            let tensors = run(engine, head, &parts["feature"])?;
            parts.extend(tensors);
        }
        for (name, tensor) in &run(engine, "whole", &image)? {
            assert_close(&format!("{file}: {name} of the whole"), tensor, &parts[name]);
        }
        for (name, digest) in frame["tensors"].as_object().expect("tensors") {
            let tensor = &parts[name];
            let samples = numbers(&digest["samples"]);
            let step = (tensor.len() / 64).max(1);
            let found: Vec<f32> = tensor.iter().step_by(step).take(64).copied().collect();
            assert_close(&format!("{file}: {name}"), &found, &samples);
            let norm = tensor.iter().map(|&value| f64::from(value).powi(2)).sum::<f64>().sqrt();
            let expected = digest["norm"].as_f64().expect("a norm");
            assert!(
                (norm - expected).abs() <= 1e-4 * expected,
                "{file}: norm of {name}: {norm}, not {expected}"
            );
        }
    }
    Ok(())
}

#[test]
fn rten_agrees_with_the_second_engine() {
    on_lane(|| hold_to_reference(&Rten)).expect("a thread").expect("the models load and run");
}

#[cfg(feature = "ort")]
#[test]
fn ort_agrees_with_the_reference_and_so_with_rten() {
    let library = std::env::var_os("ORT_DYLIB_PATH").expect("set ORT_DYLIB_PATH to a libonnxruntime.so");
    let engine = red_bodies::onnx::Ort::new(Path::new(&library)).expect("onnxruntime loads");
    on_lane(|| hold_to_reference(&engine)).expect("a thread").expect("the models load and run");
}
