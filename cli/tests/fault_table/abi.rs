//! Rows 31 and 41 to 49: what C may get wrong.

mod border;
mod calls;
mod installed;
mod world;

use calls::{Call, Kind, all, header};
use red_ffi::*;
use std::ptr::with_exposed_provenance_mut as at;
use world::{Lent, World};

/// Calls with one pointer made wrong at a time; the answer to each, with the call, the pointer and its kind.
fn spoiled(
    spoil: impl Fn(Kind, usize, &mut World) -> Option<usize>,
    judge: impl Fn(&str, usize, Kind, red_status),
) -> usize {
    let kinds = header();
    let mut tried = 0;
    for Call { name, pointers, call } in all() {
        let (_, kinds) = kinds.iter().find(|(known, _)| known == name).expect("a function of the header");
        for (i, kind) in kinds.iter().enumerate() {
            let mut world = World::new();
            let mut given = pointers(&mut world);
            assert_eq!(given.len(), kinds.len(), "{name}");
            let Some(wrong) = spoil(*kind, given[i], &mut world) else { continue };
            given[i] = wrong;
            let before = world.state();
            let status = call(&world, &given);
            judge(name, i, *kind, status);
            assert!(world.state() == before, "{name} changed something, pointer {i} was wrong");
            tried += 1;
        }
    }
    tried
}

#[test]
fn row_41_null_for_any_pointer_of_any_function_is_told() {
    // Nothing of the header is left out, and everything works as long as nothing is wrong.
    let mut of_header: Vec<String> = header().into_iter().map(|(name, _)| name).collect();
    let mut tried: Vec<&str> = all().map(|call| call.name).collect();
    of_header.sort();
    tried.sort_unstable();
    assert_eq!(of_header, tried);
    for Call { name, pointers, call } in all() {
        let mut world = World::new();
        let given = pointers(&mut world);
        let status = call(&world, &given);
        let lacks_a_driver = status == red_status::Cuda && *name == "red_runtime_add_cuda_pool";
        assert!(status == red_status::Ok || lacks_a_driver, "{name}: {status:?}");
    }
    let count = spoiled(
        |_, _, _| Some(0),
        |name, i, _, status| assert_eq!(status, red_status::NullPointer, "{name}, pointer {i}"),
    );
    assert!(count > 100, "{count} pointers");
}

