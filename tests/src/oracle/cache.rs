//! Frame cache: outputs that live, encoders that wait or hit, eviction.

use super::job::{FrameKey, Job, State};
use super::{Sim, SubId};
use crate::graph::Role;

/// Which outputs go when nothing runs in a pool and its head does not fit.
#[derive(Clone, Copy)]
pub(super) enum Eviction {
    WithoutReadyDecoder,
    NotReadBy(SubId),
    All,
}

impl Sim<'_> {
    pub(super) fn is_cached(&self, key: &FrameKey) -> bool {
        self.cached.iter().any(|output| output.key == *key)
    }

    /// When the running encoder of this key ends.
    pub(super) fn running_until(&self, key: &FrameKey) -> Option<u64> {
        self.running.iter().filter(|unit| unit.key.as_ref() == Some(key)).map(|unit| unit.finish).min()
    }

    /// Every ready encoder whose output is cached is done at this instant, and so on for what that readies.
    pub(super) fn hit(&mut self, now: u64) {
        while let Some((job, node)) = self.next_hit() {
            let job = &mut self.jobs[job];
            job.state[node] = State::Done;
            job.started = true;
            let id: SubId = (job.task, job.index, node);
            self.overtaken.retain(|(head, _)| *head != id);
            let graph = std::rc::Rc::clone(&job.graph);
            self.outcome.row(self.workload, id, &graph, None, now, now);
            self.outcome.encoder_runs_saved += 1;
        }
    }

    fn next_hit(&self) -> Option<(usize, usize)> {
        let hits = |job: &Job, node: usize| {
            let encoder = job.graph.nodes[node].role == Role::Encoder;
            let cached = || job.frames[node].as_ref().is_some_and(|key| self.is_cached(key));
            encoder && job.is_ready(node, false) && cached()
        };
        let nodes = |job: usize| (0..self.jobs[job].state.len()).map(move |node| (job, node));
        (0..self.jobs.len()).flat_map(nodes).find(|&(job, node)| hits(&self.jobs[job], node))
    }

    /// Frees outputs without an uncompleted decoder or a not-started encoder of their key in a job in flight.
    pub(super) fn drop_unused(&mut self) {
        let jobs = &self.jobs;
        self.cached.retain(|output| {
            jobs.iter().any(|job| {
                job.sharing(&output.key, Role::Decoder).any(|node| job.state[node] != State::Done)
                    || job.sharing(&output.key, Role::Encoder).any(|node| job.state[node] == State::Waiting)
            })
        });
    }

    /// Evicts outputs of `pool`; their encoders run again where a decoder still needs them.
    pub(super) fn evict(&mut self, pool: usize, eviction: Eviction) {
        let here = self.cached.iter().filter(|output| output.pool == pool);
        let evicted: Vec<FrameKey> =
            here.map(|output| output.key.clone()).filter(|key| self.may_go(key, eviction)).collect();
        self.cached.retain(|output| output.pool != pool || !evicted.contains(&output.key));
        self.look_due |= !evicted.is_empty();
        for job in &mut self.jobs {
            for key in &evicted {
                rerun(job, key);
            }
        }
    }

    fn may_go(&self, key: &FrameKey, eviction: Eviction) -> bool {
        match eviction {
            Eviction::WithoutReadyDecoder => !self
                .jobs
                .iter()
                .any(|job| job.sharing(key, Role::Decoder).any(|decoder| job.is_ready(decoder, false))),
            Eviction::NotReadBy((task, index, node)) => !self
                .job(task, index)
                .is_some_and(|job| job.sharing(key, Role::Decoder).any(|decoder| decoder == node)),
            Eviction::All => true,
        }
    }
}

/// Puts the encoders of `key` back whose own decoders are not all done.
fn rerun(job: &mut Job, key: &FrameKey) {
    let encoders: Vec<usize> = job.sharing(key, Role::Encoder).collect();
    for encoder in encoders {
        let nodes = &job.graph.nodes;
        let own =
            |&&v: &&usize| nodes[v].role == Role::Decoder && same_stage(&nodes[v].name, &nodes[encoder].name);
        let unfinished = nodes[encoder].succs.iter().filter(own).any(|&v| job.state[v] != State::Done);
        if unfinished && job.state[encoder] == State::Done {
            job.state[encoder] = State::Waiting;
        }
    }
}

fn same_stage(a: &str, b: &str) -> bool {
    let stage = |name: &str| name.split_once('.').map(|(stage, _)| stage.to_owned());
    stage(a) == stage(b)
}
