//! The house rules that a compiler does not check, read off the sources. Every gate first has to catch a planted
//! violation: a gate that finds nothing because it looks at nothing is worse than none.

use crate::sources::{Source, read_all};

/// Layers of the core, lowest first: a module uses its own layer and those before it.
const LAYERS: &[&[&str]] = &[
    &["time", "id", "capacity", "fmt", "error"],
    &["graph"],
    &["deadlines", "analysis"],
    &["ready_queue"],
    &["policy", "config"],
    &["scheduler"],
];

const CORE: &str = "core-nostd/src/";
const SYNC: &str = "sync/src/";
/// The whole core: a newcomer reads it in one sitting.
const CORE_TOTAL: usize = 7_152;
const CORE_BUDGET: usize = 250;
const BUDGET: usize = 400;

/// Where the executive's atomics and cells come from: the model checker has a file of its own in this one's place.
const PRIMITIVE: &str = "sync/src/primitive.rs";
/// Protocols of the Linux host that the model checker drives; theirs come from `rt-linux/src/primitive.rs`.
const PROTOCOLS: &[&str] = &[
    "rt-linux/src/bell.rs",
    "rt-linux/src/errands.rs",
    "rt-linux/src/seat.rs",
    "rt-linux/src/slot.rs",
    "rt-linux/src/spares.rs",
    "rt-linux/src/stream_seat.rs",
    "rt-linux/src/waiting.rs",
];

/// Files that may be unsafe, and why.
const UNSAFE: &[(&str, &str)] = &[
    ("sync/src/ticket_lock.rs", "hands out exclusive access to a shared cell"),
    ("sync/src/mailbox.rs", "a ring shared by one producer and one consumer"),
    ("rt-linux/src/sys.rs", "the system calls that nix lacks"),
    ("rt-linux/src/allocations.rs", "a counting allocator"),
    ("rt-linux/src/per_process.rs", "what is leaked lives for ever"),
    ("cuda-shim/src/sys.rs", "names of C"),
    ("cuda-shim/src/result.rs", "calls of C, and the driver's handles"),
    ("cuda-shim/src/result/memory.rs", "calls of C, and memory that it gives"),
    ("cuda-shim/src/result/nvml.rs", "calls of C"),
    ("ffi/src/boundary.rs", "follows pointers from C"),
    ("ffi/src/guard.rs", "one call at a time on what callers share"),
    ("ffi/src/handles.rs", "objects in C's memory"),
    ("ffi/src/runtime/called.rs", "a runtime belongs to its handle"),
    ("ffi/src/runtime/bodies.rs", "functions that C gives and lanes call"),
    ("ffi/src/runtime/tasks.rs", "addresses that C vouches for"),
    ("ffi/src/runtime/fork.rs", "a call of the C library"),
    ("ffi/src/runtime/text.rs", "text that C gives"),
    ("bodies/src/plugin.rs", "calls functions of shared objects"),
    ("bodies/src/clock.rs", "reads a thread's CPU clock"),
    ("bodies/examples/measure.rs", "a counting allocator"),
    ("tests/planted/src/main.rs", "bugs that sanitizers have to find"),
    ("fuzz/fuzz_targets/keys.rs", "stands in for a function of the C library"),
    ("fuzz/fuzz_targets/abi_calls/ground.rs", "memory that the library and the fuzzer use"),
    ("tests/soak/src/allocator.rs", "a counting allocator"),
    ("tests/soak/src/death.rs", "a thread that dies"),
    ("tests/symbols/src/lib.rs", "names in an object file"),
    ("tests/symbols/src/bare.rs", "what a target without an operating system lacks"),
    ("loom-tests/src/lanes.rs", "cells whose sharing the model checker judges"),
    ("benches/src/machine.rs", "pins threads"),
    ("benches/src/ours/abi/functions.rs", "functions of a shared object"),
    ("benches/src/peers/embassy.rs", "the hooks that the executor calls"),
    ("examples/embassy-qemu/src/board.rs", "registers, and the vector table"),
    ("examples/embassy-qemu/src/firmware.rs", "addresses that the linker gives"),
];

/// Where functions of the C ABI get their names, and nothing else.
const NAMES_OF_C: &[&str] = &["#![allow(unsafe_code, reason = \"names of C\")]", "#[unsafe(no_mangle)]"];

/// Why a rule of the layers is broken at `line`.
fn violation(source: &Source, line: usize, why: &str) -> String {
    format!("{}:{line}: {why}", source.path)
}

