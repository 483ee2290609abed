//! Filling lanes: the queue of a pool, memory, merging, the barrier grid.

use std::cmp::Reverse;

use super::band::Place;
use super::cache::Eviction;
use super::job::{Job, State, SubId};
use super::{MERGE_WINDOW_NS, Sim, Unit, keys};
use crate::graph::Role;

/// Order of dispatch: band, the highest first, key, release, how its task fared, task, job index, node index.
pub(super) type Order = (Reverse<Place>, i128, u64, u64, usize, u64, usize);

/// What a pool starts next.
struct Pick {
    id: SubId,
    /// The head that it overtakes.
    overtakes: Option<SubId>,
}

impl Sim<'_> {
    /// Fills the free lanes, or waits for the grid first where there is one.
    pub(super) fn dispatch(&mut self, now: u64) {
        let grid = self.workload.sync.filter(|_| self.policy.waits_for_grid());
        if let Some(grid) = grid {
            if self.barrier.is_none() && self.can_any_start(now) {
                self.barrier = Some(now.div_ceil(grid.grid_ns) * grid.grid_ns + grid.cost_ns);
            }
            if self.barrier != Some(now) {
                return;
            }
            self.barrier = None;
        }
        self.wake = None;
        let mut pool = 0;
        while pool < self.workload.pools.len() && !self.look_due {
            if !self.start_one(pool, now) {
                pool += 1;
            } else if self.wake.take().is_some() {
                // What starts in one pool may be what another one has to wait for.
                pool = 0;
            }
        }
    }

    fn can_any_start(&self, now: u64) -> bool {
        let startable = |pool: usize| {
            let head = self.queue(pool).first().copied().filter(|_| self.free_lane(pool).is_some());
            head.is_some_and(|head| self.pick(pool, head, now).is_some())
        };
        (0..self.workload.pools.len()).any(startable)
    }

    fn free_lane(&self, pool: usize) -> Option<u32> {
        let taken = |lane: u32| self.running.iter().any(|unit| unit.pool == pool && unit.lane == lane);
        (0..self.workload.pools[pool].lanes).find(|&lane| !taken(lane))
    }

    /// Starts one unit in the pool, if it has a free lane and something for it.
    fn start_one(&mut self, pool: usize, now: u64) -> bool {
        let Some(lane) = self.free_lane(pool) else { return false };
        if self.queue(pool).is_empty() {
            return false;
        }
        self.reassign(now);
        let (goes, until) = self.first_to_start(pool, now);
        if let Some(until) = until {
            self.wake = Some(self.wake.map_or(until, |wake| wake.min(until)));
        }
        let Some(goes) = goes else { return false };
        if let Some(pick) = self.pick(pool, goes, now) {
            if let Some(head) = pick.overtakes {
                self.note_overtaking(head);
            }
            self.start(pool, lane, pick.id, now);
        } else if let Some(head) = self.make_room(pool, goes) {
            self.start(pool, lane, head, now);
        } else {
            return false;
        }
        true
    }

    /// Keys of this instant, under the policies that re-assign.
    pub(super) fn reassign(&mut self, now: u64) {
        if self.policy.reassigns() {
            for job in &mut self.jobs {
                keys::reassign(job, now);
            }
        }
    }

    /// Ready sub-jobs of a pool in order of dispatch. An encoder whose key is running waits outside.
    pub(super) fn queue(&self, pool: usize) -> Vec<SubId> {
        let mut queue: Vec<(Order, SubId)> = Vec::new();
        for job in &self.jobs {
            for node in 0..job.state.len() {
                let ready = job.graph.nodes[node].pool == pool
                    && job.is_ready(node, self.policy.gates_levels())
                    && !self.waits_for_key(job, node);
                if ready {
                    queue.push((order(job, node), (job.task, job.index, node)));
                }
            }
        }
        queue.sort_unstable();
        queue.into_iter().map(|(_, id)| id).collect()
    }

    pub(super) fn waits_for_key(&self, job: &Job, node: usize) -> bool {
        let running = || job.frames[node].as_ref().is_some_and(|key| self.running_until(key).is_some());
        self.policy.caches() && job.graph.nodes[node].role == Role::Encoder && running()
    }

    /// What is to start if it fits; else what may overtake it, which need not wait.
    fn pick(&self, pool: usize, head: SubId, now: u64) -> Option<Pick> {
        let used = self.memory_used(pool);
        let fits = |id: SubId, used: u64| self.fits(pool, used, self.memory_of(id));
        if fits(head, used) {
            return Some(Pick { id: head, overtakes: None });
        }
        let overtaken = self.overtaken.iter().find(|(id, _)| *id == head).map_or(0, |(_, count)| *count);
        let follower =
            self.queue(pool).into_iter().find(|&id| fits(id, used) && !self.has_to_wait(pool, id, now));
        let follower = follower.filter(|_| overtaken < self.workload.pools[pool].lanes)?;
        Some(Pick { id: follower, overtakes: Some(head) })
    }

    /// The head, or the most pressing ready decoder, after outputs of the pool went; nothing while something runs
    /// there. Encoders that run again may be the new head, and once all outputs are gone any head fits.
    fn make_room(&mut self, pool: usize, head: SubId) -> Option<SubId> {
        if self.running.iter().any(|unit| unit.pool == pool) {
            return None;
        }
        self.evict(pool, Eviction::WithoutReadyDecoder);
        if self.can_start(pool, head) {
            return Some(head);
        }
        let queue = self.queue(pool);
        let head = *queue.first()?;
        // What an encoder makes can be thrown away again; the end of a decoder is for good.
        let decoder = queue.into_iter().find(|&id| self.role_of(id) == Some(Role::Decoder));
        let chosen = decoder.filter(|_| self.role_of(head) == Some(Role::Encoder)).unwrap_or(head);
        self.evict(pool, Eviction::NotReadBy(chosen));
        if self.can_start(pool, chosen) {
            return Some(chosen);
        }
        self.evict(pool, Eviction::All);
        self.queue(pool).first().copied()
    }

    fn can_start(&self, pool: usize, id: SubId) -> bool {
        self.queue(pool).contains(&id) && self.fits(pool, self.memory_used(pool), self.memory_of(id))
    }

    fn role_of(&self, (task, index, node): SubId) -> Option<Role> {
        self.job(task, index).map(|job| job.graph.nodes[node].role)
    }

    fn note_overtaking(&mut self, head: SubId) {
        match self.overtaken.iter_mut().find(|(id, _)| *id == head) {
            Some((_, count)) => *count += 1,
            None => self.overtaken.push((head, 1)),
        }
    }

    fn memory_of(&self, (task, index, node): SubId) -> u64 {
        self.job(task, index).map_or(0, |job| job.graph.nodes[node].memory_bytes)
    }

    /// Running footprints and cached outputs.
    fn memory_used(&self, pool: usize) -> u64 {
        let running = self.running.iter().filter(|unit| unit.pool == pool).map(|unit| unit.memory);
        running.sum::<u64>() + self.kept(pool)
    }

    pub(super) fn kept(&self, pool: usize) -> u64 {
        self.cached.iter().filter(|output| output.pool == pool).map(|output| output.memory).sum()
    }

    fn fits(&self, pool: usize, used: u64, more: u64) -> bool {
        self.workload.pools[pool].memory_bytes.is_none_or(|budget| used + more <= budget)
    }

    /// Starts the unit that `head` leads on a free lane.
    fn start(&mut self, pool: usize, lane: u32, head: SubId, now: u64) {
        let members = if self.policy.merges() { self.members(pool, head, now) } else { vec![head] };
        // An encoder that runs again waits anew, also where it had not been the unit's head.
        self.overtaken.retain(|(id, _)| !members.contains(id));
        let mut unit = Unit { pool, lane, finish: now, memory: 0, key: None, members };
        for &(task, index, node) in &unit.members {
            let job = self.job(task, index).expect("queued jobs are in flight");
            let sub = &job.graph.nodes[node];
            unit.finish = unit.finish.max(now + sub.wcet_ns);
            unit.memory = unit.memory.max(sub.memory_bytes);
            if sub.role == Role::Encoder {
                unit.key.clone_from(&job.frames[node]);
            }
        }
        for &id in &unit.members {
            let (task, index, node) = id;
            let job = self.job_mut(task, index).expect("queued jobs are in flight");
            job.state[node] = State::Running(now);
            job.started = true;
            let graph = std::rc::Rc::clone(&job.graph);
            self.outcome.row(self.workload, id, &graph, Some(lane), now, unit.finish);
        }
        self.executions.push((pool, now, unit.finish));
        self.outcome.busy_ns[pool] += unit.finish.min(self.horizon) - now;
        self.outcome.units_dispatched += 1;
        self.running.push(unit);
    }

    /// The unit of `head`: ready encoders of its pool and key, within one window of releases, whose joining
    /// lengthens nothing or leaves every member in time.
    fn members(&self, pool: usize, head: SubId, now: u64) -> Vec<SubId> {
        let job_of = |id: SubId| self.job(id.0, id.1).expect("queued jobs are in flight");
        let frame = |id: SubId| job_of(id).frames[id.2].clone();
        let is_encoder = |id: SubId| job_of(id).graph.nodes[id.2].role == Role::Encoder;
        if !is_encoder(head) {
            return vec![head];
        }
        let same: Vec<SubId> =
            self.queue(pool).into_iter().filter(|&id| is_encoder(id) && frame(id) == frame(head)).collect();
        let released = |id: SubId| job_of(id).release;
        let anchor = window_anchor(same.iter().map(|&id| released(id)).collect(), released(head));

        let cost = |id: SubId| job_of(id).graph.nodes[id.2].cost_ns;
        let latest = |id: SubId| job_of(id).latest_finish[id.2];
        let used = self.memory_used(pool);
        let mut members = vec![head];
        for id in same {
            let in_window = released(id) >= anchor && released(id) - anchor <= MERGE_WINDOW_NS;
            if id == head || !in_window || !self.fits(pool, used, self.memory_of(id)) {
                continue;
            }
            let unit_cost = members.iter().map(|&member| cost(member)).max().unwrap_or(0);
            let new_cost = unit_cost.max(cost(id));
            let earliest = members.iter().map(|&member| latest(member)).min().unwrap_or(i128::MAX);
            let in_time = i128::from(now) + i128::from(new_cost) <= earliest.min(latest(id));
            if cost(id) == unit_cost || in_time {
                members.push(id);
            }
        }
        members
    }
}

pub(super) fn order(job: &Job, node: usize) -> Order {
    (Reverse(job.band), job.keys[node], job.release, job.fortune, job.task, job.index, node)
}

/// First release of the window that holds `release`: windows begin at the first release and, each, at the
/// first one beyond the last window.
fn window_anchor(mut releases: Vec<u64>, release: u64) -> u64 {
    releases.sort_unstable();
    let mut anchor = releases[0];
    for next in releases.into_iter().filter(|&next| next <= release) {
        if next - anchor > MERGE_WINDOW_NS {
            anchor = next;
        }
    }
    anchor
}
