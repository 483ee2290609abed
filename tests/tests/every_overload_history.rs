//! Every history of ten ticks of the overload monitor, through the public scheduler, against a counter that is read off
//! the specification.
//!
//! A de Bruijn sequence contains each history once: so each of them also comes after many others, and what it leaves
//! behind is met by those that follow.

use red_core::{
    Action, Caps, Config, Dag, Duration, Instant, Node, Overload, Scheduler, ShedReason, TaskId, Timing, Wcet,
};

type Small = Caps<3, 4, 8>;

const LENGTH: usize = 10;
const TICK: Duration = Duration::from_millis(5);
/// Ticks in a row, and sub-jobs in the queue, beyond which jobs are given up.
const TICKS: u32 = 3;
const QUEUE: u16 = 2;
/// How long before its tick a job is released.
const AHEAD: u64 = 1_000_000;

/// What one tick sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Tick {
    /// One short job that is in time.
    Calm,
    /// Three sub-jobs in the queue, in time.
    Long,
    /// A job that is late at its worst case, and not at its best.
    Late,
    /// A long queue and a late job.
    LongAndLate,
    /// A lane that was busy since the tick before.
    Busy,
    /// As `LongAndLate`, but nobody asks until the tick is over.
    Missed,
}

impl Tick {
    fn is_late(self) -> bool {
        matches!(self, Self::Late | Self::LongAndLate | Self::Missed)
    }

    fn is_long(self) -> bool {
        matches!(self, Self::Long | Self::LongAndLate | Self::Missed)
    }
}

/// The monitor as `over >= W` says, and whether it forgets its count when it spoke.
struct Reading {
    over: u32,
    needed: u32,
    needs_late: bool,
    forgets: bool,
}

impl Reading {
    /// Ours: only while some job is late at its worst case.
    fn hopeless() -> Self {
        Self { over: 0, needed: TICKS, needs_late: true, forgets: false }
    }

    /// The paper's predicate.
    fn lowest_urgency() -> Self {
        Self { over: 0, needed: TICKS, needs_late: false, forgets: true }
    }

    /// Whether jobs are given up at this tick.
    fn speaks(&mut self, tick: Tick) -> bool {
        let is_overload = (tick.is_long() || tick == Tick::Busy) && (tick.is_late() || !self.needs_late);
        self.over = if is_overload && tick != Tick::Missed { self.over + 1 } else { 0 };
        let speaks = self.over >= self.needed;
        if speaks && self.forgets {
            self.over = 0;
        }
        speaks
    }
}

/// Tells the scheduler what a tick is to see, and carries out everything at once.
struct Host {
    scheduler: Scheduler<Small>,
    short: TaskId,
    wide: TaskId,
    late: TaskId,
    at: u64,
}

impl Host {
    fn new(config: Config) -> Self {
        let overload = Overload { queue: QUEUE, ticks: TICKS as u8, ..Overload::PAPER };
        let mut scheduler = Scheduler::new(Config { overload, ..config });
        let mut admit = |nodes: usize, wcet: u64, deadline: u64, value: u32| {
            let mut dag = Dag::new();
            for _ in 0..nodes {
                dag.add_node(Node::new(Wcet::from_millis(wcet))).expect("few nodes");
            }
            let timing = Timing::new(Duration::from_millis(deadline)).value(value);
            scheduler.add_task(&dag, timing).expect("few tasks")
        };
        let (short, wide, late) = (admit(1, 1, 1_000, 5), admit(3, 1, 1_000, 5), admit(1, 3, 2, 1));
        Self { scheduler, short, wide, late, at: TICK.as_nanos() }
    }

    /// Runs what is ready to its end, in no time; the reasons of the jobs that were given up.
    fn run(&mut self, now: Instant) -> Vec<ShedReason> {
        let mut sheds = Vec::new();
        while let Some(action) = self.scheduler.poll(now) {
            match action {
                Action::Dispatch(started) => self.scheduler.complete(started.unit, now).expect("it runs"),
                Action::Ended(outcome) => sheds.extend(outcome.shed),
                other => panic!("nobody asked for {other:?}"),
            }
        }
        sheds
    }

