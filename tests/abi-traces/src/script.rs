//! A workload as a list of what happens: everything is drawn before it runs, so that any executor can read it.

use red_core::{
    Admission, BestCase, Bytes, Config, Duration, Frame, Gate, Late, Node, Reassign, SensorId, Shed, Wcet,
};
use red_traces::workload::{self, Arrival, Common, Pool, Terms};
use red_traces::{POLICIES, RULES, Rng};

/// Releases and edits happen before it; then what is in flight ends.
const HORIZON_NS: u64 = 15_000_000;
/// Executors stop after so many instants, should a workload never end.
pub(crate) const INSTANTS: u32 = 5_000;
/// How executions of units end, by turns.
const FATES: usize = 61;

/// A capacity class of the C ABI.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Class {
    Small,
    Medium,
    Large,
}

/// How a graph is made or changed. Numbers may be those of nodes that there are not.
#[derive(Clone, Debug)]
pub(crate) enum Step {
    Node(Node),
    Edge(u8, u8),
    Refine(u8, Node, Vec<Node>),
    Replace(u8, Node),
    Remove(u8),
    Cut(u8, u8),
}

pub(crate) struct Task {
    pub(crate) terms: Terms,
    pub(crate) steps: Vec<Step>,
}

/// What happens. Tasks are meant by their place in the list.
#[derive(Clone, Debug)]
pub(crate) enum Event {
    Admit(usize),
    Release {
        task: usize,
        at_ns: u64,
        capture: Option<u64>,
    },
    Remove(usize),
    /// An edit of a task begins in one of the places for edits, is changed there, and committed or dropped.
    Begin {
        place: usize,
        task: usize,
    },
    Change {
        place: usize,
        step: Step,
    },
    Commit(usize),
    Drop(usize),
    Retire(u8),
    Restore(u8),
    /// Somebody reports a unit, and releases a job, by names that nobody gave out.
    Stray {
        unit: u64,
        task: u32,
    },
    /// A poll whose time is so much earlier.
    Back(u64),
    /// The next outcome is taken without a poll.
    Take,
}

/// How the execution of a unit ends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fate {
    /// Of its WCET.
    pub(crate) percent: u64,
    pub(crate) how: How,
    /// The lane says it twice.
    pub(crate) repeats: bool,
}

#[derive(Clone, Copy, Debug)]
pub(crate) enum How {
    Complete,
    CompleteAndPoll,
    Fail,
    /// The lane asks for itself afterwards.
    PollOn,
}

pub(crate) struct Script {
    pub(crate) seed: u64,
    pub(crate) class: Class,
    pub(crate) policy: &'static str,
    pub(crate) preset: Config,
    pub(crate) config: Config,
    pub(crate) pools: Vec<Pool>,
    pub(crate) sensors: Vec<Duration>,
    pub(crate) tasks: Vec<Task>,
    pub(crate) fates: Vec<Fate>,
    /// In the order in which they happen.
    pub(crate) events: Vec<(u64, Event)>,
}

impl Script {
    /// The workload of a seed.
    pub(crate) fn draw(seed: u64) -> Self {
        let rng = &mut Rng::new(seed);
        let (policy, preset) = POLICIES[(seed % POLICIES.len() as u64) as usize];
        let config = vary(workload::config(seed, rng), rng);
        let common = workload::common(&config, rng);
        let class = match seed % 16 {
            1 | 4 | 7 | 10 => Class::Small,
            13 => Class::Large,
            _ => Class::Medium,
        };
        let mut sensors: Vec<_> = common.sensor.into_iter().collect();
        // Some are refused, some are one.
        if rng.chance(20) {
            sensors.extend([sensors.first().copied().unwrap_or(Duration::ZERO), Duration::from_micros(700)]);
        }
        let count = rng.within(1, 5);
        let load = rng.within(60, 500) / count;
        let mut drawing = Drawing { rng, common: &common, events: Vec::new() };
        let tasks = (0..count as usize).map(|task| drawing.task(task, load)).collect();
        drawing.happenings(count as usize);
        let mut events = drawing.events;
        events.sort_by_key(|(at_ns, _)| *at_ns);
        let fates = (0..FATES).map(|_| fate(rng)).collect();
        let pools = common.pools.into_iter().flatten().collect();
        Self { seed, class, policy, preset, config, pools, sensors, tasks, fates, events }
    }
}

