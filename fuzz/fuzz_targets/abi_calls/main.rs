//! Any sequence of calls of the C ABI, with arguments right and wrong, judged by what the header says and by the same
//! calls on the core itself.
//!
//! Several schedulers and graphs of several classes are open at once, in memory that is lent, closed and lent again.
//! Handles are NULL, misaligned, closed, forged, of another copy or of another kind, or lie in memory that was given back;
//! structs are of other sizes and versions; numbers out of range; arrays too long, too short, empty; outputs lie where
//! inputs are; times go back and leap; tasks, units and jobs are those of the past. After every call:
//!
//! - its status is one that the header lists, and one that the wrong arguments explain; where none is wrong it is what
//!   the core itself answers, and so is every byte that comes out, with canaries around it;
//! - what the call is not about has not changed, nor has anything where it was refused, nor memory that was given back
//!   or never lent;
//! - units are given out once, jobs end once, and what is counted is what happened.
//!
//! *Limit.* No library can tell what an address leads to: never given are addresses where nothing is mapped, outputs in
//! memory that is lent, and more room than there is. Calls come from one thread.
#![no_main]

mod arguments;
mod bytes;
mod desk;
mod graphs;
mod ground;
mod header;
mod jobs;
mod planted;
mod schedulers;
mod stream;
mod twin;
mod values;
mod world;

use std::cell::RefCell;
use std::sync::LazyLock;

use bytes::Bytes;
use desk::Desk;
use ground::Ground;
use libfuzzer_sys::fuzz_target;
use world::{Kind, Sizes, Thing, World};

/// Calls of one input: more reach nothing new, and cost time.
const CALLS: usize = 150;
/// Room for all arguments of a call.
const DESK: usize = 1 << 17;

/// The functions of the header, and how often they are called.
type Call = (&'static str, u8, fn(&mut World<'_>));
const FUNCTIONS: &[Call] = &[
    ("red_config_preset", 1, schedulers::preset),
    ("red_dag_open_4x16x16", 3, graphs::open_small),
    ("red_dag_open_8x64x32", 2, graphs::open_medium),
    ("red_dag_open_16x256x64", 2, graphs::open_large),
    ("red_dag_close", 4, graphs::close),
    ("red_dag_add_node", 10, graphs::add_node),
    ("red_dag_add_edge", 8, graphs::add_edge),
    ("red_dag_remove_node", 3, graphs::remove_node),
    ("red_dag_remove_edge", 3, graphs::remove_edge),
    ("red_dag_refine", 4, graphs::refine),
    ("red_dag_summarize", 2, graphs::summarize),
    ("red_dag_node", 2, graphs::node),
    ("red_dag_successors", 2, graphs::successors),
    ("red_dag_place", 3, graphs::place),
    ("red_dag_share", 2, graphs::share),
    ("red_dag_prove", 2, graphs::prove),
    ("red_scheduler_open_4x16x16", 3, schedulers::open_small),
    ("red_scheduler_open_8x64x32", 2, schedulers::open_medium),
    ("red_scheduler_open_16x256x64", 2, schedulers::open_large),
    ("red_scheduler_close", 2, schedulers::close),
    ("red_scheduler_add_pool", 3, schedulers::add_pool),
    ("red_scheduler_add_sensor", 3, schedulers::add_sensor),
    ("red_scheduler_config", 1, schedulers::config),
    ("red_scheduler_memory_used", 2, schedulers::memory_used),
    ("red_scheduler_add_task", 8, schedulers::add_task),
    ("red_scheduler_remove_task", 2, schedulers::remove_task),
    ("red_scheduler_certificate", 2, schedulers::certificate),
    ("red_scheduler_edit", 5, schedulers::edit),
    ("red_scheduler_commit", 6, schedulers::commit),
    ("red_scheduler_release", 18, jobs::release),
    ("red_scheduler_release_at", 10, jobs::release_at),
    ("red_scheduler_poll", 30, jobs::poll),
    ("red_scheduler_poll_on", 8, jobs::poll_on),
    ("red_scheduler_complete", 18, jobs::complete),
    ("red_scheduler_complete_and_poll", 12, jobs::complete_and_poll),
    ("red_scheduler_fail", 4, jobs::fail),
    ("red_scheduler_take_outcome", 3, jobs::take_outcome),
    ("red_scheduler_retire_lane", 2, jobs::retire_lane),
    ("red_scheduler_restore_lane", 3, jobs::restore_lane),
    ("red_scheduler_poll_at", 2, jobs::poll_at),
    ("red_scheduler_unit", 3, jobs::unit),
    ("red_scheduler_members", 3, jobs::members),
    ("red_scheduler_job", 2, jobs::job),
    ("red_scheduler_executions", 2, jobs::executions),
    ("red_scheduler_figures", 2, jobs::figures),
    ("red_scheduler_take_events", 5, jobs::take_events),
];

