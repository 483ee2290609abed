use super::*;
use crate::TicketLock;
use red_core::Caps;

/// The paper's workload: 4 tasks of 16 nodes, 16 jobs, 4 lanes.
type Paper = Caps<4, 16, 16>;

#[test]
fn the_papers_workload_fits_in_12_kib_with_its_synchronizers() {
    let bytes = size_of::<SharedScheduler<Paper, TicketLock<Scheduler<Paper>>, 1, 8>>();
    assert!(bytes <= 12 * 1024, "{bytes} bytes");
    assert_eq!(Scheduler::<Paper>::RECORD_SIZE, size_of::<u64>() * 4);
}

#[test]
fn who_keeps_posting_cannot_keep_a_lane() {
    let mut dag = red_core::Dag::<Paper>::new();
    dag.add_node(red_core::Node::new(red_core::Wcet::from_millis(1))).unwrap();
    let mut scheduler = Scheduler::<Paper>::new(red_core::Config::REDRT);
    let timing = red_core::Timing::new(red_core::Duration::from_millis(50));
    let request =
        Request { task: scheduler.add_task(&dag, timing).unwrap(), at: Instant::ZERO, capture: None };
    let shared = SharedScheduler::<_, TicketLock<_>, 2, 4>::new(scheduler);
    let [noisy, quiet] = [0, 1].map(|number| shared.producer(number).unwrap());
    assert!(shared.producer(0).is_none() && shared.producer(2).is_none());
    noisy.push(request).unwrap();
    quiet.push(Request { capture: Some(7), ..request }).unwrap();
    let taken = shared.with(|_, requests| {
        let posting = core::iter::from_fn(|| {
            let next = requests.next();
            noisy.push(request).unwrap_or(());
            next
        });
        posting.map(|request| request.capture).take(100).collect::<Vec<_>>()
    });
    assert_eq!(taken, [None, None, None, None, Some(7)]);
}
