//! Calls of the core that no capacity changes, and of the queue.

use red_core::{
    Bytes, Certificate, Config, Contention, CostEstimate, DeadlineRule, Duration, Estimator, Floor, Frame,
    Instant, LaneId, Node, NodeId, Outcome, PoolId, ReadyQueue, Role, ShedReason, SignedDuration, Table,
    Timing, UnitId, Wcet,
};

type Queue = ReadyQueue<u64, Table<u64, 16>, Table<u16, 16>>;

#[expect(non_snake_case, reason = "an entry is the name of a type and that of its call")]
mod entry {
    use super::*;

    crate::entries! { "any";
        fn ReadyQueue_new() -> Queue { Queue::new() }
        fn ReadyQueue_is_empty(queue: &Queue) -> bool { queue.is_empty() }
        fn ReadyQueue_len(queue: &Queue) -> usize { queue.len() }
        fn ReadyQueue_contains(queue: &Queue, slot: usize) -> bool { queue.contains(slot) }
        fn ReadyQueue_peek(queue: &Queue) -> Option<(usize, u64)> { queue.peek() }
        fn ReadyQueue_push(queue: &mut Queue, slot: usize, key: u64) { queue.push(slot, key) }
        fn ReadyQueue_pop(queue: &mut Queue) -> Option<(usize, u64)> { queue.pop() }
        fn ReadyQueue_rekey(queue: &mut Queue, slot: usize, key: u64) -> bool { queue.rekey(slot, key) }
        fn ReadyQueue_remove(queue: &mut Queue, slot: usize) -> Option<u64> { queue.remove(slot) }
        fn Floor_new(m: u32, k: u32) -> Floor { Floor::new(m, k) }
        fn Floor_most_lost_around(floor: &Floor, index: u64) -> u32 { floor.most_lost_around(index) }
        fn Floor_spares(floor: &Floor, index: u64) -> bool { floor.spares(index) }
        fn Floor_ended(floor: &mut Floor, index: u64, is_lost: bool) { floor.ended(index, is_lost) }
        fn Estimator_new(node: &Node) -> Estimator { Estimator::new(node) }
        fn Estimator_push(window: &mut Estimator, executed: Duration) { window.push(executed) }
        fn Estimator_mean(window: &Estimator) -> Option<CostEstimate> { window.mean() }
        fn Estimator_minimum(window: &Estimator) -> Option<Duration> { window.minimum() }
        fn Estimator_maximum(window: &Estimator) -> Option<Duration> { window.maximum() }
        fn Instant_checked_add(instant: Instant, d: Duration) -> Option<Instant> { instant.checked_add(d) }
        fn Instant_saturating_add(instant: Instant, d: Duration) -> Instant { instant.saturating_add(d) }
        fn Instant_since(instant: Instant, earlier: Instant) -> Duration { instant.since(earlier) }
        fn Instant_minus(instant: Instant, other: Instant) -> SignedDuration { instant.minus(other) }
        fn Duration_from_micros(us: u64) -> Duration { Duration::from_micros(us) }
        fn Duration_from_secs(s: u64) -> Duration { Duration::from_secs(s) }
        fn Duration_saturating_add(d: Duration, other: Duration) -> Duration { d.saturating_add(other) }
        fn Wcet_get(wcet: Wcet) -> Duration { wcet.get() }
        fn Node_new(wcet: Wcet) -> Node { Node::new(wcet) }
        fn Node_shared_encoder(wcet: Wcet, frame: Frame) -> Node { Node::shared_encoder(wcet, frame) }
        fn Node_decoder(wcet: Wcet) -> Node { Node::decoder(wcet) }
        fn Node_best_case(node: Node, best: Duration) -> Node { node.best_case(best) }
        fn Node_atomic(node: Node, contention: Contention) -> Node { node.atomic(contention) }
        fn Node_memory(node: Node, memory: Bytes) -> Node { node.memory(memory) }
        fn Node_in_pool(node: Node, pool: PoolId) -> Node { node.in_pool(pool) }
        fn Node_cost(node: &Node) -> u64 { node.cost() }
        fn Node_role(node: &Node) -> Role { node.role() }
        fn Node_pool(node: &Node) -> PoolId { node.pool() }
        fn Node_wcet(node: &Node) -> Wcet { node.wcet() }
        fn Node_best(node: &Node) -> Duration { node.best() }
        fn Node_is_atomic(node: &Node) -> bool { node.is_atomic() }
        fn Node_footprint(node: &Node) -> Bytes { node.footprint() }
        fn UnitId_lane(unit: UnitId) -> LaneId { unit.lane() }
        fn UnitId_node(unit: UnitId) -> NodeId { unit.node() }
        fn UnitId_to_bits(unit: UnitId) -> u64 { unit.to_bits() }
        fn UnitId_from_bits(bits: u64) -> UnitId { UnitId::from_bits(bits) }
        fn Outcome_lateness(outcome: &Outcome) -> SignedDuration { outcome.lateness() }
        fn Outcome_on_time(outcome: &Outcome) -> bool { outcome.on_time() }
        fn ShedReason_name(reason: ShedReason) -> &'static str { reason.name() }
        fn Timing_new(deadline: Duration) -> Timing { Timing::new(deadline) }
        fn Timing_every(timing: Timing, period: Duration) -> Timing { timing.every(period) }
        fn Timing_value(timing: Timing, value: u32) -> Timing { timing.value(value) }
        fn Timing_parts(timing: &Timing) -> (Duration, Option<Duration>, u32, [u8; 2]) { timing.parts() }
        fn Timing_floor(timing: Timing, m: u32, k: u32) -> Timing { timing.floor(m, k) }
        fn Config_with_lanes(config: Config, lanes: u8) -> Config { config.with_lanes(lanes) }
        fn Config_with_memory(config: Config, memory: Bytes) -> Config { config.with_memory(memory) }
        fn Certificate_fits(proof: &Certificate) -> bool { proof.fits() }
        fn Certificate_margin(proof: &Certificate) -> SignedDuration { proof.margin() }
        fn DeadlineRule_is_level(rule: DeadlineRule) -> bool { rule.is_level() }
    }
}
