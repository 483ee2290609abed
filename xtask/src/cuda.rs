//! CUDA without a device: our prototypes against NVIDIA's header, and our kernels against its assembler. Both come as
//! packages of Python's, for this alone; nothing that is built needs them.

use std::fs;
use std::path::{Path, PathBuf};

use crate::depth::Depth;
use crate::process::{Failure, Run};
use crate::report::Tally;
use crate::tools;
use crate::workspace::{Workspace, entries};

/// Compute capabilities: Nano, TX2, Xavier, Orin, and a server's.
const ARCHITECTURES: [&str; 5] = ["sm_53", "sm_62", "sm_72", "sm_87", "sm_90"];
/// Folders with kernels.
const KERNELS: [&str; 3] = ["bodies/kernels", "examples/kernels", "tests/gpu/kernels"];
const REQUIREMENTS: &str = "cuda-shim/tests/requirements.txt";
const PROTOTYPES: &str = "cuda-shim/src/driver_api.h";
const CHECK: &str = "cuda-shim/tests/against_cuda_h.c";

/// # Errors
/// A prototype differs, a kernel does not assemble, or a planted mistake is not seen.
pub(crate) fn step(workspace: &Workspace, _: Depth) -> Result<Tally, Failure> {
    let packages = tools::python(workspace)?.packages(Path::new(REQUIREMENTS), "cuda")?;
    let mut tally = Tally::default();
    let compile = |source: &Path| {
        let include = packages.join("nvidia/cuda_runtime/include");
        let cc =
            workspace.command("cc").args(&["-std=gnu11", "-Wall", "-Wextra", "-Werror", "-fsyntax-only"]);
        cc.args(&["-I"]).args(&[include]).args(&[source])
    };
    tally.passed += well(compile(Path::new(CHECK)))?;
    let api = read(&workspace.root.join(PROTOTYPES))?;
    let check = read(&workspace.root.join(CHECK))?;
    let folder = workspace.target.join("tmp/against-cuda-h");
    for (is, planted) in
        [("unsigned char value", "unsigned value"), ("cuEventDestroy_v2", "cuEventDestroy_v9")]
    {
        let wrong = api.replacen(is, planted, 1);
        let beside = check.replacen("../src/driver_api.h", "driver_api.h", 1);
        if wrong == api || beside == check {
            return Err(Failure::Wrong(format!(
                "{PROTOTYPES} has no `{is}`, so nothing can be planted there"
            )));
        }
        write(&folder.join("driver_api.h"), &wrong)?;
        write(&folder.join("check.c"), &beside)?;
        tally.passed += found(compile(&folder.join("check.c")), planted)?;
    }
    let ptxas = |architecture: &str, kernel: &Path| {
        let assembler = workspace.command(packages.join("nvidia/cuda_nvcc/bin/ptxas"));
        let options = ["--warning-as-error", "--gpu-name", architecture, "--output-file", "/dev/null"];
        assembler.args(&options).args(&[kernel])
    };
    for kernel in kernels(workspace)? {
        for architecture in ARCHITECTURES {
            tally.passed += well(ptxas(architecture, &kernel))?;
        }
    }
    let planted = folder.join("planted.ptx");
    let text = read(&workspace.root.join(KERNELS[0]).join("spin.ptx"))?;
    write(&planted, &text.replacen("sub.u64", "sub.f16", 1))?;
    tally.passed += found(ptxas(ARCHITECTURES[0], &planted), "sub.f16")?;
    Ok(tally)
}

/// What only a device can show, on the one of this machine: the program is built and takes this one's place.
pub(crate) fn on_device(workspace: &Workspace, arguments: &[&str]) -> Failure {
    let build = ["build", "--release", "--package", "redrt", "--package", "red-gpu-tests"];
    if let Err(failure) = workspace.cargo(&build).stream() {
        return failure;
    }
    workspace.command(workspace.target.join("release/red-gpu-tests")).args(arguments).replace()
}

fn kernels(workspace: &Workspace) -> Result<Vec<PathBuf>, Failure> {
    let mut found = Vec::new();
    for folder in KERNELS {
        let files = entries(&workspace.root.join(folder))?;
        let before = found.len();
        found.extend(files.into_iter().filter(|file| file.extension().is_some_and(|kind| kind == "ptx")));
        if found.len() == before {
            return Err(Failure::Wrong(format!("no kernel in {folder}")));
        }
    }
    found.sort();
    Ok(found)
}

fn well(run: Run) -> Result<u32, Failure> {
    run.text().map(|_| 1)
}

/// That it fails, as it should.
fn found(run: Run, planted: &str) -> Result<u32, Failure> {
    match run.all_text()? {
        (_, true) => {
            Err(Failure::Wrong(format!("the planted `{planted}` is not found, so this check finds nothing")))
        }
        (_, false) => {
            say!("planted `{planted}`: found, as it should be");
            Ok(1)
        }
    }
}

fn read(path: &Path) -> Result<String, Failure> {
    fs::read_to_string(path).map_err(Failure::of_file(path))
}

fn write(path: &Path, text: &str) -> Result<(), Failure> {
    let folder = path.parent().unwrap_or(path);
    fs::create_dir_all(folder).map_err(Failure::of_file(folder))?;
    fs::write(path, text).map_err(Failure::of_file(path))
}
