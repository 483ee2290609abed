//! Federated scheduling (Li, Chen, Agrawal, Lu, Gill, Saifullah: Analysis of federated and global scheduling for parallel
//! real-time tasks, ECRTS 2014): what a proof without a schedule accepts.
//!
//! *Rule.* A task whose work W is more than its D and T allow one lane is heavy, and gets ceil((W - L) / (min(D, T) - L))
//! lanes of its own. The others run as sequences, each on one of the lanes that remain, by first fit, the densest first:
//! the densities W / min(D, T) on a lane add up to at most 1.
//! *Why it holds.* Graham's bound for heavy tasks; EDF on one lane meets all deadlines while densities are at most 1.

use super::sets::Task;

/// Whether a set is proved to meet all deadlines on so many lanes.
#[must_use]
pub(crate) fn is_proved(tasks: &[Task], lanes: u64) -> bool {
    let mut left = lanes;
    let mut densities = Vec::new();
    for task in tasks {
        let (work, window) = (task.graph.work(), task.deadline_ns.min(task.period_ns));
        if work <= window {
            densities.push(work as f64 / window as f64);
            continue;
        }
        let (longest, beside) = (task.graph.longest(), work - task.graph.longest());
        let own = window.checked_sub(longest).filter(|slack| *slack > 0).map(|slack| beside.div_ceil(slack));
        match own.and_then(|own| left.checked_sub(own)) {
            Some(rest) => left = rest,
            None => return false,
        }
    }
    densities.sort_by(|a, b| b.total_cmp(a));
    let mut taken = vec![0.0; left as usize];
    densities.into_iter().all(|density| {
        let lane = taken.iter_mut().find(|taken| **taken + density <= 1.0);
        lane.map(|taken| *taken += density).is_some()
    })
}
