use super::*;

extern "C" fn body(_user: *mut c_void, _context: *const red_context) -> i32 {
    RED_BODY_DONE
}

fn callback(user: &mut u8) -> red_callback {
    red_callback { body: Some(body), user: (&raw mut *user).cast(), node: 0, reserved: 0 }
}

#[test]
fn a_unit_of_a_task_that_is_gone_runs_no_body_of_the_next_in_its_place() {
    let (mut first, mut next) = (1, 2);
    let of = |generation: u32| Work { task: TaskId::from_bits(generation << 16 | 3), ..Work::default() };
    let bodies = Bodies::new();
    assert!(bodies.get(&of(1)).is_none_or(|(body, _)| body.is_none()), "no body was given");
    bodies.set(of(1).task, &[callback(&mut first)]);
    assert!(bodies.get(&of(1)).is_some_and(|(body, user)| body.is_some() && user == (&raw mut first).cast()));
    bodies.set(of(2).task, &[callback(&mut next)]);
    assert!(bodies.get(&of(1)).is_none());
    assert!(bodies.get(&of(2)).is_some_and(|(body, user)| body.is_some() && user == (&raw mut next).cast()));
    assert!(bodies.get(&Work { node: NodeId::new(1), ..of(2) }).is_none());
}
