//! Rows 52, 55 and 56: CPUs that are taken away from a run, for a while or for good.

use crate::alone::alone;
use crate::apart::{apart, passed};
use crate::lanes::{Notes, Plan};
use crate::process::{ended, file};
use crate::redrt::{count, run, summary};
use crate::rights::{NO_PRIORITY, need_real_time, need_root, not_run, without};
use nix::sched::{CpuSet, sched_setaffinity};
use nix::unistd::{Pid, gettid};
use red_rt::placement::usable_cpus;
use red_rt::report::Surrender;
use red_rt::runtime::Mode;
use std::fs;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicI32, Ordering};
use std::thread;
use std::time::Duration;

/// Between two looks at a group that is to go.
const LOOK: Duration = Duration::from_millis(10);

/// A process that ends with the test, whatever becomes of it.
struct Ends(Child);

impl Drop for Ends {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _gone = self.0.kill().and_then(|()| self.0.wait());
    }
}

#[test]
fn row_52_throttling_of_real_time_threads_is_seen_as_a_standstill() {
    need_real_time();
    let runtime = fs::read_to_string("/proc/sys/kernel/sched_rt_runtime_us").unwrap_or_default();
    if runtime.trim() == "-1" {
        not_run("needs throttling, which sysctl kernel.sched_rt_runtime_us=950000 switches on");
    }
    let cpu = *usable_cpus().expect("an affinity mask").last().expect("at least one CPU");
    let text = format!(
        "pool = [{{ name = 'cpu', lanes = 1, cpus = [{cpu}] }}]\n[[task]]\nname = 't'\nonce = true\ndeadline = '30s'\n\
         node = [{{ name = 'a', wcet = '4s', body = {{ spin = '4s' }} }}]\n"
    );
    let path = file("row-52.toml", text.as_bytes());
    let _alone = alone();
    // Somebody ordinary who wants the same CPU: for him the kernel stops the lane, whether it calls that throttling of
    // the one or a server of the other.
    let hog =
        Command::new("taskset").args(["-c", &cpu.to_string(), "sh", "-c", "while :; do :; done"]).spawn();
    let hog = Ends(hog.expect("no taskset; install it with: apt-get install util-linux"));
    let output = run(&path, &["--duration", "100ms"]).output().expect("the command starts");
    let (throttled, told) = summary(&output, 0);
    assert!(count(&throttled, "standstills") > 0, "{throttled}");
    assert!(told.contains("standstills: ") && told.contains("kernel.rt_throttling"), "{told}");
    drop(hog);
    a_busy_lane_is_not_stopped();
}

/// Of each second the kernel would take 50 ms. So may a host that does not give a virtual machine its CPUs: once more, then.
fn a_busy_lane_is_not_stopped() {
    let text =
        b"pool = [{ name = 'cpu', lanes = 1 }]\n[[task]]\nname = 't'\nperiod = '4ms'\ndeadline = '20ms'\n\
        node = [{ name = 'a', wcet = '5ms', body = { spin = '5ms' } }]\n";
    let path = file("row-52-busy.toml", text);
    let is_kept = (0..4).any(|_| {
        let output = run(&path, &["--duration", "4s"]).output().expect("the command starts");
        let (busy, told) = summary(&output, 0);
        let is_told = told.contains("bodies ran outside of real time for ");
        assert!(count(&busy, "ordinary_ns") > 100_000_000 && is_told, "{told}");
        count(&busy, "standstills") == 0
    });
    assert!(is_kept, "the kernel stopped the lane in each of four runs");
}

/// Where a hierarchy of control groups with this controller is mounted, and whether it is one of version 2.
fn hierarchy(controller: &str) -> Option<(PathBuf, bool)> {
    let mounts = fs::read_to_string("/proc/self/mounts").ok()?;
    let of = |line: &str| {
        let fields: Vec<&str> = line.split_whitespace().collect();
        let (root, kind, options) = (PathBuf::from(fields.get(1)?), *fields.get(2)?, *fields.get(3)?);
        match kind {
            "cgroup" if options.split(',').any(|option| option == controller) => Some((root, false)),
            "cgroup2" => {
                let has = fs::read_to_string(root.join("cgroup.controllers")).ok()?;
                // Children have it only if their parent gives it away.
                let given = has.split_whitespace().any(|name| name == controller)
                    && fs::write(root.join("cgroup.subtree_control"), format!("+{controller}")).is_ok();
                given.then_some((root, true))
            }
            _ => None,
        }
    };
    mounts.lines().find_map(of)
}

/// A control group of this test, removed in the end.
struct Group {
    folder: PathBuf,
    is_second: bool,
}

impl Group {
    fn new(controller: &str, name: &str) -> Self {
        need_root();
        let Some((root, is_second)) = hierarchy(controller) else {
            not_run(&format!("needs control groups with the controller `{controller}`"));
        };
        let folder = root.join(format!("red-fault-table-{name}-{}", std::process::id()));
        fs::create_dir(&folder)
            .unwrap_or_else(|error| not_run(&format!("needs a control group of its own: {error}")));
        Self { folder, is_second }
    }

    fn set(&self, file: &str, value: &str) {
        let path = self.folder.join(file);
        fs::write(&path, value).unwrap_or_else(|error| panic!("{} = {value}: {error}", path.display()));
    }

    fn take(&self, process: u32) {
        self.set("cgroup.procs", &process.to_string());
    }
}