/// `crate::` paths that point up, or whose layer cannot be seen.
fn layer_violations(sources: &[Source]) -> Vec<String> {
    let layer_of = |module: &str| LAYERS.iter().position(|layer| layer.contains(&module));
    let mut found = Vec::new();
    for source in sources.iter().filter(|s| s.is_in(CORE) && !s.is_test() && !s.path.ends_with("src/lib.rs"))
    {
        let module = source.module();
        for (line, used) in source.crate_paths() {
            let allowed = match (layer_of(&module), layer_of(&used)) {
                _ if used == module => true,
                (Some(own), Some(other)) => other <= own,
                _ => false,
            };
            if !allowed {
                found.push(violation(source, line, &format!("`{module}` uses `crate::{used}`")));
            }
        }
        for (line, _) in source.lines_with("super::super") {
            found.push(violation(source, line, "`super::super` hides which layer is meant"));
        }
    }
    found
}

/// The executive: the core and what shares it among lanes.
fn is_executive(source: &Source) -> bool {
    source.is_in(CORE) || source.is_in(SYNC)
}

fn budget_violations(sources: &[Source]) -> Vec<String> {
    let over = |source: &&Source| {
        let budget = if is_executive(source) { CORE_BUDGET } else { BUDGET };
        let lines = source.lines_without_tests();
        (lines > budget).then(|| format!("{}: {lines} lines, the budget is {budget}", source.path))
    };
    sources.iter().filter(|source| !source.is_test()).filter_map(|source| over(&source)).collect()
}

fn total_violations(sources: &[Source]) -> Vec<String> {
    let core = sources.iter().filter(|source| source.is_in(CORE) && !source.is_test());
    let lines: usize = core.map(Source::lines_that_count).sum();
    let over = lines > CORE_TOTAL;
    over.then(|| format!("{CORE}: {lines} lines in all, the budget is {CORE_TOTAL}")).into_iter().collect()
}

fn unsafe_violations(sources: &[Source]) -> Vec<String> {
    let listed = |source: &Source| UNSAFE.iter().any(|(path, _)| source.path == *path);
    let outside = sources.iter().filter(|source| !listed(source) && !source.is_test());
    outside
        .flat_map(|source| {
            let words = ["unsafe", "unsafe_code"].into_iter().flat_map(|word| source.lines_with(word));
            let rules = ["#![deny(unsafe_code)]", "#![forbid(unsafe_code)]"];
            let names = if source.is_in("ffi/src/") { NAMES_OF_C } else { &[] };
            let unlisted =
                words.filter(|(_, text)| !rules.iter().chain(names).any(|rule| text.trim() == *rule));
            unlisted
                .map(|(line, _)| violation(source, line, "unsafe outside of the listed files"))
                .collect::<Vec<_>>()
        })
        .collect()
}

fn float_violations(sources: &[Source]) -> Vec<String> {
    sources
        .iter()
        .filter(|source| is_executive(source))
        .flat_map(|source| {
            let types =
                ["f32", "f64"].into_iter().flat_map(|word| source.lines_with(word)).map(|(line, _)| line);
            types
                .chain(source.float_literals())
                .map(|line| violation(source, line, "a float"))
                .collect::<Vec<_>>()
        })
        .collect()
}

fn loom_violations(sources: &[Source]) -> Vec<String> {
    let products = sources.iter().filter(|source| is_executive(source) || source.is_in("rt-linux/src/"));
    products
        .flat_map(|source| {
            let lines = source.lines_with("loom").into_iter();
            lines
                .map(|(line, _)| violation(source, line, "the model checker is the models' business"))
                .collect::<Vec<_>>()
        })
        .collect()
}

/// Atomics and cells that the model checker would not see.
fn atomic_violations(sources: &[Source]) -> Vec<String> {
    let is_modelled = |source: &&Source| {
        is_executive(source) && source.path != PRIMITIVE || PROTOCOLS.contains(&source.path.as_str())
    };
    sources
        .iter()
        .filter(is_modelled)
        .flat_map(|source| {
            let words = ["sync::atomic", "UnsafeCell", "hint::spin_loop"];
            let lines = words.into_iter().flat_map(|word| source.lines_with(word));
            lines
                .map(|(line, _)| {
                    violation(source, line, "what the model checker has to see is in `primitive`")
                })
                .collect::<Vec<_>>()
        })
        .collect()
}

