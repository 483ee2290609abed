//! `redrt verify`: certificates that hold, and those that were changed.

mod process;

use process::run;
use serde_json::Value;

const CRUISE: &str = "examples/cruise.toml";

/// Two tasks on two lanes, the second with this WCET.
fn workload(wcet: &str) -> String {
    format!(
        "pool = [{{ name = \"gpu\", lanes = 2 }}]\n\
         [[task]]\nname = \"a\"\ndeadline = \"50ms\"\nperiod = \"50ms\"\nnode = [{{ name = \"n\", wcet = \"9ms\" }}]\n\
         [[task]]\nname = \"b\"\ndeadline = \"80ms\"\nperiod = \"80ms\"\nnode = [{{ name = \"n\", wcet = \"{wcet}\" }}]\n"
    )
}

/// A file of this content; the tests run beside each other, so names differ.
fn file(name: &str, content: &str) -> String {
    process::file(name, content.as_bytes()).display().to_string()
}

fn planned(of: &str) -> Value {
    let (_, out, err) = run(&["plan", of, "--json"]);
    serde_json::from_str(&out).unwrap_or_else(|error| panic!("{error}: {out}{err}"))
}

fn verified(certificate: &Value, of: &str) -> (i32, Value) {
    let certificate = file(&format!("{:016x}.json", hash(certificate)), &certificate.to_string());
    let (status, out, err) = run(&["verify", &certificate, of, "--json"]);
    (status, serde_json::from_str(&out).unwrap_or_else(|error| panic!("{error}: {out}{err}")))
}

fn hash(value: &Value) -> u64 {
    use std::hash::{BuildHasher, BuildHasherDefault, DefaultHasher};
    BuildHasherDefault::<DefaultHasher>::default().hash_one(value.to_string())
}

#[test]
fn a_plan_and_its_certificate_hold_for_their_workload_and_for_no_other() {
    let (mine, other) = (file("mine.toml", &workload("11ms")), file("other.toml", &workload("12ms")));
    let plan = planned(&mine);
    assert_eq!(plan["admission"]["guarantee"], "analytic");
    for certificate in [&plan, &plan["certificate"]] {
        let (status, verdict) = verified(certificate, &mine);
        assert_eq!(
            (status, &verdict["holds"], &verdict["analytic"]),
            (0, &true.into(), &true.into()),
            "{verdict}"
        );
        let (status, verdict) = verified(certificate, &other);
        assert_eq!((status, &verdict["holds"]), (1, &false.into()));
        assert!(verdict["rejected"].as_str().is_some_and(|why| why.contains("workload_sha256")), "{verdict}");
    }
}

#[test]
fn whatever_is_changed_in_a_plan_is_rejected() {
    let mine = file("changed.toml", &workload("11ms"));
    let plan = planned(&mine);
    let changes = [
        ("/certificate/tasks/0/response_ns", "/certificate/margin_ns"),
        ("/certificate/clusters/0/lanes", "/tasks/1/nodes/0/cost_ns"),
        ("/admission/margin_ns", "/scheduler_bytes"),
    ];
    for pointer in changes.into_iter().flat_map(|(a, b)| [a, b]) {
        let mut changed = plan.clone();
        let value = changed.pointer_mut(pointer).unwrap_or_else(|| panic!("{pointer}"));
        *value = (value.as_u64().unwrap_or(0) + 1).into();
        assert_eq!(verified(&changed, &mine).0, 1, "{pointer}");
    }
}

#[test]
fn plan_writes_what_verify_reads() {
    let path = file("cruise.certificate.json", "");
    let (status, _, err) = run(&["plan", CRUISE, "--certificate", &path, "--force"]);
    assert_eq!(status, 0, "{err}");
    let (status, out, err) = run(&["verify", &path, CRUISE]);
    assert_eq!((status, &*err), (0, ""));
    assert!(out.starts_with("every statement holds\n") && out.contains("analytic"), "{out}");
}

#[test]
fn what_is_no_certificate_is_refused_with_the_cure() {
    for (text, words) in [("{", "no JSON"), ("[]", "no JSON object")] {
        let (status, out, err) = run(&["verify", &file("none.json", text), CRUISE]);
        assert_eq!((status, &*out), (2, ""));
        assert!(err.contains(words) && err.contains("redrt plan --certificate"), "{err}");
    }
    let (status, _, err) = run(&["verify", "nowhere.json", CRUISE]);
    assert!(status == 2 && err.contains("nowhere.json"), "{err}");
    let (status, out, _) = run(&["verify", &file("empty.json", "{}"), CRUISE]);
    assert!(status == 1 && out.contains("rejected"), "{out}");
}
