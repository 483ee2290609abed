use super::*;
use nix::errno::Errno;
use std::fs;

const MISSING: &str = "setcap cap_sys_nice";

fn refused(call: &'static str) -> SetupError {
    SetupError::NotPermitted { call, errno: Errno::EPERM, fix: MISSING }
}

#[test]
fn a_group_without_a_budget_is_named_as_the_cause_and_a_missing_right_otherwise() {
    let root = std::env::temp_dir().join(format!("redrt-denied-{}", std::process::id()));
    let write = |path: &str, text: &str| {
        let path = root.join(path);
        fs::create_dir_all(path.parent().expect("below the root")).expect("a writable temporary folder");
        fs::write(path, text).expect("a writable temporary folder");
    };
    write("proc/self/status", "CapEff:\t0000000000800000\n");
    write("proc/sys/kernel/sched_rt_runtime_us", "950000\n");
    write("proc/self/cgroup", "4:cpu,cpuacct:/box\n0::/\n");
    write("sys/fs/cgroup/cpu/box/cpu.rt_runtime_us", "0\n");
    let told = |call| Denied::on(&root, refused(call)).to_string();
    let of_group = told("sched_setscheduler(SCHED_FIFO)");
    assert!(
        of_group.contains("no real-time budget (/sys/fs/cgroup/cpu/box/cpu.rt_runtime_us = 0)"),
        "{of_group}"
    );
    assert!(of_group.contains("fix: give the group a budget") && !of_group.contains(MISSING), "{of_group}");
    assert!(of_group.contains("SCHED_FIFO") && of_group.contains("EPERM"), "{of_group}");
    // Locked memory is no matter of the group.
    assert!(told("mlockall(MCL_CURRENT | MCL_FUTURE)").ends_with(MISSING));
    write("proc/self/status", "CapEff:\t0000000000000000\n");
    write("proc/self/limits", "Max realtime priority     0                    0\n");
    assert!(
        told("sched_setscheduler(SCHED_FIFO)").ends_with(MISSING),
        "without the right, that is the cause"
    );
    fs::remove_dir_all(&root).expect("our own folder");
}
