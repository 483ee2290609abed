//! A lane that waits for jobs of a higher rank: how long, and by what it reckons.

use red_core::{Action, Caps, Config, Dag, Duration, Instant, Node, Scheduler, TaskId, Timing, UnitId, Wcet};

type Small = Caps<2, 1, 4, 1, 1, 1>;

const MS: u64 = 1_000_000;

/// `brake`, worth 1000, takes 16 ms of each 20; a node of `map` takes up to 24 ms.
struct Lane {
    scheduler: Scheduler<Small>,
    brake: TaskId,
    map: TaskId,
}

impl Lane {
    fn new(config: Config, floor: Option<(u32, u32)>) -> Self {
        Self::due(config, floor, 20)
    }

    /// With jobs of `brake` that are due so long after their release.
    fn due(config: Config, floor: Option<(u32, u32)>, deadline_ms: u64) -> Self {
        let mut scheduler = Scheduler::<Small>::new(config);
        let mut add = |cost_ms, deadline_ms, value, floor: Option<(u32, u32)>| {
            let mut dag = Dag::new();
            let best = Duration::from_millis(if cost_ms == 16 { 16 } else { 0 });
            dag.add_node(Node::new(Wcet::from_millis(cost_ms)).best_case(best)).unwrap();
            let timing = Timing::new(Duration::from_millis(deadline_ms));
            let timing = timing.every(Duration::from_millis(20)).value(value);
            scheduler.add_task(&dag, floor.map_or(timing, |(m, k)| timing.floor(m, k))).unwrap()
        };
        let (brake, map) = (add(16, deadline_ms, 1_000, floor), add(24, 200, 1, None));
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

    /// `brake` has run from 0 to 16 ms, and a job of `map` is there.
    fn until_16(mut self) -> Self {
        self.release(self.brake, 0);
        self.release(self.map, 0);
        let first = self.starts(0).unwrap();
        self.complete(first, 16_000);
        self
    }
}

fn at(us: u64) -> Instant {
    Instant::ZERO.saturating_add(Duration::from_nanos(us * MS / 1_000))
}

#[test]
fn a_late_release_is_waited_for_for_an_eighth_of_its_period() {
    let mut lane = Lane::new(Config::REDRT, None).until_16();
    assert_eq!(lane.starts(16_000), None);
    assert!(!lane.scheduler.can_dispatch(), "the node that is ready waits");
    assert_eq!(lane.scheduler.poll_at(), Some(at(20_000)));
    // `brake` should be there at 20.
    assert_eq!((lane.starts(20_000), lane.starts(22_499)), (None, None));
    assert_eq!(lane.scheduler.poll_at(), Some(at(22_500)));
    assert!(lane.starts(22_500).is_some());
}

#[test]
fn a_release_in_time_is_first() {
    let mut lane = Lane::new(Config::REDRT, None).until_16();
    assert_eq!(lane.starts(16_000), None);
    lane.release(lane.brake, 20_100);
    let unit = lane.starts(20_100).unwrap();
    assert_eq!(lane.scheduler.unit(unit).unwrap().first.task, lane.brake);
}

#[test]
fn what_was_short_of_late_need_not_wait() {
    let mut lane = Lane::new(Config::REDRT, None);
    lane.release(lane.map, 0);
    let alone = lane.starts(0).unwrap();
    lane.complete(alone, 3_000);
    // The next one fits between two of `brake` by what was measured, not by its WCET.
    lane.release(lane.brake, 20_000);
    lane.release(lane.map, 20_000);
    let first = lane.starts(20_000).unwrap();
    lane.complete(first, 36_000);
    assert!(lane.starts(36_000).is_some());
}

#[test]
fn a_floor_is_waited_for_whatever_the_values() {
    for config in [Config::REDRT, Config::REDRT_LOOKAHEAD] {
        let mut lane = Lane::new(config, Some((1, 1))).until_16();
        assert_eq!(lane.starts(16_000), None);
        assert_eq!(lane.scheduler.poll_at(), Some(at(20_000)));
    }
}

#[test]
fn what_has_enough_to_spare_is_not_waited_for() {
    // Behind the node `brake` starts at 40 ms, 20 after its release, and takes 16.
    for (deadline_ms, starts) in [(20, false), (35, false), (36, true)] {
        let mut lane = Lane::due(Config::REDRT, None, deadline_ms).until_16();
        assert_eq!(lane.starts(16_000).is_some(), starts, "{deadline_ms} ms");
    }
}

#[test]
fn who_has_never_come_or_comes_no_more_is_not_waited_for() {
    let mut lane = Lane::new(Config::REDRT, None);
    lane.release(lane.map, 16_000);
    assert!(lane.starts(16_000).is_some());
    let mut lane = Lane::new(Config::REDRT, None).until_16();
    assert!(lane.scheduler.remove_task(lane.brake, at(16_000)));
    assert!(lane.starts(16_000).is_some());
}

/// Jobs to come of a short period take no place from the next job of another task.
#[test]
fn many_jobs_of_one_task_hide_none_of_another() {
    let mut scheduler = Scheduler::<Caps<3, 2, 4, 2, 1, 1>>::new(Config::REDRT.with_lanes(2));
    let mut add = |nodes, cost_ms, period_ms, deadline_ms, value| {
        let mut dag = Dag::new();
        for _ in 0..nodes {
            dag.add_node(Node::new(Wcet::from_millis(cost_ms))).unwrap();
        }
        let timing = Timing::new(Duration::from_millis(deadline_ms)).every(Duration::from_millis(period_ms));
        scheduler.add_task(&dag, timing.value(value).floor(1, 1)).unwrap()
    };
    let (short, brake) = (add(1, 1, 5, 5, 1_000), add(2, 20, 45, 22, 1_000));
    let map = add(1, 40, 1_000, 400, 1);
    let starts = |scheduler: &mut Scheduler<_>, now| {
        let mut units = Vec::new();
        while let Some(action) = scheduler.poll(now) {
            if let Action::Dispatch(dispatch) = action {
                units.push(dispatch.unit);
            }
        }
        units
    };
    for (task, ends_us) in [(short, 1_000), (brake, 20_000), (short, 21_000)] {
        let now = at(ends_us - if task == brake { 20_000 } else { 1_000 });
        scheduler.release(task, now).unwrap();
        for unit in starts(&mut scheduler, now) {
            scheduler.complete(unit, at(ends_us)).unwrap();
        }
    }
    // Until 61 ms `map` would hold one of the lanes that `brake` needs at 45 ms, and four jobs of `short` come before.
    scheduler.release(map, at(21_000)).unwrap();
    assert_eq!(starts(&mut scheduler, at(21_000)), []);
    assert_eq!(scheduler.poll_at(), Some(at(45_000)));
}
