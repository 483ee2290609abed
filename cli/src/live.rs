//! The live view of a run: a block that is redrawn on a terminal, plain lines elsewhere. On standard error, so
//! that standard output stays clean.

use crate::session::host::Live;
use crate::terminal::{self, Paint, Teller};
use red_workload::build::Numbered;
use std::io;
use std::sync::atomic::{AtomicU64, Ordering};

/// Between two plain lines.
const PLAIN_NS: u64 = 2_000_000_000;
/// Characters of the time bar.
const CELLS: usize = 40;
/// Lanes that are shown: the block must fit every terminal.
const LANES: usize = 8;

/// A view of one run.
pub(crate) struct View {
    title: String,
    duration_ns: u64,
    /// From, until.
    obstacle_ns: Option<(u64, u64)>,
    names: Vec<Vec<String>>,
    lanes: Vec<String>,
    /// Whether a deadline was missed, by cell of the time bar that has begun.
    missed: Vec<bool>,
    missed_so_far: u64,
    moves: bool,
    paint: Paint,
    /// Who shows it looks after the run as well, and must not wait for a reader.
    teller: Teller,
    drawn: usize,
    next_plain_ns: u64,
    obstacle_told: bool,
    drifted: u64,
}

impl View {
    /// A view of a run of `duration_ns`, titled by its policy.
    pub(crate) fn new(
        title: String,
        duration_ns: u64,
        obstacle_ns: Option<(u64, u64)>,
        lanes: Vec<String>,
    ) -> Self {
        Self {
            title,
            duration_ns,
            obstacle_ns,
            names: Vec::new(),
            lanes,
            missed: Vec::new(),
            missed_so_far: 0,
            moves: terminal::moves(&io::stderr()),
            paint: Paint::on(&io::stderr()),
            teller: Teller::new(),
            drawn: 0,
            next_plain_ns: PLAIN_NS,
            obstacle_told: false,
            drifted: 0,
        }
    }

    /// Names for what lanes run.
    pub(crate) fn name(&mut self, nodes: &[Vec<Numbered>]) {
        self.names = nodes.iter().map(|task| task.iter().map(|n| n.name.clone()).collect()).collect();
    }

    /// Shows the state at `now`.
    pub(crate) fn show(&mut self, now_ns: u64, live: &Live) {
        if !self.moves {
            return self.plain(now_ns, live);
        }
        self.look_for_misses(now_ns, live);
        let mut lines = self.figures(now_ns, live);
        for (title, lane) in self.lanes.iter().zip(&live.lanes).take(LANES) {
            lines.push(format!("  {title:<16} {}", self.node(get(lane))));
        }
        if self.lanes.len() > LANES {
            lines.push(format!("  and {} lanes more", self.lanes.len() - LANES));
        }
        self.draw(&lines);
    }

    /// Shows the state at the end: without the lanes, which run nothing any more.
    pub(crate) fn end(&mut self, now_ns: u64, live: &Live) {
        if self.moves {
            self.look_for_misses(now_ns, live);
            let mut lines = self.figures(now_ns, live);
            lines.push(String::new());
            self.draw(&lines);
        }
    }

    /// Draws over what was drawn before, in one write. Lines are cut at the edge of a terminal that is too narrow,
    /// because the cursor goes back by lines.
    fn draw(&mut self, lines: &[String]) {
        let up = if self.drawn > 0 { format!("\x1b[{}A", self.drawn) } else { String::new() };
        let lines_down: String = lines.iter().map(|line| format!("{line}\x1b[K\n")).collect();
        // From the first column, also after the terminal has shown a key.
        self.teller.tell(format!("\x1b[?7l\r{up}{lines_down}\x1b[J\x1b[?7h"));
        self.drawn = lines.len();
    }