/// A configuration with some fields of its own.
fn vary(config: Config, rng: &mut Rng) -> Config {
    let mut new = config;
    for _ in 0..if rng.chance(40) { rng.within(1, 4) } else { 0 } {
        match rng.within(0, 12) {
            0 | 11 => new.rule = RULES[rng.index(RULES.len())],
            1 => new.gate = [Gate::Precedence, Gate::Level][rng.index(2)],
            2 => new.reassign = [Reassign::Never, Reassign::OnDispatch, Reassign::OnChange][rng.index(3)],
            3 => new.merge_skew = rng.chance(50).then(|| Duration::from_micros(rng.within(0, 5_000))),
            4 => new.frame_cache = rng.chance(50),
            5 => new.shed = [Shed::Never, Shed::LowestUrgency, Shed::Hopeless][rng.index(3)],
            6 => new.late = [Late::Continue, Late::AbortJob][rng.index(2)],
            7 => new.best_case = [BestCase::Observed, BestCase::Declared][rng.index(2)],
            8 => new.admission = [Admission::Report, Admission::Enforce][rng.index(2)],
            // Just enough for an encoder and a decoder.
            12 => new.memory = Some(Bytes(40 << 20)),
            9 => new.overload.utilisation.0 = rng.within(100_000, 1_000_000) as u32,
            _ => (new.overload.queue, new.overload.ticks) = (rng.within(0, 8) as u16, rng.within(0, 4) as u8),
        }
    }
    new
}

fn fate(rng: &mut Rng) -> Fate {
    let percent = if rng.chance(5) { rng.within(100, 250) } else { rng.within(30, 100) };
    let how = match rng.within(0, 99) {
        0..3 => How::Fail,
        3..40 => How::CompleteAndPoll,
        40..60 => How::PollOn,
        _ => How::Complete,
    };
    Fate { percent, how, repeats: rng.chance(3) }
}

struct Drawing<'a> {
    rng: &'a mut Rng,
    common: &'a Common,
    events: Vec<(u64, Event)>,
}

