use super::super::plan;
use super::super::tests::{Lab, independent};
use super::*;
use crate::fixtures::accepted;
use crate::model::Workload;

const MS: i128 = 1_000_000;

fn admission(workload: &Workload) -> Admission {
    plan::<Lab>(workload).unwrap().admission
}

#[test]
fn a_bound_equal_to_its_limit_fits() {
    let exact = admission(&independent(1, &[(10, 10, 10)]));
    assert_eq!((exact.fits, exact.margin_ns, exact.guarantee), (true, 0, Guarantee::Analytic));
    let short = admission(&independent(1, &[(11, 10, 20)]));
    assert_eq!((short.fits, short.margin_ns), (false, -MS));
    assert_eq!(short.binding, "response time (graham) of task `t0`");
}

#[test]
fn the_period_limits_a_longer_deadline() {
    let admission = admission(&independent(1, &[(11, 30, 10)]));
    assert!(!admission.fits);
}

#[test]
fn a_pool_that_is_exactly_full_fits() {
    // Thirds of a second are no whole nanoseconds.
    let full = admission(&independent(1, &[(10, 30, 30), (10, 30, 30), (20, 60, 60)]));
    assert_eq!((full.fits, full.margin_ns), (true, 0));
    let over = admission(&independent(1, &[(10, 30, 30), (10, 30, 30), (21, 60, 60)]));
    assert!(!over.fits);
    assert_eq!(over.binding, "utilisation of pool `gpu`");
}

#[test]
fn a_hyperperiod_beyond_64_bits_still_gives_an_answer() {
    let mut workload = independent(1, &[(1, 10, 10); 16]);
    for (i, task) in workload.tasks.iter_mut().enumerate() {
        task.arrival = crate::model::Arrival::Periodic { period_ns: (1 << 60) + 2 * i as u64 + 1 };
    }
    assert!(admission(&workload).fits);
}

#[test]
fn tasks_that_share_a_pool_are_proved_together_or_not_at_all() {
    let light = admission(&independent(1, &[(1, 3, 10), (1, 10, 10)]));
    assert_eq!((light.guarantee, light.margin_ns), (Guarantee::Analytic, MS));
    assert_eq!(light.binding, "response time (A0) of task `t0` among all");
    // They fit alone, and the load is that of one lane of two; but on two lanes two long ones may go first.
    let blocked = admission(&independent(2, &[(2, 3, 10), (9, 10, 20), (9, 10, 20)]));
    assert_eq!((blocked.fits, blocked.guarantee), (true, Guarantee::BestEffort));
}

/// Two pools, a task in each; `cpu` is taken by an event of the first task too.
fn apart(event: &str) -> Workload {
    accepted(&format!(
        r#"
        pool = [{{ name = "gpu", lanes = 1 }}, {{ name = "cpu", lanes = 1 }}]
        [[task]]
        name = "a"
        deadline = "10ms"
        period = "10ms"
        node = [{{ name = "n", wcet = "1ms" }}]
        [[task]]
        name = "b"
        deadline = "10ms"
        period = "10ms"
        node = [{{ name = "n", wcet = "1ms", pool = "cpu" }}]
        {event}"#
    ))
}

#[test]
fn tasks_with_pools_of_their_own_are_proved_until_an_event_mixes_them_too_much() {
    assert_eq!(admission(&apart("")).guarantee, Guarantee::Analytic);
    let mixed = |wcet| {
        let add = format!("add = [{{ name = \"m\", wcet = \"{wcet}\", pool = \"cpu\" }}]");
        let mixed = admission(&apart(&format!("[[event]]\nat = \"1s\"\ntask = \"a\"\n{add}")));
        (mixed.fits, mixed.guarantee)
    };
    assert_eq!(mixed("1ms"), (true, Guarantee::Analytic));
    assert_eq!(
        mixed("8ms"),
        (true, Guarantee::BestEffort),
        "8 ms of it and 1 ms are no more than 10 ms, but for the event"
    );
}

#[test]
fn an_event_that_asks_for_too_much_is_named() {
    let heavy = "[[event]]\nat = \"1s\"\ntask = \"a\"\nadd = [{ name = \"m\", wcet = \"20ms\" }]";
    let overloaded = admission(&apart(heavy));
    assert!(!overloaded.fits);
    assert_eq!(overloaded.binding, "response time (graham) of task `a` after the events at 1.000 s");
    let passing = format!("{heavy}\n[[event]]\nat = \"2s\"\ntask = \"a\"\nremove = [\"m\"]");
    assert!(!admission(&apart(&passing)).fits, "an overload that passes is one all the same");
}

