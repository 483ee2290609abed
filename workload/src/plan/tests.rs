use super::*;
use crate::fixtures::{EXAMPLE_TOML, accepted};

pub(super) type Lab = red_core::Caps<16, 256, 64, 32, 32, 4, 16>;

const MS: u64 = 1_000_000;

/// One pool of `lanes` lanes, tasks of one node each: (cost, deadline, period) in milliseconds.
pub(super) fn independent(lanes: u32, tasks: &[(u64, u64, u64)]) -> Workload {
    let mut text = format!("pool = [{{ name = \"gpu\", lanes = {lanes} }}]\n");
    for (i, (cost, deadline, period)) in tasks.iter().enumerate() {
        text += &format!(
            "[[task]]\nname = \"t{i}\"\ndeadline = \"{deadline}ms\"\nperiod = \"{period}ms\"\n\
             node = [{{ name = \"n\", wcet = \"{cost}ms\" }}]\n"
        );
    }
    accepted(&text)
}

#[test]
fn the_manuals_example_is_planned_before_and_after_its_events() {
    let plan = plan::<Lab>(&accepted(EXAMPLE_TOML)).unwrap();
    let [task] = &plan.tasks[..] else { panic!("one task") };
    let names: Vec<&str> = task.nodes.iter().map(|node| &*node.name).collect();
    assert_eq!(names, ["camera", "perception.encoder", "perception.lane", "perception.segment", "control"]);
    assert_eq!((task.work_ns, task.critical_path_ns), (28 * MS, 24 * MS));
    let heights: Vec<usize> = task.nodes.iter().map(|node| node.height).collect();
    assert_eq!(heights, [0, 1, 2, 2, 3]);
    // Graham on two lanes: 24 + 4 / 2; two paths taken apart leave nothing beside them: 24 + 0.
    let base = &task.certificate.base;
    assert_eq!((base.bound, base.response_ns, base.limit_ns), ("long-path", 24 * MS, 100 * MS));
    let changed: Vec<(u64, u64)> =
        task.certificate.changes.iter().map(|p| (p.at_ns / MS, p.work_ns / MS)).collect();
    assert_eq!(changed, [(3_000, 37), (6_000, 28)]);
    assert!(plan.admission.fits);
}

#[test]
fn json_has_the_keys_of_the_contract_in_their_order() {
    let plan = plan::<Lab>(&independent(1, &[(1, 10, 10)])).unwrap();
    let text = serde_json::to_string(&plan).unwrap();
    let expected = r#"{"tasks":[{"name":"t0","deadline_ns":10000000,"work_ns":1000000,"critical_path_ns":1000000,"levels":[{"height":0,"cost_ns":1000000,"share_ns":10000000}],"nodes":[{"name":"n","height":0,"cost_ns":1000000,"level_sum_ns":10000000,"level_graham_ns":10000000,"path_proportional_ns":10000000,"latest_finish_ns":10000000,"latest_start_ns":9000000}],"certificate":{"#;
    assert!(text.starts_with(expected), "{text}");
    let end = format!(
        r#""admission":{{"fits":true,"guarantee":"analytic","binding":"response time (graham) of task `t0`","margin_ns":9000000}},"scheduler_bytes":{},"certificate":{{"version":1,"#,
        plan.scheduler_bytes
    );
    assert!(text.contains(&end), "{text}");
}

#[test]
fn latest_times_are_exact_below_the_signed_range() {
    let mut workload = independent(1, &[(1, 10, 10)]);
    let mut node = workload.tasks[0].nodes[0].clone();
    (node.name, node.after) = ("m".to_owned(), vec!["n".to_owned()]);
    let crate::model::Work::Plain(part) = &mut node.work else { panic!("a plain node") };
    part.wcet_ns = u64::MAX - MS;
    workload.tasks[0].nodes.push(node);
    let plan = plan::<Lab>(&workload).unwrap();
    let node = &plan.tasks[0].nodes[0];
    let tail = i128::from(u64::MAX - MS);
    assert_eq!(node.latest_finish_ns, i128::from(10 * MS) - tail);
    assert_eq!(node.latest_start_ns, i128::from(9 * MS) - tail);
    let text = serde_json::to_string(&plan).unwrap();
    assert!(text.contains(&format!(r#""latest_start_ns":{}"#, node.latest_start_ns)), "{text}");
}
