use red_tests::rng::{Shape, random_workload};
use red_tests::oracle::{self, Policy};
#[test]
fn probe() {
    let seed: u64 = std::env::var("SEED").unwrap().parse().unwrap();
    let t: u64 = std::env::var("T").unwrap().parse().unwrap();
    let w = random_workload(seed, &Shape::default());
    println!("{:#?}", w.pools);
    println!("{:?}", w.sensors);
    for task in &w.tasks { println!("{} D {} {:?} off {}", task.name, task.deadline_ns, task.arrival, task.offset_ns); for n in &task.nodes { println!("   {:?}", n); } }
    println!("{:?}", w.events.len());
    let o = oracle::simulate(&w, Policy::Redrt, 300_000_000);
    for r in o.rows.iter().filter(|r| r.finish_ns + 30_000_000 > t && r.start_ns <= t) { println!("{} {:?} {} {} {} .. {}", r.pool, r.lane, r.task, r.job, r.node, format!("{}-{}", r.start_ns, r.finish_ns)); }
    for s in &o.sheds { println!("{s:?}"); }
}