impl Drawing<'_> {
    /// A task, which is admitted at the start, and its releases.
    fn task(&mut self, task: usize, load: u64) -> Task {
        let mut steps = Vec::new();
        let (dag, terms, arrival) =
            workload::task(self.common, load, self.rng, &mut |step| steps.push(step.into()));
        // What the graph has to refuse.
        if self.rng.chance(30) {
            let nodes = dag.len() as u64 + 2;
            let mut some = || self.rng.within(0, nodes) as u8;
            steps.extend([Step::Edge(some(), some()), Step::Cut(some(), some()), Step::Remove(nodes as u8)]);
        }
        self.events.push((0, Event::Admit(task)));
        self.releases(task, arrival);
        Task { terms, steps }
    }

    fn releases(&mut self, task: usize, Arrival { offset_ns, period_ns }: Arrival) {
        let mut now = offset_ns;
        while now < HORIZON_NS {
            let capture = self.rng.chance(20).then_some(now / 2_000_000);
            // Now and then the host learns of a release late.
            let late_ns = if self.rng.chance(10) { self.rng.within(0, now.min(300_000)) } else { 0 };
            self.events.push((now, Event::Release { task, at_ns: now - late_ns, capture }));
            now += period_ns;
        }
    }

    fn happenings(&mut self, tasks: usize) {
        self.edits(tasks);
        for _ in 0..self.rng.within(0, 4) {
            let back = self.rng.within(1, 100_000);
            self.at(|_| Event::Back(back));
            self.at(|_| Event::Take);
        }
        if self.rng.chance(30) {
            self.at(|rng| Event::Stray { unit: rng.bits(), task: rng.bits() as u32 });
            self.at(|rng| Event::Stray { unit: rng.within(0, 1 << 20), task: rng.within(0, 3) as u32 });
        }
        if self.rng.chance(25) {
            let task = self.rng.index(tasks);
            let now = self.at(|_| Event::Remove(task));
            let later = now + self.rng.within(0, 2_000_000);
            self.events.push((later, Event::Admit(task)));
        }
        if self.rng.chance(15) {
            // More than there is room for.
            let task = self.rng.index(tasks);
            let at_ns = self.rng.within(0, HORIZON_NS - 1);
            let release = Event::Release { task, at_ns, capture: None };
            self.events.extend((0..self.rng.within(10, 40)).map(|_| (at_ns, release.clone())));
        }
        if self.rng.chance(30) {
            self.at(|rng| Event::Retire(rng.within(0, 4) as u8));
            self.at(|rng| Event::Retire(rng.within(0, 4) as u8));
            self.at(|rng| Event::Restore(rng.within(0, 4) as u8));
            // In the end all lanes are there, so that everything ends.
            self.events.extend((0..9).map(|lane| (HORIZON_NS, Event::Restore(lane))));
        }
    }

    /// Edits that follow one another, and two at once, of which the second is refused.
    fn edits(&mut self, tasks: usize) {
        for _ in 0..self.rng.within(0, 5) {
            let task = self.rng.index(tasks);
            let two = self.rng.chance(30);
            let now = self.at(|_| Event::Begin { place: 0, task });
            self.changes(now, 0);
            if two {
                self.events.push((now, Event::Begin { place: 1, task }));
                self.changes(now, 1);
            }
            let later = now + if self.rng.chance(50) { 0 } else { self.rng.within(0, 1_000_000) };
            let drops = self.rng.chance(10);
            self.events.push((later, if drops { Event::Drop(0) } else { Event::Commit(0) }));
            if two {
                self.events.push((later, Event::Commit(1)));
            }
        }
    }

    fn changes(&mut self, now: u64, place: usize) {
        for _ in 0..self.rng.within(1, 4) {
            let mut some = || self.rng.within(0, 9) as u8;
            let (from, to) = (some(), some());
            let step = match some() {
                0..=3 => Step::Node(workload::plain(self.common, self.rng)),
                4 | 5 => Step::Edge(from, to),
                6 => Step::Remove(from),
                7 => Step::Cut(from, to),
                8 => self.stage(from),
                _ => Step::Node(Node::new(Wcet::from_nanos(u64::MAX >> 1))),
            };
            self.events.push((now, Event::Change { place, step }));
        }
    }

    /// A new encoder, whose sensor may not be there; or a graph refined in the middle of an edit, which makes it another.
    fn stage(&mut self, stage: u8) -> Step {
        let sensor = self.rng.chance(30).then(|| SensorId::new(self.rng.within(0, 3) as u8));
        let plain = workload::plain(self.common, self.rng);
        let frame = Frame { weights: self.rng.within(0, 1) as u16, frame: 0, sensor };
        let encoder = Node::shared_encoder(plain.wcet(), frame).in_pool(plain.pool()).memory(Bytes(1 << 20));
        if self.rng.chance(50) {
            return Step::Node(encoder);
        }
        let decoders =
            (0..self.rng.within(0, 2)).map(|_| Node::decoder(plain.wcet()).in_pool(plain.pool())).collect();
        Step::Refine(stage, encoder, decoders)
    }

    /// Somewhen; when.
    fn at(&mut self, event: impl FnOnce(&mut Rng) -> Event) -> u64 {
        let now = self.rng.within(0, HORIZON_NS - 1);
        let event = event(self.rng);
        self.events.push((now, event));
        now
    }
}

impl From<workload::Step<'_>> for Step {
    fn from(step: workload::Step<'_>) -> Self {
        match step {
            workload::Step::Node(node) => Self::Node(node),
            workload::Step::Edge(from, to) => Self::Edge(from.index() as u8, to.index() as u8),
            workload::Step::Refine(stage, encoder, decoders) => {
                Self::Refine(stage.index() as u8, encoder, decoders.to_vec())
            }
            workload::Step::Replace(place, by) => Self::Replace(place.index() as u8, by),
        }
    }
}