#[test]
fn row_42_a_handle_that_was_closed_forged_or_is_of_something_else_is_told() {
    let open = |kind: Kind, world: &World| match kind {
        Kind::Handle("red_dag") => Some(world.dag.bits),
        Kind::Handle("red_runtime") => Some(world.runtime.bits),
        Kind::Handle(_) => Some(world.scheduler.bits),
        _ => None,
    };
    // In the place of a handle: one that was never opened, that was closed, of another copy of the library, of a place that
    // there is not, and of something else.
    let never = |_: u64, _: &mut World| 0;
    let closed = |_: u64, world: &mut World| {
        let mut memory = Lent::<RED_DAG_4X16X16_BYTES>::new();
        let mut dag = red_dag::default();
        assert_eq!(red_dag_open_4x16x16(memory.at(), RED_DAG_4X16X16_BYTES, &raw mut dag), red_status::Ok);
        let bits = dag.bits;
        assert_eq!(red_dag_close(&raw mut dag), red_status::Ok);
        assert_eq!(dag.bits, 0);
        world.wide = bits;
        bits
    };
    let newer = |bits: u64, _: &mut World| bits + (1 << 32);
    let foreign = |bits: u64, _: &mut World| bits ^ 0xff_0000;
    let nowhere = |bits: u64, _: &mut World| bits & !0xff | 0xff;
    let other = |bits: u64, world: &mut World| {
        if bits == world.dag.bits { world.scheduler.bits } else { world.dag.bits }
    };
    let forged = |_: u64, _: &mut World| u64::MAX;
    type Swap<'a> = &'a dyn Fn(u64, &mut World) -> u64;
    let cases: [(Swap<'_>, red_status); 7] = [
        (&never, red_status::Closed),
        (&closed, red_status::Closed),
        (&newer, red_status::Closed),
        (&foreign, red_status::Foreign),
        (&nowhere, red_status::Closed),
        (&other, red_status::OtherKind),
        (&forged, red_status::Foreign),
    ];
    for (case, (swap, expected)) in cases.into_iter().enumerate() {
        let place = std::cell::Cell::new(0_u64);
        let handle = place.as_ptr().expose_provenance();
        let opens = |name: &str, i: usize| {
            name.contains("_open") || matches!((name, i), ("red_scheduler_edit" | "red_runtime_edit", 2))
        };
        let count = spoiled(
            |kind, _, world| {
                let bits = open(kind, world)?;
                place.set(swap(bits, world));
                Some(handle)
            },
            |name, i, kind, status| {
                // Where a handle comes out, what was there does not matter.
                let expected = if opens(name, i) { red_status::Ok } else { expected };
                assert_eq!(status, expected, "case {case}: {name}, pointer {i}, {kind:?}");
                if opens(name, i) {
                    let mut bits = place.get();
                    let bits = &raw mut bits;
                    let closed = red_dag_close(bits.cast()) == red_status::Ok
                        || red_scheduler_close(bits.cast()) == red_status::Ok
                        || red_runtime_close(bits.cast()) == red_status::Ok;
                    assert!(closed, "{name}");
                }
            },
        );
        assert!(count > 45, "{count} handles");
    }
    // Closed twice, once by a copy.
    let mut world = World::new();
    let mut copy = world.dag;
    assert_eq!(red_dag_close(&raw mut world.dag), red_status::Ok);
    assert_eq!(red_dag_close(&raw mut world.dag), red_status::Closed);
    assert_eq!(red_dag_close(&raw mut copy), red_status::Closed);
}

/// A copy of a struct that may grow, in memory with room behind it, with its size changed.
fn resized(address: usize, size: impl Fn(u32) -> u32, room: &mut [u64; 1024], last: u8) -> usize {
    let from: *const u32 = at::<u32>(address);
    // SAFETY: a struct that begins with its size, which is how much of it there is.
    let declared = unsafe { from.read() };
    // SAFETY: as above; `room` is larger than any of them.
    unsafe { from.cast::<u8>().copy_to_nonoverlapping(room.as_mut_ptr().cast(), declared as usize) };
    let size = size(declared);
    let bytes = room.as_mut_ptr().cast::<u8>();
    // SAFETY: the first four bytes of `room`.
    unsafe { bytes.cast::<u32>().write(size) };
    if last != 0 {
        // SAFETY: sizes that are tried with this are below the room's.
        unsafe { bytes.wrapping_add(size as usize - 1).write(last) };
    }
    bytes.expose_provenance()
}

#[test]
fn row_43_a_struct_that_is_too_short_or_too_long_is_told_and_a_longer_one_is_taken_where_that_is_safe() {
    let room = std::cell::RefCell::new([0_u64; 1024]);
    let grow = |size: &dyn Fn(u32) -> u32, last: u8, expected: &dyn Fn(&str, usize) -> red_status| {
        let count = spoiled(
            |kind, address, _| {
                *room.borrow_mut() = [0; 1024];
                let is_growing = matches!(kind, Kind::Growing { .. });
                is_growing.then(|| resized(address, size, &mut room.borrow_mut(), last))
            },
            |name, i, _, status| assert_eq!(status, expected(name, i), "{name}, pointer {i}"),
        );
        assert!(count > 10, "{count} structs");
    };
    let refused = |_: &str, _: usize| red_status::StructSize;
    for size in [0, 4, 8, 20] {
        grow(&|_| size, 0, &refused);
    }
    for less in [1, 4, 8] {
        grow(&|declared| declared - less, 0, &refused);
    }
    for size in [4_100, u32::MAX, u32::MAX - 3, 1 << 31] {
        grow(&|_| size, 0, &refused);
    }
    // Longer, as of a later version: taken, if what is not known is zero; what is not known comes out as zero.
    for (last, more) in [(0, 8), (0, 64), (1, 8)] {
        let given = std::cell::Cell::new((0, 0));
        let mut count = 0;
        for Call { name, pointers, call } in all() {
            let kinds = header().into_iter().find(|(known, _)| known == name).expect("of the header").1;
            for (i, kind) in kinds.iter().enumerate() {
                // In an array all are of one size.
                let Kind::Growing { is_read } = kind else { continue };
                if (*name, i) == ("red_dag_refine", 2) {
                    continue;
                }
                let mut world = World::new();
                let mut arguments = pointers(&mut world);
                *room.borrow_mut() = [0; 1024];
                let size = |declared| {
                    given.set((declared, declared + more));
                    declared + more
                };
                arguments[i] = resized(arguments[i], size, &mut room.borrow_mut(), last);
                let status = call(&world, &arguments);
                let expected = if *is_read && last != 0 { red_status::UnknownField } else { red_status::Ok };
                assert_eq!(status, expected, "{name}, pointer {i}");
                let (known, all) = given.get();
                let bytes = room.borrow().map(u64::to_ne_bytes).concat();
                let is_cleared = bytes[known as usize..all as usize].iter().all(|byte| *byte == 0);
                assert!(*is_read || is_cleared, "{name}, pointer {i}");
                count += 1;
            }
        }
        assert!(count > 10, "{count} structs");
    }
}

#[test]
fn row_44_another_version_of_the_abi_is_told() {
    for version in [0, RED_ABI_VERSION + 1, u32::MAX] {
        let room = std::cell::RefCell::new([0_u64; 1024]);
        let count = spoiled(
            |kind, address, _| {
                let wrong = matches!(kind, Kind::Growing { .. })
                    .then(|| resized(address, |size| size, &mut room.borrow_mut(), 0))?;
                // SAFETY: the second word of `room`.
                unsafe { at::<u32>(wrong).wrapping_add(1).write(version) };
                Some(wrong)
            },
            |name, i, _, status| assert_eq!(status, red_status::Version, "{name}, pointer {i}"),
        );
        assert!(count > 10, "{count} structs");
    }
    assert_eq!(red_abi_version(), RED_ABI_VERSION);
}

#[test]
fn row_45_memory_and_arrays_that_are_misaligned_overlap_or_are_too_short_or_too_long_are_told() {
    // One byte off, for every pointer of every function.
    let count = spoiled(
        |kind, address, _| (kind != Kind::Text).then_some(address + 1),
        |name, i, _, status| assert_eq!(status, red_status::Misaligned, "{name}, pointer {i}"),
    );
    assert!(count > 100, "{count} pointers");
    let mut world = World::new();
    let World {
        scheduler_memory, free_memory, dag, opened_dag, opened_scheduler, config, placed, lanes, ..
    } = &mut *world;
    let opened_scheduler = &raw mut *opened_scheduler;
    // Too short by a byte, empty, and NULL of no length.
    for (open, need) in [
        (red_scheduler_open_4x16x16 as extern "C" fn(_, _, _, _) -> _, red_scheduler_bytes_4x16x16()),
        (red_scheduler_open_8x64x32, red_scheduler_bytes_8x64x32()),
        (red_scheduler_open_16x256x64, red_scheduler_bytes_16x256x64()),
    ] {
        for bytes in [need - 1, 0] {
            assert_eq!(
                open(free_memory.at(), bytes, &raw const *config, opened_scheduler),
                red_status::TooShort
            );
        }
        assert_eq!(
            open(std::ptr::null_mut(), 0, &raw const *config, opened_scheduler),
            red_status::NullPointer
        );
        assert_eq!(open(free_memory.at(), need, &raw const *config, opened_scheduler), red_status::Ok);
        assert_eq!(red_scheduler_close(opened_scheduler), red_status::Ok);
    }
    // In memory of something open, all of it or a part.
    for offset in [0, 64, RED_SCHEDULER_4X16X16_BYTES - RED_DAG_4X16X16_BYTES] {
        let inside = scheduler_memory.at().wrapping_byte_add(offset);
        let opened = red_dag_open_4x16x16(inside, RED_DAG_4X16X16_BYTES, &raw mut *opened_dag);
        assert_eq!(opened, red_status::Overlap, "{offset}");
    }
    // Arrays: more than there could be, NULL with a length, no length, and room for fewer than there are.
    let (mut count, placed) = (77, placed.as_mut_ptr());
    let place = |lanes: *const u32, pools, room, count: &mut usize| {
        red_dag_place(&raw const *dag, red_rule::LevelSum as u32, 1_000, lanes, pools, placed, room, count)
    };
    for pools in [33, 1 << 32, usize::MAX] {
        assert_eq!(place(lanes.as_ptr(), pools, 16, &mut count), red_status::TooLong);
    }
    for room in [usize::MAX, usize::MAX / 2] {
        assert_eq!(place(lanes.as_ptr(), 1, room, &mut count), red_status::TooLong);
    }
    assert_eq!(place(std::ptr::null(), 1, 16, &mut count), red_status::NullPointer);
    assert_eq!(count, 77, "outputs are written on success only");
    assert_eq!(place(std::ptr::null(), 0, 16, &mut count), red_status::Ok);
    assert_eq!(count, 3);
    assert_eq!(place(lanes.as_ptr(), 1, 2, &mut count), red_status::TooShort);
    assert_eq!(count, 3, "how much room it takes");
}

#[test]
fn row_46_numbers_outside_of_their_enumerations_are_told() {
    let mut world = World::new();
    let World { config, node, dag, number, free_memory, lanes, placed, count, opened_scheduler, .. } =
        &mut *world;
    let opened = &raw mut *opened_scheduler;
    let at_memory = free_memory.at();
    for preset in [6, u32::MAX] {
        assert_eq!(red_config_preset(preset, &raw mut *config), red_status::OutOfRange);
    }
    // Each field of a configuration that has fewer values than its bits.
    type Field = fn(&mut red_config) -> &mut u32;
    let fields: [(Field, u32); 12] = [
        (|c| &mut c.rule, 6),
        (|c| &mut c.gate, 3),
        (|c| &mut c.reassign, 3),
        (|c| &mut c.refine, 2),
        (|c| &mut c.frame_cache, 2),
        (|c| &mut c.shed, 3),
        (|c| &mut c.late, 2),
        (|c| &mut c.best_case, 2),
        (|c| &mut c.admission, 2),
        (|c| &mut c.preempt, 2),
        (|c| &mut c.overload_queue, 1 << 16),
        (|c| &mut c.overload_ticks, 1 << 8),
    ];
    let bytes = RED_SCHEDULER_4X16X16_BYTES;
    for (field, first_wrong) in fields {
        for wrong in [first_wrong, first_wrong + 1, u32::MAX] {
            let mut config = *config;
            *field(&mut config) = wrong;
            let status = red_scheduler_open_4x16x16(at_memory, bytes, &raw const config, opened);
            assert_eq!(status, red_status::OutOfRange, "{config:?}");
        }
    }
    let tickless = red_config { overload_tick_ns: 0, ..*config };
    assert_eq!(
        red_scheduler_open_4x16x16(at_memory, bytes, &raw const tickless, opened),
        red_status::OutOfRange
    );
    let full = red_status::PoolsFull;
    for (lanes, expected) in [(0, red_status::NoLane), (5, full), (256, full), (u32::MAX, full)] {
        let config = red_config { lanes, ..*config };
        assert_eq!(red_scheduler_open_4x16x16(at_memory, bytes, &raw const config, opened), expected);
    }
    let encoder = red_node { role: red_role::SharedEncoder as u32, ..*node };
    let nodes = [
        (red_node { role: 3, ..*node }, red_status::OutOfRange),
        (red_node { role: u32::MAX, ..*node }, red_status::OutOfRange),
        (red_node { atomic: 2, ..*node }, red_status::OutOfRange),
        (red_node { contention_ns: 1, ..*node }, red_status::OutOfRange),
        (red_node { weights: 1 << 16, ..encoder }, red_status::OutOfRange),
        (red_node { frame: 1 << 16, ..encoder }, red_status::OutOfRange),
        (red_node { sensor: 256, ..encoder }, red_status::UnknownSensor),
        (red_node { pool: 256, ..*node }, red_status::UnknownPool),
        (red_node { wcet_ns: u64::MAX, ..*node }, red_status::WorkOverflow),
    ];
    for (node, expected) in nodes {
        assert_eq!(red_dag_add_node(&raw mut *dag, &raw const node, &raw mut *number), expected, "{node:?}");
    }
    for rule in [6, u32::MAX] {
        let placed = placed.as_mut_ptr();
        let status = red_dag_place(&raw const *dag, rule, 1, lanes.as_ptr(), 2, placed, 16, &raw mut *count);
        assert_eq!(status, red_status::OutOfRange);
    }
    let scheduler = &raw mut world.scheduler;
    for lane in [256, u32::MAX] {
        assert_eq!(red_scheduler_poll_on(scheduler, lane, 3, &raw mut world.action), red_status::UnknownLane);
        assert_eq!(red_scheduler_retire_lane(scheduler, lane), red_status::UnknownLane);
        assert_eq!(red_scheduler_restore_lane(scheduler, lane), red_status::UnknownLane);
    }
    // No text for what is no status, and none is a crash.
    for number in [-1, 17, 1_000, i32::MAX, i32::MIN] {
        // SAFETY: a constant text.
        let text = unsafe { std::ffi::CStr::from_ptr(red_status_text(number)) };
        assert_eq!(text, c"no status of this library");
    }
}