/// Asserts that a gate is quiet about `clean`, speaks once about each of `planted`, and is quiet about the tree.
fn hold(gate: fn(&[Source]) -> Vec<String>, clean: &[Source], planted: &[Source]) {
    assert_eq!(gate(clean), Vec::<String>::new(), "the gate speaks about what is right");
    for source in planted {
        let found = gate(std::slice::from_ref(source));
        assert_eq!(found.len(), 1, "planted in {}, found {found:?}", source.path);
    }
    let found = gate(&read_all());
    assert!(found.is_empty(), "{} violations:\n{}", found.len(), found.join("\n"));
}

#[test]
fn no_module_uses_one_above_it() {
    let clean = [
        Source::new("core-nostd/src/policy/merge.rs", "use crate::time::Instant; // not crate::scheduler\n"),
        Source::new("core-nostd/src/id.rs", "pub(crate) fn f() -> &str { \"crate::scheduler\" }"),
    ];
    let planted = [
        Source::new("core-nostd/src/graph/dag.rs", "use crate::policy::Floor;\n"),
        Source::new("core-nostd/src/policy/merge.rs", "fn f(s: &crate::scheduler::Scheduler) {}"),
        Source::new("core-nostd/src/time.rs", "use crate::{id::JobId, graph::Dag};"),
        Source::new("core-nostd/src/policy/floor.rs", "use crate::sync::Mailbox;"),
        Source::new("core-nostd/src/id.rs", "use crate::Scheduler;"),
        Source::new("core-nostd/src/novelty.rs", "use crate::time::Instant;"),
        Source::new("core-nostd/src/graph/dag.rs", "use super::super::scheduler::Scheduler;"),
    ];
    hold(layer_violations, &clean, &planted);
}

/// Files of tests that no module names: they would never be compiled.
fn orphan_violations(sources: &[Source]) -> Vec<String> {
    let tests = sources.iter().filter_map(|source| source.path.strip_suffix("/tests.rs"));
    let names_it = |folder: &str| {
        let inside = ["mod", "lib", "main"].map(|name| format!("{folder}/{name}.rs"));
        let parents = [&[format!("{folder}.rs")], inside.as_slice()].concat();
        let parent = sources.iter().filter(|source| parents.contains(&source.path));
        parent.flat_map(|source| source.lines_with("tests")).any(|(_, text)| text.ends_with("mod tests;"))
    };
    let orphans = tests.filter(|folder| !names_it(folder));
    orphans.map(|folder| format!("{folder}/tests.rs: no module has `mod tests;` for it")).collect()
}

#[test]
fn every_file_of_tests_belongs_to_a_module() {
    let tests = |path: &str| Source::new(path, "#[test]\nfn a_test() {}\n");
    let clean = [
        Source::new("core-nostd/src/time.rs", "#[cfg(test)]\nmod tests;\n"),
        tests("core-nostd/src/time/tests.rs"),
        Source::new("core-nostd/src/scheduler/mod.rs", "#[cfg(test)]\nmod tests;\n"),
        tests("core-nostd/src/scheduler/tests.rs"),
    ];
    let planted = [tests("core-nostd/src/gone/tests.rs")];
    hold(orphan_violations, &clean, &planted);
}

#[test]
fn no_file_is_longer_than_its_budget() {
    let lines = |n: usize| "// one line\n".repeat(n);
    let with_tests = format!("{}#[cfg(test)]\nmod tests {{\n{}}}\n", lines(CORE_BUDGET), lines(100));
    let clean = [
        Source::new("core-nostd/src/time.rs", &with_tests),
        Source::new("sim/src/host.rs", &lines(BUDGET)),
        Source::new("core-nostd/src/time/tests.rs", &lines(BUDGET + 1)),
        Source::new("bodies/tests/reference.rs", &lines(BUDGET + 1)),
    ];
    let planted = [
        Source::new("core-nostd/src/time.rs", &lines(CORE_BUDGET + 1)),
        Source::new("tests/src/oracle.rs", &lines(BUDGET + 1)),
    ];
    hold(budget_violations, &clean, &planted);
}

#[test]
fn the_core_is_not_longer_than_one_sitting() {
    let lines = |n: usize| "/// a line of documentation\nconst A: u8 = 0;\n\n// why\n".repeat(n / 2);
    let clean = [
        Source::new("core-nostd/src/time.rs", &lines(CORE_TOTAL)),
        Source::new("core-nostd/src/time/tests.rs", &lines(100)),
        Source::new("sim/src/host.rs", &lines(100)),
    ];
    let planted = [Source::new("core-nostd/src/time.rs", &lines(CORE_TOTAL + 2))];
    hold(total_violations, &clean, &planted);
}

