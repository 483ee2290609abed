//! tmp
use red_core as _;
use red_sim::{Execution, Options, simulate};
use red_tests::oracle::{self, Policy};
use red_tests::rng::{Shape, random_workload};
use std::collections::BTreeSet;

#[test]
fn dbg() {
    let Ok(seeds) = std::env::var("DBG") else { return };
    let nomem = std::env::var("NOMEM").is_ok();
    let shape = Shape { memory: !nomem, pools: if std::env::var("ONE").is_ok() {1} else {2}, ..Shape::default() };
    let pols: Vec<usize> = std::env::var("POL").map(|p| p.split(',').map(|x| x.parse().unwrap()).collect()).unwrap_or(vec![0,1,2,3,4]);
    for seed in seeds.split(',').map(|s| s.parse::<u64>().unwrap()) { for &p in &pols {
        let policy = Policy::ALL[p];
        let w = random_workload(seed, &shape);
        let h = 300_000_000;
        let o = oracle::simulate(&w, policy, h);
        let options = Options { policy: red_workload::policy::Policy::ALL[p], horizon_ns: h, seed: 1, execution: Execution::Wcet, preempt: false, schedule: true };
        let r = simulate(&w, &options).unwrap();
        let a: BTreeSet<_> = r.schedule.unwrap().into_iter().map(|r| (r.start_ns, format!("{} lane {:?} {}/{}/{} ..{}", r.pool, r.lane, r.task, r.job, r.node, r.finish_ns)))
            .chain(r.sheds.unwrap().into_iter().map(|s| (s.at_ns, format!("SHED {}/{} {}", s.task, s.job, s.reason)))).collect();
        let b: BTreeSet<_> = o.rows.iter().map(|r| (r.start_ns, format!("{} lane {:?} {}/{}/{} ..{}", r.pool, r.lane, r.task, r.job, r.node, r.finish_ns)))
            .chain(o.sheds.iter().map(|s| (s.at_ns, format!("SHED {}/{} {}", s.task, s.job, s.reason.name())))).collect();
        let Some(first) = a.symmetric_difference(&b).next() else { continue };
        let t = first.0;
        println!("== seed {seed} {policy:?} at {t}; pools {:?} sync {:?}", w.pools.iter().map(|p| (&p.name, p.lanes, p.memory_bytes)).collect::<Vec<_>>(), w.sync);
        for x in a.union(&b).filter(|x| x.0 + 12_000_000 > t && x.0 <= t + 1_000_000) {
            let m = match (a.contains(x), b.contains(x)) { (true, true) => " ", (true, false) => "C", _ => "O" };
            println!("{m} {} {}", x.0, x.1);
        }
    } }
}
