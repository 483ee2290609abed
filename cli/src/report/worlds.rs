//! The recorded past with one thing otherwise.

use red_sim::{Past, World};
use red_workload::build::Numbered;

/// What is otherwise; of all of these one is.
#[derive(Clone, Debug, Default)]
pub(super) struct Otherwise {
    /// A node of a task never takes longer than this.
    pub(super) capped: Option<(usize, String, u64)>,
    /// A task releases every second job only.
    pub(super) halved: Option<usize>,
    /// A task releases none.
    pub(super) without: Option<usize>,
    /// A node of a task is two, each of half its time: the first has this name, the second has kept its own.
    pub(super) split: Option<(usize, String, String)>,
}

/// The past as it was but for that.
pub(super) struct Changed<'a> {
    pub(super) past: &'a Past,
    pub(super) otherwise: Otherwise,
}

impl Changed<'_> {
    /// The number that a job had in the past.
    fn then(&self, task: usize, job: u64) -> u64 {
        if self.otherwise.halved == Some(task) { job.saturating_mul(2) } else { job }
    }
}

impl World for Changed<'_> {
    fn release(&self, task: usize, job: usize) -> Option<u64> {
        if self.otherwise.without == Some(task) {
            return None;
        }
        self.past.release(task, usize::try_from(self.then(task, job as u64)).ok()?)
    }

    fn time(&self, task: usize, job: u64, node: &Numbered) -> (u64, bool) {
        let job = self.then(task, job);
        if let Some((_, first, second)) = self.otherwise.split.as_ref().filter(|(of, ..)| *of == task) {
            let whole =
                || self.past.time(task, job, &Numbered { name: second.clone(), role: node.role.clone() });
            // Together they are what the node took; half a WCET is no guess at it.
            if node.name == *first {
                let (time, is_known) = whole();
                return if is_known { (time.div_ceil(2), true) } else { self.past.time(task, job, node) };
            }
            if node.name == *second {
                let (time, is_known) = whole();
                return if is_known { (time / 2, true) } else { (time, false) };
            }
        }
        let (time, is_known) = self.past.time(task, job, node);
        match &self.otherwise.capped {
            Some((of, name, most)) if *of == task && *name == node.name => (time.min(*most), is_known),
            _ => (time, is_known),
        }
    }

    fn fails(&self, task: usize, job: u64, node: &Numbered) -> bool {
        self.past.fails(task, self.then(task, job), node)
    }
}

#[cfg(test)]
mod tests;
