use super::HandlerState::{Done, Idle, Io, OutOfMemory, Ready, Running};
use super::*;

#[test]
fn only_the_transitions_of_the_diagram_are_legal() {
    let diagram = [
        (Idle, Ready),
        (Ready, Running),
        (Running, Done),
        (Done, Idle),
        (Running, Io),
        (Io, Running),
        (Running, OutOfMemory),
        (Io, OutOfMemory),
        (OutOfMemory, Ready),
        (OutOfMemory, Done),
    ];
    for from in HandlerState::ALL {
        for to in HandlerState::ALL {
            let handler = HandlerCell(AtomicU8::new(from as u8));
            let legal = diagram.contains(&(from, to));
            assert_eq!(handler.go(from, to), if legal { Ok(()) } else { Err(TransitionError::Illegal) });
            assert_eq!(handler.state(), if legal { to } else { from }, "{from:?} to {to:?}");
        }
    }
}

#[test]
fn a_handler_that_is_elsewhere_stays_there() {
    let handler = HandlerCell::new();
    assert_eq!(handler.go(Running, Done), Err(TransitionError::Elsewhere));
    assert_eq!(handler.state(), Idle);
    assert!(TransitionError::Elsewhere.to_string().starts_with("The handler is not in the state"));
}
