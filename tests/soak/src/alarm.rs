//! A workload that does not end: threads that wait for each other tell nobody.

use std::process::{Command, Stdio};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// Does something once, unless it is dropped in time.
pub(crate) struct Alarm {
    held: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Alarm {
    pub(crate) fn set(after: Duration, act: impl FnOnce() + Send + 'static) -> Self {
        let (held, is_held) = channel();
        let thread = thread::spawn(move || {
            if is_held.recv_timeout(after) == Err(RecvTimeoutError::Timeout) {
                act();
            }
        });
        Self { held: Some(held), thread: Some(thread) }
    }
}

/// Nothing of it is left, so that a look at memory sees none of it.
impl Drop for Alarm {
    fn drop(&mut self) {
        drop(self.held.take());
        drop(self.thread.take().map(JoinHandle::join));
    }
}

/// Ends another process, a halted one too.
pub(crate) fn kill(process: u32) {
    let mut command = Command::new("kill");
    // Where there is no such program, the process is waited for.
    let _status = command.args(["-KILL", &process.to_string()]).stdin(Stdio::null()).status();
}