/// What a byte calls.
static BY_BYTE: LazyLock<Vec<Call>> = LazyLock::new(|| {
    let mut called: Vec<&str> = FUNCTIONS.iter().map(|(name, ..)| *name).collect();
    called.sort_unstable();
    assert_eq!(
        called,
        header::functions().collect::<Vec<_>>(),
        "functions that the header has, and those called"
    );
    FUNCTIONS.iter().flat_map(|call| std::iter::repeat_n(*call, call.1.into())).collect()
});

thread_local! {
    static ARENA: RefCell<Ground> = RefCell::new(Ground::new(graphs::arena(2, false).max(graphs::arena(0, true))));
    static ARGUMENTS: RefCell<Ground> = RefCell::new(Ground::new(DESK));
}

fuzz_target!(|bytes: &[u8]| {
    let Some((first, rest)) = bytes.split_first() else { return };
    let sizes = match first {
        0..236 => Sizes { classes: 1, crowd: false },
        236..250 => Sizes { classes: 2, crowd: false },
        // To compare a scheduler of the largest class costs as much as fifty executions.
        250..254 if rest.first().is_some_and(|byte| byte % 8 == 0) => Sizes { classes: 3, crowd: false },
        250..254 => Sizes { classes: 2, crowd: false },
        _ => Sizes { classes: 1, crowd: true },
    };
    ARENA.with_borrow_mut(|arena| {
        ARGUMENTS
            .with_borrow_mut(|desk| run(World::new(Bytes::new(rest), arena, Desk::new(desk), sizes), *first));
    });
});

fn run(mut world: World<'_>, first: u8) {
    world::constants();
    let w = &mut world;
    // Half of all begin with something that can be called.
    if first % 2 == 1 {
        begin(w, if w.is_crowded() { 0 } else { w.classes() - 1 });
    }
    for _ in 0..CALLS {
        if w.choices.is_empty() {
            break;
        }
        let which = w.choices.below(BY_BYTE.len());
        (BY_BYTE[which].2)(w);
    }
    end(w);
}

/// A scheduler with a task, and in a crowd as many graphs as there may be.
fn begin(w: &mut World<'_>, class: usize) {
    w.careful = true;
    [schedulers::open_small, schedulers::open_medium, schedulers::open_large][class](w);
    [graphs::open_small, graphs::open_medium, graphs::open_large][class](w);
    let nodes = if class == 2 { w.choices.below(254) } else { 1 + w.choices.below(6) };
    (0..nodes).for_each(|_| graphs::add_node(w));
    (0..4).for_each(|_| graphs::add_edge(w));
    schedulers::add_task(w);
    if w.is_crowded() {
        (0..260).for_each(|_| graphs::open_small(w));
    }
    w.careful = false;
}

/// Everything ends and is closed: the library's table is the next execution's too.
fn end(w: &mut World<'_>) {
    w.careful = true;
    let is_scheduler = |w: &World<'_>, at: usize| matches!(w.open[at].thing, Thing::Scheduler(..));
    // The last scheduler is the one that careful calls are about.
    while let Some(at) = (0..w.open.len()).rfind(|at| is_scheduler(w, *at)) {
        // What is large may be closed while it runs.
        if w.open[at].class == 0 || w.twin(at).0.figures().jobs_in_flight < 4 {
            jobs::let_end(w, at);
        }
        schedulers::close(w);
    }
    while w.open.iter().any(|open| open.thing.kind() == Kind::Dag) {
        graphs::close(w);
    }
    w.nothing_else_was_written();
}
