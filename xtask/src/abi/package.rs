//! The files by which build systems find the libraries. They name everything relative to themselves, so that what was
//! installed can be moved.

use super::layer::{Layer, VERSION};

const CONFIG: &str = include_str!("../../../ffi/package/redConfig.cmake.in");
const CONFIG_VERSION: &str = include_str!("../../../ffi/package/redConfigVersion.cmake.in");
const PKG_CONFIG: &str = include_str!("../../../ffi/package/library.pc.in");

/// The files of CMake, by their names; `besides` is what a program links that has the whole library in it.
pub(crate) fn cmake(besides: &[String]) -> [(&'static str, String); 2] {
    let libraries: Vec<_> = besides.iter().map(|library| library.trim_start_matches("-l")).collect();
    let series = format!("{}.{}", env!("CARGO_PKG_VERSION_MAJOR"), env!("CARGO_PKG_VERSION_MINOR"));
    let filled = |text: &str| {
        fill(
            text,
            &[
                ("VERSION", VERSION),
                ("MAJOR", env!("CARGO_PKG_VERSION_MAJOR")),
                ("SERIES", &series),
                ("BESIDES", &libraries.join(";")),
                // Of the machine that this was compiled for, and so the libraries.
                ("POINTER", &size_of::<usize>().to_string()),
            ],
        )
    };
    [("redConfig.cmake", filled(CONFIG)), ("redConfigVersion.cmake", filled(CONFIG_VERSION))]
}

/// The file of pkg-config for a library, and its name.
pub(crate) fn pkg_config(layer: Layer, besides: &[String]) -> (String, String) {
    let (other, what) = match layer {
        Layer::Core => (Layer::All, "RED, scheduler for graphs of neural networks: the scheduler alone"),
        Layer::All => (Layer::Core, "RED, scheduler for graphs of neural networks"),
    };
    let values = [
        ("NAME", layer.library()),
        ("WHAT", what),
        ("VERSION", VERSION),
        ("OTHER", other.library()),
        ("PRIVATE", &besides.join(" ")),
    ];
    (format!("{}.pc", layer.library()), fill(PKG_CONFIG, &values))
}

/// A text with values in the place of their names.
fn fill(text: &str, values: &[(&str, &str)]) -> String {
    values.iter().fold(text.to_owned(), |text, (name, value)| text.replace(&format!("@{name}@"), value))
}

#[cfg(test)]
mod tests;
