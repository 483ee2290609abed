//! Every test there is, as a list: quick things first.

use std::path::Path;

use crate::aarch64;
use crate::abi;
use crate::abi_traces;
use crate::clients;
use crate::cortex_m;
use crate::cross::{self, CORTEX_M0, CORTEX_M4};
use crate::cuda;
use crate::depth::Depth;
use crate::faults;
use crate::fuzz;
use crate::lock_files;
use crate::loom;
use crate::miri;
use crate::paper;
use crate::preempt_rt;
use crate::process::{Failure, Run};
use crate::report::Tally;
use crate::sanitizers;
use crate::symbols;
use crate::tools;
use crate::traces;
use crate::workspace::Workspace;

/// One thing to check.
#[derive(Clone, Copy)]
pub(crate) struct Step {
    pub(crate) name: &'static str,
    pub(crate) what: &'static str,
    pub(crate) run: fn(&Workspace, Depth) -> Result<Tally, Failure>,
}

const STEPS: &[Step] = &[
    Step { name: "fmt", what: "the sources are formatted", run: fmt },
    Step {
        name: "target",
        what: "core, synchronizers and adapter build for microcontrollers, with and without defmt",
        run: target,
    },
    Step { name: "clippy", what: "no lint speaks, all targets and features", run: clippy },
    Step { name: "test", what: "unit, behaviour and documentation tests", run: test },
    Step { name: "doc", what: "the documentation builds without a warning", run: doc },
    Step { name: "faults", what: "each row of the fault table has its test, and passes", run: fault_table },
    Step {
        name: "symbols",
        what: "no call of the release reaches a panic or an allocation",
        run: symbols::check,
    },
    Step {
        name: "abi",
        what: "the C ABI as it ships: header, libraries, packages, and the README's programs",
        run: abi::step,
    },
    Step {
        name: "clients",
        what: "programs in C and C++ with that library: tests, under sanitizers and valgrind too, and examples",
        run: clients::step,
    },
    Step {
        name: "soak",
        what: "random workloads, edits and faults on real threads, about half a minute, in real time where granted",
        run: half_a_minute,
    },
    Step { name: "models", what: "the networks are what their generator makes", run: models },
    Step { name: "onnx", what: "a second inference engine agrees on the networks", run: onnx },
    Step {
        name: "cuda",
        what: "prototypes against NVIDIA's header, kernels against its assembler for five architectures",
        run: cuda::step,
    },
    Step {
        name: "paper",
        what: "the paper's tables and the scoreboard are what is printed, and promises kept",
        run: paper_tables,
    },
    Step { name: "examples", what: "every example runs", run: examples },
    Step {
        name: "deny",
        what: "licences, sources, duplicates and lock files of the dependencies",
        run: deny,
    },
    Step { name: "fuzz", what: "random inputs for the readers and the calls", run: fuzz::step },
    Step {
        name: "miri",
        what: "unit tests of core, synchronizers and C ABI in an interpreter",
        run: miri::step,
    },
    Step {
        name: "sanitizers",
        what: "races of lanes under stress, and what unsafe code does to memory",
        run: sanitizers::step,
    },
    Step {
        name: "loom",
        what: "models of the concurrency, every interleaving within bounds",
        run: loom::step,
    },
    Step {
        name: "aarch64",
        what: "the tests of core, simulator and C ABI on AArch64, emulated",
        run: aarch64::step,
    },
    Step {
        name: "abi-traces",
        what: "an executor in C++ over the C ABI does what the core does, byte for byte",
        run: abi_traces::step,
    },
    Step { name: "traces", what: "the same actions on every target, byte for byte", run: traces::step },
    Step { name: "cortex-m", what: "a firmware with embassy on an emulated Cortex-M4", run: cortex_m::step },
    Step { name: "preempt-rt", what: "redrt on an emulated real-time kernel", run: preempt_rt::step },
];

/// What the examples are given, by their file; `{target}` is the folder for everything built.
const EXAMPLES: &[(&str, &[&str])] =
    &[("bodies/examples/frames.rs", &["{target}"]), ("bodies/examples/measure.rs", &["models", "3"])];

/// What `test` takes.
pub(crate) fn help() -> String {
    let list: String = STEPS.iter().map(|step| format!("\n  {:<10} {}", step.name, step.what)).collect();
    format!(
        "usage: cargo xtask test [--deep] [STEP]...\n\nAll steps, in this order, or only those that are named; \
         --deep: without the bounds that\nkeep them short.\n{list}"
    )
}

