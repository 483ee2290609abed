//! Who could have all jobs in time beside all that counts before it has them, whatever comes of less value.

use super::waits::{on_time, on_time_on, task};

/// Two that fit together, and one that comes on top.
fn control_detector_map() -> [String; 3] {
    [
        task("control", "value = 50", (40, 70), &[("cpu", 3), ("cpu", 3), ("cpu", 3)]),
        task("detector", "value = 60", (40, 48), &[("cpu", 29)]),
        task("map", "value = 1", (80, 110), &[("cpu", 18)]),
    ]
}

/// 29 ms of the highest value cannot go first each time, though both above `map` fit together.
#[test]
fn what_is_worth_more_waits_where_it_can() {
    let [control, detector, map] = control_detector_map();
    for tasks in [[&control, &detector, &map], [&map, &detector, &control], [&detector, &map, &control]] {
        let found = on_time(&tasks.map(String::as_str).concat());
        let is_above = |t: &usize| *tasks[*t] != map;
        let fares = (0..3).filter(is_above).map(|t| found[t]);
        assert!(fares.into_iter().all(|(on_time, due)| on_time + 9 >= due), "{found:?}");
    }
}

/// One job of 30 ms at the start, and it is as if it had never come: what comes once costs the others its own time.
#[test]
fn what_came_once_costs_nobody_its_jobs_for_ever() {
    let once = "[[task]]\nname = 'once'\nonce = true\ndeadline = '100ms'\nvalue = 1000\n\
                [[task.node]]\nname = 'n'\nwcet = '30ms'\n";
    let others = control_detector_map().concat();
    let (without, found) = (on_time(&others), on_time(&[once, &others].concat()));
    assert_eq!(found[0], (1, 1));
    for (with, without) in found[1..3].iter().zip(&without) {
        assert!(with.0 + 5 >= without.0, "{found:?}, without {without:?}");
    }
}

/// What floors need goes before values, but leaves `control` all of its 500 jobs where it does not need its lane.
#[test]
fn floors_take_no_more_than_they_need() {
    let objects = "[[task]]\nname = 'objects'\nperiod = '20ms'\ndeadline = '20ms'\nfloor = [1, 2]\nnode = [\n\
        { name = 'near', wcet = '8ms', body = { spin = '7ms' } }, { name = 'far', wcet = '8ms', body = { spin = '7ms' } }]\n";
    let others = |value: u32| {
        format!(
            "[[task]]\nname = 'flow-{value}'\nperiod = '20ms'\ndeadline = '40ms'\nvalue = {value}\nnode = [\n\
            {{ name = 'a', wcet = '3ms', body = {{ spin = '2ms' }} }}, {{ name = 'b', wcet = '3ms', body = {{ spin = '2ms' }} }}]\n"
        )
    };
    let map = task("map", "value = 4\nfloor = [1, 2]", (20, 100), &[("cpu", 12)]);
    let control = task("control", "value = 1000", (20, 20), &[("cpu", 16)]);
    let found = on_time_on(2, &[objects.to_owned(), others(3), others(2), map, control].concat());
    assert!(found[4].0 + 9 >= found[4].1, "{found:?}");
    assert!(2 * found[0].0 >= found[0].1 && 2 * found[3].0 >= found[3].1, "{found:?}");
}
