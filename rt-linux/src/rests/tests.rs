use super::*;
use std::collections::VecDeque;

const MS: u64 = 1_000_000;
const SECOND: u64 = 1_000 * MS;
const LINUX: RealTimeBudget = RealTimeBudget { runtime_ns: 950 * MS, period_ns: SECOND };

/// A thread that executes, rests and idles, and what it used in the last period.
struct Thread {
    rests: Rests,
    now: Reading,
    /// Begin and end of what it executed in the last period.
    executed: VecDeque<(u64, u64)>,
    used_ns: u64,
}

impl Thread {
    fn new(budget: RealTimeBudget) -> Self {
        let now = Reading { now_ns: 12_345_678_901, used_ns: 5 * SECOND };
        Self { rests: Rests::new(budget, now).unwrap(), now, executed: VecDeque::new(), used_ns: 0 }
    }

    /// Executes a body and rests. Panics where more than the runtime was used in the period that ends with the body.
    fn execute(&mut self, body_ns: u64, budget: RealTimeBudget) -> u64 {
        let end = self.now.now_ns + body_ns;
        self.executed.push_back((self.now.now_ns, end));
        let begin = end - budget.period_ns;
        self.used_ns += body_ns;
        while let Some((from, until)) = self.executed.pop_front_if(|first| first.1 <= begin) {
            self.used_ns -= until - from;
        }
        let before = self.executed.front().map_or(0, |first| begin.saturating_sub(first.0));
        let used = self.used_ns - before;
        assert!(used <= budget.runtime_ns, "{used} ns of {budget:?} at {end} ns");
        self.now = Reading { now_ns: end, used_ns: self.now.used_ns + body_ns };
        let rest = self.rests.owed(self.now);
        self.idle(rest);
        rest
    }

    fn idle(&mut self, time_ns: u64) {
        self.now.now_ns += time_ns;
    }
}

#[test]
fn a_lane_that_is_always_busy_never_uses_more_than_its_budget_and_little_less() {
    for body_us in [250, 1_000, 4_700, 15_000, 40_000, 60_000] {
        for idle_ms in [0, 5, 60, 400, 900] {
            let mut thread = Thread::new(LINUX);
            // With idle time somewhere.
            while thread.now.now_ns < 15 * SECOND {
                thread.execute(body_us * 1_000, LINUX);
            }
            thread.idle(idle_ms * MS);
            let start = thread.now;
            while thread.now.now_ns < start.now_ns + 10 * SECOND {
                thread.execute(body_us * 1_000, LINUX);
            }
            let used = thread.now.used_ns - start.used_ns;
            assert!(used * 100 > (thread.now.now_ns - start.now_ns) * 93, "{body_us} us: {used} ns in 10 s");
        }
    }
}

#[test]
fn other_budgets_are_kept_too() {
    for (runtime_ms, period_ms) in [(50, 1_000), (500, 1_000), (90, 100), (9_000, 10_000)] {
        let budget = RealTimeBudget { runtime_ns: runtime_ms * MS, period_ns: period_ms * MS };
        let mut thread = Thread::new(budget);
        let start = thread.now;
        while thread.now.now_ns < start.now_ns + 20 * budget.period_ns {
            thread.execute(MS / 2, budget);
        }
        let share = (thread.now.used_ns - start.used_ns) as f64 / (20 * budget.runtime_ns) as f64;
        assert!(share > 0.8, "{share} of {budget:?}");
    }
}

#[test]
fn a_lane_that_idles_for_a_while_does_not_rest() {
    for (busy_ms, idle_ms) in [(80, 8), (8, 1), (15, 1)] {
        let mut thread = Thread::new(LINUX);
        for _ in 0..10_000 / (busy_ms + idle_ms) {
            let rested: u64 = (0..busy_ms).map(|_| thread.execute(MS, LINUX)).sum();
            assert_eq!(rested, 0, "{busy_ms} ms of {}", busy_ms + idle_ms);
            thread.idle(idle_ms * MS);
        }
    }
}

#[test]
fn rests_are_short() {
    let mut thread = Thread::new(LINUX);
    let rests: Vec<_> = (0..5_000).map(|_| thread.execute(4 * MS, LINUX)).collect();
    assert!(rests.iter().all(|rest| *rest < 600_000) && rests.iter().any(|rest| *rest > 0));
}

#[test]
fn after_a_body_that_the_kernel_stopped_a_rest_is_no_longer_than_that_of_a_period() {
    for body_s in [1, 4, 100] {
        let start = Reading { now_ns: 0, used_ns: 0 };
        let mut rests = Rests::new(LINUX, start).unwrap();
        // Of each second 50 ms were taken.
        let end = Reading { now_ns: body_s * SECOND, used_ns: body_s * 950 * MS };
        let rest = rests.owed(end);
        assert!((1..=64 * MS).contains(&rest), "{rest} ns after {body_s} s");
        let later = Reading { now_ns: end.now_ns + rest + MS, used_ns: end.used_ns + MS };
        assert!(rests.owed(later) < MS, "once");
    }
}

#[test]
fn without_throttling_there_are_no_rests() {
    let start = Reading { now_ns: 0, used_ns: 0 };
    for (runtime_ns, period_ns) in [(SECOND, SECOND), (2 * SECOND, SECOND), (0, SECOND), (0, 0), (0, 99)] {
        assert!(Rests::new(RealTimeBudget { runtime_ns, period_ns }, start).is_none());
    }
}
