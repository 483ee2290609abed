//! The sub-deadlines that the scheduler gave to what lanes ran, for the trace. Some policies assign them again while
//! a job runs, so each is noted when its unit starts.

use red_core::UnitId;
use red_rt::handler::{Failed, Handler, Work};
use red_rt::stream::{Progress, Stream, Submitted};
use red_rt::stream_seat::StreamSeat;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// Task, job and node.
pub(crate) type SubJob = (usize, u64, usize);

/// Notes of all lanes, in tables that are large enough before real time starts.
#[derive(Debug)]
pub(crate) struct SubDeadlines {
    /// By lane. A lane's threads alone take its lock while they run, so nobody waits for it.
    lanes: Vec<Mutex<Vec<(SubJob, u64)>>>,
}

impl SubDeadlines {
    /// Room for `units` units over all lanes, in equal parts; those beyond it have no note.
    pub(crate) fn new(lanes: usize, units: usize) -> Arc<Self> {
        let room = units / lanes.max(1);
        Arc::new(Self { lanes: (0..lanes).map(|_| Mutex::new(Vec::with_capacity(room))).collect() })
    }

    /// The bodies of a lane, with a note for each that starts.
    pub(crate) fn of(self: &Arc<Self>, lane: usize, bodies: Box<dyn Handler>) -> Box<dyn Handler> {
        Box::new(Noting { bodies, lane, notes: self.clone() })
    }

    /// All notes: nanoseconds since the start of the run, by the first sub-job of the unit.
    pub(crate) fn all(&self) -> HashMap<SubJob, u64> {
        let of_lane = |lane: &Mutex<Vec<_>>| lane.lock().unwrap_or_else(PoisonError::into_inner).clone();
        self.lanes.iter().flat_map(of_lane).collect()
    }

    fn note(&self, lane: usize, work: &Work) {
        let Some(Ok(mut notes)) = self.lanes.get(lane).map(Mutex::lock) else { return };
        if notes.len() < notes.capacity() {
            notes.push(((work.task.index(), work.job, work.node.index()), work.sub_deadline_ns));
        }
    }
}

struct Noting {
    bodies: Box<dyn Handler>,
    lane: usize,
    notes: Arc<SubDeadlines>,
}

impl Handler for Noting {
    fn prepare(&mut self) {
        self.bodies.prepare();
    }

    fn begin(&mut self, origin_ns: u64) {
        self.bodies.begin(origin_ns);
    }

    fn run(&mut self, work: &Work) -> Result<(), Failed> {
        self.notes.note(self.lane, work);
        self.bodies.run(work)
    }

    fn stream(&mut self) -> Option<&mut dyn Stream> {
        self.bodies.stream()?;
        Some(self)
    }
}

impl Stream for Noting {
    fn submit(&mut self, work: &Work, after: &[UnitId]) -> Submitted {
        let submitted = self.bodies.stream().map_or(Submitted::Failed, |stream| stream.submit(work, after));
        if submitted == Submitted::Given {
            self.notes.note(self.lane, work);
        }
        submitted
    }

    fn look(&mut self) -> Progress {
        self.bodies.stream().map_or(Progress::Done(Err(Failed)), |stream| stream.look())
    }

    fn call(&mut self, seat: &Arc<StreamSeat>) -> Result<(), Failed> {
        self.bodies.stream().ok_or(Failed)?.call(seat)
    }

    fn quarantine(&mut self) {
        if let Some(stream) = self.bodies.stream() {
            stream.quarantine();
        }
    }

    fn is_lost(&mut self) -> bool {
        self.bodies.stream().is_none_or(|stream| stream.is_lost())
    }
}
