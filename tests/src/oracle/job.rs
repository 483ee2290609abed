//! One job in flight.

use std::rc::Rc;

use red_workload::model::Workload;

use super::band::Place;
use crate::graph::{Graph, Role};

/// Task, job index, node index.
pub(super) type SubId = (usize, u64, usize);

/// What a frame was captured at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Capture {
    /// Shared by all jobs of one capture instant of a sensor.
    Sensor(u64),
    /// No sensor of that name: the job's own.
    Job(usize, u64),
}

/// What encoder results may be shared for: weights, frame name, capture.
pub(super) type FrameKey = (String, String, Capture);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum State {
    /// Not started: its predecessors are missing, or it is queued, or it waits for a running encoder.
    Waiting,
    /// On a lane since this instant.
    Running(u64),
    Done,
}

pub(super) struct Job {
    pub(super) task: usize,
    pub(super) index: u64,
    pub(super) release: u64,
    /// Deadline on the time axis.
    pub(super) due: i128,
    /// Version of the task's graph.
    pub(super) version: usize,
    pub(super) graph: Rc<Graph>,
    pub(super) heights: Vec<usize>,
    pub(super) state: Vec<State>,
    /// Whether any node ever started, or took a kept output.
    pub(super) started: bool,
    /// Under our policies, how its task had fared at its release.
    pub(super) fortune: u64,
    /// As of the last look.
    pub(super) band: Place,
    /// Dispatch key of each node, on the time axis.
    pub(super) keys: Vec<i128>,
    /// a + D - tail of each node.
    pub(super) latest_finish: Vec<i128>,
    /// Frame of each encoder and decoder.
    pub(super) frames: Vec<Option<FrameKey>>,
}

impl Job {
    /// The pools of its nodes.
    pub(super) fn pools(&self) -> impl Iterator<Item = usize> + '_ {
        self.graph.nodes.iter().map(|node| node.pool)
    }

    pub(super) fn is_complete(&self) -> bool {
        self.state.iter().all(|&state| state == State::Done)
    }

    /// Not started, every predecessor done, and under a level gate every lower level done.
    pub(super) fn is_ready(&self, node: usize, gated: bool) -> bool {
        let done = |other: usize| self.state[other] == State::Done;
        self.state[node] == State::Waiting
            && self.graph.nodes[node].preds.iter().all(|&pred| done(pred))
            && (!gated
                || (0..self.state.len())
                    .all(|other| self.heights[other] >= self.heights[node] || done(other)))
    }

    /// Nodes with this role whose frame is `key`.
    pub(super) fn sharing<'a>(&'a self, key: &'a FrameKey, role: Role) -> impl Iterator<Item = usize> + 'a {
        let nodes = 0..self.graph.nodes.len();
        nodes.filter(move |&node| {
            self.graph.nodes[node].role == role && self.frames[node].as_ref() == Some(key)
        })
    }

    /// The longest path over `weights` after each node, through what is not done: behind an encoder that runs
    /// again there may be decoders that did.
    pub(super) fn remaining_tails(&self, weights: &[u64]) -> Vec<u64> {
        let mut tails = vec![0; weights.len()];
        for &v in self.graph.order.iter().rev() {
            let left = self.graph.nodes[v].succs.iter().filter(|&&s| self.state[s] != State::Done);
            tails[v] = left.map(|&s| weights[s] + tails[s]).max().unwrap_or(0);
        }
        tails
    }

    /// The longest path over `weights`, which are 0 for what is done.
    pub(super) fn remaining_path(&self, weights: &[u64]) -> i128 {
        let tails = self.remaining_tails(weights);
        let remain = (0..weights.len()).filter(|&v| self.state[v] != State::Done);
        i128::from(remain.map(|v| weights[v] + tails[v]).max().unwrap_or(0))
    }
}

/// The frame of each encoder and decoder of a job.
pub(super) fn frames(
    workload: &Workload,
    graph: &Graph,
    task: usize,
    index: u64,
    release: u64,
) -> Vec<Option<FrameKey>> {
    let frame = |node: &crate::graph::SubNode| {
        let (weights, name) = node.stage.clone()?;
        let sensor = workload.sensors.iter().find(|sensor| sensor.name == name);
        let capture = match sensor {
            Some(sensor) => Capture::Sensor(release / sensor.period_ns * sensor.period_ns),
            None => Capture::Job(task, index),
        };
        Some((weights, name, capture))
    };
    graph.nodes.iter().map(frame).collect()
}
