//! Files that ask more of the lanes than they can do, and what happens to them.

use red_sim::{Execution, Options, Report, World, simulate_in};
use red_tests::rng::Rng;
use red_workload::build::Numbered;
use red_workload::metrics::TaskMetrics;
use red_workload::model::Workload;
use red_workload::policy::Policy;
use red_workload::{Format, parse};
use std::fmt::Write;

/// How long nodes take: all of their WCET, anything from half of it on, or half of it and one time in five all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Times {
    Wcet,
    Uniform,
    Bimodal,
}

impl Times {
    pub(crate) const ALL: [Self; 3] = [Self::Wcet, Self::Uniform, Self::Bimodal];

    pub(crate) const fn mean_percent(self) -> u64 {
        match self {
            Self::Wcet => 100,
            Self::Uniform => 75,
            Self::Bimodal => 60,
        }
    }

    fn draw(self, wcet_ns: u64, rng: &mut Rng) -> u64 {
        match self {
            Self::Wcet => wcet_ns,
            Self::Uniform => rng.within(wcet_ns / 2, wcet_ns),
            Self::Bimodal => wcet_ns / if rng.chance(20) { 1 } else { 2 },
        }
    }
}

#[derive(Clone, Debug)]
pub(crate) struct Task {
    pub(crate) name: String,
    pub(crate) value: u32,
    pub(crate) floor: Option<(u32, u32)>,
    pub(crate) period_ns: u64,
    pub(crate) deadline_ns: u64,
    /// Of each node: WCET, and those that it waits for.
    pub(crate) nodes: Vec<(u64, Vec<usize>)>,
    /// Its jobs come later than their period says by less than a tenth of it.
    pub(crate) jitter: bool,
    pub(crate) seed: u64,
    /// It releases nothing later than this.
    pub(crate) until_ns: u64,
}

/// What a set is to be like.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wish {
    pub(crate) tasks: (u64, u64),
    pub(crate) lanes: u64,
    /// Mean work over lanes.
    pub(crate) load_percent: u64,
    pub(crate) times: Times,
    pub(crate) values: &'static [u32],
    pub(crate) floors: bool,
}

#[derive(Clone, Debug)]
pub(crate) struct Set {
    pub(crate) lanes: u64,
    pub(crate) times: Times,
    pub(crate) tasks: Vec<Task>,
}

impl Task {
    pub(crate) fn work_ns(&self) -> u64 {
        self.nodes.iter().map(|node| node.0).sum()
    }

    /// The longest path.
    pub(crate) fn path_ns(&self) -> u64 {
        let mut ends = Vec::new();
        for (wcet, after) in &self.nodes {
            let start: u64 = after.iter().map(|node| ends[*node]).max().unwrap_or(0);
            ends.push(start + wcet);
        }
        ends.into_iter().max().unwrap_or(0)
    }

    pub(crate) fn longest_node_ns(&self) -> u64 {
        self.nodes.iter().map(|node| node.0).max().unwrap_or(0)
    }
}

/// A chain, or a first and a last node with all others side by side between them.
pub(crate) fn nodes(rng: &mut Rng) -> Vec<(u64, Vec<usize>)> {
    let count = rng.within(1, 7) as usize;
    let is_chain = rng.chance(50);
    let after = |nth: usize| match nth {
        0 => vec![],
        _ if is_chain => vec![nth - 1],
        _ if nth + 1 == count && count > 2 => (1..nth).collect(),
        _ => vec![0],
    };
    (0..count).map(|nth| (rng.within(1_000_000, 12_000_000), after(nth))).collect()
}

