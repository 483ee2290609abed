//! Builds the stand-in driver, and one that lacks entry points.

use std::path::{Path, PathBuf};
use std::{env, fs};

/// The prototypes are those that the shim calls by, so a stand-in with others does not compile.
const PROTOTYPES: &str = "../../cuda-shim/src";
const SOURCES: [&str; 3] = ["driver/calls.c", "driver/script.c", "driver/streams.c"];

fn main() {
    println!("cargo::rerun-if-changed=driver");
    println!("cargo::rerun-if-changed={PROTOTYPES}/driver_api.h");
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo gives it"));
    build(&out, &[]);
    build(&out.join("lacking"), &["-DLACKING"]);
}

fn build(folder: &Path, more: &[&str]) {
    fs::create_dir_all(folder).expect("a folder in the folder for what is built");
    let compiler = cc::Build::new().get_compiler();
    let mut command = compiler.to_command();
    command.args(["-std=c11", "-Wall", "-Wextra", "-Werror", "-O1", "-g", "-shared", "-fPIC", "-pthread"]);
    command.args(["-Wl,-soname,libcuda.so.1", "-I", PROTOTYPES]).args(more).args(SOURCES);
    let status = command.arg("-o").arg(folder.join("libcuda.so.1")).status();
    let status = status.expect("no C compiler; install it with: apt-get install gcc libc6-dev");
    assert!(status.success(), "the stand-in does not compile: {status}");
}
