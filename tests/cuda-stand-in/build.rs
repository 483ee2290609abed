//! Builds the stand-in driver, and one that lacks entry points.

use std::path::{Path, PathBuf};
use std::{env, fs};

/// The prototypes are those that the shim calls by, so a stand-in with others does not compile.
const PROTOTYPES: &str = "../../cuda-shim/src";
/// What each library is made of.
const LIBRARIES: [(&str, &[&str]); 2] = [
    ("libcuda.so.1", &["driver/calls.c", "driver/kernels.c", "driver/script.c", "driver/streams.c"]),
    ("libnvidia-ml.so.1", &["driver/nvml.c", "driver/script.c"]),
];

fn main() {
    println!("cargo::rerun-if-changed=driver");
    println!("cargo::rerun-if-changed={PROTOTYPES}/driver_api.h");
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo gives it"));
    build(&out, &[]);
    build(&out.join("lacking"), &["-DLACKING"]);
}

fn build(folder: &Path, more: &[&str]) {
    fs::create_dir_all(folder).expect("a folder in the folder for what is built");
    for (library, sources) in LIBRARIES {
        let mut command = cc::Build::new().get_compiler().to_command();
        command
            .args(["-std=c11", "-Wall", "-Wextra", "-Werror", "-O1", "-g", "-shared", "-fPIC", "-pthread"]);
        command.arg(format!("-Wl,-soname,{library}")).args(["-I", PROTOTYPES]).args(more).args(sources);
        let status = command.arg("-o").arg(folder.join(library)).arg("-lm").status();
        let status = status.expect("no C compiler; install it with: apt-get install gcc libc6-dev");
        assert!(status.success(), "the stand-in does not compile: {status}");
    }
}
