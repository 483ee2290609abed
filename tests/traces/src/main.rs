//! The program that writes traces: on Linux to standard output, on a microcontroller by semihosting.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod chip;
#[cfg(not(target_os = "none"))]
mod linux;

#[cfg(not(target_os = "none"))]
fn main() -> std::process::ExitCode {
    linux::main()
}
