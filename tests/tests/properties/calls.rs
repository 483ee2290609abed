//! Calls in any order.

use proptest::prelude::*;
use red_tests::calls::{Call, Change, Host, configurations};

use super::cases;

fn change() -> impl Strategy<Value = Change> {
    prop_oneof![
        (0u8..8, 0u8..8, 0u8..8).prop_map(|(after, cost, kind)| Change::Add(after, cost, kind)),
        (0u8..8).prop_map(Change::Remove),
        (0u8..8, 0u8..8).prop_map(|(from, to)| Change::Link(from, to)),
        (0u8..8, 0u8..8).prop_map(|(from, to)| Change::Unlink(from, to)),
    ]
}

fn call() -> impl Strategy<Value = Call> {
    prop_oneof![
        6 => (0u64..3_000).prop_map(Call::Wait),
        1 => (0u8..63).prop_map(Call::Leap),
        2 => (1u64..5_000).prop_map(Call::StepBack),
        6 => (0usize..2).prop_map(Call::Release),
        3 => (0usize..2, 0u64..3, 0u64..3_000).prop_map(|(task, capture, ago)| Call::Capture(task, capture, ago)),
        10 => (0usize..2).prop_map(Call::Complete),
        3 => (0usize..2).prop_map(Call::CompleteAndPoll),
        2 => (0usize..2).prop_map(Call::Fail),
        4 => (0usize..100).prop_map(Call::Again),
        1 => any::<u64>().prop_map(Call::Stranger),
        2 => (0usize..2).prop_map(Call::Remove),
        3 => (0usize..2, change()).prop_map(|(task, change)| Call::Edit(task, change)),
        2 => Just(Call::Commit),
        1 => (0u8..3).prop_map(Call::Retire),
        2 => (0u8..3).prop_map(Call::Restore),
        2 => Just(Call::Take),
        14 => Just(Call::Poll),
        2 => (0u8..3).prop_map(Call::PollOn),
    ]
}

proptest! {
    #![proptest_config(cases(1_000))]

    #[test]
    fn no_call_reaches_what_is_not_its_own_and_nothing_is_forgotten(
        config in prop::sample::select(configurations().to_vec()), calls in prop::collection::vec(call(), 1..150)
    ) {
        let mut host = Host::new(config);
        calls.into_iter().for_each(|call| host.call(call));
        host.finish();
    }
}

#[test]
fn a_failure_that_one_of_two_does_not_hear_of_is_found() {
    let calls = [Call::Release(0), Call::Poll, Call::StepBack(1), Call::Fail(0)];
    let tried = |planted: bool| {
        std::panic::catch_unwind(|| {
            let host = Host::new(configurations()[0]);
            let mut host = if planted { host.with_planted_bug() } else { host };
            calls.into_iter().for_each(|call| host.call(call));
            host.finish();
        })
    };
    assert!(tried(false).is_ok() && tried(true).is_err());
}

#[test]
fn a_result_that_an_encoder_without_decoders_took_last_is_freed() {
    let limited = configurations().into_iter().find(|config| config.memory.is_some());
    let mut host = Host::new(limited.expect("one of them has a budget"));
    let calls = [Call::Edit(1, Change::Add(3, 0, 0)), Call::Commit, Call::Release(1)];
    calls.into_iter().for_each(|call| host.call(call));
    host.finish();
}

/// Found by `cargo xtask fuzz core_calls`.
#[test]
fn lanes_that_are_busy_longer_than_a_clock_can_count_are_counted_on() {
    let mut host = Host::new(configurations()[0]);
    let calls =
        [Call::Release(0), Call::Release(1), Call::Poll, Call::Leap(62), Call::Leap(62), Call::Leap(62)];
    calls.into_iter().for_each(|call| host.call(call));
    host.finish();
}
