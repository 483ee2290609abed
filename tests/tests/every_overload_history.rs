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
    /// One short job.
    Calm,
    /// Three sub-jobs in the queue.
    Long,
    /// A lane that was busy since the tick before.
    Busy,
    /// As `Long`, but nobody looks until the tick is over.
    LongMissed,
    /// As `Calm`, but nobody looks until the tick is over, and the queue is long.
    CalmMissed,
}

impl Tick {
    /// A tick that nobody looks at sees what the last event before it left.
    fn is_overload(self) -> bool {
        matches!(self, Self::Long | Self::Busy | Self::LongMissed)
    }

    fn is_missed(self) -> bool {
        matches!(self, Self::LongMissed | Self::CalmMissed)
    }
}

/// The monitor as `over >= W` says.
struct Reading {
    over: u32,
    needed: u32,
    counts: fn(Tick) -> bool,
    /// Whether it forgets its count when it spoke.
    forgets: bool,
}

impl Reading {
    /// The paper's predicate.
    fn lowest_urgency() -> Self {
        Self { over: 0, needed: TICKS, counts: Tick::is_overload, forgets: true }
    }

    /// Whether jobs are given up at this tick, or at the look that counts it.
    fn speaks(&mut self, tick: Tick) -> bool {
        self.over = if (self.counts)(tick) { self.over + 1 } else { 0 };
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
    at: u64,
}

impl Host {
    fn new(config: Config) -> Self {
        let overload = Overload { queue: QUEUE, ticks: TICKS as u8, ..Overload::PAPER };
        let mut scheduler = Scheduler::new(Config { overload, ..config });
        let mut admit = |nodes: usize| {
            let mut dag = Dag::new();
            for _ in 0..nodes {
                dag.add_node(Node::new(Wcet::from_millis(1))).expect("few nodes");
            }
            scheduler.add_task(&dag, Timing::new(Duration::from_secs(1))).expect("few tasks")
        };
        let (short, wide) = (admit(1), admit(3));
        Self { scheduler, short, wide, at: TICK.as_nanos() }
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
        let is_long = matches!(tick, Tick::Long | Tick::LongMissed);
        self.scheduler.release(if is_long { self.wide } else { self.short }, ahead).expect("room");
        if let Some(unit) = busy {
            self.scheduler.complete(unit, at).expect("it runs");
        }
        let asked = if tick.is_missed() { at.saturating_add(Duration::from_micros(1)) } else { at };
        if tick == Tick::CalmMissed {
            self.scheduler.release(self.wide, asked).expect("room");
        }
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
fn compare(mut reading: Reading, ticks: &[Tick]) -> Result<u32, String> {
    let (mut host, mut spoken) = (Host::new(Config::RED), 0);
    for (number, tick) in ticks.iter().enumerate() {
        let (sheds, speaks) = (host.tick(*tick), reading.speaks(*tick));
        spoken += u32::from(speaks);
        if sheds.is_empty() == speaks || sheds.iter().any(|reason| *reason != ShedReason::Urgency) {
            let before = &ticks[number.saturating_sub(LENGTH)..=number];
            return Err(format!("after {before:?}: {sheds:?}, though the reading says {speaks}"));
        }
    }
    Ok(spoken)
}

const SEEN: &[Tick] = &[Tick::Calm, Tick::Long, Tick::Busy];
const MISSED: &[Tick] = &[Tick::Calm, Tick::Long, Tick::LongMissed, Tick::CalmMissed];

#[test]
fn a_de_bruijn_sequence_has_every_history_once() {
    let sequence = de_bruijn(SEEN, 4);
    let words: Vec<_> = sequence.windows(4).map(|word| word.to_vec()).collect();
    assert_eq!(words.len(), SEEN.len().pow(4));
    assert!((0..words.len()).all(|i| !words[..i].contains(&words[i])));
}

fn in_every_history(letters: &[Tick]) {
    let ticks = de_bruijn(letters, LENGTH);
    let spoken = compare(Reading::lowest_urgency(), &ticks).unwrap_or_else(|found| panic!("{found}"));
    println!("{} histories, in {spoken} ticks jobs were given up", ticks.len() + 1 - LENGTH);
    assert_eq!(ticks.len(), letters.len().pow(LENGTH as u32) + LENGTH - 1);
    assert!(spoken > 0);
}

#[test]
fn the_monitor_speaks_as_the_specification_says_in_every_history_of_ten_ticks() {
    in_every_history(SEEN);
}

#[test]
fn so_it_does_where_ticks_lie_between_two_looks() {
    in_every_history(MISSED);
}

#[test]
fn a_monitor_of_another_reading_is_found() {
    let paper = Reading::lowest_urgency;
    let seen = [Reading { needed: TICKS + 1, ..paper() }, Reading { forgets: false, ..paper() }];
    for reading in seen {
        assert!(compare(reading, &de_bruijn(SEEN, 4)).is_err());
    }
    let counts: [fn(Tick) -> bool; 2] =
        [|tick| tick.is_overload() && !tick.is_missed(), |tick| tick != Tick::Calm];
    for counts in counts {
        assert!(compare(Reading { counts, ..paper() }, &de_bruijn(MISSED, 4)).is_err());
    }
}
