use crate::prove;
use crate::world::{set, task};
use red_certificate::Cluster;

#[test]
fn a_task_alone_in_two_clusters_takes_its_path_and_what_waits_beside_it() {
    let mut both = task("both", 100, Some(100), &[4, 6, 6], &[(0, 1), (0, 2)]);
    both.versions[0].nodes[1].cluster = 1;
    both.versions[0].nodes[2].cluster = 1;
    let mut set = set(1, vec![both]);
    set.clusters.push(Cluster { pool: "dla".to_owned(), name: "dla".to_owned(), lanes: 1 });
    let certificate = prove(&set);
    assert_eq!(certificate.tasks[0].response_ns, Some(16), "{certificate:?}");
}