/// Two stages on one frame whose encoders take 1 ms and `other`, with a budget of `memory`.
fn stages(other: &str, memory: &str) -> Workload {
    accepted(&format!(
        r#"
        pool = [{{ name = "gpu", lanes = 2, memory = "{memory}" }}]
        [[task]]
        name = "a"
        deadline = "50ms"
        period = "50ms"
        [[task.node]]
        name = "p"
        mimonet = {{ weights = "w", frame = "f", encoder = {{ wcet = "1ms", memory = "1KiB" }}, decoders = [{{ name = "d", wcet = "1ms" }}] }}
        [[task.node]]
        name = "q"
        mimonet = {{ weights = "w", frame = "f", encoder = {{ wcet = "{other}", memory = "1KiB" }}, decoders = [{{ name = "d", wcet = "1ms" }}] }}"#
    ))
}

#[test]
fn a_result_that_may_take_longer_than_ones_own_execution_is_not_proved() {
    assert_eq!(admission(&stages("1ms", "1MiB")).guarantee, Guarantee::Analytic);
    assert_eq!(admission(&stages("9ms", "1MiB")).guarantee, Guarantee::BestEffort);
}

#[test]
fn a_budget_that_makes_nodes_wait_is_not_proved() {
    let tight = stages("1ms", "2KiB");
    let plan = plan::<Lab>(&tight).unwrap();
    assert!(!plan.tasks[0].certificate.base.memory_holds);
    assert_eq!((plan.admission.fits, plan.admission.guarantee), (true, Guarantee::BestEffort));
}

#[test]
fn tasks_that_share_encoder_results_are_proved_where_those_cost_the_same() {
    let mut workload = apart("");
    let stage = stages("1ms", "1MiB").tasks[0].nodes[0].clone();
    let mut elsewhere = stage.clone();
    let crate::model::Work::Stage(there) = &mut elsewhere.work else { panic!("a stage") };
    there.encoder.pool = 1;
    there.decoders[0].1.pool = 1;
    workload.tasks[0].nodes = vec![stage];
    workload.tasks[1].nodes = vec![elsewhere];
    assert_eq!(admission(&workload).guarantee, Guarantee::Analytic, "each job has its own capture");
    workload.sensors.push(crate::model::Sensor { name: "f".to_owned(), period_ns: 1 });
    assert_eq!(
        admission(&workload).guarantee,
        Guarantee::Analytic,
        "who waits for a result would compute it as long"
    );
    let crate::model::Work::Stage(there) = &mut workload.tasks[1].nodes[0].work else { panic!("a stage") };
    there.encoder.wcet_ns *= 2;
    assert_eq!(admission(&workload).guarantee, Guarantee::BestEffort);
}

#[test]
fn margins_are_exact_beyond_64_bits() {
    let mut workload = independent(1, &[(1, 10, 10); 16]);
    for task in &mut workload.tasks {
        task.deadline_ns = 1 << 62;
        let crate::model::Work::Plain(part) = &mut task.nodes[0].work else { panic!("a plain node") };
        part.wcet_ns = u64::MAX;
        set_period(&mut task.arrival, 1);
    }
    let late = admission(&workload);
    let second = 1_000_000_000;
    assert_eq!((late.fits, late.margin_ns), (false, second - 16 * second * i128::from(u64::MAX)));
    assert_eq!(late.binding, "utilisation of pool `gpu`");
    workload.tasks.truncate(1);
    set_period(&mut workload.tasks[0].arrival, 1 << 62);
    let plan = plan::<Lab>(&workload).unwrap();
    assert_eq!(plan.tasks[0].certificate.base.margin_ns, (1 << 62) - i128::from(u64::MAX));
    let text = serde_json::to_string(&plan).unwrap();
    assert!(text.contains(r#""margin_ns":-13835058055282163711"#), "{text}");
}

fn set_period(arrival: &mut crate::model::Arrival, period_ns: u64) {
    *arrival = crate::model::Arrival::Periodic { period_ns };
}
