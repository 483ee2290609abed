//! The live view of a run: a block that is redrawn on a terminal, plain lines elsewhere. On standard error, so
//! that standard output stays clean.

use crate::session::host::Live;
use red_workload::build::Numbered;
use std::fmt::Write as _;
use std::io::{self, IsTerminal, Write as _};
use std::sync::atomic::Ordering;

/// Between two plain lines.
const PLAIN_NS: u64 = 2_000_000_000;
/// Characters of the time bar.
const BAR: u64 = 40;

/// A view of one run.
pub(crate) struct View {
    title: String,
    duration_ns: u64,
    /// Marked on the bar: from, until.
    obstacle_ns: Option<(u64, u64)>,
    names: Vec<Vec<String>>,
    lanes: Vec<String>,
    terminal: bool,
    drawn: usize,
    next_plain_ns: u64,
}

impl View {
    /// A view of a run of `duration_ns`, titled by its policy.
    pub(crate) fn new(
        title: &str,
        duration_ns: u64,
        obstacle_ns: Option<(u64, u64)>,
        lanes: Vec<String>,
    ) -> Self {
        let terminal = io::stderr().is_terminal();
        let title = title.to_owned();
        Self {
            title,
            duration_ns,
            obstacle_ns,
            names: Vec::new(),
            lanes,
            terminal,
            drawn: 0,
            next_plain_ns: PLAIN_NS,
        }
    }

    /// Names for what lanes run.
    pub(crate) fn name(&mut self, nodes: &[Vec<Numbered>]) {
        self.names = nodes.iter().map(|task| task.iter().map(|n| n.name.clone()).collect()).collect();
    }

    /// Shows the state at `now`.
    pub(crate) fn show(&mut self, now_ns: u64, live: &Live) {
        if !self.terminal {
            if now_ns >= self.next_plain_ns {
                self.next_plain_ns += PLAIN_NS;
                tell(&format!("{}\n", self.counters(now_ns, live)));
            }
            return;
        }
        let mut block = String::new();
        if self.drawn > 0 {
            let _infallible = write!(block, "\x1b[{}A", self.drawn);
        }
        let _infallible = writeln!(block, "\x1b[K{}", self.counters(now_ns, live));
        let _infallible = writeln!(block, "\x1b[K  {}", self.bar(now_ns));
        for (title, lane) in self.lanes.iter().zip(&live.lanes) {
            let _infallible =
                writeln!(block, "\x1b[K  {title:<12} {}", self.node(lane.load(Ordering::Relaxed)));
        }
        self.drawn = 2 + self.lanes.len();
        tell(&block);
    }

    fn counters(&self, now_ns: u64, live: &Live) -> String {
        let get = |counter: &std::sync::atomic::AtomicU64| counter.load(Ordering::Relaxed);
        format!(
            "{:<8} {:>5.1} s of {:.0} s   released {:>5}   on time {:>5}   missed {:>5}   shed {:>4}   encoder runs saved {:>5}",
            self.title,
            now_ns.min(self.duration_ns) as f64 / 1e9,
            self.duration_ns as f64 / 1e9,
            get(&live.released),
            get(&live.on_time),
            get(&live.missed),
            get(&live.shed),
            get(&live.saved),
        )
    }

    fn bar(&self, now_ns: u64) -> String {
        let cell = |i: u64| {
            let at = self.duration_ns / BAR * i;
            let obstacle = self.obstacle_ns.is_some_and(|(from, until)| (from..until).contains(&at));
            match (at <= now_ns, obstacle) {
                (true, true) => '#',
                (true, false) => '=',
                (false, true) => 'o',
                (false, false) => '.',
            }
        };
        let bar: String = (0..BAR).map(cell).collect();
        let note = if self.obstacle_ns.is_some() { "   (o: obstacle in sight)" } else { "" };
        format!("[{bar}]{note}")
    }

    fn node(&self, what: u64) -> &str {
        let name = |what: u64| {
            let task = usize::try_from(what >> 8).ok()?;
            self.names.get(task)?.get((what & 0xff) as usize)
        };
        what.checked_sub(1).and_then(name).map_or("idle", String::as_str)
    }
}

fn tell(text: &str) {
    let mut err = io::stderr().lock();
    // Where nobody listens, nobody misses it.
    let _told = err.write_all(text.as_bytes()).and_then(|()| err.flush());
}
