//! Certificates that were changed: what is accepted of them is as true as what was made.

#[path = "../src/world.rs"]
#[allow(dead_code, reason = "tests of the package need more of it")]
mod world;

use red_analysis::prove;
use red_certificate::{Certificate, Set, verify};
use serde_json::Value;
use world::{Rng, random, responses};

const WORDS: [&str; 13] = [
    "any",
    "key",
    "a",
    "b",
    "a0",
    "prefix",
    "paths",
    "several",
    "analytic",
    "empirical",
    "best-effort",
    "latest-start",
    "",
];

fn some_set(rng: &mut Rng) -> Set {
    let clusters = rng.within(1, 2) as usize;
    let (load, deadline) = (rng.within(10, 60), if rng.within(0, 1) == 0 { 100 } else { 250 });
    random(rng, clusters, load, deadline)
}

/// Calls with every place of a document, in its order.
fn places<'a>(value: &'a mut Value, nth: &mut usize) -> Option<&'a mut Value> {
    // Not a recursion: a certificate is no deeper than this stack grows.
    let mut open = vec![value];
    while let Some(value) = open.pop() {
        if *nth == 0 {
            return Some(value);
        }
        *nth -= 1;
        match value {
            Value::Array(values) => open.extend(values.iter_mut().rev()),
            Value::Object(fields) => open.extend(fields.values_mut()),
            _ => {}
        }
    }
    None
}

/// One place changed: a number, a word, a digit, an element more, fewer, or in another place.
fn change(rng: &mut Rng, value: &mut Value) {
    match value {
        Value::Null => *value = rng.within(0, 300).into(),
        Value::Bool(_) => {}
        Value::Number(number) => {
            let old = number.as_i64().unwrap_or(0);
            let new = match rng.within(0, 6) {
                0 => old.wrapping_add(1),
                1 => old.wrapping_sub(1),
                2 => old / 2,
                3 => old.wrapping_add(old / 2),
                4 => rng.within(0, 300) as i64,
                5 => i64::MAX,
                _ => return *value = if rng.within(0, 1) == 0 { u64::MAX.into() } else { Value::Null },
            };
            *value = new.into();
        }
        Value::String(text) if text.len() == 64 => {
            let at = rng.within(0, 63) as usize;
            let digit = if text.as_bytes()[at] == b'0' { "1" } else { "0" };
            text.replace_range(at..=at, digit);
        }
        Value::String(text) => match rng.within(0, 1) {
            0 => *text = WORDS[rng.within(0, WORDS.len() as u64 - 1) as usize].to_owned(),
            _ => text.push('0'),
        },
        Value::Array(values) if values.is_empty() => values.push(0.into()),
        Value::Array(values) => {
            let [at, other] = [0; 2].map(|_| rng.within(0, values.len() as u64 - 1) as usize);
            match rng.within(0, 3) {
                0 => drop(values.remove(at)),
                1 => values.insert(at, values[other].clone()),
                2 => values.insert(at, rng.within(0, 300).into()),
                _ => values.swap(at, other),
            }
        }
        Value::Object(fields) => {
            let nth = rng.within(0, fields.len() as u64 - 1) as usize;
            let name = fields.keys().nth(nth).cloned().unwrap_or_default();
            fields.remove(&name);
        }
    }
}

/// Certificates of random sets with one place changed, as far as they are certificates still.
fn changed(rng: &mut Rng, count: usize, mut look: impl FnMut(&mut Rng, &Set, &Certificate, Certificate)) {
    let mut done = 0;
    while done < count {
        let set = some_set(rng);
        let good = prove(&set);
        if good.tasks.iter().all(|task| task.response_ns.is_none()) {
            continue;
        }
        assert_eq!(verify(&good, &set), Ok(()));
        for _ in 0..20 {
            let mut document = serde_json::to_value(&good).expect("plain data");
            let mut all = usize::MAX;
            assert!(places(&mut document, &mut all).is_none());
            let mut nth = rng.within(0, (usize::MAX - all) as u64 - 1) as usize;
            change(rng, places(&mut document, &mut nth).expect("a place"));
            // Where it can be read at all.
            if let Ok(bad) = serde_json::from_value::<Certificate>(document)
                && bad != good
            {
                look(rng, &set, &good, bad);
                done += 1;
            }
        }
    }
}

#[test]
fn a_certificate_that_is_changed_anywhere_is_rejected() {
    let seed = 11;
    println!("seed {seed}");
    let mut seen = 0;
    changed(&mut Rng(seed), 2_000, |_, set, _, bad| {
        seen += 1;
        assert!(verify(&bad, set).is_err(), "{set:#?}\n{bad:#?}");
    });
    assert!(seen >= 2_000);
}

/// The largest of its versions' response times, the margin and the checksum, as they follow from the rest.
fn consistent(mut certificate: Certificate) -> Certificate {
    for task in &mut certificate.tasks {
        if task.response_ns.is_some() {
            task.response_ns = task.versions.iter().filter_map(|version| version.response_ns).max();
        }
    }
    let (margin_ns, binding) = Certificate::tightest(&certificate.tasks).unzip();
    (certificate.margin_ns, certificate.binding) = (margin_ns, binding.unwrap_or_default());
    certificate.sealed()
}

#[test]
fn what_is_accepted_of_a_changed_certificate_with_a_new_checksum_is_true() {
    let seed = 12;
    println!("seed {seed}");
    let (mut seen, mut accepted, mut shorter) = (0, 0, 0);
    changed(&mut Rng(seed), 6_000, |rng, set, good, bad| {
        seen += 1;
        let bad = if rng.within(0, 3) == 0 { bad.sealed() } else { consistent(bad) };
        if bad == *good || verify(&bad, set).is_err() {
            return;
        }
        accepted += 1;
        // What the set alone decides is as it was.
        assert_eq!((bad.version, &bad.workload_sha256, &bad.rule), (1, &good.workload_sha256, &good.rule));
        for (bad, good) in bad.clusters.iter().zip(&good.clusters) {
            assert_eq!(
                (&bad.pool, &bad.name, bad.lanes, &bad.tasks),
                (&good.pool, &good.name, good.lanes, &good.tasks)
            );
        }
        for (bad, good) in bad.tasks.iter().zip(&good.tasks) {
            assert_eq!((&bad.name, bad.deadline_ns), (&good.name, good.deadline_ns));
            for (bad, good) in bad.versions.iter().zip(&good.versions) {
                let numbers = |v: &red_certificate::VersionProof| {
                    (v.work_ns, v.critical_path_ns, v.shortest_path_ns, v.hops, v.last_key_ns)
                };
                assert_eq!(numbers(bad), numbers(good));
                shorter += usize::from(bad.response_ns < good.response_ns);
            }
        }
        // And no run is longer than it says.
        let kept: Vec<bool> = bad.tasks.iter().map(|task| task.response_ns.is_some()).collect();
        for _ in 0..20 {
            for (worst, task) in responses(rng, set, &kept).iter().zip(&bad.tasks) {
                assert!(task.response_ns.is_none_or(|bound| *worst <= bound), "{worst}\n{set:#?}\n{bad:#?}");
            }
        }
    });
    println!("{seen} changed, {accepted} accepted, {shorter} of them with a shorter time than was found");
    assert!(accepted > 50 && accepted < seen / 2);
}
