//! A robot's perception on a microcontroller: RED as embassy tasks, on an emulated board. See README.md.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod board;
#[cfg(target_os = "none")]
mod clock;
#[cfg(target_os = "none")]
mod firmware;
#[cfg(target_os = "none")]
mod scene;

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!(
        "This is firmware: in its folder, `cargo run --release` builds it for the board and starts the emulator."
    );
}
