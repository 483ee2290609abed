//! The Linux host of the RED scheduler: lanes as pinned `SCHED_FIFO` threads.
//!
//! # The operating-system layer
//!
//! | module | what it gives |
//! |---|---|
//! | [`clock`] | `CLOCK_MONOTONIC` as one integer of nanoseconds |
//! | [`bell`] | a wake-up that makes no system call while nobody sleeps |
//! | [`spin_lead`], [`sleeper`] | sleeping to an absolute time, with a final spin that calibrates itself |
//! | [`seat`] | where a lane is handed its next unit: one cache line, that moves once |
//! | [`stream`], [`stream_seat`] | lanes that give their units to a stream, and get some ahead |
//! | `cuda` (feature `cuda`) | streams of a CUDA device as lanes |
//! | [`waiting`] | how lanes wait: who keeps the time, who takes a request |
//! | [`errands`] | how a thread that is no lane has something done under the scheduler's lock |
//! | [`slot`], [`spares`] | the bound of a body, and who goes on when it has passed |
//! | [`pi_lock`] | the priority-inheriting lock for threads that share a CPU |
//! | [`setup`] | FIFO priority, pinning, locked memory, heap and idle-state settings |
//! | [`placement`] | which CPUs the lanes get |
//! | [`watchdog`] | demotes a lane whose body never returns |
//! | [`stop`] | who may stop a run; Ctrl-C and SIGTERM as a bell |
//! | [`control`] | what other threads may ask of a run: releases, errands, its end |
//! | [`panics`] | panics of node bodies, kept instead of printed |
//! | [`utilisation`] | how much a GPU is used, by whomever, for overload control |
//! | [`usage`] | page faults and involuntary context switches |
//! | [`preflight`] | the findings of `redrt doctor` |
//!
//! # Priorities
//!
//! Lanes run at one FIFO priority P, each on its own CPU; the watchdog runs at P + 1. Everything else stays
//! an ordinary thread.
//!
//! # What is refused
//!
//! A right that is missing is a [`setup::SetupError::NotPermitted`] with its fix. Whoever decides to go on
//! without it has a best-effort run: lanes share CPUs, take the [`pi_lock::PiLock`] and never spin.
#![deny(unsafe_code)]

pub mod allocations;
mod allowance;
pub mod bell;
pub mod clock;
pub mod control;
#[cfg(feature = "cuda")]
pub mod cuda;
pub mod errands;
pub mod handler;
pub mod held_cpus;
mod held_memory;
mod lane;
mod on_stream;
mod oversight;
pub mod panics;
mod per_process;
pub mod pi_lock;
pub mod placement;
pub mod preflight;
mod primitive;
pub mod report;
pub mod runtime;
pub mod seat;
pub mod setup;
mod shared;
pub mod sleeper;
pub mod slot;
pub mod spares;
pub mod spin_lead;
mod standstills;
pub mod stop;
pub mod stream;
pub mod stream_seat;
mod supervision;
mod sys;
mod threads;
pub mod timeline;
pub mod usage;
pub mod utilisation;
pub mod waiting;
pub mod watchdog;
