//! A sign of life for work that takes more than a second, where somebody looks.

use crate::terminal;
use std::io;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

/// Does `work`; after a second, and each second, one line on a terminal tells for how long already.
pub(crate) fn during<T>(what: &str, work: impl FnOnce() -> T) -> T {
    if !terminal::moves(&io::stderr()) {
        return work();
    }
    thread::scope(|scope| {
        let (done, running) = mpsc::channel::<()>();
        let watch = move || {
            let start = Instant::now();
            let mut shown = false;
            while running.recv_timeout(Duration::from_secs(1)) == Err(RecvTimeoutError::Timeout) {
                shown = true;
                terminal::tell(&format!("\r{what}: {} s", start.elapsed().as_secs()));
            }
            if shown {
                terminal::tell("\r\x1b[K");
            }
        };
        // Without the thread there is no sign of life, and the work is done all the same.
        let _watcher = thread::Builder::new().spawn_scoped(scope, watch);
        let result = work();
        drop(done);
        result
    })
}
