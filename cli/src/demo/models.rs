//! The demo's networks travel inside the program and are unpacked beside what the demo writes.

use crate::outcome::Failure;
use red_workload::shown_path;
use std::fs;
use std::path::Path;

const MODELS: [(&str, &[u8]); 5] = [
    ("encoder.onnx", include_bytes!("../../../models/encoder.onnx")),
    ("lane.onnx", include_bytes!("../../../models/lane.onnx")),
    ("segment.onnx", include_bytes!("../../../models/segment.onnx")),
    ("detect.onnx", include_bytes!("../../../models/detect.onnx")),
    ("control.onnx", include_bytes!("../../../models/control.onnx")),
];

/// Makes the folder, and writes the networks into it.
pub(crate) fn unpack(folder: &Path) -> Result<(), Failure> {
    let write = || {
        fs::create_dir_all(folder)?;
        MODELS.iter().try_for_each(|(name, bytes)| fs::write(folder.join(name), bytes))
    };
    write().map_err(|e| {
        Failure::Machine(format!(
            "cannot unpack the networks into `{}`: {e}; choose another folder with --out",
            shown_path(folder)
        ))
    })
}