    /// One tick; the reasons of the jobs that were given up.
    fn tick(&mut self, tick: Tick) -> Vec<ShedReason> {
        let before = Instant::from_nanos(self.at);
        self.at += TICK.as_nanos();
        let at = Instant::from_nanos(self.at);
        let mut busy = None;
        if tick == Tick::Busy {
            self.scheduler.release(self.short, before).expect("room");
            let Some(Action::Dispatch(started)) = self.scheduler.poll(before) else {
                panic!("the lane is free")
            };
            busy = Some(started.unit);
        }
        let ahead = Instant::from_nanos(self.at - AHEAD);
        let mut release = |task| self.scheduler.release(task, ahead).expect("room");
        release(if tick.is_long() { self.wide } else { self.short });
        if tick.is_late() {
            release(self.late);
        }
        if let Some(unit) = busy {
            self.scheduler.complete(unit, at).expect("it runs");
        }
        let asked = if tick == Tick::Missed { at.saturating_add(Duration::from_micros(1)) } else { at };
        let sheds = self.run(asked);
        assert_eq!(self.scheduler.jobs_in_flight(), 0, "each tick begins with nothing in flight");
        sheds
    }
}

/// A cyclic sequence that contains each word of `length` letters once, its beginning repeated at its end.
fn de_bruijn(letters: &[Tick], length: usize) -> Vec<Tick> {
    // Lyndon words in their order, those whose length divides the words'.
    let (mut word, mut sequence) = (vec![0; length], vec![0]);
    while let Some(last) = word.iter().rposition(|letter| *letter + 1 < letters.len()) {
        word.truncate(last + 1);
        word[last] += 1;
        if length.is_multiple_of(word.len()) {
            sequence.extend(&word);
        }
        word = word.iter().copied().cycle().take(length).collect();
    }
    sequence.extend_from_within(..length - 1);
    sequence.into_iter().map(|letter| letters[letter]).collect()
}

/// Whether the scheduler gives jobs up exactly where the reading says; else how many ticks had gone by.
fn compare(config: Config, mut reading: Reading, reason: ShedReason, ticks: &[Tick]) -> Result<u32, String> {
    let (mut host, mut spoken) = (Host::new(config), 0);
    for (number, tick) in ticks.iter().enumerate() {
        let (sheds, speaks) = (host.tick(*tick), reading.speaks(*tick));
        spoken += u32::from(speaks);
        if sheds.contains(&reason) != speaks || sheds.iter().any(|other| *other != reason) {
            let before = &ticks[number.saturating_sub(LENGTH)..=number];
            return Err(format!("after {before:?}: {sheds:?}, though the reading says {speaks}"));
        }
    }
    Ok(spoken)
}

const OURS: &[Tick] = &[Tick::Calm, Tick::Long, Tick::Late, Tick::LongAndLate];
const PAPER: &[Tick] = &[Tick::Calm, Tick::Long, Tick::Busy];
const MISSED: &[Tick] = &[Tick::Calm, Tick::LongAndLate, Tick::Missed];

#[test]
fn a_de_bruijn_sequence_has_every_history_once() {
    let sequence = de_bruijn(PAPER, 4);
    let words: Vec<_> = sequence.windows(4).map(|word| word.to_vec()).collect();
    assert_eq!(words.len(), PAPER.len().pow(4));
    assert!((0..words.len()).all(|i| !words[..i].contains(&words[i])));
}

#[test]
fn the_monitor_speaks_as_the_specification_says_in_every_history_of_ten_ticks() {
    for (name, config, reading, reason, letters) in [
        ("redrt", Config::REDRT, Reading::hopeless(), ShedReason::Overload, OURS),
        ("redrt, ticks missed", Config::REDRT, Reading::hopeless(), ShedReason::Overload, MISSED),
        ("red", Config::RED, Reading::lowest_urgency(), ShedReason::Urgency, PAPER),
        ("red, ticks missed", Config::RED, Reading::lowest_urgency(), ShedReason::Urgency, MISSED),
    ] {
        let ticks = de_bruijn(letters, LENGTH);
        let spoken =
            compare(config, reading, reason, &ticks).unwrap_or_else(|found| panic!("{name}: {found}"));
        println!("{name}: {} histories, in {spoken} ticks jobs were given up", ticks.len() + 1 - LENGTH);
        assert_eq!(ticks.len(), letters.len().pow(LENGTH as u32) + LENGTH - 1);
        assert!(spoken > 0);
    }
}

#[test]
fn a_monitor_that_speaks_a_tick_late_or_forgets_is_found() {
    let ticks = de_bruijn(OURS, 4);
    let late = Reading { needed: TICKS + 1, ..Reading::hopeless() };
    assert!(compare(Config::REDRT, late, ShedReason::Overload, &ticks).is_err());
    let forgets = Reading { forgets: true, ..Reading::hopeless() };
    assert!(compare(Config::REDRT, forgets, ShedReason::Overload, &ticks).is_err());
    let never_mind = Reading { needs_late: false, ..Reading::hopeless() };
    assert!(compare(Config::REDRT, never_mind, ShedReason::Overload, &ticks).is_err());
}
