use super::super::plan;
use super::super::tests::{Lab, independent};
use super::*;
use crate::fixtures::accepted;
use crate::model::Workload;
use crate::plan::Guarantee;

fn divided_where(workload: &Workload, accepts: impl FnMut(&Workload) -> bool) -> Option<Division> {
    division::<Lab>(workload, &plan::<Lab>(workload).unwrap(), accepts).unwrap()
}

fn divided(workload: &Workload) -> Option<Division> {
    divided_where(workload, |_| true)
}

#[test]
fn a_division_that_is_written_into_the_file_proves_what_it_says() {
    let tasks = [(8, 33, 100), (18, 35, 100), (6, 18, 100)];
    let workload = independent(2, &tasks);
    assert_eq!(plan::<Lab>(&workload).unwrap().admission.guarantee, Guarantee::BestEffort);
    let found = divided(&workload).expect("a division");
    assert_eq!((found.proved, found.clusters.len()), (3, 2));
    let lines = found.to_string();
    let clusters = "clusters = [{ name = \"c1\", lanes = 1 }, { name = \"c2\", lanes = 1 }]";
    assert!(lines.contains(&format!("to pool `gpu`:\n    {clusters}")), "{lines}");
    let cluster_of = |task: &str| {
        let holds = |cluster: &&Divided| cluster.tasks.iter().any(|other| other == task);
        found.clusters.iter().find(holds).map(|cluster| cluster.name.clone()).expect("a cluster")
    };
    for Divided { name, tasks, .. } in &found.clusters {
        let line = format!("  to {}:\n    cluster = \"{name}\"", tasks.join(", "));
        assert!(lines.contains(&line), "{lines}");
    }
    let mut file = format!("pool = [{{ name = \"gpu\", lanes = 2, {clusters} }}]\n");
    for (i, (wcet, deadline, period)) in tasks.into_iter().enumerate() {
        let cluster = cluster_of(&format!("t{i}"));
        file += &format!(
            "[[task]]\nname = \"t{i}\"\ncluster = \"{cluster}\"\ndeadline = \"{deadline}ms\"\n\
             period = \"{period}ms\"\nnode = [{{ name = \"n\", wcet = \"{wcet}ms\" }}]\n"
        );
    }
    assert_eq!(plan::<Lab>(&accepted(&file)).unwrap().admission.guarantee, Guarantee::Analytic);
    let mut asked = Vec::new();
    divided_where(&workload, |divided| {
        asked.push(divided.clone());
        true
    });
    assert_eq!(asked, [accepted(&file)], "what is asked about is what the file says");
}

#[test]
fn what_is_proved_needs_no_division() {
    assert_eq!(divided(&independent(2, &[(1, 10, 10)])), None);
}

#[test]
fn a_budget_is_not_divided() {
    let mut workload = independent(2, &[(8, 33, 100), (18, 35, 100), (6, 18, 100)]);
    workload.pools[0].memory_bytes = Some(1 << 30);
    assert_eq!(divided(&workload), None);
}

#[test]
fn a_division_is_dropped_under_which_a_bound_gets_longer() {
    // Lanes apart would prove `t2`, but `t0` and `t1` share one then, and each may wait for the whole other.
    let workload = independent(2, &[(30, 100, 100), (40, 100, 100), (5, 10, 100)]);
    let proved = plan::<Lab>(&workload).unwrap().certificate;
    let set = set::<Lab>(&workload).unwrap();
    let (_, divided_set) = red_analysis::divide(&set, &proved, |_, _| true).expect("a division");
    assert!(divided_set.is_analytic() && !proved.is_analytic());
    assert!(!is_no_worse(&proved, &divided_set));
    assert_eq!(divided(&workload), None);
}
