//! Debian's PREEMPT_RT kernel in an emulator, with `redrt` on it: what only a real-time kernel grants is granted and
//! used. No time that it measures is a result.

use std::fs;
use std::path::{Path, PathBuf};

use crate::cross;
use crate::depth::Depth;
use crate::process::Failure;
use crate::report::Tally;
use crate::tools;
use crate::workspace::Workspace;

const KERNELS: &str = "linux-image-rt-amd64";
/// The first process, linked with everything it needs.
const FIRST: &str = "red-rt-boot";
const FIRST_TARGET: &str = "x86_64-unknown-linux-gnu";
const PIPELINE: &str = "tests/rt-boot/pipeline.toml";
/// Three CPUs: one for each of two lanes, one for the rest.
const MACHINE: &[&str] = &[
    "-accel",
    "tcg",
    "-cpu",
    "max",
    "-smp",
    "3",
    "-m",
    "1024",
    "-display",
    "none",
    "-monitor",
    "none",
    "-serial",
    "stdio",
    "-no-reboot",
];
const LANES: [u32; 2] = [1, 2];
/// How often a lane has to be seen while it runs, so that its page faults say something.
const LOOKS: u64 = 5;
const COMMAND_LINE: &str = "console=ttyS0 quiet panic=-1";
/// Takes all rights from `redrt`: a boot that has to fail.
const PLANTED: &str = "red.plant=user";

/// What has to be on the console: a line with each of these words, after `RT `.
const EXPECTED: &[(&str, &[&str])] = &[
    ("the kernel is PREEMPT_RT", &["realtime 1"]),
    ("the watchdog is above the lanes", &["fifo red-watchdog priority 71 "]),
    ("the pipeline ran in real time", &["run {", "\"realtime\":true"]),
    ("it counted no page fault and no allocation", &["run {", "\"page_faults\":0,", "\"allocations\":0,"]),
    ("it ended well", &["run ended with exit status: 0"]),
    ("doctor sees the kernel", &["doctor PASS kernel.preempt_rt"]),
    ("doctor sees the right to a priority", &["doctor PASS rights.rtprio"]),
    ("doctor sees the right to lock memory", &["doctor PASS rights.memlock"]),
    ("doctor finds nothing that forbids real time", &["doctor ", " 0 fail"]),
];

/// The step: a boot where everything is as it should be, and one without rights, where it must not be.
pub(crate) fn step(workspace: &Workspace, _: Depth) -> Result<Tally, Failure> {
    if std::env::consts::ARCH != "x86_64" {
        return Err(Failure::Wrong(
            "this step starts an x86-64 kernel with the redrt of this machine".into(),
        ));
    }
    let folder = workspace.target.join("preempt-rt");
    let kernel = kernel(workspace, &folder)?;
    let image = image(workspace, &folder)?;
    let boot = |more: &str| {
        let qemu = cross::tool(workspace, "qemu-system-x86_64", &["qemu-system-x86"])?;
        let files = qemu.args(MACHINE).args(&["-kernel"]).args(&[&kernel]).args(&["-initrd"]).args(&[&image]);
        files.args(&["-append", &format!("{COMMAND_LINE} {more}")]).capture()
    };
    let console = boot("")?;
    console.lines().filter(|line| line.starts_with("RT ")).for_each(|line| say!("{line}"));
    let wrong = missing(&console);
    if !wrong.is_empty() {
        return Err(Failure::Wrong(format!(
            "on the real-time kernel it is not so that: {}",
            wrong.join("; ")
        )));
    }
    let planted = missing(&boot(PLANTED)?);
    say!("without rights, to be found: {}", planted.join("; "));
    if let Some(cpu) = LANES.into_iter().find(|cpu| !planted.contains(&no_lane(*cpu))) {
        return Err(Failure::Wrong(format!("without rights it still looks as if {}", no_lane(cpu))));
    }
    Ok(Tally { passed: 2, ..Tally::default() })
}

fn no_lane(cpu: u32) -> String {
    format!("a lane is SCHED_FIFO and alone on CPU {cpu}")
}