/// The steps of these names in the order of the list; all of them when no name is given.
///
/// # Errors
/// A name that is not in the list.
pub(crate) fn choose(names: &[&str]) -> Result<Vec<Step>, String> {
    let list = STEPS.iter().map(|step| step.name).collect::<Vec<_>>().join(", ");
    if let Some(unknown) = names.iter().find(|name| STEPS.iter().all(|step| step.name != **name)) {
        return Err(format!("no step {unknown:?}; there are {list}"));
    }
    let chosen = |step: &&Step| names.is_empty() || names.contains(&step.name);
    Ok(STEPS.iter().filter(chosen).copied().collect())
}

fn fmt(workspace: &Workspace, _: Depth) -> Result<Tally, Failure> {
    workspace.cargo(&["fmt", "--all", "--", "--check"]).stream()?;
    workspace.cargo(&["fmt", "--manifest-path", "fuzz/Cargo.toml", "--", "--check"]).stream()
}

fn target(workspace: &Workspace, _: Depth) -> Result<Tally, Failure> {
    for target in [CORTEX_M0, CORTEX_M4] {
        cross::library(workspace, target)?;
        let build = ["build", "--package", "red-embassy", "--target", target];
        workspace.cargo(&build).stream()?;
        workspace.cargo(&build).args(&["--features", "defmt"]).stream()?;
    }
    Ok(Tally::default())
}

fn clippy(workspace: &Workspace, _: Depth) -> Result<Tally, Failure> {
    let all = ["clippy", "--workspace", "--all-targets", "--all-features", "--", "--deny", "warnings"];
    workspace.cargo(&all).stream()
}

fn test(workspace: &Workspace, _: Depth) -> Result<Tally, Failure> {
    // The rows of the fault table are a step of their own.
    workspace.cargo(&["test", "--workspace", "--no-fail-fast", "--", "--skip", "::row_"]).stream()
}

/// As the tests built it, with their checks and with the features of the whole workspace: of its own features alone most of
/// what it needs would be built again.
pub(crate) fn soak(workspace: &Workspace, arguments: &[&str]) -> Result<Run, Failure> {
    let build = ["build", "--quiet", "--profile", "test", "--workspace", "--bin", "red-soak"];
    workspace.cargo(&build).stream()?;
    Ok(workspace.command(workspace.target.join("debug/red-soak")).args(arguments))
}

fn fault_table(workspace: &Workspace, _: Depth) -> Result<Tally, Failure> {
    faults::run(workspace)
}

fn half_a_minute(workspace: &Workspace, _: Depth) -> Result<Tally, Failure> {
    // Real time where it is granted; where it is not, the soak says so and what is missing. By their number, and not by
    // time, there are workloads enough to judge by on a slow machine too.
    soak(workspace, &["--workloads", "36", "--length-ms", "500", "--best-effort"])?.stream()
}

fn doc(workspace: &Workspace, _: Depth) -> Result<Tally, Failure> {
    workspace.cargo(&["doc", "--workspace", "--no-deps"]).env("RUSTDOCFLAGS", "--deny warnings").stream()
}

fn models(workspace: &Workspace, _: Depth) -> Result<Tally, Failure> {
    tools::python(workspace)?.generate(&["--check"])
}

fn onnx(workspace: &Workspace, _: Depth) -> Result<Tally, Failure> {
    let library = tools::python(workspace)?.onnxruntime()?;
    let test = ["test", "--package", "red-bodies", "--features", "ort", "--no-fail-fast"];
    workspace.cargo(&test).env("ORT_DYLIB_PATH", library).stream()
}

fn paper_tables(workspace: &Workspace, _: Depth) -> Result<Tally, Failure> {
    paper::run(workspace, true)
}

fn examples(workspace: &Workspace, _: Depth) -> Result<Tally, Failure> {
    let target = workspace.target.display().to_string();
    for file in workspace.examples()? {
        let known = EXAMPLES.iter().find(|(name, _)| file == Path::new(name));
        let (_, arguments) = known.ok_or_else(|| {
            Failure::Wrong(format!("{} is not run: give its arguments in xtask's EXAMPLES", file.display()))
        })?;
        let arguments: Vec<_> =
            arguments.iter().map(|argument| argument.replace("{target}", &target)).collect();
        let package = file.ancestors().nth(2).unwrap_or(&file).join("Cargo.toml");
        let name = file.file_stem().unwrap_or_default();
        // The profile of the tests, which is built already.
        let run =
            workspace.cargo(&["run", "--quiet", "--profile", "test", "--manifest-path"]).args(&[&package]);
        run.args(&["--example"]).args(&[name]).args(&["--"]).args(&arguments).stream()?;
    }
    Ok(Tally::default())
}

fn deny(workspace: &Workspace, _: Depth) -> Result<Tally, Failure> {
    lock_files::check(workspace)?;
    tools::cargo_deny(workspace)?.args(&["check", "bans", "licenses", "sources"]).stream()
}
