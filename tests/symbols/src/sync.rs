//! Calls of the synchronizers.

use red_core::{Action, Caps, Instant, Scheduler};
use red_sync::{
    Exclusive, Gate, HandlerCell, HandlerState, Inside, Mailbox, Post, Request, Requests, SeqLock,
    SharedScheduler, TicketLock, TransitionError,
};

type C = Caps<4, 16, 16>;
type Lock = TicketLock<Scheduler<C>>;
type Shared = SharedScheduler<C, Lock, 4, 8>;
type Box = Mailbox<Request, 8>;

#[expect(non_snake_case, reason = "an entry is the name of a type and that of its call")]
mod entry {
    use super::*;

    crate::entries! { "sync";
        fn Gate_closed() -> Gate { Gate::closed() }
        fn Gate_open(gate: &Gate) { gate.open(); }
        fn Gate_enter(gate: &Gate) -> Option<Inside<'_>> { gate.enter() }
        fn Gate_close(gate: &Gate) -> bool { gate.close() }
        fn Gate_forget(gate: &Gate) { gate.forget(); }
        fn Gate_inside(gate: &Gate) -> u32 { gate.inside() }
        fn Inside_drop(inside: Inside<'_>) { drop(inside) }
        fn HandlerCell_new() -> HandlerCell { HandlerCell::new() }
        fn HandlerCell_go(cell: &HandlerCell, from: HandlerState, to: HandlerState) -> Result<(), TransitionError> {
            cell.go(from, to)
        }
        fn HandlerCell_state(cell: &HandlerCell) -> HandlerState { cell.state() }
        fn Mailbox_new() -> Box { Box::new() }
        fn Mailbox_claim(mailbox: &Box) -> Option<Post<'_, Request, 8>> { mailbox.claim() }
        fn SeqLock_new() -> SeqLock<3> { SeqLock::new() }
        fn SeqLock_write(words: &SeqLock<3>, new: [*mut (); 3]) { words.write(new) }
        fn SeqLock_read(words: &SeqLock<3>) -> Option<[*mut (); 3]> { words.read() }
        fn Mailbox_pop(mailbox: &Box) -> Option<Request> { mailbox.pop() }
        fn Post_push(post: &Post<'_, Request, 8>, letter: Request) -> Result<(), Request> { post.push(letter) }
        fn Post_drop(post: Post<'_, Request, 8>) { drop(post) }
        fn TicketLock_new(value: u64) -> TicketLock<u64> { TicketLock::new(value) }
        fn TicketLock_drawn(lock: &TicketLock<u64>) -> u32 { lock.drawn() }
        fn TicketLock_with(lock: &TicketLock<u64>, value: u64) -> u64 {
            lock.with(|inside| core::mem::replace(inside, value))
        }
        fn SharedScheduler_new(scheduler: Scheduler<C>) -> Shared { Shared::new(scheduler) }
        fn SharedScheduler_producer(shared: &Shared, number: usize) -> Option<Post<'_, Request, 8>> {
            shared.producer(number)
        }
        fn SharedScheduler_with(shared: &Shared, now: Instant) -> Option<Action> {
            shared.with(|scheduler, requests| {
                while let Some(r) = requests.next() {
                    let _refused = scheduler.release_at(r.task, r.at, r.capture, now);
                }
                scheduler.poll(now)
            })
        }
        fn Requests_next(requests: &mut Requests<'_, 8>) -> Option<Request> { requests.next() }
    }
}
