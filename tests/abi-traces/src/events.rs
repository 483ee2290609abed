//! What happens to a scheduler, but for what its lanes report.

use std::io;

use red_core::{
    Capacity, CommitError, Dag, EdgeError, Instant, JobId, LaneId, Node, NodeId, TaskId, UnitId, refine,
};

use crate::host::Host;
use crate::script::Step;
use crate::words::{answer, certificate};

/// What a call says that answers with a word.
fn yes(is: bool) -> &'static str {
    if is { "= yes" } else { "= no" }
}

/// One step; pools that the class has not are told before the graph is asked.
fn take<C: Capacity>(dag: &mut Dag<C>, step: &Step) -> String {
    let id = NodeId::new;
    let has_pool = |node: &Node| node.pool().index() < C::POOLS;
    let unknown = || "! UnknownPool".to_owned();
    match step {
        Step::Node(node) if !has_pool(node) => unknown(),
        Step::Node(node) => answer(dag.add_node(*node).map(NodeId::index)),
        Step::Edge(from, to) => answer::<_, EdgeError>(dag.add_edge(id(*from), id(*to)).map(|()| "ok")),
        Step::Refine(_, encoder, decoders) if !has_pool(encoder) || !decoders.iter().all(has_pool) => {
            unknown()
        }
        Step::Refine(stage, encoder, decoders) => {
            let refined = refine(dag, id(*stage), *encoder, decoders);
            answer(refined.map(|refined| {
                *dag = refined.dag;
                refined.encoder.index()
            }))
        }
        Step::Replace(place, by) => replace(dag, id(*place), *by),
        Step::Remove(node) => yes(dag.remove_node(id(*node))).to_owned(),
        Step::Cut(from, to) => yes(dag.remove_edge(id(*from), id(*to))).to_owned(),
    }
}

/// The graph again, with another node in one place.
fn replace<C: Capacity>(dag: &mut Dag<C>, place: NodeId, by: Node) -> String {
    let mut new = Dag::new();
    let nodes: Vec<_> = dag.nodes().collect();
    let mut answers = Vec::new();
    for id in &nodes {
        let node = if *id == place { Some(&by) } else { dag.node(*id) };
        let node = node.copied().filter(|node| node.pool().index() < C::POOLS);
        let added = node.map(|node| answer(new.add_node(node).map(NodeId::index)));
        answers.push(added.unwrap_or_else(|| "! UnknownPool".to_owned()));
    }
    for from in &nodes {
        for to in dag.successors(*from).iter() {
            answers.push(answer(new.add_edge(*from, NodeId::new(to as u8)).map(|()| "ok")));
        }
    }
    *dag = new;
    answers.join(" ")
}

impl<C: Capacity> Host<'_, C> {
    pub(crate) fn admit(&mut self, task: usize) -> io::Result<()> {
        let of_task = &self.script.tasks[task];
        let mut dag = Box::new(Dag::<C>::new());
        for step in &of_task.steps {
            writeln!(self.out, "{} make {}", self.now, take(&mut dag, step))?;
        }
        self.ask(&dag, of_task.terms.deadline)?;
        let admitted = self.core.add_task(&dag, of_task.terms.timing());
        writeln!(self.out, "{} admit {task} {}", self.now, answer(admitted.map(TaskId::to_bits)))?;
        if let Ok(admitted) = admitted {
            self.tasks[task] = (admitted, 0);
            let proof = self.core.certificate(admitted);
            writeln!(
                self.out,
                "{} proof {}",
                self.now,
                proof.as_ref().map_or("none".to_owned(), certificate)
            )?;
        }
        Ok(())
    }

    pub(crate) fn release(&mut self, task: usize, at_ns: u64, capture: Option<u64>) -> io::Result<()> {
        let (id, index) = self.tasks[task];
        let now = self.instant();
        let released = if at_ns == self.now && capture.is_none() {
            self.core.release(id, now)
        } else {
            self.core.release_at(id, Instant::from_nanos(at_ns), capture, now)
        };
        self.tasks[task].1 += 1;
        writeln!(self.out, "{} release {task} {}", self.now, answer(released.map(JobId::to_bits)))?;
        let job = self.core.job_id(id, index).map(JobId::to_bits);
        writeln!(self.out, "{} job {index} {}", self.now, answer(job.ok_or(Unknown::Job)))
    }

    pub(crate) fn remove(&mut self, task: usize) -> io::Result<()> {
        let now = self.instant();
        let removed = self.core.remove_task(self.tasks[task].0, now);
        writeln!(self.out, "{} remove {task} {}", self.now, yes(removed))
    }

    pub(crate) fn begin(&mut self, place: usize, task: usize) -> io::Result<()> {
        self.edits[place] = self.core.edit(self.tasks[task].0).map(Box::new);
        writeln!(self.out, "{} begin {place} {task} {}", self.now, yes(self.edits[place].is_some()))
    }

    pub(crate) fn change(&mut self, place: usize, step: &Step) -> io::Result<()> {
        let made = self.edits[place].as_deref_mut().map(|dag| take(dag, step));
        writeln!(self.out, "{} change {place} {}", self.now, made.as_deref().unwrap_or("none"))
    }

    pub(crate) fn commit(&mut self, place: usize) -> io::Result<()> {
        let now = self.instant();
        let told = match self.edits[place].take() {
            None => "none".to_owned(),
            Some(edit) => {
                answer::<_, CommitError>(self.core.commit(&edit, now).map(|proof| certificate(&proof)))
            }
        };
        writeln!(self.out, "{} commit {place} {told}", self.now)
    }

    pub(crate) fn retire(&mut self, lane: u8) -> io::Result<()> {
        let retired = self.core.retire_lane(LaneId::new(lane));
        writeln!(self.out, "{} retire {lane} {}", self.now, yes(retired))
    }

    pub(crate) fn restore(&mut self, lane: u8) -> io::Result<()> {
        let restored = self.core.restore_lane(LaneId::new(lane));
        writeln!(self.out, "{} restore {lane} {}", self.now, yes(restored))
    }

    pub(crate) fn stray(&mut self, unit: u64, task: u32) -> io::Result<()> {
        let (id, of, now) = (UnitId::from_bits(unit), TaskId::from_bits(task), self.instant());
        // What lanes run is not reported by strangers.
        let runs = self.core.unit(id).is_some();
        let completed =
            if runs { "runs".to_owned() } else { answer(self.core.complete(id, now).map(|()| "ok")) };
        let released = answer(self.core.release(of, now).map(JobId::to_bits));
        let job = answer(self.core.job_id(of, unit).map(JobId::to_bits).ok_or(Unknown::Job));
        writeln!(self.out, "{} stray {completed} {released} {job}", self.now)
    }

    pub(crate) fn take(&mut self) -> io::Result<()> {
        match self.core.take_outcome() {
            Some(outcome) => self.ended(&outcome),
            None => writeln!(self.out, "{} no outcome", self.now),
        }
    }
}

/// What the core says by none.
#[derive(Debug)]
enum Unknown {
    Job,
}
