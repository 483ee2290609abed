use super::*;
use crate::{Bytes, Caps, Config, Dag, Duration, Timing, Wcet};

/// Three nodes fill the memory, and the last one, which needs 6 bytes, fits once the second of these ends: lanes are free for it before.
#[test]
fn a_node_starts_as_soon_as_there_is_memory() {
    type Small = Caps<4, 16, 16, 4, 2>;
    let mut scheduler = Scheduler::<Small>::new(Config::REDRT);
    let pool = scheduler.add_pool(3, Some(Bytes(10))).unwrap();
    let mut dag = Dag::<Small>::new();
    for (wcet, bytes) in [(9, 4), (7, 5), (5, 1), (2, 6)] {
        let node = Node::new(Wcet::from_nanos(wcet)).in_pool(pool);
        dag.add_node(node.memory(Bytes(bytes))).unwrap();
    }
    let task = scheduler.add_task(&dag, Timing::new(Duration::from_nanos(9))).unwrap();
    let need = scheduler.need_of_next(pool.index(), &scheduler.tasks[task.index()]);
    assert_eq!(need.lanes().collect::<Vec<_>>(), [(0, 5), (0, 9), (0, 9)]);
}
