//! Two that have nothing in common but the format: what finds proofs, and what checks them.

#[path = "../src/world.rs"]
mod world;

use red_analysis::prove;
use red_certificate::verify;
use world::{Rng, random};

/// Sets of one and two clusters, of constrained and of arbitrary deadlines.
fn sets(seed: u64, count: u64) -> impl Iterator<Item = red_certificate::Set> {
    println!("seed {seed}");
    let mut rng = Rng(seed);
    (0..count).map(move |n| {
        let load = rng.within(10, 70);
        random(&mut rng, 1 + (n % 2) as usize, load, if n % 4 < 2 { 100 } else { 250 })
    })
}

#[test]
fn every_certificate_that_is_made_is_accepted() {
    let mut proved = std::collections::BTreeMap::new();
    for (n, set) in sets(1, 4_000).enumerate() {
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
