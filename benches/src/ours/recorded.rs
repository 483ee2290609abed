//! One lane whose every call is recorded, and the same without a tape.

use std::env;
use std::fs;
use std::path::PathBuf;
use std::process;
use std::time;

use red_core::{Action, Capacity, Instant, LaneId, PoolId, Scheduler};
use red_record::{Header, Recorder, Tape, Writer};

use super::{BARE, admit, dag};
use crate::measure::{Runner, fill};
use crate::not_run::NotRun;
use crate::peers::Setup;

/// A log that goes away with the runner.
struct Log {
    path: PathBuf,
    writer: Option<Writer>,
    tape: Option<Tape>,
}

impl Log {
    fn new<C: Capacity>() -> Result<Self, NotRun> {
        let path = env::temp_dir().join(format!("red-bench-{}.redlog", process::id()));
        let header = Header {
            program: "bench".into(),
            capacities: Header::capacities_of::<C>(),
            policy: "redrt".into(),
            duration_ns: 0,
            realtime: false,
            file: String::new(),
            format: "toml".into(),
            workload: String::new(),
            config: None,
        };
        let started = Writer::start(&path, &header);
        let (writer, tape) = started.map_err(|e| NotRun::Failed(format!("{}: {e}", path.display())))?;
        Ok(Self { path, writer: Some(writer), tape: Some(tape) })
    }
}

impl Drop for Log {
    fn drop(&mut self) {
        self.tape = None;
        let dropped = self.writer.take().map(|writer| writer.finish().0.dropped);
        if dropped != Some(0) {
            println!("recording dropped {dropped:?} inputs: what it costs is not in this table");
        }
        let _gone = fs::remove_file(&self.path);
    }
}

pub(super) fn build<C: Capacity>(setup: &Setup<'_>, records: bool) -> Result<Runner, NotRun> {
    let mut scheduler = Box::new(Scheduler::<C>::new(BARE));
    let task = admit(&mut scheduler, &dag(setup.graph, |_| PoolId::new(0))?)?;
    let (body, call, lane) = (setup.body, setup.body.behind_pointer(), LaneId::new(0));
    let mut log = if records { Some(Log::new::<C>()?) } else { None };
    let epoch = time::Instant::now();
    let now = move || Instant::from_nanos(epoch.elapsed().as_nanos() as u64);
    Ok(Box::new(move |runs, samples| {
        let mut completed = true;
        let tape = log.as_mut().and_then(|log| log.tape.as_mut());
        let mut scheduler = Recorder::new(&mut scheduler, tape);
        fill(samples, || {
            for _ in 0..runs {
                let at = now();
                completed &= scheduler.release_at(task, at, None, at).is_ok();
                let mut at = at;
                let mut ended = false;
                while !ended && completed {
                    let mut unit = None;
                    while let Some(action) = scheduler.poll_on(lane, at) {
                        match action {
                            Action::Dispatch(next) => unit = Some(next.unit),
                            Action::Ended(_) => ended = true,
                            _ => {}
                        }
                    }
                    if let Some(unit) = unit {
                        call(body, unit.node().index());
                        at = now();
                        completed &= scheduler.complete(unit, at).is_ok();
                    } else {
                        completed &= ended;
                    }
                }
            }
        });
        if completed { Ok(()) } else { Err(NotRun::Failed("RED left a job undone".to_owned())) }
    }))
}
