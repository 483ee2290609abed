//! Two that have nothing in common but the format: what finds proofs, and what checks them.

#[path = "../src/world.rs"]
mod world;

use red_analysis::prove;
use red_certificate::{Certificate, Rejected, Set, verify};
use world::{Rng, random, responses, set, task};

/// Sets of one and two clusters, of constrained and of arbitrary deadlines, and of one task now and then.
fn sets(seed: u64, count: u64) -> impl Iterator<Item = Set> {
    println!("seed {seed}");
    let mut rng = Rng(seed);
    (0..count).map(move |n| {
        let load = rng.within(10, 70);
        let mut set = random(&mut rng, 1 + (n % 2) as usize, load, if n % 4 < 2 { 100 } else { 250 });
        if n % 8 == 0 {
            set.tasks.truncate(1);
        }
        set
    })
}

#[test]
fn every_certificate_that_is_made_is_accepted() {
    let mut proved = std::collections::BTreeMap::new();
    for (n, set) in sets(1, 8_000).enumerate() {
        let certificate = prove(&set);
        if let Err(error) = verify(&certificate, &set) {
            panic!("set {n}: {error}\n{set:#?}\n{certificate:#?}");
        }
        for proof in certificate.tasks.iter().flat_map(|t| &t.versions).filter_map(|v| v.proof.as_ref()) {
            *proved.entry(proof.name()).or_insert(0) += 1;
        }
    }
    println!("{proved:?}");
    assert!(proved.len() == 4 && proved.values().all(|times| *times > 100), "{proved:?}");
}

/// Two jobs of `late` hold both lanes when `high` and `job` come: `job` waits for both of them and for `high`.
#[test]
fn two_jobs_of_one_task_hold_two_lanes_against_another() {
    let set = set(
        2,
        vec![
            task("job", 300, Some(400), &[1], &[]),
            task("high", 250, Some(400), &[12], &[]),
            task("late", 1_000, Some(12), &[20], &[]),
        ],
    );
    let certificate = prove(&set);
    assert_eq!(verify(&certificate, &set), Ok(()));
    let seed = 5;
    println!("seed {seed}");
    let mut rng = Rng(seed);
    let worst = (0..20_000).map(|_| responses(&mut rng, &set, &[true; 3])[0]).max();
    assert_eq!(worst, Some(20));
    assert!(certificate.tasks[0].response_ns >= worst);
    // What one node of `late` on one lane would make of it.
    let counted_once = with_response(&certificate, 0, 17);
    assert!(matches!(verify(&counted_once, &set), Err(Rejected::Inequality { .. })));
}

/// The same where the only version of a task responds in less time than it is proved to.
fn with_response(certificate: &Certificate, task: usize, response_ns: u64) -> Certificate {
    let mut changed = certificate.clone();
    changed.tasks[task].response_ns = Some(response_ns);
    changed.tasks[task].versions[0].response_ns = Some(response_ns);
    resealed(changed)
}

/// With what follows from the tasks, and the checksum.
fn resealed(mut certificate: Certificate) -> Certificate {
    let (margin_ns, binding) = Certificate::tightest(&certificate.tasks).unzip();
    certificate.margin_ns = margin_ns;
    certificate.binding = binding.unwrap_or_default();
    certificate.sealed()
}
