//! The first process on a booted kernel: it mounts what programs expect, runs `redrt`, prints what the kernel says of
//! the threads meanwhile, and switches the machine off. Every line for the host begins with `RT `; the host judges.
//!
//! With `red.plant=user` on the kernel's command line, `redrt` runs as a user without rights.

mod threads;

use std::fs;
use std::io;
use std::os::unix::process::CommandExt;
use std::process::{Command, Output, Stdio};
use std::thread;
use std::time::Duration;

use nix::mount::{MsFlags, mount};
use nix::sys::reboot::{RebootMode, reboot};
use nix::sys::termios::tcdrain;

use threads::Watch;

const REDRT: &str = "/bin/redrt";
const RUN: [&str; 5] = ["run", "/pipeline.toml", "--duration", "2s", "--json"];
/// Only settings: what an emulated machine measures says nothing.
const DOCTOR: [&str; 2] = ["doctor", "--quick"];
/// A user without any right.
const NOBODY: u32 = 65_534;
/// How often the kernel is asked.
const INTERVAL: Duration = Duration::from_millis(100);

fn main() {
    if let Err(reason) = examine() {
        println!("RT failed: {reason}");
    }
    // The serial line is slower than this program, and what it has not sent goes with the machine.
    let _sent = tcdrain(io::stdout());
    // The machine goes off; if it cannot, the host stops it.
    let _still_on = reboot(RebootMode::RB_POWER_OFF);
}

fn examine() -> io::Result<()> {
    for (kind, place) in [("proc", "/proc"), ("sysfs", "/sys"), ("devtmpfs", "/dev"), ("tmpfs", "/tmp")] {
        fs::create_dir_all(place)?;
        mount(Some(kind), place, Some(kind), MsFlags::empty(), None::<&str>)?;
    }
    println!("RT kernel {}", fs::read_to_string("/proc/version")?.trim());
    // Kernels without the patch lack the file.
    println!("RT realtime {}", fs::read_to_string("/sys/kernel/realtime").unwrap_or_default().trim());
    let is_planted = fs::read_to_string("/proc/cmdline")?.contains("red.plant=user");

    let mut child = command(&RUN, is_planted).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn()?;
    let mut watch = Watch::new(child.id());
    while child.try_wait()?.is_none() {
        watch.look();
        thread::sleep(INTERVAL);
    }
    print(&watch.lines());
    tell("run", &child.wait_with_output()?);
    tell("doctor", &command(&DOCTOR, is_planted).output()?);
    Ok(())
}

fn command(arguments: &[&str], is_planted: bool) -> Command {
    let mut command = Command::new(REDRT);
    command.args(arguments).stdin(Stdio::null());
    if is_planted {
        command.uid(NOBODY).gid(NOBODY);
    }
    command
}

fn tell(what: &str, output: &Output) {
    for text in [&output.stdout, &output.stderr] {
        let text = String::from_utf8_lossy(text);
        print(&text.lines().map(|line| format!("{what} {line}")).collect::<Vec<_>>());
    }
    println!("RT {what} ended with {}", output.status);
}

fn print(lines: &[String]) {
    for line in lines {
        println!("RT {line}");
    }
}
