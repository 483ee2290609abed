//! Which single change would have saved the jobs that missed: each is simulated once, over the whole recorded past, and every
//! miss is looked up in what came of it. What changes least comes first, so the first that saves a job is the smallest.

use super::worlds::{Changed, Otherwise};
use crate::replay::figures::Figures;
use crate::table::time;
use red_core::Config;
use red_report::model::{Kind, Miss, Run, Tried};
use red_sim::{Execution, Options, Report, World, simulate_in};
use red_workload::model::{Arrival, Part, Work, Workload};
use red_workload::policy::Policy;
use std::cmp::Reverse;
use std::collections::{BTreeMap, HashSet};

/// Executions that all simulations together have at most: about ten seconds.
const MOST: usize = 12_000_000;
/// So many of a kind are tried: the worst nodes, tasks and pools.
const EACH: usize = 3;
/// Deadlines longer by so many percent.
const LITTLE_LONGER: [u64; 3] = [5, 10, 25];
const MUCH_LONGER: [u64; 2] = [50, 100];
/// Lanes of all pools at most.
const LANES: u32 = red_workload::model::MAX_LANES;

/// What was recorded.
pub(super) struct Recorded<'a> {
    pub(super) workload: &'a Workload,
    pub(super) policy: Policy,
    pub(super) figures: &'a Figures,
    /// Until when this workload is simulated.
    pub(super) horizon_ns: &'a dyn Fn(&Workload) -> u64,
}

/// One change.
struct Trial {
    words: String,
    workload: Workload,
    config: Config,
    otherwise: Otherwise,
}

/// Tries changes, and notes for each miss the first that saves it. `goes_on` may end that early.
pub(super) fn find(run: &mut Run, recorded: &Recorded<'_>, goes_on: impl Fn() -> bool) {
    if run.misses.is_empty() {
        return;
    }
    let trials = trials(run, recorded);
    let affordable = MOST / run.slices.len().max(1);
    let (all, mut done) = (trials.len(), 0);
    for trial in trials.into_iter().take(affordable) {
        if recorded.figures.past.is_cut() || !goes_on() {
            break;
        }
        done += 1;
        // What the executive has no room for is no change to propose.
        let Some(report) = simulated(&trial, recorded) else { continue };
        note(run, &trial, &report);
    }
    run.tried_note = "The recorded releases and execution times in virtual time, with one thing otherwise; a change counts as smaller \
                      the earlier it comes in the list. A machine's own delays are not in virtual time."
        .to_owned();
    if done < all {
        let more = format!(" Of {all} changes {done} were tried: the run is too long for more.");
        run.tried_note.push_str(&more);
    }
}

fn simulated(trial: &Trial, recorded: &Recorded<'_>) -> Option<Report> {
    let world = Changed { past: &recorded.figures.past, otherwise: trial.otherwise.clone() };
    let options = Options {
        policy: recorded.policy,
        horizon_ns: (recorded.horizon_ns)(&trial.workload),
        seed: 0,
        execution: Execution::Wcet,
        preempt: false,
        schedule: false,
    };
    simulate_in(&world as &dyn World, &trial.workload, trial.config, &options).ok()
}

fn note(run: &mut Run, trial: &Trial, report: &Report) {
    let number = run.tried.len();
    // Jobs of a task that releases fewer have other numbers.
    let other = [trial.otherwise.halved, trial.otherwise.without];
    let is_saved = |miss: &Miss| {
        let job = report.jobs.get(miss.task).and_then(|jobs| jobs.get(usize::try_from(miss.job).ok()?));
        let on_time =
            job.is_some_and(|job| job.shed.is_none() && job.at_ns.is_some_and(|at| at <= job.deadline_ns));
        on_time && !other.contains(&Some(miss.task))
    };
    let mut saves = 0;
    for miss in run.misses.iter_mut().filter(|miss| is_saved(miss)) {
        saves += 1;
        miss.saved_by.get_or_insert(number);
    }
    for group in &mut run.groups {
        let saved = group.misses.iter().filter(|miss| is_saved(&run.misses[**miss])).count();
        if group.best.is_none() && saved * 2 > group.misses.len() {
            group.best = Some((number, saved));
        }
    }
    run.tried.push(Tried {
        change: trial.words.clone(),
        on_time: report.tasks.iter().map(|task| task.on_time).sum(),
        missed: report.tasks.iter().map(|task| task.missed).sum(),
        saves,
    });
}

