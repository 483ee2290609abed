use super::*;
use std::cell::RefCell;

fn unit(number: u64, lane: u64) -> UnitId {
    UnitId::from_bits(number << 16 | lane)
}

/// Three streams; an event is its number.
struct Device {
    order: Order<usize>,
    own: [Own; 3],
    /// What each stream waited for.
    waited: RefCell<Vec<(usize, usize)>>,
}

impl Device {
    fn new() -> Self {
        let mut events = 0..;
        let order = Order::new(0b111, || events.next().ok_or(())).unwrap();
        Self { order, own: [0, 1, 2].map(Own::of), waited: RefCell::default() }
    }

    /// Gives a unit to its stream.
    fn give(&mut self, unit: UnitId, after: &[UnitId]) -> Option<(u64, u64)> {
        let lane = unit.lane().index();
        let own = &mut self.own[lane];
        let waited = |event: &usize| -> Result<(), ()> {
            self.waited.borrow_mut().push((lane, *event));
            Ok(())
        };
        let waits = self.order.wait_for(own, after, waited).unwrap()?;
        self.order.mark(own, unit, |_| Ok::<_, ()>(())).unwrap();
        Some((waits.issued, waits.avoided))
    }
}

#[test]
fn what_was_not_given_yet_is_not_waited_for() {
    let mut device = Device::new();
    assert_eq!(device.give(unit(2, 1), &[unit(1, 0)]), None);
    assert_eq!(device.give(unit(1, 0), &[]), Some((0, 0)));
    assert_eq!(device.give(unit(2, 1), &[unit(1, 0)]), Some((1, 0)));
    assert_eq!(device.waited.borrow().len(), 1);
}

#[test]
fn a_wait_that_an_earlier_one_implies_is_avoided() {
    let mut device = Device::new();
    device.give(unit(1, 0), &[]);
    assert_eq!(device.give(unit(2, 1), &[unit(1, 0)]), Some((1, 0)));
    // Its stream waited for that already.
    assert_eq!(device.give(unit(3, 1), &[unit(1, 0)]), Some((0, 1)));
    // By way of the second stream, and of its order.
    assert_eq!(device.give(unit(4, 2), &[unit(3, 1), unit(1, 0)]), Some((1, 1)));
    assert_eq!(device.give(unit(5, 2), &[unit(1, 0), unit(2, 1)]), Some((0, 2)));
    // What came later is another matter.
    device.give(unit(6, 0), &[]);
    assert_eq!(device.give(unit(7, 2), &[unit(6, 0)]), Some((1, 0)));
    // The youngest is looked at first.
    device.give(unit(8, 1), &[unit(6, 0)]);
    device.give(unit(9, 0), &[unit(8, 1)]);
    assert_eq!(device.give(unit(10, 2), &[unit(8, 1), unit(9, 0)]), Some((1, 1)));
}

#[test]
fn a_mark_that_is_another_turns_by_now_is_not_waited_for() {
    let mut device = Device::new();
    for number in 1..=MARKS as u64 + 1 {
        device.give(unit(number, 0), &[]);
    }
    assert_eq!(device.give(unit(100, 1), &[unit(1, 0)]), Some((0, 1)));
    assert_eq!(device.order.event(0, 1), None);
    assert!(device.order.event(0, 2).is_some());
}

#[test]
fn random_orders_wait_for_what_they_must_and_for_nothing_else() {
    // What each unit follows, by brute force.
    let mut state = 7_u64;
    let mut random = move |below: u64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) % below
    };
    for _ in 0..300 {
        let mut device = Device::new();
        let mut follows: Vec<Vec<bool>> = Vec::new();
        let mut units: Vec<UnitId> = Vec::new();
        let mut last: [Option<usize>; 3] = [None; 3];
        for number in 1..=12 {
            let lane = random(3) as usize;
            let others: Vec<usize> =
                (0..units.len()).filter(|i| units[*i].lane().index() != lane && random(3) == 0).collect();
            let after: Vec<UnitId> = others.iter().map(|i| units[*i]).collect();
            let mut own = vec![false; 12];
            let take = |own: &mut Vec<bool>, i: usize, follows: &[Vec<bool>]| {
                own[i] = true;
                (0..i).for_each(|j| own[j] |= follows[i][j]);
            };
            if let Some(i) = last[lane] {
                take(&mut own, i, &follows);
            }
            // The youngest first, as a reader of the rule would.
            let mut needed = 0;
            for i in others.iter().rev() {
                if !own[*i] {
                    needed += 1;
                    take(&mut own, *i, &follows);
                }
            }
            let all = others.len() as u64;
            assert_eq!(device.give(unit(number, lane as u64), &after), Some((needed, all - needed)));
            last[lane] = Some(units.len());
            units.push(unit(number, lane as u64));
            follows.push(own);
        }
    }
}
