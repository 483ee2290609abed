//! Who loses to whom and why, in one sentence a task.

use super::super::evidence::period_ns;
use super::losses::Losses;
use crate::outcome::Failure;
use red_core::Duration;
use red_sim::{Lab, Options, simulate};
use red_workload::model::{Event, Task, Work, Workload};
use red_workload::plan::{Plan, set};
use std::collections::HashSet;

/// All lanes all the time, in millionths.
const WHOLE_PPM: u128 = 1_000_000;

/// What each task asks of each pool: the most of all its graphs.
pub(super) struct Asked {
    /// By task and pool, millionths of a lane; nothing where it has no node. What comes once asks for none.
    load_ppm: Vec<Vec<Option<u128>>>,
    /// By task: the longest path of any of its graphs, its longest node, and the longest that ran.
    longest_ns: Vec<u64>,
    node_ns: Vec<u64>,
    ran_ns: Vec<u64>,
}

impl Asked {
    /// `losses` are of the simulations that showed them: what never ran there stands in nobody's way.
    pub(super) fn of(workload: &Workload, plan: &Plan, losses: [&[Losses]; 2]) -> Self {
        let pools = workload.pools.len();
        // What could be planned has a set; without one nothing is said of load.
        let set = set::<Lab>(workload).unwrap_or_default();
        let mut load_ppm = vec![vec![None; pools]; workload.tasks.len()];
        for ((load, task), planned) in load_ppm.iter_mut().zip(&workload.tasks).zip(&set.tasks) {
            let period_ns = period_ns(task.arrival);
            for graph in &planned.versions {
                for (pool, most) in load.iter_mut().enumerate() {
                    let here = graph.nodes.iter().filter(|node| node.cluster == pool);
                    let work = here.map(|node| u128::from(node.cost_ns)).reduce(|sum, cost| sum + cost);
                    let asked = |work: u128| {
                        period_ns.map_or(0, |period_ns| (work * WHOLE_PPM).div_ceil(period_ns.into()))
                    };
                    *most = (*most).max(work.map(asked));
                }
            }
        }
        let longest = |task: &red_workload::plan::TaskPlan| {
            let certificate = &task.certificate;
            let proofs = [&certificate.base].into_iter().chain(&certificate.changes);
            proofs.map(|proof| proof.critical_path_ns).max().unwrap_or(0)
        };
        let node_ns = set.tasks.iter().map(|planned| {
            let nodes = planned.versions.iter().flat_map(|graph| &graph.nodes);
            nodes.map(|node| node.cost_ns).max().unwrap_or(0)
        });
        let ran =
            |task| losses.iter().filter_map(|tasks| tasks.get(task)).map(|task: &Losses| task.ran_ns).max();
        Self {
            load_ppm,
            longest_ns: plan.tasks.iter().map(longest).collect(),
            node_ns: node_ns.collect(),
            ran_ns: (0..workload.tasks.len()).map(|task| ran(task).unwrap_or(0)).collect(),
        }
    }

    fn uses(&self, task: usize, pool: usize) -> bool {
        self.load_ppm[task][pool].is_some()
    }

    fn meet(&self, one: usize, other: usize) -> bool {
        one != other
            && (0..self.load_ppm[one].len()).any(|pool| self.uses(one, pool) && self.uses(other, pool))
    }

    /// The pool of a task that these tasks ask most of: its index, and millionths of its lanes.
    fn busiest(&self, workload: &Workload, task: usize, of: impl Fn(usize) -> bool) -> Option<(usize, u128)> {
        let share = |pool: usize| {
            let asked: u128 =
                (0..self.load_ppm.len()).filter(|i| of(*i)).filter_map(|i| self.load_ppm[i][pool]).sum();
            (pool, asked.div_ceil(workload.pools[pool].lanes.into()))
        };
        let pools = (0..workload.pools.len()).filter(|pool| self.uses(task, *pool));
        pools.map(share).max_by_key(|(_, ppm)| *ppm)
    }
}