/// The list of changes, what changes least first.
fn trials(run: &Run, recorded: &Recorded<'_>) -> Vec<Trial> {
    let Recorded { policy, .. } = *recorded;
    // A run has no grid.
    let workload = Workload { sync: None, ..recorded.workload.clone() };
    let config = policy.config();
    let plain =
        |words: String| Trial { words, workload: workload.clone(), config, otherwise: Otherwise::default() };
    let mut trials = vec![plain("nothing: without the machine's own delays it was on time".to_owned())];
    for (task, node, wcet_ns) in overrunning(run) {
        let name = run.node(task, node);
        let mut trial =
            plain(format!("{} of {} never beyond its WCET of {}", name, run.task(task), time(Some(wcet_ns))));
        trial.otherwise.capped = Some((task, name, wcet_ns));
        trials.push(trial);
    }
    if !config.frame_cache && has_stages(&workload) {
        let ours = Config::REDRT;
        let shared = Config { refine: true, merge_skew: ours.merge_skew, frame_cache: true, ..config };
        trials.push(Trial {
            config: shared,
            ..plain(format!("encoders shared, all else as under {}", policy.name()))
        });
    }
    if policy != Policy::Redrt {
        trials.push(Trial { config: Policy::Redrt.config(), ..plain("policy redrt".to_owned()) });
    }
    let missing: Vec<usize> = worst(run.misses.iter().map(|miss| (miss.task, 1)));
    let longer = |trials: &mut Vec<Trial>, percents: &[u64]| {
        for (percent, task) in
            percents.iter().flat_map(|percent| missing.iter().map(move |task| (*percent, *task)))
        {
            let mut trial = plain(String::new());
            let deadline = &mut trial.workload.tasks[task].deadline_ns;
            *deadline =
                u64::try_from(u128::from(*deadline) * u128::from(100 + percent) / 100).unwrap_or(*deadline);
            trial.words =
                format!("deadline of {} longer by {percent} %: {}", run.task(task), time(Some(*deadline)));
            trials.push(trial);
        }
    };
    longer(&mut trials, &LITTLE_LONGER);
    let blockers = blockers(run);
    let nodes = blockers.iter().map(|((task, node), ns)| ((*task, *node), *ns));
    for (task, node) in worst(nodes) {
        trials.extend(split(&workload, task, &run.node(task, node)).map(|(workload, otherwise)| Trial {
            workload,
            otherwise,
            ..plain(format!("{} of {} in two halves", run.node(task, node), run.task(task)))
        }));
    }
    let tasks = worst(blockers.iter().map(|((task, _), ns)| (*task, *ns)));
    for task in tasks.iter().filter(|task| !matches!(workload.tasks[**task].arrival, Arrival::Once)) {
        let mut trial = plain(format!("every second job of {} only", run.task(*task)));
        trial.otherwise.halved = Some(*task);
        trials.push(trial);
    }
    if workload.pools.iter().map(|pool| pool.lanes).sum::<u32>() < LANES {
        for pool in 0..workload.pools.len().min(EACH) {
            let mut trial = plain(String::new());
            trial.workload.pools[pool].lanes += 1;
            trial.words = format!("one lane more in pool {}", workload.pools[pool].name);
            trials.push(trial);
        }
    }
    longer(&mut trials, &MUCH_LONGER);
    for task in tasks {
        let mut trial = plain(format!("without {}", run.task(task)));
        trial.otherwise.without = Some(task);
        trials.push(trial);
    }
    trials
}

/// Those with the largest sums.
fn worst<K: Ord + Copy>(costs: impl Iterator<Item = (K, u64)>) -> Vec<K> {
    let mut sums: BTreeMap<K, u64> = BTreeMap::new();
    costs.for_each(|(key, cost)| *sums.entry(key).or_default() += cost);
    let mut keys: Vec<(K, u64)> = sums.into_iter().collect();
    keys.sort_by_key(|(_, cost)| Reverse(*cost));
    keys.into_iter().take(EACH).map(|(key, _)| key).collect()
}

/// Nodes whose overruns cost the misses most, and their WCETs.
fn overrunning(run: &Run) -> Vec<(usize, usize, u64)> {
    let missed: HashSet<(usize, u64)> = run.misses.iter().map(|miss| (miss.task, miss.job)).collect();
    let wcet_ns =
        |task, job, node: usize| Some(run.graphs.get(run.job(task, job)?.graph)?.nodes.get(&node)?.wcet_ns);
    let named = run.misses.iter().flat_map(|miss| &miss.parts).filter_map(|part| part.by);
    let involved: HashSet<_> = named.collect();
    let overruns = run.slices.iter().filter_map(|slice| {
        let (task, job, node) = slice.of;
        let is_involved = missed.contains(&(task, job)) || involved.contains(&slice.of);
        let wcet_ns = wcet_ns(task, job, node).filter(|_| is_involved)?;
        let over_ns = (slice.end_ns - slice.start_ns).saturating_sub(wcet_ns);
        (over_ns > 0).then_some(((task, node, wcet_ns), over_ns))
    });
    worst(overruns)
}

/// How long nodes of other tasks had the lanes that misses waited for.
fn blockers(run: &Run) -> Vec<((usize, usize), u64)> {
    let parts = run.misses.iter().flat_map(|miss| miss.parts.iter().map(move |part| (miss.task, part)));
    let waits = parts.filter(|(_, part)| part.kind == Kind::Lane);
    waits
        .filter_map(|(own, part)| {
            part.by.filter(|(task, ..)| *task != own).map(|(task, _, node)| ((task, node), part.ns()))
        })
        .collect()
}

fn has_stages(workload: &Workload) -> bool {
    let added = workload.events.iter().flat_map(|event| &event.add);
    workload
        .tasks
        .iter()
        .flat_map(|task| &task.nodes)
        .chain(added)
        .any(|node| matches!(node.work, Work::Stage(_)))
}

/// The workload with a plain node of a task in two halves; not of one that is indivisible or comes by an event.
fn split(workload: &Workload, task: usize, name: &str) -> Option<(Workload, Otherwise)> {
    let mut workload = workload.clone();
    let nodes = &mut workload.tasks.get_mut(task)?.nodes;
    let place = nodes.iter().position(|node| node.name == name)?;
    let Work::Plain(part) = &nodes[place].work else { return None };
    if part.atomic || part.wcet_ns < 2 {
        return None;
    }
    let half = |ns: u64| Part { wcet_ns: ns, bcet_ns: part.bcet_ns / 2, ..part.clone() };
    let (one, other) = (half(part.wcet_ns.div_ceil(2)), half(part.wcet_ns / 2));
    // No name of a file has a dot.
    let first_name = format!("{name}.1");
    let mut first = nodes[place].clone();
    first.name.clone_from(&first_name);
    first.work = Work::Plain(one);
    nodes[place].after = vec![first_name.clone()];
    nodes[place].work = Work::Plain(other);
    nodes.push(first);
    Some((workload, Otherwise { split: Some((task, first_name, name.to_owned())), ..Otherwise::default() }))
}
