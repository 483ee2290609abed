//! Rights that a test needs, or takes away.

use crate::process::command;
use red_rt::placement::usable_cpus;
use red_rt::setup::Fifo;
use std::process::Command;
use std::{fs, thread};

/// Limits of `prlimit` under which no thread gets a real-time priority.
pub(crate) const NO_PRIORITY: [&str; 2] = ["--rtprio=0:0", "--nice=0:0"];

/// The row cannot be tried on this machine: it fails, and the table says that it was not run, and why.
pub(crate) fn not_run(why: &str) -> ! {
    panic!("not run: {why}");
}

/// Ends the test where the machine grants no real-time priority.
pub(crate) fn need_real_time() {
    let cpu = *usable_cpus().expect("an affinity mask").last().expect("at least one CPU");
    let granted = thread::spawn(move || Fifo { priority: 1, cpu }.apply()).join().expect("no panic");
    if granted.is_err() {
        not_run("needs CAP_SYS_NICE, as root has it");
    }
}

pub(crate) fn is_root() -> bool {
    let status = fs::read_to_string("/proc/self/status").expect("Linux has it");
    status
        .lines()
        .any(|line| line.strip_prefix("Uid:").is_some_and(|ids| ids.split_whitespace().nth(1) == Some("0")))
}

/// Ends the test where it is not run by root.
pub(crate) fn need_root() {
    if !is_root() {
        not_run("needs root");
    }
}

/// The command below these limits of `prlimit`, and as root without these capabilities.
pub(crate) fn without(limits: &[&str], capabilities: &str, arguments: &[&str]) -> Command {
    for tool in ["prlimit", "setpriv"] {
        let there = Command::new(tool).arg("--version").output();
        there.unwrap_or_else(|why| panic!("{tool}: {why}; install it with: apt-get install util-linux"));
    }
    let mut wrapped = Command::new("prlimit");
    wrapped.args(limits).arg("--");
    if is_root() {
        wrapped.args(["setpriv", "--bounding-set", capabilities, "--inh-caps", capabilities, "--"]);
    }
    let bare = command(arguments);
    wrapped.arg(bare.get_program()).args(bare.get_args());
    wrapped.current_dir(bare.get_current_dir().expect("the root of the repository"));
    wrapped
}
