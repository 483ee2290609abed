use super::*;
use crate::graph::NodeSet;
use crate::Caps;
type Robot = Caps<4, 16, 16>;
#[test]
fn sizes() {
    println!("sched {} pool {} lane {} job {} task {} version {} output {} susp {} queue-entry {} ", size_of::<Scheduler<Robot>>(), size_of::<Pool<Robot>>(), size_of::<Lane>(), size_of::<Job<Robot>>(), size_of::<Task<Robot>>(),
     size_of::<version::Version<Robot>>(), size_of::<Output>(), size_of::<Suspended>(), size_of::<Entry<Rank>>());
    println!("node {} est {} set {} config {} monitor {}", size_of::<crate::Node>(), size_of::<crate::Estimator>(), size_of::<NodeSet<Robot>>(), size_of::<Config>(), size_of::<Monitor>());
}
#[test]
fn shared_size() {
    println!("shared {}", size_of::<crate::SharedScheduler<Robot, crate::sync::TicketLock<Scheduler<Robot>>, 1, 8>>());
}