impl Set {
    pub(crate) fn draw(seed: u64, wish: Wish) -> Self {
        let rng = &mut Rng::new(seed);
        let count = rng.within(wish.tasks.0, wish.tasks.1);
        let shares: Vec<u64> = (0..count).map(|_| rng.within(100, 1_000)).collect();
        let all: u64 = shares.iter().sum();
        let task = |(nth, share): (usize, &u64)| {
            let value = wish.values[rng.within(0, wish.values.len() as u64 - 1) as usize];
            let k = rng.within(2, 5) as u32;
            let floor = (wish.floors && rng.chance(50)).then(|| (rng.within(1, u64::from(k) - 1) as u32, k));
            let mut task = Task {
                name: format!("t{nth}"),
                value,
                floor,
                nodes: nodes(rng),
                period_ns: 0,
                deadline_ns: 0,
                jitter: rng.chance(50),
                seed: rng.bits(),
                until_ns: u64::MAX,
            };
            let mean = task.work_ns() * wish.times.mean_percent() / 100;
            task.period_ns = mean * all * 100 / (share * wish.lanes * wish.load_percent);
            let alone = task.path_ns().max(task.work_ns().div_ceil(wish.lanes));
            task.deadline_ns = alone + task.period_ns.max(alone) * rng.within(25, 100) / 100;
            task
        };
        let tasks = shares.iter().enumerate().map(task).collect();
        Self { lanes: wish.lanes, times: wish.times, tasks }
    }

    /// Tasks chosen by value, with deadlines that are shorter; `None` where one has no time left.
    pub(crate) fn part(&self, is_in: impl Fn(&Task) -> bool, shorter_ns: u64) -> Option<Self> {
        let mut part = self.clone();
        part.tasks.retain(is_in);
        for task in &mut part.tasks {
            task.deadline_ns = task.deadline_ns.checked_sub(shorter_ns).filter(|left| *left > 0)?;
        }
        Some(part)
    }

    /// The workload file.
    pub(crate) fn file(&self) -> String {
        let mut text = format!("[[pool]]\nname = \"cpu\"\nlanes = {}\n", self.lanes);
        for Task { name, value, floor, period_ns, deadline_ns, nodes, .. } in &self.tasks {
            let _infallible = writeln!(
                text,
                "[[task]]\nname = \"{name}\"\nvalue = {value}\nperiod = \"{period_ns}ns\"\ndeadline = \"{deadline_ns}ns\""
            );
            if let Some((m, k)) = floor {
                let _infallible = writeln!(text, "floor = [{m}, {k}]");
            }
            for (nth, (wcet, after)) in nodes.iter().enumerate() {
                let after: Vec<String> = after.iter().map(|node| format!("\"n{node}\"")).collect();
                let bcet = if self.times == Times::Wcet { *wcet } else { wcet / 2 };
                let _infallible = writeln!(
                    text,
                    "[[task.node]]\nname = \"n{nth}\"\nwcet = \"{wcet}ns\"\nbcet = \"{bcet}ns\"\nafter = [{}]",
                    after.join(", ")
                );
            }
        }
        text
    }

    pub(crate) fn workload(&self) -> Workload {
        let file = self.file();
        parse(file.as_bytes(), Format::Toml, "set.toml").unwrap_or_else(|e| panic!("{e}\n{file}"))
    }

    /// What a policy makes of it, by task.
    pub(crate) fn run(&self, policy: Policy, horizon_ns: u64) -> Report {
        let workload = self.workload();
        let options = Options {
            policy,
            horizon_ns,
            seed: 1,
            execution: Execution::Wcet,
            preempt: false,
            schedule: false,
        };
        simulate_in(self, &workload, policy.config(), &options).expect("it fits")
    }

    /// Jobs on time of those that were due, by task name.
    pub(crate) fn on_time(&self, policy: Policy, horizon_ns: u64) -> Vec<(String, u64, u64)> {
        let due = |task: &TaskMetrics| (task.name.clone(), task.on_time, task.on_time + task.missed);
        self.run(policy, horizon_ns).tasks.iter().map(due).collect()
    }
}

impl World for Set {
    fn release(&self, task: usize, job: usize) -> Option<u64> {
        let task = &self.tasks[task];
        let late = Rng::new(task.seed ^ job as u64).within(0, task.period_ns / 10);
        let first = Rng::new(task.seed).within(0, task.period_ns);
        let at = first + job as u64 * task.period_ns + if task.jitter { late } else { 0 };
        (at <= task.until_ns).then_some(at)
    }

    fn time(&self, task: usize, job: u64, node: &Numbered) -> (u64, bool) {
        let task = &self.tasks[task];
        let nth = node.name.trim_start_matches('n').parse::<usize>().expect("nodes are numbered");
        let seed = task.seed.wrapping_mul(31).wrapping_add(job).wrapping_mul(31).wrapping_add(nth as u64);
        (self.times.draw(task.nodes[nth].0, &mut Rng::new(seed)), true)
    }
}
