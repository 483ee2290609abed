//! The board: two timers that count down, one for alarms, a serial line, and the interrupts of these. Where it is
//! unsafe, a register is touched at the address that the board's description gives.

use core::fmt;

use cortex_m::interrupt::InterruptNumber;
use cortex_m::peripheral::{NVIC, SCB, scb::VectActive};

use crate::{clock, firmware};

/// How fast the timers count.
pub(crate) const HZ: u32 = 25_000_000;

const CLOCK: usize = 0x4000_0000;
const CAMERA: usize = 0x4000_1000;
const ALARM: usize = 0x4000_2000;
const SERIAL: usize = 0x4000_4000;

// Of the timers.
const CONTROL: usize = 0x0;
const VALUE: usize = 0x4;
const RELOAD: usize = 0x8;
const CLEAR: usize = 0xC;
/// Runs, and interrupts when it reaches 0.
const RUN: u32 = 0b1001;

// Of the alarm's timer.
const ALARM_LOAD: usize = 0x0;
const ALARM_CONTROL: usize = 0x8;
const ALARM_CLEAR: usize = 0xC;
/// Runs once, over 32 bits, and interrupts.
const RUN_ONCE: u32 = 0b1010_0011;

/// The interrupts that are used, by their numbers.
#[derive(Clone, Copy)]
#[repr(u16)]
enum Interrupt {
    Clock = 8,
    Camera = 9,
    Alarm = 10,
}

// SAFETY: these are numbers of the board's interrupts.
unsafe impl InterruptNumber for Interrupt {
    fn number(self) -> u16 {
        self as u16
    }
}

/// An entry of the vector table.
type Handler = extern "C" fn();

/// The vector table after the processor's own exceptions.
// Sound because the start-up code expects exactly this symbol in this section.
#[unsafe(no_mangle)]
#[unsafe(link_section = ".vector_table.interrupts")]
static __INTERRUPTS: [Option<Handler>; 11] =
    [None, None, None, None, None, None, None, None, Some(clock_wrapped), Some(camera_ready), Some(alarm)];

/// Starts the clock and allows the interrupts.
pub(crate) fn start() {
    write(CLOCK + RELOAD, u32::MAX);
    write(CLOCK + VALUE, u32::MAX);
    write(CLOCK + CONTROL, RUN);
    // The lowest bit makes the serial line send.
    write(SERIAL + 0x8, 1);
    write(SERIAL + 0x10, 16);
    for interrupt in [Interrupt::Clock, Interrupt::Camera, Interrupt::Alarm] {
        // SAFETY: the handlers are in the table, and nothing relies on these interrupts being off.
        unsafe { NVIC::unmask(interrupt) };
    }
}

/// A frame every `micros`, from now on.
pub(crate) fn start_camera(micros: u32) {
    write(CAMERA + RELOAD, micros * (HZ / 1_000_000) - 1);
    write(CAMERA + VALUE, micros * (HZ / 1_000_000) - 1);
    write(CAMERA + CONTROL, RUN);
}

/// No further frames.
pub(crate) fn stop_camera() {
    write(CAMERA + CONTROL, 0);
}

/// Counts up, and wraps.
pub(crate) fn counter() -> u32 {
    !read(CLOCK + VALUE)
}

/// An interrupt after that many counts.
pub(crate) fn set_alarm(counts: u32) {
    write(ALARM + ALARM_CONTROL, 0);
    write(ALARM + ALARM_LOAD, counts);
    write(ALARM + ALARM_CONTROL, RUN_ONCE);
}

/// The serial line.
pub(crate) struct Serial;

impl fmt::Write for Serial {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        text.bytes().for_each(|byte| write(SERIAL, byte.into()));
        Ok(())
    }
}

extern "C" fn clock_wrapped() {
    write(CLOCK + CLEAR, 1);
    clock::count_wrap();
}

extern "C" fn camera_ready() {
    write(CAMERA + CLEAR, 1);
    let number = Interrupt::Camera as u8;
    firmware::frame(matches!(SCB::vect_active(), VectActive::Interrupt { irqn } if irqn == number));
}

extern "C" fn alarm() {
    write(ALARM + ALARM_CLEAR, 1);
    clock::alarm();
}

fn read(register: usize) -> u32 {
    // SAFETY: a register of the board, aligned; reading it has no effect on memory.
    unsafe { core::ptr::with_exposed_provenance::<u32>(register).read_volatile() }
}

fn write(register: usize, value: u32) {
    // SAFETY: a register of the board, aligned; writing it has no effect on memory.
    unsafe { core::ptr::with_exposed_provenance_mut::<u32>(register).write_volatile(value) };
}
