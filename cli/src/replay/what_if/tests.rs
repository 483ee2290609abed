use super::*;
use red_workload::Format;

fn workload(deadline: &str) -> Workload {
    let text = format!(
        "pool = [{{ name = 'p', lanes = 1 }}, {{ name = 'q', lanes = 1 }}]\n[[task]]\nname = 't'\nperiod = '10ms'\n\
         deadline = '{deadline}'\nnode = [{{ name = 'a', wcet = '1ms' }}]\n"
    );
    red_workload::parse(text.as_bytes(), Format::Toml, "test").expect("a workload")
}

#[test]
fn too_many_lanes_of_all_pools_name_the_option_the_limit_and_the_cure() {
    let applied = |text: &str| {
        let changes: Vec<Change> = text.split(',').map(|change| change.parse().expect("a change")).collect();
        apply(&changes, &mut workload("10ms"), &mut Policy::Edf)
    };
    let told = applied("lanes=32").expect_err("33 lanes");
    assert!(
        ["--what-if", "lanes", "33", "32 at most", "lanes.POOL=N"].iter().all(|word| told.contains(word)),
        "{told}"
    );
    assert_eq!(applied("lanes.q=16,lanes=16"), Ok(()));
}

#[test]
fn a_run_that_was_stopped_is_judged_until_then_also_while_it_drained() {
    let (recorded, changed) = (workload("100ns"), workload("300ns"));
    let judged = |end, left_open| horizon_ns(1_000, end, left_open, [&recorded, &changed]);
    assert_eq!(judged(700, true), 700);
    assert_eq!(judged(1_050, true), 1_050);
    // Its jobs had ended, or it waited as long as it does.
    assert_eq!((judged(1_050, false), judged(1_100, true)), (1_300, 1_300));
}