impl Drop for Group {
    fn drop(&mut self) {
        // Its processes have ended, but the kernel may need a moment to see it.
        let _gone = (0..100).any(|_| {
            let gone = fs::remove_dir(&self.folder).is_ok();
            if !gone {
                thread::sleep(LOOK);
            }
            gone
        });
    }
}

/// The threads of the lanes of a run in this process.
static LANES: [AtomicI32; 2] = [const { AtomicI32::new(0) }; 2];

fn enlist(lane: usize) {
    LANES[lane].store(gettid().as_raw(), Ordering::Relaxed);
}

fn allow(thread: i32, cpus: &[usize]) {
    let mut mask = CpuSet::new();
    cpus.iter().for_each(|cpu| mask.set(*cpu).expect("a CPU of this machine"));
    sched_setaffinity(Pid::from_raw(thread), &mask).expect("a thread of this process");
}

#[test]
fn row_55_a_lane_that_is_moved_is_put_back_and_one_whose_cpu_is_gone_ends_the_run() {
    need_real_time();
    let usable = usable_cpus().expect("an affinity mask");
    let [first, second, ..] = usable[..] else { not_run("needs two CPUs") };
    let group = Group::new("cpuset", "row-55");
    let _alone = alone();
    // Before the start: typed, with what there is. Without a CPU there is no process that could ask.
    let path = file(
        "row-55.toml",
        b"pool = [{ name = 'p', lanes = 1, cpus = [1023] }]\n[[task]]\nname = 't'\nonce = true\ndeadline = '1s'\n\
          node = [{ name = 'a', wcet = '1ms', body = { spin = '1us' } }]\n",
    );
    let (status, out, err) = ended(&run(&path, &[]).output().expect("the command starts"));
    assert_eq!((status, &*out), (3, ""), "{err}");
    assert!(err.contains("CPU 1023 is offline or not allowed") && err.contains("fix:"), "{err}");
    // While it runs.
    if !group.is_second {
        fs::read_to_string(group.folder.join("../cpuset.mems"))
            .map(|mems| group.set("cpuset.mems", &mems))
            .expect("the root's");
    }
    let folder = group.folder.to_str().expect("UTF-8").to_owned();
    let moved = apart(&["env", &format!("RED_GROUP={folder}")], || {
        let mode = || Mode::RealTime { priority: 10, cpus: vec![first, second] };
        let plan = |duration_ns| Plan {
            mode: mode(),
            period_ns: Some(20_000_000),
            duration_ns,
            drain_ns: 5_000_000_000,
            begin: enlist,
            body: |_: usize, _: &red_rt::handler::Work| Ok(()),
        };
        let mut moves = Some(()).into_iter();
        let told = plan(1_000_000_000).run(
            Notes::default(),
            |_, _| (),
            |now| {
                if now > 200_000_000 && moves.next().is_some() {
                    allow(LANES[1].load(Ordering::Relaxed), &[first]);
                }
            },
        );
        told.is_sound();
        assert!(told.report.pinned_again >= 1 && told.report.gave_up.is_none(), "{:?}", told.report.gave_up);
        assert_eq!((told.host.released + told.host.refused, told.report.lanes_lost), (50, 0));

        let group = PathBuf::from(std::env::var("RED_GROUP").expect("set above"));
        let mut takes = Some(()).into_iter();
        let told = plan(60_000_000_000).run(
            Notes::default(),
            |_, _| (),
            |now| {
                if now > 200_000_000 && takes.next().is_some() {
                    fs::write(group.join("cpuset.cpus"), first.to_string()).expect("a group of this test");
                    fs::write(group.join("cgroup.procs"), std::process::id().to_string())
                        .expect("it takes processes");
                }
            },
        );
        let gone = Surrender::CpuGone { lane: 1, cpu: second };
        assert_eq!(told.report.gave_up, Some(gone), "no silent migration");
        assert!(gone.to_string().contains(&format!("CPU {second} was taken from lane 1")));
    });
    let Some(output) = moved else { return };
    passed(&output);
}

#[test]
fn row_56_a_used_up_cpu_quota_is_seen_as_a_standstill() {
    let group = Group::new("cpu", "row-56");
    // A fifth of a CPU.
    if group.is_second {
        group.set("cpu.max", "20000 100000");
    } else {
        group.set("cpu.cfs_period_us", "100000");
        group.set("cpu.cfs_quota_us", "20000");
    }
    let text = "pool = [{ name = 'cpu', lanes = 1 }]\n[[task]]\nname = 't'\nperiod = '10ms'\ndeadline = '10s'\n\
                node = [{ name = 'a', wcet = '10s', body = { spin = '10ms' } }]\n";
    let path = file("row-56.toml", text.as_bytes());
    // Real-time threads have no quota, so without the right to be one.
    let arguments = ["run", path.to_str().unwrap(), "--json", "--best-effort", "--duration", "1s"];
    let mut command = without(&NO_PRIORITY, "-sys_nice,-sys_resource", &arguments);
    let _alone = alone();
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the command starts");
    group.take(child.id());
    let (cut, told) = summary(&child.wait_with_output().expect("it ends"), 0);
    assert!(count(&cut, "standstills") > 0, "{cut}");
    assert!(told.contains("standstills: ") && told.contains("rights.cpu_quota"), "{told}");
}
