use super::*;
use crate::Table;

type Queue = ReadyQueue<u64, Table<u64, 16>, Table<u16, 16>>;

/// Random operations; fewer where each takes an interpreter.
const ROUNDS: u64 = if cfg!(miri) { 100 } else { 4_000 };

/// A sequence of random operations against a sorted list.
#[test]
fn agrees_with_a_sorted_list() {
    let mut state = 1u64;
    let mut random = |n: u64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) % n
    };
    let mut queue = Queue::new();
    let mut list: Vec<(u64, usize)> = Vec::new();
    for round in 0..ROUNDS {
        let slot = random(16) as usize;
        // Distinct keys, so that the order is total.
        let key = random(1 << 20) << 16 | round;
        let at = list.iter().position(|e| e.1 == slot);
        match random(4) {
            0 => {
                queue.push(slot, key);
                list.retain(|e| e.1 != slot);
                list.push((key, slot));
            }
            1 => {
                let expected = list.first().map(|e| (e.1, e.0));
                assert_eq!(queue.pop(), expected);
                if expected.is_some() {
                    list.remove(0);
                }
            }
            2 => {
                assert_eq!(queue.rekey(slot, key), at.is_some());
                at.into_iter().for_each(|i| list[i].0 = key);
            }
            _ => assert_eq!(queue.remove(slot), at.map(|i| list.remove(i).0)),
        }
        list.sort_unstable();
        assert_eq!(queue.len(), list.len());
        assert_eq!(queue.peek(), list.first().map(|e| (e.1, e.0)));
        assert!((0..16).all(|s| queue.contains(s) == list.iter().any(|e| e.1 == s)));
    }
}
