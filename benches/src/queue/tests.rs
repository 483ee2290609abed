use super::*;

fn pops_in_order<Q: ReadyQueue>() {
    let mut queue = Q::with_capacity(4);
    for (entry, key) in [(0, 40), (1, 10), (2, 30), (3, 20)] {
        queue.push(entry, key);
    }
    queue.rekey(1, 35);
    let order: Vec<_> = std::iter::from_fn(|| queue.pop()).collect();
    assert_eq!(order, [(3, 20), (2, 30), (1, 35), (0, 40)]);
}

#[test]
fn every_queue_orders_and_rekeys() {
    pops_in_order::<Orx<u64>>();
    pops_in_order::<Orx<u128>>();
    pops_in_order::<Ours<4>>();
}

#[test]
fn every_operation_runs_at_every_size() {
    for contestant in CONTESTANTS {
        for size in SIZES {
            let mut samples = [0; 2];
            assert!((contestant.hold)(size)(10, &mut samples).is_ok());
            assert!((contestant.rekey)(size)(10, &mut samples).is_ok());
        }
    }
}
