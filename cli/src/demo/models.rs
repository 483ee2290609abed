//! The demo's networks travel inside the program and are unpacked beside what the demo writes.

use crate::outcome::Failure;
use crate::place::{Folder, Place};
use std::io::Write;

const MODELS: [(&str, &[u8]); 5] = [
    ("encoder.onnx", include_bytes!("../../../models/encoder.onnx")),
    ("lane.onnx", include_bytes!("../../../models/lane.onnx")),
    ("segment.onnx", include_bytes!("../../../models/segment.onnx")),
    ("detect.onnx", include_bytes!("../../../models/detect.onnx")),
    ("control.onnx", include_bytes!("../../../models/control.onnx")),
];

/// The networks that a folder still lacks, and their places there.
pub(crate) struct Networks(Vec<(Place, &'static [u8])>);

impl Networks {
    /// Finds the places.
    ///
    /// # Errors
    /// As for [`Folder::add`].
    pub(crate) fn of(folder: &mut Folder) -> Result<Self, Failure> {
        let mut places = Vec::new();
        for (name, bytes) in MODELS {
            places.extend(folder.add_constant("network", name, bytes)?.map(|place| (place, bytes)));
        }
        Ok(Self(places))
    }

    /// Writes them there.
    ///
    /// # Errors
    /// [`Failure::Machine`]: one cannot be written.
    pub(crate) fn unpack(&self) -> Result<(), Failure> {
        self.0.iter().try_for_each(|(place, bytes)| place.write(|file| file.write_all(bytes)))
    }
}