/// Why a task loses what it loses; `options` are those of the simulation that showed it. `between` is what it loses where times vary.
pub(super) fn of(
    workload: &Workload,
    asked: &Asked,
    options: &Options,
    task: usize,
    losses: &Losses,
    between: Option<&Losses>,
) -> Result<String, Failure> {
    let mut head = format!("task `{}` loses {} of {} jobs", losses.name, losses.lost(), losses.released);
    if losses.lost() == 0 {
        let Some(between) = between.filter(|between| between.lost() > 0) else { return Ok(head) };
        head += &format!(", and {} where times vary", between.lost());
    } else {
        let (alone, keeps_floor) = lost_among(workload, options, task, |other| other == task)?;
        if alone >= losses.lost() {
            let cause = by_itself(workload, asked, task, losses);
            let floor = if keeps_floor { "" } else { " and its floor would break" };
            return Ok(format!("{head}: even alone it would lose {alone}{floor}, for {cause}"));
        }
        if alone > 0 {
            let floor = if keeps_floor { "" } else { ", where its floor breaks too" };
            head += &format!(", {alone} of them even alone{floor}");
        }
    }
    let mut sentence = format!("{head}: {}", rank(workload, asked, task));
    if let Some((pool, ppm)) = asked.busiest(workload, task, |_| true) {
        let (name, lanes) = (&workload.pools[pool].name, lanes(workload, pool, ppm));
        sentence += &if ppm > WHOLE_PPM {
            format!("; pool `{name}` is asked for {lanes}")
        } else {
            format!("; pool `{name}` is asked for only {lanes}, but deadlines are too short to wait for all")
        };
        if shares_an_encoder(workload, pool) {
            sentence += ", where an encoder that tasks share counts for each of them";
        }
    }
    let tasks = &workload.tasks;
    let is_below = |other: usize| tasks[other].value < tasks[task].value && tasks[other].floor.is_none();
    if losses.lost() > 0 && (0..tasks.len()).any(is_below) {
        let (without, _) = lost_among(workload, options, task, |other| !is_below(other))?;
        // One job in a hundred is as it happens.
        if losses.lost() - losses.lost().min(without) > losses.released / 100 {
            let below = (0..tasks.len()).filter(|other| is_below(*other) && asked.meet(task, *other));
            let below: Vec<&Task> = below.map(|other| &tasks[other]).collect();
            sentence += &format!("; without the tasks of lower value it would lose {without}");
            if !below.is_empty() {
                sentence += &format!("; these are {}", names(&below));
            }
        }
    }
    Ok(sentence)
}

/// Whether tasks have an encoder of a pool in common, by its weights and frame. A frame of no sensor is of each job its own.
fn shares_an_encoder(workload: &Workload, pool: usize) -> bool {
    let is_captured = |frame: &str| workload.sensors.iter().any(|sensor| sensor.name == frame);
    let encoders = |task: &Task| -> HashSet<(String, String)> {
        let stages = task.nodes.iter().filter_map(|node| match &node.work {
            Work::Stage(stage) if stage.encoder.pool == pool && is_captured(&stage.frame) => {
                Some((stage.weights.clone(), stage.frame.clone()))
            }
            Work::Stage(_) | Work::Plain(_) => None,
        });
        stages.collect()
    };
    let mut seen = HashSet::new();
    workload.tasks.iter().flat_map(encoders).any(|encoder| !seen.insert(encoder))
}

/// What a task loses in a simulation of some of the tasks, of which it is one, and whether its floor holds there, if it has one.
fn lost_among(
    workload: &Workload,
    options: &Options,
    task: usize,
    is_there: impl Fn(usize) -> bool,
) -> Result<(u64, bool), Failure> {
    let place = |task: usize| (0..task).filter(|before| is_there(*before)).count();
    let there = (0..workload.tasks.len()).filter(|task| is_there(*task));
    let events = workload.events.iter().filter(|event| is_there(event.task));
    let some = Workload {
        tasks: there.map(|task| workload.tasks[task].clone()).collect(),
        events: events.map(|event| Event { task: place(event.task), ..event.clone() }).collect(),
        ..workload.clone()
    };
    let report = simulate(&some, options)?;
    let found = report.tasks.get(place(task));
    Ok(found.map_or((0, true), |task| (task.missed, task.floor.is_none_or(|floor| floor.kept))))
}

fn by_itself(workload: &Workload, asked: &Asked, task: usize, losses: &Losses) -> String {
    let (longest_ns, deadline_ns) = (asked.longest_ns[task], workload.tasks[task].deadline_ns);
    let [longest, deadline] = [longest_ns, deadline_ns].map(Duration::from_nanos);
    if longest_ns > deadline_ns {
        return format!(
            "its longest path of {longest} at WCET exceeds its deadline of {deadline}; only shorter runs are in time"
        );
    }
    match asked.busiest(workload, task, |other| other == task).filter(|(_, ppm)| *ppm > WHOLE_PPM) {
        Some((pool, ppm)) => {
            let load =
                format!("it asks for {} of pool `{}`", lanes(workload, pool, ppm), workload.pools[pool].name);
            // More than that by one in twenty.
            let too_many = (u128::from(losses.released) * (ppm - WHOLE_PPM)).div_ceil(ppm);
            if 20 * u128::from(losses.lost()) <= 21 * too_many {
                return load;
            }
            format!(
                "{load}, which costs {too_many}, and its deadline of {deadline} is too near its longest path of {longest} to use all of the lanes"
            )
        }
        None => "its deadline is too short for its work on these lanes".to_owned(),
    }
}

