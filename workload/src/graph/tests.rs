use crate::Refusal::{self, Cycle, Duplicate, Missing, Reference};
use crate::fixtures::{accepted, refused, with_nodes};

/// An ordinary node with these predecessors.
fn node(name: &str, after: &str) -> String {
    format!("{{ name = '{name}', wcet = '1ms', after = [{after}] }},")
}

/// A stage with the decoders `x` and `y`.
fn stage(name: &str, after: &str) -> String {
    let decoders = "[{ name = 'x', wcet = '1ms' }, { name = 'y', wcet = '1ms' }]";
    format!(
        "{{ name = '{name}', after = [{after}], mimonet = {{ weights = 'w', frame = 'f', \
         encoder = {{ wcet = '1ms' }}, decoders = {decoders} }} }},"
    )
}

fn event(at: &str, changes: &str) -> String {
    format!("[[event]]\nat = '{at}'\ntask = 't'\n{changes}\n")
}

fn assert_accepted(nodes: &str, events: &str) {
    accepted(&with_nodes(nodes, events));
}

fn assert_refused(nodes: &str, events: &str, refusal: Refusal, words: &str) {
    let error = refused(&with_nodes(nodes, events));
    assert_eq!(error.refusal, refusal, "{error}");
    assert!(error.to_string().contains(words), "{error}");
}

#[test]
fn references_that_are_legal() {
    assert_accepted(&(node("a", "'b'") + &node("b", "")), "");
    assert_accepted(&(stage("s", "") + &node("a", "'s', 's.x', 's.encoder'")), "");
    assert_accepted(&(stage("s", "") + &stage("z", "'s.x'")), "");
}

#[test]
fn references_to_nothing_are_refused() {
    assert_refused(&node("a", "'b'"), "", Reference, "no node of this task");
    assert_refused(&(node("camera", "") + &node("b", "'camra'")), "", Reference, "did you mean `camera`?");
    assert_refused(&(stage("s", "") + &node("a", "'s.lane'")), "", Reference, "no such part");
    assert_refused(&(node("a", "") + &node("b", "'a.x'")), "", Reference, "no such part");
    assert_refused(&(stage("s", "") + &node("b", "'s.x.y'")), "", Reference, "no such part");
    assert_refused(&(node("a", "") + &node("b", "'a', 'a'")), "", Duplicate, "twice");
    assert_refused(&(node("a", "") + &node("a", "")), "", Duplicate, "already has a node named `a`");
}

#[test]
fn cycles_are_refused_and_named() {
    assert_refused(&node("a", "'a'"), "", Cycle, "names the node itself");
    assert_refused(&stage("s", "'s.x'"), "", Cycle, "names the node itself");
    assert_refused(&(node("a", "'b'") + &node("b", "'a'")), "", Cycle, "`a` -> `b` -> `a`");
    assert_refused(&(stage("s", "'a'") + &node("a", "'s.x'")), "", Cycle, "`s.encoder` -> `s.x` -> `a`");
    let ring: String = (0..200).map(|n| node(&format!("n{n}"), &format!("'n{}'", (n + 199) % 200))).collect();
    assert_refused(&ring, "", Cycle, "`n5` -> 194 more -> `n0`");
}

#[test]
fn a_cycle_of_whole_stages_is_refused_for_the_policy_that_runs_them_whole() {
    let nodes = stage("s", "") + &node("a", "'s.encoder'");
    let back = event("1s", "add = [{ name = 'b', wcet = '1ms', after = ['a'], before = ['s.y'] }]");
    assert_accepted(&nodes, "");
    assert_refused(&nodes, &back, Cycle, "with each stage as one node, as policy edf runs it");
    assert_refused(&nodes, &back, Cycle, "`s` -> `a` -> `b` -> `s`");
}

#[test]
fn events_that_are_legal() {
    let nodes = node("a", "") + &node("z", "'a'");
    let detour = "add = [{ name = 'b', wcet = '1ms', after = ['c'], before = ['z'] }, \
                  { name = 'c', wcet = '1ms', after = ['a'] }]";
    assert_accepted(&nodes, &(event("1s", detour) + &event("2s", "remove = ['b', 'c']")));
    // The file's order does not matter, time's does.
    assert_accepted(&nodes, &(event("2s", "remove = ['b', 'c']") + &event("1s", detour)));
    // In one instant, the file's does.
    assert_accepted(&nodes, &(event("1s", detour) + &event("1s", "remove = ['b']")));
    // Edges go with the removed node, and a name is free again, also in the same event.
    assert_accepted(
        &nodes,
        &event("1s", "remove = ['a']\nadd = [{ name = 'a', wcet = '1ms', after = ['z'] }]"),
    );
    assert_accepted(&stage("s", ""), &event("1s", "remove = ['s']\nadd = [{ name = 'a', wcet = '1ms' }]"));
}

#[test]
fn events_that_do_not_fit_their_time_are_refused() {
    let nodes = node("a", "") + &node("z", "'a'");
    let add = |rest: &str| format!("add = [{{ name = 'b', wcet = '1ms', {rest} }}]");
    let cases = [
        (event("1s", "remove = ['x']"), Reference, "no node of this task at that time"),
        (event("1s", "remove = ['a']") + &event("2s", "remove = ['a']"), Reference, "removed by then"),
        (event("1s", "remove = ['a', 'a']"), Duplicate, "twice"),
        (event("1s", "remove = ['a', 'z']"), Missing, "no node left"),
        (event("1s", "remove = ['a.x']"), Reference, "a part of a stage"),
        (event("1s", "add = [{ name = 'a', wcet = '1ms' }]"), Duplicate, "already has a node named `a`"),
        (event("1s", &add("after = ['q']")), Reference, "no node of this task at that time"),
        (event("1s", &add("before = ['q']")), Reference, "`before` names `q`"),
        (event("1s", &add("before = ['z', 'z']")), Duplicate, "twice"),
        (event("1s", &add("before = ['b']")), Cycle, "names the node itself"),
        (event("1s", &add("after = ['z'], before = ['z']")), Cycle, "`z` -> `b` -> `z`"),
        (event("1s", &add("after = ['z'], before = ['a']")), Cycle, "`a` -> `z` -> `b` -> `a`"),
        (event("1s", &format!("remove = ['a']\n{}", add("after = ['a']"))), Reference, "removed by then"),
        (
            event("2s", &add("")) + &event("1s", "remove = ['b']"),
            Reference,
            "no node of this task at that time",
        ),
        (
            event("1s", "remove = ['b']") + &event("1s", &add("")),
            Reference,
            "no node of this task at that time",
        ),
    ];
    for (events, refusal, words) in cases {
        assert_refused(&nodes, &events, refusal, words);
    }
}

#[test]
fn the_full_graph_with_every_edge_is_checked() {
    let list = |count: usize| (0..count).map(|n| format!("'n{n}'")).collect::<Vec<_>>().join(",");
    let nodes: String = (0..256).map(|n| node(&format!("n{n}"), &list(n))).collect();
    assert_accepted(&nodes, "");
    let closing = nodes.replacen("after = []", "after = ['n255']", 1);
    assert_refused(&closing, "", Cycle, "`n0`");
}
