//! What no scheduler can do: the mandatory demand of every interval.
//!
//! *Rule.* A node executes within the window from its release plus the longest path before it to its deadline less the
//! longest path after it. Of its cost, what does not fit into the window outside of an interval has to be done inside. If
//! an interval between a release and a deadline has more of it than its lanes have time, no schedule meets all deadlines,
//! preemptive or not. *Necessary*, not sufficient.

use super::sets::Task;

/// A job with what is needed of it.
struct Job<'a> {
    release: u64,
    deadline: u64,
    work: u64,
    shape: &'a Shape,
}

/// Per node: cost, longest path before, longest path after.
struct Shape(Vec<(u64, u64, u64)>);

/// Whether the mandatory demand of every interval fits `lanes` lanes.
#[must_use]
pub(crate) fn is_possible(tasks: &[Task], releases: &[Vec<u64>], lanes: u64) -> bool {
    let shape = |task: &Task| {
        let paths = task.graph.heads().into_iter().zip(task.graph.tails());
        Shape(task.graph.costs.iter().zip(paths).map(|(cost, (head, tail))| (*cost, head, tail)).collect())
    };
    let shapes: Vec<Shape> = tasks.iter().map(shape).collect();
    let mut jobs = Vec::new();
    for ((task, shape), releases) in tasks.iter().zip(&shapes).zip(releases) {
        jobs.extend(releases.iter().map(|release| Job {
            release: *release,
            deadline: release + task.deadline_ns,
            work: task.graph.work(),
            shape,
        }));
    }
    let mut starts: Vec<u64> = jobs.iter().map(|job| job.release).collect();
    let mut ends: Vec<u64> = jobs.iter().map(|job| job.deadline).collect();
    starts.sort_unstable();
    starts.dedup();
    ends.sort_unstable();
    ends.dedup();
    starts.iter().all(|start| {
        let late: Vec<&Job<'_>> = jobs.iter().filter(|job| job.deadline > *start).collect();
        ends.iter().filter(|end| *end > start).all(|end| {
            let demand: u64 = late.iter().map(|job| job.demand(*start, *end)).sum();
            demand <= lanes * (end - start)
        })
    })
}

impl Job<'_> {
    fn demand(&self, start: u64, end: u64) -> u64 {
        if self.release >= end {
            return 0;
        }
        if self.release >= start && self.deadline <= end {
            return self.work;
        }
        let mandatory = |(cost, head, tail): &(u64, u64, u64)| {
            let (from, to) = (self.release + head, self.deadline.saturating_sub(*tail));
            let outside = start.saturating_sub(from) + to.saturating_sub(end);
            cost.saturating_sub(outside).min(end - start)
        };
        self.shape.0.iter().map(mandatory).sum()
    }
}
