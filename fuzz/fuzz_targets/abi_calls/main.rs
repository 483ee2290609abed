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
//! - units are given out once, jobs end once, and what is counted is what happened;
//! - a log that was ended answers again as it did.
//!
//! *Limit.* No library can tell what an address leads to: never given are addresses where nothing is mapped, outputs in
//! memory that is lent, and more room than there is. Calls come from one thread. Runtimes are set up and closed, never
//! started.
#![no_main]

mod arguments;
mod bytes;
mod desk;
mod graphs;
mod ground;
mod header;
mod jobs;
mod logs;
mod planted;
mod runtimes;
mod schedulers;
mod sizes;
mod statuses;
mod stream;
mod twin;
mod values;
mod world;

use std::cell::RefCell;
use std::sync::LazyLock;

use bytes::Bytes;
use desk::Desk;
use ground::Ground;
use libfuzzer_sys::{Corpus, fuzz_target};
use sizes::{More, Sizes};
use world::{Kind, Thing, World};

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
    ("red_scheduler_dispatch_ahead", 3, schedulers::dispatch_ahead),
    ("red_scheduler_lose_pool", 1, schedulers::lose_pool),
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
    ("red_scheduler_waits_for", 3, jobs::waits_for),
    ("red_scheduler_job", 2, jobs::job),
    ("red_scheduler_executions", 2, jobs::executions),
    ("red_scheduler_figures", 2, jobs::figures),
    ("red_scheduler_take_events", 4, jobs::take_events),
    ("red_record_begin", 1, logs::begin),
    ("red_record_end", 1, logs::end),
    ("red_runtime_open", 2, runtimes::open),
    ("red_runtime_close", 1, runtimes::close),
    ("red_runtime_state_of", 1, runtimes::state_of),
    ("red_runtime_message", 1, runtimes::message),
    ("red_runtime_report", 1, runtimes::report),
    ("red_runtime_start", 1, runtimes::start),
    ("red_runtime_release", 1, runtimes::release),
    ("red_runtime_stop", 1, runtimes::stop),
    ("red_runtime_wait", 1, runtimes::wait),
    ("red_runtime_figures", 2, runtimes::figures),
    ("red_runtime_take_outcomes", 1, runtimes::take_outcomes),
    ("red_runtime_take_events", 1, runtimes::take_events),
    ("red_runtime_add_pool", 4, runtimes::add_pool),
    ("red_runtime_add_cuda_pool", 1, runtimes::add_cuda_pool),
    ("red_runtime_add_sensor", 3, runtimes::add_sensor),
    ("red_runtime_pin", 2, runtimes::pin),
    ("red_runtime_every", 3, runtimes::every),
    ("red_runtime_record", 3, runtimes::record),
    ("red_runtime_now", 1, runtimes::now),
    ("red_runtime_add_task", 12, runtimes::tasks::add_task),
    ("red_runtime_remove_task", 2, runtimes::tasks::remove_task),
    ("red_runtime_certificate", 2, runtimes::tasks::certificate),
    ("red_runtime_edit", 8, runtimes::tasks::edit),
    ("red_runtime_commit", 12, runtimes::tasks::commit),
    ("red_scheduler_take_warning", 1, jobs::take_warning),
    ("red_runtime_take_warnings", 1, runtimes::take_warnings),
    ("red_runtime_task_report", 1, runtimes::tasks::report),
];

/// What a byte calls; and where there are runtimes.
static BY_BYTE: LazyLock<[Vec<Call>; 2]> = LazyLock::new(|| {
    let mut called: Vec<&str> = FUNCTIONS.iter().map(|(name, ..)| *name).collect();
    called.sort_unstable();
    assert_eq!(
        called,
        header::functions().collect::<Vec<_>>(),
        "functions that the header has, and those called"
    );
    ["red_runtime_", "red_scheduler_"].map(|other| {
        // Seldom, with handles of another kind.
        let few = |call: &Call| if call.0.starts_with(other) { 1 } else { call.1 };
        let calls: Vec<Call> =
            FUNCTIONS.iter().flat_map(|call| std::iter::repeat_n(*call, few(call).into())).collect();
        assert!(calls.len() <= 256, "a byte chooses among them");
        calls
    })
});

