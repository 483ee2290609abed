//! What the kernel says of a process's threads, looked at from outside while it runs.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// The real-time policy of `sched_setscheduler`.
const FIFO: u64 = 1;
/// Looks before which a thread may still be starting: page faults count from then on.
const STARTING: u32 = 5;

/// A process under watch.
pub(crate) struct Watch {
    process: u32,
    looks: u32,
    locked: String,
    threads: BTreeMap<u32, Thread>,
}

/// A thread with a real-time priority.
struct Thread {
    name: String,
    priority: u64,
    cpus: String,
    /// Page faults when it had started, and last.
    faults: [u64; 2],
}

impl Watch {
    pub(crate) fn new(process: u32) -> Self {
        Self { process, looks: 0, locked: String::new(), threads: BTreeMap::new() }
    }

    /// Looks at all threads. What has ended meanwhile keeps what was seen last.
    pub(crate) fn look(&mut self) {
        self.looks += 1;
        let folder = format!("/proc/{}", self.process);
        if let Some(locked) = status(Path::new(&folder), "VmLck") {
            self.locked = locked;
        }
        let tasks = fs::read_dir(format!("{folder}/task")).into_iter().flatten().flatten();
        for task in tasks {
            let thread = task.file_name().to_string_lossy().parse().ok().zip(Thread::read(&task.path()));
            let Some((number, mut now)) = thread else { continue };
            let before = self.threads.get(&number).filter(|_| self.looks > STARTING);
            now.faults[0] = before.map_or(now.faults[1], |before| before.faults[0]);
            self.threads.insert(number, now);
        }
    }

    pub(crate) fn lines(&self) -> Vec<String> {
        let mut lines = vec![format!("locked {}", self.locked)];
        lines.extend(self.threads.values().map(|thread| {
            let Thread { name, priority, cpus, faults: [first, last] } = thread;
            format!("fifo {name} priority {priority} cpus {cpus} faults {}", last - first)
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
        (policy == FIFO).then_some(Self { name, priority, cpus, faults: [0, minor + major] })
    }
}

/// A line of `status`.
fn status(folder: &Path, key: &str) -> Option<String> {
    let text = fs::read_to_string(folder.join("status")).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix(':'))?;
    Some(line.trim().to_owned())
}