/// What is not so, by the console of a boot.
fn missing(console: &str) -> Vec<String> {
    let said: Vec<&str> = console.lines().filter_map(|line| line.trim_end().strip_prefix("RT ")).collect();
    let has = |words: &[&str]| said.iter().any(|line| words.iter().all(|word| line.contains(word)));
    let unmet = EXPECTED.iter().filter(|(_, words)| !has(words)).map(|(what, _)| (*what).to_owned());
    let number = |line: &str, key: &str| -> Option<u64> {
        let digits = line.split_once(key)?.1;
        digits.split(|c: char| !c.is_ascii_digit()).next()?.parse().ok()
    };
    let fifo = || said.iter().filter(|line| line.starts_with("fifo "));
    let is_lane = |line: &str, cpu: u32| {
        line.contains(&format!(" priority 70 cpus {cpu} "))
            && number(line, " looks ").is_some_and(|looks| looks >= LOOKS)
    };
    let lanes = LANES.into_iter().filter(|cpu| !fifo().any(|line| is_lane(line, *cpu))).map(no_lane);
    let faults = fifo().filter(|line| number(line, " faults ") != Some(0));
    let faults = faults.map(|line| format!("a real-time thread has no page faults ({line})"));
    let numbers = [("memory is locked", "locked "), ("jobs completed", "\"completed\":")];
    let none = numbers
        .into_iter()
        .filter(|(_, key)| !said.iter().any(|line| number(line, key).is_some_and(|number| number > 0)));
    unmet.chain(lanes).chain(faults).chain(none.map(|(what, _)| what.to_owned())).collect()
}

/// The newest real-time kernel of Debian, downloaded if it is not there.
fn kernel(workspace: &Workspace, folder: &Path) -> Result<PathBuf, Failure> {
    let newest = format!("apt-cache depends {KERNELS} | sed -n 's/^ *Depends: //p' | head -n 1");
    let shell = |line: &str| workspace.command("sh").args(&["-ec", line]);
    let mut name = shell(&newest).output()?;
    if name.is_empty() {
        tools::debian(workspace, "the list of Debian's packages", &[])?;
        name = shell(&newest).output()?;
    }
    if name.is_empty() {
        let why = format!("the lists of this Debian have no {KERNELS}, whose kernel this step starts");
        return Err(Failure::Wrong(why));
    }
    let place = folder.join(&name);
    let kernel = place.join("vmlinuz");
    if !kernel.exists() {
        make(&place)?;
        let get = format!(
            "cd '{}'; apt-get download '{name}'; dpkg-deb --fsys-tarfile *.deb | tar -x --wildcards './boot/vmlinuz*'; \
             rm ./*.deb; mv boot/vmlinuz* vmlinuz",
            place.display()
        );
        shell(&get).stream()?;
    }
    Ok(kernel)
}

/// The first file system: the first process, `redrt` as the tests built it, what it links, and a workload.
fn image(workspace: &Workspace, folder: &Path) -> Result<PathBuf, Failure> {
    let first = ["build", "--release", "--package", FIRST, "--target", FIRST_TARGET];
    // Static, because there is nothing yet when it starts.
    let flags = ("CARGO_TARGET_X86_64_UNKNOWN_LINUX_GNU_RUSTFLAGS", "-C target-feature=+crt-static");
    workspace.cargo(&first).env(flags.0, flags.1).stream()?;
    workspace.cargo(&["build", "--profile", "test", "--package", "redrt", "--bin", "redrt"]).stream()?;

    let (root, image) = (folder.join("root"), folder.join("image"));
    // What an earlier build left would only be in the way.
    let _gone = fs::remove_dir_all(&root);
    let redrt = workspace.target.join("debug/redrt");
    let linked = workspace.command("ldd").args(&[&redrt]).output()?;
    let libraries = linked.split_whitespace().filter(|word| word.starts_with('/')).map(PathBuf::from);
    let mut files: Vec<(PathBuf, PathBuf)> = libraries.map(|path| (path.clone(), path)).collect();
    files.push((workspace.target.join(FIRST_TARGET).join("release").join(FIRST), "/init".into()));
    files.push((redrt, "/bin/redrt".into()));
    files.push((workspace.root.join(PIPELINE), "/pipeline.toml".into()));
    for (from, to) in &files {
        let to = root.join(to.strip_prefix("/").unwrap_or(to));
        to.parent().map_or(Ok(()), make)?;
        fs::copy(from, &to).map_err(Failure::of_file(from))?;
    }
    tools::present(workspace, "strip", &["binutils"])?;
    // Names for debuggers would be most of the image.
    workspace.command("strip").args(&[root.join("init"), root.join("bin/redrt")]).stream()?;
    let _there = cross::tool(workspace, "cpio", &["cpio"])?;
    let pack = format!("cd '{}'; find . | cpio -o -H newc --quiet > '{}'", root.display(), image.display());
    workspace.command("sh").args(&["-ec", &pack]).stream()?;
    Ok(image)
}

fn make(folder: &Path) -> Result<(), Failure> {
    fs::create_dir_all(folder).map_err(Failure::of_file(folder))
}

#[cfg(test)]
mod tests;