    fn plain(&mut self, now_ns: u64, live: &Live) {
        if let Some((from, until)) = self.obstacle_ns
            && (from..until).contains(&now_ns) != self.obstacle_told
        {
            self.obstacle_told = !self.obstacle_told;
            let what =
                if self.obstacle_told { "an obstacle comes into sight" } else { "the obstacle is gone" };
            self.teller.tell(format!("{:<8}{:>6.1} s {what}\n", self.title, seconds(now_ns)));
        }
        let drifted = get(&live.drifted);
        if drifted != self.drifted {
            self.drifted = drifted;
            let (title, at) = (&self.title, seconds(now_ns));
            self.teller.tell(format!("{title:<8}{at:>6.1} s {}\n", self.drift(drifted)));
        }
        if now_ns >= self.next_plain_ns {
            self.next_plain_ns += PLAIN_NS;
            self.teller.tell(format!("{}\n", self.jobs(now_ns, live)));
        }
    }

    fn look_for_misses(&mut self, now_ns: u64, live: &Live) {
        let missed = get(&live.missed);
        self.missed.resize(self.cells(now_ns), false);
        if missed > self.missed_so_far
            && let Some(cell) = self.missed.last_mut()
        {
            *cell = true;
        }
        self.missed_so_far = missed;
    }

    fn figures(&self, now_ns: u64, live: &Live) -> Vec<String> {
        let marks: String = self
            .missed
            .iter()
            .map(|missed| if *missed { self.paint.red("x") } else { "=".to_owned() })
            .collect();
        let ahead = " ".repeat(CELLS - self.missed.len());
        let mut lines =
            vec![self.jobs(now_ns, live), format!("  jobs      [{marks}{ahead}]  = on time  x missed")];
        if let Some((from, until)) = self.obstacle_ns {
            let (from, until) = (self.cells(from), self.cells(until));
            let road = |cells: usize| ".".repeat(cells);
            let obstacle = self.paint.yellow(&"o".repeat(until - from));
            let seen = self.missed.len();
            let what = if seen > from && seen <= until {
                self.paint.yellow("in sight")
            } else {
                "not in sight".to_owned()
            };
            lines.push(format!("  obstacle  [{}{obstacle}{}]  {what}", road(from), road(CELLS - until)));
        }
        let drifted = get(&live.drifted);
        if drifted > 0 {
            lines.push(format!("  {}", self.paint.yellow(&self.drift(drifted))));
        }
        lines.push(format!("  encoder runs saved {:>5}   shed {:>5}", get(&live.saved), get(&live.shed)));
        lines
    }

    fn jobs(&self, now_ns: u64, live: &Live) -> String {
        let missed = format!("missed {:>5}", get(&live.missed));
        format!(
            "{:<8}{:>6.1} s of {} s   released {:>5}   on time {:>5}   {}",
            self.title,
            seconds(now_ns.min(self.duration_ns)),
            seconds(self.duration_ns),
            get(&live.released),
            get(&live.on_time),
            if get(&live.missed) > 0 { self.paint.red(&missed) } else { missed },
        )
    }

    /// Cells of the time bar that have begun at an instant.
    fn cells(&self, at_ns: u64) -> usize {
        let cells = u128::from(at_ns) * CELLS as u128 / u128::from(self.duration_ns.max(1));
        usize::try_from(cells).unwrap_or(CELLS).min(CELLS)
    }

    fn drift(&self, what: u64) -> String {
        format!("cost drift: `{}` takes longer than in the beginning", self.node(what))
    }

    fn node(&self, what: u64) -> &str {
        let name = |what: u64| {
            let task = usize::try_from(what >> 8).ok()?;
            self.names.get(task)?.get((what & 0xff) as usize)
        };
        what.checked_sub(1).and_then(name).map_or("idle", String::as_str)
    }
}

fn get(counter: &AtomicU64) -> u64 {
    counter.load(Ordering::Relaxed)
}

fn seconds(ns: u64) -> f64 {
    ns as f64 / 1e9
}

#[cfg(test)]
mod tests;
