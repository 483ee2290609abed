//! Random workloads through the C ABI, by an executor in C++, and what the core's own calls make of them: the same text,
//! byte for byte.

use std::fs;
use std::path::{Path, PathBuf};

use crate::depth::Depth;
use crate::process::Failure;
use crate::report::Tally;
use crate::tools;
use crate::traces::{self, first_difference};
use crate::workspace::Workspace;

const PROGRAM: &str = "red-abi-traces";
/// How many workloads, if nobody says; and how many where it takes longer or a mistake is to be found.
const QUICK: u32 = 1_000;
const DEEP: u32 = 20_000;
const FEW: u32 = 100;

/// How the executor is compiled, and what it is told.
struct Build {
    compiler: &'static str,
    package: &'static str,
    flags: &'static [&'static str],
    /// It runs few workloads.
    is_slow: bool,
}

const BUILDS: [Build; 3] = [
    Build { compiler: "g++", package: "g++", flags: &["-O2"], is_slow: false },
    Build { compiler: "clang++", package: "clang", flags: &["-O2"], is_slow: false },
    Build {
        compiler: "g++",
        package: "g++",
        flags: &["-O1", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"],
        is_slow: true,
    },
];

/// Executors with a mistake, which has to be found.
const MISTAKES: [&str; 2] = ["last-lane-first", "drop-release"];

const STRICT: [&str; 6] = ["-std=c++17", "-Wall", "-Wextra", "-Werror", "-pedantic", "-Iffi/include"];

/// The step: as many workloads as the depth says.
pub(crate) fn step(workspace: &Workspace, depth: Depth) -> Result<Tally, Failure> {
    compare(workspace, if depth == Depth::Deep { DEEP } else { QUICK })
}

/// What `cargo xtask abi-traces` was asked for.
pub(crate) fn count(words: &[&str]) -> Option<u32> {
    if words.is_empty() { Some(QUICK) } else { traces::count(words) }
}

/// Runs `count` workloads both ways, by executors of two compilers and under sanitizers, and compares what they write;
/// then mistakes of an executor have to be found.
///
/// # Errors
/// A program cannot be built or run, or writes something else.
pub(crate) fn compare(workspace: &Workspace, count: u32) -> Result<Tally, Failure> {
    let mut tally = Tally::default();
    let core = Core::build(workspace)?;
    let all = core.write(count)?;
    let few = core.write(FEW)?;
    say!(
        "the core itself: {count} workloads, {} lines, {} bytes",
        all.trace.split(|byte| *byte == b'\n').count() - 1,
        all.trace.len()
    );
    let library = library(workspace)?;
    let mut executor = None;
    for build in &BUILDS {
        let program = build.executor(workspace, &library)?;
        let (given, name) = (if build.is_slow { &few } else { &all }, build.name());
        if let Some(difference) = given.differs(workspace, &program, &[])? {
            return Err(Failure::Wrong(format!("the C ABI, by {name}, does something else:\n{difference}")));
        }
        say!("the C ABI, by {name}: the same for {} workloads", given.count);
        tally.passed += 1;
        executor.get_or_insert(program);
    }
    for mistake in MISTAKES {
        let found =
            executor.as_ref().map_or(Ok(None), |program| few.differs(workspace, program, &[mistake]))?;
        let found =
            found.ok_or_else(|| Failure::Wrong(format!("an executor's mistake, {mistake}, is not found")))?;
        say!("an executor with a mistake, {mistake}:\n{found}");
        tally.passed += 1;
    }
    Ok(tally)
}

/// The static library of the C ABI, as it ships.
fn library(workspace: &Workspace) -> Result<PathBuf, Failure> {
    let build =
        ["rustc", "--quiet", "--package", "red-ffi", "--no-default-features", "--profile", "release-ffi"];
    workspace.cargo(&build).args(&["--crate-type", "staticlib"]).stream()?;
    Ok(workspace.target.join("release-ffi/libred_ffi.a"))
}

/// The program that draws workloads and runs them on the core.
struct Core<'a> {
    workspace: &'a Workspace,
    program: PathBuf,
}

/// Workloads in a file, and the trace that an executor of them has to write.
struct Given {
    count: u32,
    file: PathBuf,
    trace: Vec<u8>,
}

impl<'a> Core<'a> {
    fn build(workspace: &'a Workspace) -> Result<Self, Failure> {
        workspace.cargo(&["build", "--quiet", "--release", "--package", PROGRAM]).stream()?;
        Ok(Self { workspace, program: workspace.target.join("release").join(PROGRAM) })
    }

    fn write(&self, count: u32) -> Result<Given, Failure> {
        let run =
            |what: &str| self.workspace.command(&self.program).args(&[what, &count.to_string()]).bytes();
        let (text, trace) = (run("workloads")?, run("traces")?);
        let folder = folder(self.workspace)?;
        let file = folder.join(format!("{count}.txt"));
        fs::write(&file, text).map_err(Failure::of_file(&file))?;
        Ok(Given { count, file, trace })
    }
}

impl Build {
    fn name(&self) -> String {
        [&[self.compiler], self.flags].concat().join(" ")
    }

    fn executor(&self, workspace: &Workspace, library: &Path) -> Result<PathBuf, Failure> {
        tools::present(workspace, self.compiler, &[self.package])?;
        let program =
            folder(workspace)?.join(format!("{}{}", self.compiler, if self.is_slow { "-slow" } else { "" }));
        let run = workspace.command(self.compiler).args(&STRICT).args(self.flags);
        let run = run.args(&["ffi/tests/trace/main.cpp"]).args(&[library]).args(&["-o"]).args(&[&program]);
        run.stream()?;
        Ok(program)
    }
}

impl Given {
    /// Where the executor's trace is another one.
    fn differs(
        &self,
        workspace: &Workspace,
        program: &Path,
        mistake: &[&str],
    ) -> Result<Option<String>, Failure> {
        let written = workspace.command(program).args(&[&self.file]).args(mistake).bytes()?;
        if written == self.trace {
            return Ok(None);
        }
        let [ours, theirs] = [&self.trace, &written].map(|trace| String::from_utf8_lossy(trace));
        let shown = first_difference(&ours, &theirs);
        Ok(Some(shown.unwrap_or_else(|| "the same lines, with other ends".to_owned())))
    }
}

/// Where workloads and executors lie.
fn folder(workspace: &Workspace) -> Result<PathBuf, Failure> {
    let folder = workspace.target.join("abi-traces");
    fs::create_dir_all(&folder).map_err(Failure::of_file(&folder))?;
    Ok(folder)
}
