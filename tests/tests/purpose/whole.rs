//! Who could have all jobs in time beside all that counts before it has them, whatever comes of less value.

use super::waits::{on_time, on_time_on, task};

/// 29 ms of the highest value cannot go first each time, though both above `map` fit together.
#[test]
fn what_is_worth_more_waits_where_it_can() {
    let (detector, map) = (
        task("detector", "value = 60", (40, 48), &[("cpu", 29)]),
        task("map", "value = 1", (80, 110), &[("cpu", 18)]),
    );
    let control = task("control", "value = 50", (40, 70), &[("cpu", 3), ("cpu", 3), ("cpu", 3)]);
    for tasks in [[&control, &detector, &map], [&map, &detector, &control], [&detector, &map, &control]] {
        let found = on_time(&tasks.map(String::as_str).concat());
        let is_above = |t: &usize| *tasks[*t] != map;
        let fares = (0..3).filter(is_above).map(|t| found[t]);
        assert!(fares.into_iter().all(|(on_time, due)| on_time + 9 >= due), "{found:?}");
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
