//! A lane that waits for the next job of a higher rank: how long, and by what it reckons.

use red_core::{Action, Caps, Config, Dag, Duration, Instant, Node, Scheduler, TaskId, Timing, UnitId, Wcet};

type Small = Caps<2, 1, 4, 1, 1, 1>;

const MS: u64 = 1_000_000;

/// `brake`, worth 1000, takes 16 ms of each 20; a node of `map` takes up to 24 ms. After the first one there is pressure.
struct Lane {
    scheduler: Scheduler<Small>,
    brake: TaskId,
    map: TaskId,
}

impl Lane {
    fn new(config: Config, floor: Option<(u32, u32)>) -> Self {
        let mut scheduler = Scheduler::<Small>::new(config);
        let mut add = |cost_ms, deadline_ms, value, floor: Option<(u32, u32)>| {
            let mut dag = Dag::new();
            let best = Duration::from_millis(if cost_ms == 16 { 16 } else { 0 });
            dag.add_node(Node::new(Wcet::from_millis(cost_ms)).best_case(best)).unwrap();
            let timing = Timing::new(Duration::from_millis(deadline_ms));
            let timing = timing.every(Duration::from_millis(20)).value(value);
            scheduler.add_task(&dag, floor.map_or(timing, |(m, k)| timing.floor(m, k))).unwrap()
        };
        let (brake, map) = (add(16, 20, 1_000, floor), add(24, 200, 1, None));
        Self { scheduler, brake, map }
    }

    fn release(&mut self, task: TaskId, now_us: u64) {
        self.scheduler.release(task, at(now_us)).unwrap();
    }

    /// What starts now, if anything does.
    fn starts(&mut self, now_us: u64) -> Option<UnitId> {
        let mut started = None;
        while let Some(action) = self.scheduler.poll(at(now_us)) {
            if let Action::Dispatch(dispatch) = action {
                started = Some(dispatch.unit);
            }
        }
        started
    }

    fn complete(&mut self, unit: UnitId, now_us: u64) {
        self.scheduler.complete(unit, at(now_us)).unwrap();
    }

    /// To 40 ms: `brake` has run from 0 to 16, `map` from then on for so long, and the job of `brake` at 20 is lost if that was
    /// too long.
    fn until_40(mut self, map_us: u64) -> Self {
        self.release(self.brake, 0);
        self.release(self.map, 0);
        let first = self.starts(0).unwrap();
        self.complete(first, 16_000);
        let long = self.starts(16_000).unwrap();
        if map_us < 4_000 {
            self.complete(long, 16_000 + map_us);
            assert_eq!(self.starts(16_000 + map_us), None);
        }
        self.release(self.brake, 20_000);
        let second = self.starts(20_000);
        assert_eq!(second.is_some(), map_us < 4_000);
        match second {
            Some(second) => self.complete(second, 36_000),
            None => self.complete(long, 16_000 + map_us),
        }
        assert_eq!(self.starts(40_000), None);
        self
    }

    /// `brake` runs from 40 to 56 ms, and a job of `map` is there.
    fn until_56(mut self) -> Self {
        self.release(self.brake, 40_000);
        self.release(self.map, 40_000);
        let third = self.starts(40_000).unwrap();
        self.complete(third, 56_000);
        self
    }
}

fn at(us: u64) -> Instant {
    Instant::ZERO.saturating_add(Duration::from_nanos(us * MS / 1_000))
}

#[test]
fn a_late_release_is_waited_for_for_an_eighth_of_its_period() {
    let mut lane = Lane::new(Config::REDRT, None).until_40(24_000).until_56();
    assert_eq!(lane.starts(56_000), None);
    assert_eq!(lane.scheduler.poll_at(), Some(at(60_000)));
    // `brake` should be there at 60.
    assert_eq!((lane.starts(60_000), lane.starts(62_499)), (None, None));
    assert_eq!(lane.scheduler.poll_at(), Some(at(62_500)));
    assert!(lane.starts(62_500).is_some());
}

#[test]
fn a_release_in_time_is_first() {
    let mut lane = Lane::new(Config::REDRT, None).until_40(24_000).until_56();
    assert_eq!(lane.starts(56_000), None);
    lane.release(lane.brake, 60_100);
    let unit = lane.starts(60_100).unwrap();
    assert_eq!(lane.scheduler.unit(unit).unwrap().first.task, lane.brake);
}

#[test]
fn what_was_short_of_late_need_not_wait() {
    // Its job fits between two of `brake` by what was measured, not by its WCET; there is no pressure.
    let mut lane = Lane::new(Config::REDRT, None).until_40(3_000).until_56();
    assert!(lane.starts(56_000).is_some());
    // A floor is looked ahead for without pressure, by the same measure.
    let mut lane = Lane::new(Config::REDRT_LOOKAHEAD, Some((1, 1)));
    lane.release(lane.brake, 0);
    lane.release(lane.map, 0);
    let first = lane.starts(0).unwrap();
    lane.complete(first, 16_000);
    assert_eq!(lane.starts(16_000), None);
    assert_eq!(lane.scheduler.poll_at(), Some(at(20_000)));
}
