use super::*;
use red_core::UnitId;

extern "C" fn body(_user: *mut c_void, _context: *const red_context) -> i32 {
    RED_BODY_DONE
}

fn callback(user: &mut u8) -> red_callback {
    red_callback { body: Some(body), user: (&raw mut *user).cast(), node: 0, reserved: 0 }
}

/// Node 0 of a task, as that unit of lane 1.
fn work(generation: u32, unit: u64) -> Work {
    let task = TaskId::from_bits(generation << 16 | 3);
    Work { task, unit: UnitId::from_bits(unit << 16 | 1), ..Work::default() }
}

#[test]
fn a_unit_of_a_task_that_is_gone_runs_no_body_of_the_next_in_its_place() {
    let (mut first, mut next) = (1, 2);
    let of = |generation| work(generation, 1);
    let bodies = Bodies::new();
    assert!(bodies.get(&of(1)).is_none_or(|(body, _)| body.is_none()), "no body was given");
    bodies.set(of(1).task, 0, &[callback(&mut first)]);
    assert!(bodies.get(&of(1)).is_some_and(|(body, user)| body.is_some() && user == (&raw mut first).cast()));
    bodies.set(of(2).task, 0, &[callback(&mut next)]);
    assert!(bodies.get(&of(1)).is_none());
    assert!(bodies.get(&of(2)).is_some_and(|(body, user)| body.is_some() && user == (&raw mut next).cast()));
    assert!(bodies.get(&Work { node: NodeId::new(1), ..of(2) }).is_none());
}

#[test]
fn a_unit_of_a_node_that_is_gone_runs_no_body_of_the_next_in_its_place() {
    let (mut first, mut next) = (1, 2);
    let (old, new) = (work(1, 7), work(1, 8));
    let bodies = Bodies::new();
    bodies.set(old.task, 6, &[callback(&mut first)]);
    assert!(bodies.get(&old).is_some_and(|(_, user)| user == (&raw mut first).cast()));
    bodies.set(old.task, 7, &[callback(&mut next)]);
    assert!(bodies.get(&old).is_none(), "it was started before");
    assert!(bodies.get(&new).is_some_and(|(_, user)| user == (&raw mut next).cast()));
}
