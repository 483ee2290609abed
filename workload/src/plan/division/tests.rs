use super::super::plan;
use super::super::tests::{Lab, independent};
use super::*;
use crate::fixtures::accepted;
use crate::model::Workload;
use crate::plan::Guarantee;

fn divided(workload: &Workload) -> Option<Division> {
    division::<Lab>(workload, &plan::<Lab>(workload).unwrap()).unwrap()
}

#[test]
fn a_division_that_is_written_into_the_file_proves_what_it_says() {
    let workload = independent(2, &[(30, 100, 100), (40, 100, 100), (5, 10, 100)]);
    let found = divided(&workload).expect("a division");
    assert_eq!(found.proved, 3);
    let lines = found.to_string();
    assert!(
        lines.contains(
            "to pool `gpu`:\n    clusters = [{ name = \"c1\", lanes = 1 }, { name = \"c2\", lanes = 1 }]"
        ),
        "{lines}"
    );
    assert!(
        lines.contains("to t2:\n    cluster = \"c1\"") && lines.contains("to t0, t1:\n    cluster = \"c2\""),
        "{lines}"
    );
    let task = |name: &str, cluster: &str, wcet: u64, deadline: u64| {
        format!(
            "[[task]]\nname = \"{name}\"\ncluster = \"{cluster}\"\ndeadline = \"{deadline}ms\"\nperiod = \"100ms\"\n\
             node = [{{ name = \"n\", wcet = \"{wcet}ms\" }}]\n"
        )
    };
    let file = format!(
        "pool = [{{ name = \"gpu\", lanes = 2, clusters = [{{ name = \"c1\", lanes = 1 }}, {{ name = \"c2\", lanes = 1 }}] }}]\n{}{}{}",
        task("t0", "c2", 30, 100),
        task("t1", "c2", 40, 100),
        task("t2", "c1", 5, 10),
    );
    assert_eq!(plan::<Lab>(&accepted(&file)).unwrap().admission.guarantee, Guarantee::Analytic);
}

#[test]
fn what_is_proved_needs_no_division() {
    assert_eq!(divided(&independent(2, &[(1, 10, 10)])), None);
}
