//! D-over: EDF while nothing is lost by it, and else the job that is worth more than all that it puts at risk.
//!
//! *Rule.* The current job has the lanes. One that comes with an earlier deadline takes them if the time that can be spared,
//! without a job that waits for the current one being late, is enough; all others wait. A job that waits and could start no
//! later takes over if it is worth more than 1 + sqrt(k) times the current one and those that the current one put off, k being
//! the greatest value for its work over the least of all tasks; else it is given up.
//!
//! *Here* nobody is taken off a lane: what would change hands while a node runs does so before it starts, where the wait
//! would reach beyond a latest start. *On several lanes* the original says nothing: what is left of a job is its work over the
//! lanes, or its longest path where that is longer, and lanes that the current job leaves over go to the others, those that were
//! put off first.

use super::load::Set;
use super::others::{Answer, Job, Look, Rule};

/// Time that cannot be exhausted.
const PLENTY: i64 = i64::MAX;

pub(super) struct DOver {
    /// 1 + sqrt(k).
    factor: f64,
    current: Option<usize>,
    /// Put off by one with an earlier deadline: name, since when, and the time that could be spared then; the last first.
    put_off: Vec<(usize, u64, i64)>,
    /// The others that wait.
    waiting: Vec<usize>,
    spare: i64,
}

impl DOver {
    pub(super) fn of(set: &Set) -> Self {
        let density = |(task, value): (usize, &u32)| f64::from(*value) / set.tasks[task].graph.work() as f64;
        let densities = || set.values.iter().enumerate().map(density);
        let k = densities().fold(0.0, f64::max) / densities().fold(f64::INFINITY, f64::min);
        let (put_off, waiting) = (Vec::new(), Vec::new());
        Self { factor: 1.0 + k.sqrt(), current: None, put_off, waiting, spare: PLENTY }
    }

    fn came(&mut self, id: usize, look: &Look<'_>) {
        let job = look.job(id);
        let Some(current) = self.current else {
            self.waiting.push(id);
            return;
        };
        let left = job.left as i64;
        if job.deadline < look.job(current).deadline && self.spare >= left {
            self.put_off.push((current, look.now, self.spare));
            self.spare = look.laxity(job).min(self.less(left));
            self.current = Some(id);
        } else {
            self.waiting.push(id);
        }
    }

    const fn less(&self, time: i64) -> i64 {
        if self.spare == PLENTY { PLENTY } else { self.spare - time }
    }

    /// The next current job.
    fn choose(&mut self, look: &Look<'_>) {
        let first = |waiting: &[usize]| {
            waiting.iter().copied().min_by_key(|id| (look.job(*id).deadline, *id)).map(|id| look.job(id))
        };
        let (other, before) = (first(&self.waiting), self.put_off.pop());
        self.spare = match before {
            Some((_, _, PLENTY)) | None => PLENTY,
            Some((_, since, spare)) => spare - (look.now - since) as i64,
        };
        match (before, other) {
            (Some((id, ..)), Some(job))
                if job.deadline < look.job(id).deadline && self.spare >= job.left as i64 =>
            {
                self.put_off.push((id, look.now, self.spare));
                self.spare = look.laxity(job).min(self.less(job.left as i64));
                self.take(job.id);
            }
            (Some((id, ..)), _) => self.current = Some(id),
            (None, Some(job)) => {
                self.spare = look.laxity(job);
                self.take(job.id);
            }
            (None, None) => self.current = None,
        }
    }

    fn take(&mut self, id: usize) {
        self.waiting.retain(|other| *other != id);
        self.current = Some(id);
    }

    /// Who waits and could not start any later takes over, or is given up.
    fn latest_starts(&mut self, look: &Look<'_>, given_up: &mut Vec<usize>) {
        loop {
            let Some(current) = self.current.map(|id| look.job(id)) else { return };
            let until = current.next as i64;
            let late = self.waiting.iter().map(|id| look.job(*id)).filter(|job| look.laxity(job) < until);
            let Some(next) = late.min_by_key(|job| (look.laxity(job), job.id)) else { return };
            let at_risk: f64 = self.put_off.iter().map(|(id, ..)| look.job(*id).value).sum();
            if look.laxity(next) >= 0 && next.value > self.factor * (current.value + at_risk) {
                self.waiting.push(current.id);
                self.waiting.extend(self.put_off.drain(..).map(|(id, ..)| id));
                self.spare = 0;
                self.take(next.id);
            } else {
                self.waiting.retain(|id| *id != next.id);
                given_up.push(next.id);
            }
        }
    }
}

impl Rule for DOver {
    fn look(&mut self, look: &Look<'_>) -> Answer {
        let is_here = |id: usize| look.jobs.iter().any(|job| job.id == id);
        self.put_off.retain(|(id, ..)| is_here(*id));
        self.waiting.retain(|id| is_here(*id));
        self.current = self.current.filter(|id| is_here(*id));
        if self.current.is_none() {
            self.choose(look);
        }
        for id in look.came {
            if is_here(*id) {
                self.came(*id, look);
            }
        }
        if self.current.is_none() {
            self.choose(look);
        }
        let mut given_up = Vec::new();
        if look.free > 0 {
            self.latest_starts(look, &mut given_up);
        }
        let mut waiting = self.waiting.clone();
        waiting.sort_by_key(|id| (look.job(*id).deadline, *id));
        let put_off = self.put_off.iter().rev().map(|(id, ..)| *id);
        Answer { order: self.current.into_iter().chain(put_off).chain(waiting).collect(), given_up }
    }
}

impl Look<'_> {
    /// A job in flight by its name.
    fn job(&self, id: usize) -> &Job {
        &self.jobs[self.jobs.partition_point(|job| job.id < id)]
    }

    /// Time until a job has to run without a pause, at mean times, in nanoseconds.
    fn laxity(&self, job: &Job) -> i64 {
        job.deadline as i64 - self.now as i64 - job.left as i64
    }
}
