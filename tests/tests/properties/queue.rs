//! The ready queue against a sorted list.

use proptest::prelude::*;
use red_core::{ReadyQueue, Table};

use super::cases;

#[derive(Clone, Debug)]
enum Call {
    Push(usize, u64),
    Pop,
    Rekey(usize, u64),
    Remove(usize),
}

fn call() -> impl Strategy<Value = Call> {
    let key = || 0u64..20;
    prop_oneof![
        4 => (0usize..24, key()).prop_map(|(slot, key)| Call::Push(slot, key)),
        2 => Just(Call::Pop),
        2 => (0usize..24, key()).prop_map(|(slot, key)| Call::Rekey(slot, key)),
        1 => (0usize..24).prop_map(Call::Remove),
    ]
}

proptest! {
    #![proptest_config(cases(512))]

    #[test]
    fn it_is_a_list_that_is_sorted(calls in prop::collection::vec(call(), 0..200)) {
        let mut queue = ReadyQueue::<u64, Table<_, 24>, Table<_, 24>>::new();
        let mut list: Vec<(u64, usize)> = Vec::new();
        for call in calls {
            match call {
                Call::Push(slot, key) => {
                    queue.push(slot, key);
                    list.retain(|(_, other)| *other != slot);
                    list.push((key, slot));
                }
                Call::Pop => {
                    let popped = queue.pop();
                    // Which of equal keys goes first is the key's business.
                    prop_assert_eq!(popped.map(|(_, key)| key), list.iter().map(|(key, _)| *key).min());
                    if let Some((slot, key)) = popped {
                        prop_assert!(list.contains(&(key, slot)));
                        list.retain(|(_, other)| *other != slot);
                    }
                }
                Call::Rekey(slot, key) => {
                    queue.rekey(slot, key);
                    list.iter_mut().filter(|(_, other)| *other == slot).for_each(|entry| entry.0 = key);
                }
                Call::Remove(slot) => {
                    let there = list.iter().find(|(_, other)| *other == slot).map(|(key, _)| *key);
                    prop_assert_eq!(queue.remove(slot), there);
                    list.retain(|(_, other)| *other != slot);
                }
            }
            prop_assert_eq!(queue.len(), list.len());
            prop_assert_eq!(queue.peek().map(|(_, key)| key), list.iter().map(|(key, _)| *key).min());
            prop_assert!((0..24).all(|slot| queue.contains(slot) == list.iter().any(|(_, other)| *other == slot)));
        }
    }
}