thread_local! {
    static ARENA: RefCell<Ground> = RefCell::new(Ground::new(graphs::MOST));
    static ARGUMENTS: RefCell<Ground> = RefCell::new(Ground::new(DESK));
}

fuzz_target!(|bytes: &[u8]| -> Corpus {
    let Some((first, rest)) = bytes.split_first() else { return Corpus::Keep };
    let (classes, more) = match first {
        // A log has memory of its own, and so has a runtime.
        0..4 => (1, More::Log),
        4..8 => (1, More::Runtimes),
        8..236 => (1, More::Nothing),
        236..250 => (2, More::Nothing),
        250..254 => (3, More::Nothing),
        _ => (1, More::Crowd),
    };
    let sizes = Sizes { classes, more }.affordable(bytes);
    let is_logged = ARENA.with_borrow_mut(|arena| {
        ARGUMENTS
            .with_borrow_mut(|desk| run(World::new(Bytes::new(rest), arena, Desk::new(desk), sizes), *first))
    });
    if is_logged {
        // What a log's thread ran is for the clock to say: nothing is learnt from it, so that the same seed always leads
        // to the same inputs.
        logs::wait_for_threads();
        return Corpus::Reject;
    }
    Corpus::Keep
});

/// Whether a log was begun.
fn run(mut world: World<'_>, first: u8) -> bool {
    let w = &mut world;
    // Half of all begin with something that can be called.
    if first % 2 == 1 {
        begin(w, w.classes() - 1);
    }
    for _ in 0..CALLS {
        if w.choices.is_empty() {
            break;
        }
        let calls = &BY_BYTE[usize::from(w.has(More::Runtimes))];
        let which = w.choices.below(calls.len());
        (calls[which].2)(w);
    }
    end(w);
    world.is_logged
}

/// A scheduler with a task, and in a crowd as many graphs as there may be.
fn begin(w: &mut World<'_>, class: usize) {
    w.careful = true;
    [schedulers::open_small, schedulers::open_medium, schedulers::open_large][class](w);
    if w.has(More::Log) {
        logs::begin(w);
    }
    if w.has(More::Runtimes) {
        runtimes::open(w);
        graphs::open_large(w);
    } else {
        [graphs::open_small, graphs::open_medium, graphs::open_large][class](w);
    }
    let nodes = if class == 2 { w.choices.below(254) } else { 1 + w.choices.below(6) };
    (0..nodes).for_each(|_| graphs::add_node(w));
    (0..4).for_each(|_| graphs::add_edge(w));
    if w.has(More::Runtimes) {
        runtimes::tasks::add_task(w)
    } else {
        schedulers::add_task(w)
    }
    if w.has(More::Crowd) {
        (0..260).for_each(|_| graphs::open_small(w));
    }
    w.careful = false;
}

/// Everything ends and is closed: the library's table is the next execution's too.
fn end(w: &mut World<'_>) {
    w.nothing_else_was_written();
    w.careful = true;
    let is_scheduler = |w: &World<'_>, at: usize| matches!(w.open[at].thing, Thing::Scheduler(..));
    // The last scheduler is the one that careful calls are about.
    while let Some(at) = (0..w.open.len()).rfind(|at| is_scheduler(w, *at)) {
        // What is large may be closed while it runs.
        if w.open[at].class == 0 || w.twin(at).0.figures().jobs_in_flight < 4 {
            jobs::let_end(w, at);
        }
        if w.twin(at).1.log.is_some() {
            logs::end(w);
        }
        schedulers::close(w);
    }
    while w.open.iter().any(|open| open.thing.kind() == Kind::Dag) {
        graphs::close(w);
    }
    while w.open.iter().any(|open| open.thing.kind() == Kind::Runtime) {
        runtimes::close(w);
    }
    w.nothing_else_was_written();
}
