use super::*;
use std::collections::VecDeque;

const MS: u64 = 1_000_000;
const SECOND: u64 = 1_000 * MS;
const LINUX: RealTimeBudget = RealTimeBudget { runtime_ns: 950 * MS, period_ns: SECOND };

/// A thread that executes and idles, and what it used under SCHED_FIFO in the last period.
struct Thread {
    allowance: Allowance,
    now: Reading,
    /// Begin and end of what it executed under SCHED_FIFO in the last period.
    executed: VecDeque<(u64, u64)>,
    used_ns: u64,
}

impl Thread {
    fn new(budget: RealTimeBudget) -> Self {
        let now = Reading { now_ns: 12_345_678_901, used_ns: 5 * SECOND };
        let allowance = Allowance::new(budget, 70, now).unwrap();
        Self { allowance, now, executed: VecDeque::new(), used_ns: 0 }
    }

    /// Executes a body. Whether it was an ordinary one. Panics where more than the runtime was used in the period that ends
    /// with the body.
    fn execute(&mut self, body_ns: u64, budget: RealTimeBudget) -> bool {
        let (begin, is_ordinary) = (self.now.now_ns, self.allowance.is_used_up(self.now));
        let end = begin + body_ns;
        self.now = Reading { now_ns: end, used_ns: self.now.used_ns + body_ns };
        if is_ordinary {
            self.allowance.ran_ordinary(self.now);
            return true;
        }
        self.executed.push_back((begin, end));
        let first = end - budget.period_ns;
        self.used_ns += body_ns;
        while let Some((from, until)) = self.executed.pop_front_if(|body| body.1 <= first) {
            self.used_ns -= until - from;
        }
        let before = self.executed.front().map_or(0, |body| first.saturating_sub(body.0));
        let used = self.used_ns - before;
        assert!(used <= budget.runtime_ns, "{used} ns of {budget:?} at {end} ns");
        false
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
            let bodies = 10 * SECOND / (body_us * 1_000);
            let ordinary = (0..bodies).filter(|_| thread.execute(body_us * 1_000, LINUX)).count() as u64;
            // A body is ordinary as a whole.
            let at_most = if body_us < 5_000 { 8 } else { 50 };
            assert!(ordinary * 100 <= bodies * at_most, "{body_us} us: {ordinary} of {bodies} bodies");
            let told = thread.allowance.ordinary_ns;
            assert!(told >= ordinary * body_us * 1_000 && told < 25 * SECOND, "{told} ns");
        }
    }
}

#[test]
fn other_budgets_are_kept_too() {
    for (runtime_ms, period_ms) in [(50, 1_000), (500, 1_000), (90, 100), (9_000, 10_000)] {
        let budget = RealTimeBudget { runtime_ns: runtime_ms * MS, period_ns: period_ms * MS };
        let mut thread = Thread::new(budget);
        let bodies = 20 * budget.period_ns / (MS / 2);
        let fifo = (0..bodies).filter(|_| !thread.execute(MS / 2, budget)).count() as f64;
        let share = fifo * (MS as f64 / 2.0) / (20 * budget.runtime_ns) as f64;
        assert!(share > 0.8, "{share} of {budget:?}");
    }
}

#[test]
fn a_lane_that_idles_for_a_while_stays_in_real_time() {
    for (busy_ms, idle_ms) in [(80, 8), (8, 1), (15, 1)] {
        let mut thread = Thread::new(LINUX);
        for _ in 0..10_000 / (busy_ms + idle_ms) {
            let ordinary = (0..busy_ms).filter(|_| thread.execute(MS, LINUX)).count();
            assert_eq!(ordinary, 0, "{busy_ms} ms of {}", busy_ms + idle_ms);
            thread.idle(idle_ms * MS);
        }
    }
}

#[test]
fn a_body_that_the_kernel_stopped_is_made_up_for_by_no_more_than_a_period() {
    for body_s in [1, 4, 100] {
        let mut allowance = Allowance::new(LINUX, 70, Reading { now_ns: 0, used_ns: 0 }).unwrap();
        // Of each second 50 ms were taken.
        let mut now = Reading { now_ns: body_s * SECOND, used_ns: body_s * 950 * MS };
        let mut ordinary = 0;
        while allowance.is_used_up(now) {
            now = Reading { now_ns: now.now_ns + MS, used_ns: now.used_ns + MS };
            allowance.ran_ordinary(now);
            ordinary += 1;
        }
        assert!((1..=66).contains(&ordinary), "{ordinary} ms after {body_s} s");
    }
}

#[test]
fn without_throttling_there_is_no_allowance() {
    let start = Reading { now_ns: 0, used_ns: 0 };
    for (runtime_ns, period_ns) in [(SECOND, SECOND), (2 * SECOND, SECOND), (0, SECOND), (0, 0), (0, 99)] {
        assert!(Allowance::new(RealTimeBudget { runtime_ns, period_ns }, 70, start).is_none());
    }
}
