//! The C++ peers: helper programs that are compiled when the bench runs and sit behind a pipe. Per request a
//! helper times its own runs, so the pipe costs nothing that is counted.

use std::env;
use std::fs;
use std::io::{self, BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, Stdio};

use crate::measure::Runner;
use crate::not_run::NotRun;
use crate::peers::Setup;

/// A helper program and what it takes to build it.
struct Source {
    name: &'static str,
    text: &'static str,
    flags: &'static [&'static str],
    /// A header that the library brings, and what to say when the compiler does not find it.
    header: (&'static str, NotRun),
}

const COMMON: &str = include_str!("../../cpp/common.hpp");

/// oneTBB's flow graph, lightweight policy, on the CPU of lane 0.
pub(crate) fn tbb(setup: &Setup<'_>) -> Result<Runner, NotRun> {
    let source = Source {
        name: "tbb",
        text: include_str!("../../cpp/tbb.cpp"),
        flags: &["-ltbb"],
        header: ("oneapi/tbb/flow_graph.h", NotRun::Missing("libtbb-dev")),
    };
    source.start(setup, &setup.machine.lanes[..1])
}

/// Taskflow, whose workers are other threads than the one that releases, on all CPUs.
pub(crate) fn taskflow(setup: &Setup<'_>) -> Result<Runner, NotRun> {
    let cure = "Debian packages no Taskflow; set CPLUS_INCLUDE_PATH to a checkout of it";
    let source = Source {
        name: "taskflow",
        text: include_str!("../../cpp/taskflow.cpp"),
        flags: &[],
        header: ("taskflow/taskflow.hpp", NotRun::Unpackaged(cure)),
    };
    source.start(setup, &setup.machine.lanes)
}

impl Source {
    fn start(&self, setup: &Setup<'_>, cpus: &[usize]) -> Result<Runner, NotRun> {
        let mut helper = Helper::start(&self.compile()?, setup, cpus).map_err(|error| self.failed(error))?;
        let name = self.name;
        Ok(Box::new(move |runs, samples| {
            helper.take(runs, samples).map_err(|error| NotRun::Failed(format!("{name} helper: {error}")))
        }))
    }

    fn failed(&self, error: impl std::fmt::Display) -> NotRun {
        NotRun::Failed(format!("{} helper: {error}", self.name))
    }

    /// Compiles beside this executable, unless that was done from the same text before.
    fn compile(&self) -> Result<PathBuf, NotRun> {
        let own = env::current_exe().map_err(|error| self.failed(error))?;
        let folder = own.with_file_name("red-benches-cpp");
        let (source, program) = (folder.join(format!("{}.cpp", self.name)), folder.join(self.name));
        let header = folder.join("common.hpp");
        if program.exists() && holds(&source, self.text) && holds(&header, COMMON) {
            return Ok(program);
        }
        let written = fs::create_dir_all(&folder)
            .and_then(|()| remove(&program))
            .and_then(|()| fs::write(&header, COMMON))
            .and_then(|()| fs::write(&source, self.text));
        written.map_err(|error| self.failed(error))?;
        let output = Command::new("g++")
            .args(["-std=c++20", "-O3", "-DNDEBUG", "-pthread", "-o"])
            .args([&program, &source])
            .args(self.flags)
            .output();
        match output {
            Err(error) if error.kind() == io::ErrorKind::NotFound => Err(NotRun::Missing("g++")),
            Err(error) => Err(self.failed(error)),
            Ok(output) if output.status.success() => Ok(program),
            Ok(output) => {
                let (header, cure) = &self.header;
                let said = String::from_utf8_lossy(&output.stderr);
                let absent = said.contains(&format!("{header}: No such file"));
                Err(if absent {
                    cure.clone()
                } else {
                    self.failed(said.lines().next().unwrap_or("g++ failed"))
                })
            }
        }
    }
}

fn holds(path: &Path, text: &str) -> bool {
    fs::read(path).is_ok_and(|found| found == text.as_bytes())
}

fn remove(path: &Path) -> io::Result<()> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

/// A running helper. It ends when its standard input closes, and by itself when a request takes too long.
struct Helper {
    child: Child,
    answers: BufReader<ChildStdout>,
}

impl Helper {
    /// Starts the program and tells it lanes, body, CPUs and edges.
    fn start(program: &Path, setup: &Setup<'_>, cpus: &[usize]) -> io::Result<Self> {
        let mut child = Command::new(program).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn()?;
        let answers = child.stdout.take().map(BufReader::new).ok_or(io::ErrorKind::BrokenPipe)?;
        let mut helper = Self { child, answers };
        let graph = setup.graph;
        let edges: usize = graph.successors.iter().map(Vec::len).sum();
        let mut text = format!("{} {} {edges} {}\n", setup.lanes, setup.body.steps, graph.nodes());
        for (from, list) in graph.successors.iter().enumerate() {
            for to in list {
                text.push_str(&format!("{from} {to}\n"));
            }
        }
        text.push_str(&cpus.len().to_string());
        for cpu in cpus {
            text.push_str(&format!(" {cpu}"));
        }
        text.push('\n');
        helper.send(&text)?;
        Ok(helper)
    }

    fn send(&mut self, text: &str) -> io::Result<()> {
        let input = self.child.stdin.as_mut().ok_or(io::ErrorKind::BrokenPipe)?;
        input.write_all(text.as_bytes())?;
        input.flush()
    }

    /// One request: `runs` runs per sample. The answer is one line of nanoseconds.
    fn take(&mut self, runs: usize, samples: &mut [u64]) -> io::Result<()> {
        self.send(&format!("{runs} {}\n", samples.len()))?;
        let mut line = String::new();
        self.answers.read_line(&mut line)?;
        let mut figures = line.split_ascii_whitespace().map(str::parse);
        for sample in samples {
            let figure = figures.next().ok_or(io::ErrorKind::UnexpectedEof)?;
            *sample = figure.map_err(io::Error::other)?;
        }
        Ok(())
    }
}

impl Drop for Helper {
    fn drop(&mut self) {
        drop(self.child.stdin.take());
        // Nothing to do about a helper that cannot be waited for.
        let _ = self.child.wait();
    }
}
