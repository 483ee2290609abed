//! Compiles the C library. No CUDA header and no CUDA library takes part.

fn main() {
    for file in
        ["include/red_cuda.h", "include/red_nvml.h", "src/driver_api.h", "src/red_cuda.c", "src/red_nvml.c"]
    {
        println!("cargo::rerun-if-changed={file}");
    }
    let mut build = cc::Build::new();
    build
        .files(["src/red_cuda.c", "src/red_nvml.c"])
        .include("include")
        .std("c11")
        .warnings(true)
        .extra_warnings(true);
    // In a shared library of somebody's it is nobody else's.
    build.flag("-fvisibility=hidden");
    build.compile("red_cuda");
    // Part of libc.so.6 since glibc 2.34; a JetPack 4 root has it apart.
    println!("cargo::rustc-link-lib=dl");
}
