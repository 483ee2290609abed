//! Traces by semihosting: arguments, output and exit status are those of the emulator.

use core::fmt;

// Has the critical section.
use cortex_m as _;
use cortex_m_rt::entry;
use semihosting::experimental::env;
use semihosting::io::{self, Stdout, Write};
use semihosting::process::ExitCode;

/// The command line is short.
const ARGUMENTS: usize = 256;

/// Collects text, because each call of semihosting stops the processor.
struct Text {
    host: Stdout,
    bytes: [u8; 16_384],
    len: usize,
}

impl Text {
    fn flush(&mut self) -> fmt::Result {
        let len = core::mem::take(&mut self.len);
        self.host.write_all(&self.bytes[..len]).map_err(|_| fmt::Error)
    }
}

impl fmt::Write for Text {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for byte in text.bytes() {
            if self.len == self.bytes.len() {
                self.flush()?;
            }
            self.bytes[self.len] = byte;
            self.len += 1;
        }
        Ok(())
    }
}

#[entry]
fn start() -> ! {
    let written = io::stdout().map_err(|_| fmt::Error).and_then(|host| {
        let mut out = Text { host, bytes: [0; 16_384], len: 0 };
        let arguments = env::args::<ARGUMENTS>().map_err(|_| fmt::Error)?;
        // The first word is the program's name.
        red_traces::run(arguments.skip(1).flatten(), &mut out)?;
        out.flush()
    });
    let status = if written.is_ok() { ExitCode::SUCCESS } else { ExitCode::FAILURE };
    status.exit_process()
}
