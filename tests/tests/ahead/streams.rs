//! A device in virtual time: streams that run what they were given in its order, each unit after those that it has to
//! wait for. It knows what ran, and so whether anything ran too early.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use red_core::{JobId, Member, NodeId, UnitId};

/// A unit in the queue of its stream.
#[derive(Debug)]
struct Given {
    unit: UnitId,
    after: Vec<UnitId>,
    /// What it executes.
    members: Vec<Member>,
    cost: u64,
    fails: bool,
    ends: Option<u64>,
}

/// What a stream has done and nobody was told yet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Report {
    /// When the host learns of it.
    pub(crate) due: u64,
    /// What.
    pub(crate) unit: UnitId,
    /// Whether it failed.
    pub(crate) failed: bool,
}

/// All streams.
#[derive(Debug, Default)]
pub(crate) struct Streams {
    queues: BTreeMap<usize, VecDeque<Given>>,
    ended: BTreeSet<UnitId>,
    /// Sub-jobs that ran to their end, or needed not.
    pub(crate) done: BTreeSet<(JobId, NodeId)>,
    /// Sub-jobs that started, and when.
    pub(crate) starts: Vec<(u64, Member)>,
    pub(crate) reports: BTreeMap<usize, VecDeque<Report>>,
}

impl Streams {
    /// Gives a unit to its lane's stream.
    pub(crate) fn give(
        &mut self,
        unit: UnitId,
        after: Vec<UnitId>,
        members: Vec<Member>,
        cost: u64,
        fails: bool,
    ) {
        for earlier in &after {
            let known = |queue: &VecDeque<Given>| queue.iter().any(|given| given.unit == *earlier);
            let is_known = self.ended.contains(earlier) || self.queues.values().any(known);
            assert!(is_known, "{unit:?} waits for {earlier:?}, which no stream was given");
        }
        let given = Given { unit, after, members, cost, fails, ends: None };
        self.queues.entry(unit.lane().index()).or_default().push_back(given);
    }

    /// When something ends next, or the host learns of something.
    pub(crate) fn next_at(&self) -> Option<u64> {
        let ends = self.queues.values().filter_map(|queue| queue.front()?.ends);
        let reports = self.reports.values().filter_map(|reports| Some(reports.front()?.due));
        ends.chain(reports).min()
    }

    /// Goes on to `now`; `delay` says how long the host takes to learn of a unit's end, `may_start` whether a member's
    /// predecessors are done.
    pub(crate) fn go_on(
        &mut self,
        now: u64,
        mut delay: impl FnMut() -> u64,
        may_start: impl Fn(&BTreeSet<(JobId, NodeId)>, &Member) -> bool,
    ) {
        loop {
            let mut moved = false;
            for (lane, queue) in &mut self.queues {
                let Some(head) = queue.front_mut() else { continue };
                if head.ends.is_none() && head.after.iter().all(|unit| self.ended.contains(unit)) {
                    head.ends = Some(now + head.cost);
                    for member in &head.members {
                        assert!(
                            may_start(&self.done, member),
                            "{member:?} starts before a predecessor ended"
                        );
                        self.starts.push((now, *member));
                    }
                    moved = true;
                }
                if head.ends == Some(now) {
                    self.ended.insert(head.unit);
                    self.done.extend(head.members.iter().map(|member| (member.job, member.node)));
                    let reports = self.reports.entry(*lane).or_default();
                    // In the order of the lane.
                    let due = now + if head.fails { 0 } else { delay() };
                    let due = reports.back().map_or(due, |last| last.due.max(due));
                    reports.push_back(Report { due, unit: head.unit, failed: head.fails });
                    queue.pop_front();
                    moved = true;
                }
            }
            if !moved {
                return;
            }
        }
    }

    /// Whether streams and host are done.
    pub(crate) fn is_idle(&self) -> bool {
        self.queues.values().all(VecDeque::is_empty) && self.reports.values().all(VecDeque::is_empty)
    }
}