#[test]
fn unsafe_is_only_in_the_listed_files() {
    let clean = [
        Source::new("core-nostd/src/lib.rs", "//! unsafe is elsewhere\n#![forbid(unsafe_code)]\n"),
        Source::new("sync/src/lib.rs", "#![deny(unsafe_code)]\n"),
        Source::new("rt-linux/src/sys.rs", "unsafe { call() }"),
        Source::new("ffi/src/job.rs", "#[unsafe(no_mangle)]\npub extern \"C\" fn red_poll() {}"),
    ];
    let planted = [
        Source::new("core-nostd/src/graph/dag.rs", "#![allow(unsafe_code, reason = \"planted\")]"),
        Source::new("sync/src/shared.rs", "#![allow(unsafe_code, reason = \"#![deny(unsafe_code)]\")]"),
        Source::new("bodies/src/spin.rs", "fn f() { unsafe { call() } }"),
        Source::new("cli/src/main.rs", "#[unsafe(no_mangle)] extern \"C\" fn f() {}"),
        Source::new("ffi/src/job.rs", "let action = unsafe { *to };"),
    ];
    hold(unsafe_violations, &clean, &planted);
}

#[test]
fn every_file_listed_as_unsafe_is_there() {
    let sources = read_all();
    let is_unsafe = |path: &str| sources.iter().any(|s| s.path == path && !s.lines_with("unsafe").is_empty());
    let idle: Vec<_> = UNSAFE.iter().filter(|(path, _)| !is_unsafe(path)).collect();
    assert!(idle.is_empty(), "listed without need: {idle:?}");
}

#[test]
fn the_core_has_no_floats() {
    let clean = [
        Source::new("core-nostd/src/time.rs", "let a = pair.0.1; // 0.5\nlet b = 0..8; \"1.5\""),
        Source::new("workload/src/metrics.rs", "let mean: f64 = 0.5;"),
    ];
    let planted = [
        Source::new("core-nostd/src/time.rs", "fn seconds(ns: u64) -> f64 { ns.into() }"),
        Source::new("core-nostd/src/policy/overload.rs", "const THETA: f32 = THETA_OF_PAPER;"),
        Source::new("core-nostd/src/policy/overload.rs", "if load > 0.9 {}"),
    ];
    hold(float_violations, &clean, &planted);
}

#[test]
fn no_product_file_knows_the_model_checker() {
    let clean = [
        Source::new("loom-tests/src/model.rs", "#![cfg(loom)]\nuse loom::model::Builder;"),
        Source::new("sync/src/mailbox.rs", "// loom sees one access\nlet heirloom = 1;"),
    ];
    let planted = [
        Source::new("sync/src/mailbox.rs", "#[cfg(not(loom))]\nmod real;"),
        Source::new("core-nostd/src/lib.rs", "#[cfg(loom)]\npub mod models;"),
        Source::new("rt-linux/src/bell.rs", "use loom::sync::atomic::AtomicU32;"),
    ];
    hold(loom_violations, &clean, &planted);
}

#[test]
fn atomics_and_cells_come_from_the_primitives() {
    let clean = [
        Source::new(PRIMITIVE, "pub(crate) use core::sync::atomic::AtomicU8;"),
        Source::new("sync/src/handler.rs", "use crate::primitive::AtomicU8; // not core::sync::atomic"),
        Source::new("rt-linux/src/usage.rs", "use std::sync::atomic::AtomicU32;"),
    ];
    let planted = [
        Source::new("core-nostd/src/scheduler/jobs.rs", "use core::sync::atomic::AtomicBool;"),
        Source::new("sync/src/mailbox.rs", "struct Place(core::cell::UnsafeCell<u8>);"),
        Source::new("rt-linux/src/bell.rs", "use std::sync::atomic::AtomicU32;"),
        Source::new("rt-linux/src/seat.rs", "use core::hint::spin_loop;"),
    ];
    hold(atomic_violations, &clean, &planted);
}

#[test]
fn every_protocol_is_there() {
    let sources = read_all();
    let lost: Vec<_> = PROTOCOLS.iter().filter(|path| sources.iter().all(|s| s.path != **path)).collect();
    assert!(lost.is_empty(), "named without need: {lost:?}");
}
