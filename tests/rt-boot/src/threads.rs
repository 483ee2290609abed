//! What the kernel says of a process's threads, looked at from outside while it runs.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

/// The real-time policy of `sched_setscheduler`.
const FIFO: u64 = 1;
/// Page faults count in this time before a thread's end: the run lasts longer, so it has started by then.
const STEADY: Duration = Duration::from_millis(1_500);

/// A process under watch.
pub(crate) struct Watch {
    process: u32,
    locked: String,
    threads: BTreeMap<u32, Thread>,
}

/// A thread with a real-time priority.
struct Thread {
    name: String,
    priority: u64,
    cpus: String,
    /// Page faults up to each look.
    faults: Vec<(Instant, u64)>,
}

impl Watch {
    pub(crate) fn new(process: u32) -> Self {
        Self { process, locked: String::new(), threads: BTreeMap::new() }
    }

    /// Looks at all threads. What has ended meanwhile keeps what was seen last.
    pub(crate) fn look(&mut self) {
        let folder = format!("/proc/{}", self.process);
        if let Some(locked) = status(Path::new(&folder), "VmLck") {
            self.locked = locked;
        }
        let tasks = fs::read_dir(format!("{folder}/task")).into_iter().flatten().flatten();
        for task in tasks {
            let thread = task.file_name().to_string_lossy().parse().ok().zip(Thread::read(&task.path()));
            let Some((number, mut now)) = thread else { continue };
            if let Some(before) = self.threads.remove(&number) {
                now.faults.splice(0..0, before.faults);
            }
            self.threads.insert(number, now);
        }
    }

    /// What there is to say of the run. Threads that had ended before it, those that try the rights, are left out.
    pub(crate) fn lines(&self) -> Vec<String> {
        let mut lines = vec![format!("locked {}", self.locked)];
        let end = self.threads.values().filter_map(Thread::last_seen).max();
        let ran = self.threads.values().filter(|thread| thread.last_seen().map(|at| at + STEADY) >= end);
        lines.extend(ran.map(|thread| {
            let Thread { name, priority, cpus, .. } = thread;
            let (faults, looks) = thread.steady_faults();
            format!("fifo {name} priority {priority} cpus {cpus} faults {faults} looks {looks}")
        }));
        lines
    }
}

impl Thread {
    /// The thread, if its policy is SCHED_FIFO.
    fn read(folder: &Path) -> Option<Self> {
        let stat = fs::read_to_string(folder.join("stat")).ok()?;
        // The name, in parentheses, may contain blanks; what follows begins with the third field.
        let (head, fields) = stat.rsplit_once(')')?;
        let fields: Vec<&str> = fields.split_whitespace().collect();
        let field = |number: usize| fields.get(number - 3)?.parse::<u64>().ok();
        let (minor, major, priority, policy) = (field(10)?, field(12)?, field(40)?, field(41)?);
        let name = head.split_once('(')?.1.replace(' ', "-");
        let cpus = status(folder, "Cpus_allowed_list")?;
        (policy == FIFO).then(|| Self { name, priority, cpus, faults: vec![(Instant::now(), minor + major)] })
    }

    fn last_seen(&self) -> Option<Instant> {
        self.faults.last().map(|(at, _)| *at)
    }

    /// Page faults while it had started, and how often it was looked at then.
    fn steady_faults(&self) -> (u64, usize) {
        let Some((end, last)) = self.faults.last() else { return (0, 0) };
        let steady = self.faults.iter().filter(|(at, _)| *at + STEADY >= *end);
        let first = steady.clone().next().map_or(0, |(_, faults)| *faults);
        (last - first, steady.count())
    }
}

/// A line of `status`.
fn status(folder: &Path, key: &str) -> Option<String> {
    let text = fs::read_to_string(folder.join("status")).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix(':'))?;
    Some(line.trim().to_owned())
}