/// Whom it loses to.
fn rank(workload: &Workload, asked: &Asked, task: usize) -> String {
    let value = workload.tasks[task].value;
    let rivals =
        || (0..workload.tasks.len()).filter(|other| asked.meet(task, *other)).map(|i| &workload.tasks[i]);
    // Jobs of which none may be lost stand as high as those of any floor, and then their value decides.
    let is_always_owed = |task: &Task| task.floor.is_some_and(|(m, k)| m == k);
    let own = &workload.tasks[task];
    let is_all = is_always_owed(own);
    let has_floor = |task: &Task| task.floor.is_some_and(|(m, _)| m > 0);
    let is_dearer = |other: &Task| other.value > value && (!is_all || has_floor(other));
    let is_first = |other: &Task| is_dearer(other) || !is_all && is_always_owed(other);
    let is_owed = |other: &Task| {
        let is_other = other.value < value || !has_floor(own) || is_always_owed(other);
        has_floor(other) && !is_all && other.value <= value && is_other
    };
    let is_equal = |other: &Task| other.value == value && !is_owed(other) && is_all == is_always_owed(other);
    let above: Vec<&Task> = rivals().filter(|other| is_dearer(other)).collect();
    let equal: Vec<&Task> = rivals().filter(|other| is_equal(other)).collect();
    let floors: Vec<&Task> = rivals().filter(|other| is_owed(other)).collect();
    let slack_ns = |task: usize| workload.tasks[task].deadline_ns.saturating_sub(asked.longest_ns[task]);
    let node_ns = |task: usize| asked.node_ns.get(task).copied().unwrap_or(0);
    let others = |is_one: &dyn Fn(usize) -> bool| -> Vec<&Task> {
        let those = (0..workload.tasks.len()).filter(|other| asked.meet(task, *other) && is_one(*other));
        those.map(|other| &workload.tasks[other]).collect()
    };
    let blocking = others(&|other| {
        let rival = &workload.tasks[other];
        !is_first(rival) && !is_equal(rival) && asked.ran_ns[other] > slack_ns(task)
    });
    // One of these may be late only because another one is behind the node, too.
    let first = (0..workload.tasks.len())
        .filter(|other| asked.meet(task, *other) && is_first(&workload.tasks[*other]));
    let together_ns: u64 = first.map(|other| asked.longest_ns[other]).sum();
    let awaited = others(&|other| {
        let rival = &workload.tasks[other];
        let behind_ns = node_ns(task) + together_ns.saturating_sub(asked.longest_ns[other]);
        is_first(rival) && period_ns(rival.arrival).is_some() && behind_ns > slack_ns(other)
    });
    let is_limited = workload.pools.iter().any(|pool| pool.memory_bytes.is_some());
    let (its, held) = if is_limited {
        ("its lane and its memory", "the lanes and the memory that they hold")
    } else {
        ("its lane", "the lanes that they hold")
    };
    let mut parts = Vec::new();
    if !above.is_empty() {
        parts.push(format!("its value {value} is below that of {}", names(&above)));
    }
    if !awaited.is_empty() {
        parts.push(format!(
            "its longest node of {} does not start where a job to come of {} would be late behind it",
            Duration::from_nanos(node_ns(task)),
            names(&awaited)
        ));
    }
    if !equal.is_empty() {
        parts.push(format!(
            "its value {value} is also that of {}, and equals share what is left, as far as their nodes fit in it",
            names(&equal)
        ));
    }
    if !floors.is_empty() {
        parts.push(format!("jobs that a floor cannot spare come first, of {}", names(&floors)));
    }
    if !blocking.is_empty() {
        parts.push(format!(
            "a started node keeps {its}, and one of {} takes longer than the {} that it can wait",
            names(&blocking),
            Duration::from_nanos(slack_ns(task))
        ));
    }
    if parts.is_empty() {
        parts.push(format!("nobody ranks above it, but nodes of others keep {held}"));
    }
    parts.join(", and ")
}

/// The first three, with their values.
fn names(tasks: &[&Task]) -> String {
    let shown = tasks.iter().take(3).map(|task| format!("`{}` ({})", task.name, task.value));
    let shown = shown.collect::<Vec<_>>().join(", ");
    match tasks.len().saturating_sub(3) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

/// Such as `133 % of 1 lane`; events may make it less.
fn lanes(workload: &Workload, pool: usize, ppm: u128) -> String {
    let up_to = if workload.events.is_empty() { "" } else { "up to " };
    let percent = (ppm + 5_000) / 10_000;
    // What is too much does not look as if it were just enough.
    let share = if ppm > WHOLE_PPM && percent == 100 {
        "just above 100 %".to_owned()
    } else {
        format!("{percent} %")
    };
    match workload.pools[pool].lanes {
        1 => format!("{up_to}{share} of 1 lane"),
        lanes => format!("{up_to}{share} of {lanes} lanes"),
    }
}
