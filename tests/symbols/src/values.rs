//! Calls of the core that no capacity changes, and of the queue.

use red_core::{CostEstimate, Duration, Estimator, Floor, Instant, ReadyQueue, Table};

type Queue = ReadyQueue<u64, Table<u64, 16>, Table<u16, 16>>;

#[expect(non_snake_case, reason = "an entry is the name of a type and that of its call")]
mod entry {
    use super::*;

    crate::entries! { "any";
        fn ReadyQueue_contains(queue: &Queue, slot: usize) -> bool { queue.contains(slot) }
        fn ReadyQueue_peek(queue: &Queue) -> Option<(usize, u64)> { queue.peek() }
        fn ReadyQueue_push(queue: &mut Queue, slot: usize, key: u64) { queue.push(slot, key) }
        fn ReadyQueue_pop(queue: &mut Queue) -> Option<(usize, u64)> { queue.pop() }
        fn ReadyQueue_rekey(queue: &mut Queue, slot: usize, key: u64) -> bool { queue.rekey(slot, key) }
        fn ReadyQueue_remove(queue: &mut Queue, slot: usize) -> Option<u64> { queue.remove(slot) }
        fn Floor_permits(floor: &Floor, index: u64) -> bool { floor.permits(index) }
        fn Floor_dropped(floor: &mut Floor, index: u64) { floor.dropped(index) }
        fn Estimator_push(window: &mut Estimator, executed: Duration) { window.push(executed) }
        fn Estimator_mean(window: &Estimator) -> Option<CostEstimate> { window.mean() }
        fn Estimator_minimum(window: &Estimator) -> Option<Duration> { window.minimum() }
        fn Estimator_maximum(window: &Estimator) -> Option<Duration> { window.maximum() }
        fn Instant_checked_add(instant: Instant, d: Duration) -> Option<Instant> { instant.checked_add(d) }
    }
}
