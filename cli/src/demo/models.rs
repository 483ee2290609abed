//! The demo's networks travel inside the program and are unpacked for the time of a run.

use crate::outcome::Failure;
use std::fs;
use std::path::{Path, PathBuf};

const MODELS: [(&str, &[u8]); 5] = [
    ("encoder.onnx", include_bytes!("../../../models/encoder.onnx")),
    ("lane.onnx", include_bytes!("../../../models/lane.onnx")),
    ("segment.onnx", include_bytes!("../../../models/segment.onnx")),
    ("detect.onnx", include_bytes!("../../../models/detect.onnx")),
    ("control.onnx", include_bytes!("../../../models/control.onnx")),
];

/// A folder with the networks; it goes with this value.
pub(crate) struct Models(PathBuf);

impl Models {
    /// Writes them into a folder of this process.
    pub(crate) fn unpack() -> Result<Self, Failure> {
        let folder = std::env::temp_dir().join(format!("redrt-demo-{}", std::process::id()));
        let models = Self(folder.clone());
        let write = || {
            fs::create_dir_all(&folder)?;
            MODELS.iter().try_for_each(|(name, bytes)| fs::write(folder.join(name), bytes))
        };
        write().map_err(|e| {
            Failure::Machine(format!(
                "cannot unpack the networks into {}: {e}; set TMPDIR to a folder that takes them",
                folder.display()
            ))
        })?;
        Ok(models)
    }

    pub(crate) fn folder(&self) -> &Path {
        &self.0
    }
}

impl Drop for Models {
    fn drop(&mut self) {
        // What cannot be removed stays in the folder for temporary files.
        let _removed = fs::remove_dir_all(&self.0);
    }
}
