//! The firmware: two lanes of an accelerator and one of the processor, released by the camera's interrupt. It ends
//! with exit status 0 only if everything was as it should be.

use core::cell::Cell;
use core::fmt::Write;
use core::panic::PanicInfo;

use critical_section::Mutex;
use defmt_semihosting as _;
use embassy_executor::{SpawnError, SpawnToken, Spawner};
use red_core::{Caps, Config, Counters, LaneId, Outcome, TaskId, Unit};
use red_embassy::{Dispatcher, Fault};
use semihosting::experimental::env;
use semihosting::process;

use crate::board::{self, Serial};
use crate::clock;
use crate::scene::{self, CRUISE, WATCH, Work};

/// 2 tasks of 8 nodes, 4 jobs in flight, 4 lanes in 2 pools.
pub(crate) type Robot = Caps<2, 8, 4, 4, 2>;

/// Frames of one run.
const FRAMES: u32 = 30;
/// Encoders, lanes, and what else there is to run for one frame; the second encoder is not run.
const UNITS_PER_FRAME: u64 = (CRUISE.len() + WATCH.len() - 1) as u64;

static RED: Dispatcher<Robot> = Dispatcher::new();
static TASKS: Mutex<Cell<Option<[TaskId; 2]>>> = Mutex::new(Cell::new(None));
static SEEN: Mutex<Cell<Seen>> = Mutex::new(Cell::new(Seen::NOTHING));

/// What happened.
#[derive(Clone, Copy)]
struct Seen {
    /// Interrupts of the camera, and those that did not come through their place in the vector table.
    frames: u32,
    strayed: u32,
    encoders: u32,
    ended: u32,
    on_time: u32,
}

impl Seen {
    const NOTHING: Self = Self { frames: 0, strayed: 0, encoders: 0, ended: 0, on_time: 0 };
}

fn note(what: impl FnOnce(&mut Seen)) {
    critical_section::with(|cs| {
        let mut seen = SEEN.borrow(cs).get();
        what(&mut seen);
        SEEN.borrow(cs).set(seen);
    });
}

/// The camera has a frame: both tasks read it. Called by its interrupt.
pub(crate) fn frame(by_its_vector: bool) {
    let mut last = false;
    note(|seen| {
        seen.frames += 1;
        seen.strayed += u32::from(!by_its_vector);
        last = seen.frames == FRAMES;
    });
    let tasks = critical_section::with(|cs| TASKS.borrow(cs).get());
    for task in tasks.into_iter().flatten() {
        // What is lost is counted by the dispatcher.
        let _counted = RED.release_from_interrupt(task);
    }
    if last {
        board::stop_camera();
    }
}

#[embassy_executor::task]
async fn dispatcher() -> ! {
    RED.run(ended).await
}

fn ended(job: &Outcome) {
    defmt::info!(
        "{} {}: {} us after its release",
        job.task,
        job.index,
        job.at.since(job.release).as_nanos() / 1_000
    );
    note(|seen| {
        seen.ended += 1;
        seen.on_time += u32::from(job.on_time());
    });
}

#[embassy_executor::task(pool_size = 3)]
async fn lane(number: u8) {
    let refused = RED.run_lane(LaneId::new(number), body).await;
    defmt::error!("lane {}: {}", number, refused);
}

async fn body(unit: Unit) -> Result<(), Fault> {
    let steps = if unit.first.task.index() == 0 { &CRUISE[..] } else { &WATCH[..] };
    let step = steps.get(unit.first.node.index()).ok_or(Fault)?;
    defmt::debug!("{} {} on {}", step.name, unit.first.index, unit.lane);
    note(|seen| seen.encoders += u32::from(step.name == "encoder"));
    match step.work {
        Work::Infer => clock::wait(step.micros).await,
        Work::Compute => clock::compute(step.micros),
    }
    Ok(())
}

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    board::start();
    RED.configure(Config::REDRT.with_lanes(2));
    // A mistake to be found: nothing can be shared.
    let other_frame = env::args::<256>().is_ok_and(|words| words.flatten().any(|word| word == "other-frame"));
    let tasks = RED.with(|scheduler| scene::add(scheduler, other_frame));
    critical_section::with(|cs| TASKS.borrow(cs).set(tasks));
    start(&spawner, dispatcher());
    (0..3).for_each(|number| start(&spawner, lane(number)));
    board::start_camera((scene::PERIOD.as_nanos() / 1_000) as u32);
    // Until the last frame's jobs are over.
    clock::wait(u64::from(FRAMES + 2) * scene::PERIOD.as_nanos() / 1_000).await;
    let seen = critical_section::with(|cs| SEEN.borrow(cs).get());
    let is_right = report(&seen, RED.with(|scheduler| scheduler.counters()));
    process::exit(i32::from(!is_right));
}

fn start<S>(spawner: &Spawner, task: Result<SpawnToken<S>, SpawnError>) {
    match task {
        Ok(task) => spawner.spawn(task),
        Err(reason) => defmt::error!("{}", reason),
    }
}

/// Prints what happened beside what should have; whether they are the same.
fn report(seen: &Seen, counters: Counters) -> bool {
    let frames = u64::from(FRAMES);
    let rows = [
        ("frames, by interrupt", u64::from(seen.frames), frames),
        ("interrupts astray", seen.strayed.into(), 0),
        ("releases lost", RED.lost_releases().into(), 0),
        ("jobs ended", seen.ended.into(), 2 * frames),
        ("jobs on time", seen.on_time.into(), 2 * frames),
        ("encoders run", seen.encoders.into(), frames),
        ("encoder runs saved", counters.encoder_runs_saved, frames),
        ("units", counters.units, UNITS_PER_FRAME * frames),
        ("overruns", counters.overruns, 0),
        ("clock steps back", counters.clock_steps_back, 0),
        ("scheduler outside .bss", u64::from(!is_in_bss(&raw const RED as usize)), 0),
    ];
    let _sent = writeln!(Serial, "scheduler state: {} bytes in .bss", Dispatcher::<Robot>::SIZE);
    for (what, found, expected) in rows {
        let verdict = if found == expected { "" } else { "  WRONG" };
        let _sent = writeln!(Serial, "{what:<24}{found:>4} of {expected:>4}{verdict}");
    }
    rows.iter().all(|(_, found, expected)| found == expected)
}

fn is_in_bss(address: usize) -> bool {
    // Sound because the linker script of cortex-m-rt has both symbols, and only their addresses are taken.
    unsafe extern "C" {
        safe static __sbss: u32;
        safe static __ebss: u32;
    }
    let (begin, end) = (&raw const __sbss as usize, &raw const __ebss as usize);
    (begin..end).contains(&address)
}

#[panic_handler]
fn panic(why: &PanicInfo<'_>) -> ! {
    let _sent = writeln!(Serial, "{why}");
    process::exit(101)
}
