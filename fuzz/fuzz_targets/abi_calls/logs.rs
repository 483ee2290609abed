//! Logs of schedulers: begun, ended, let go. What is in one that was ended answers again as it did.

use std::path::Path;
use std::sync::LazyLock;
use std::time::Duration;
use std::{fs, thread};

use red_ffi::*;

use crate::twin::or;
use crate::world::{Kind, World};

/// No log can be written there.
pub(crate) const NOWHERE: &str = "/no folder/red.redlog";

/// Threads of this process before there was a log.
static OURS: LazyLock<usize> = LazyLock::new(threads);

fn threads() -> usize {
    fs::read_dir("/proc/self/task").map_or(0, Iterator::count)
}

/// A log that was let go ends in its own time: none of it is the next input's.
pub(crate) fn wait_for_threads() {
    while threads() > *OURS {
        thread::sleep(Duration::from_millis(1));
    }
}

impl World<'_> {
    /// A log may be begun now.
    pub(crate) fn may_log(&mut self) {
        LazyLock::force(&OURS);
        self.is_logged = true;
    }

    /// A scheduler's log is let go.
    pub(crate) fn forget_log(&mut self, at: usize) {
        if let Some(file) = self.twin(at).1.log.take() {
            fs::remove_file(file).expect("a log that was begun");
        }
    }
}

pub(crate) fn begin(w: &mut World<'_>) {
    w.begin("red_record_begin");
    let (handle, at) = w.handle(Kind::Scheduler);
    let file = std::env::temp_dir().join(format!("red-fuzz-{}-{}.redlog", std::process::id(), w.calls));
    let is_somewhere = w.careful || w.choices.chance(200);
    let path = w.path(if is_somewhere { &file } else { Path::new(NOWHERE) });
    w.may_log();
    let status = red_record_begin(handle, path);
    let begun = w.expected(|w| {
        let (twin, stream) = w.twin(at);
        or(twin.is_new() && stream.log.is_none(), red_status::LogLate)?;
        or(is_somewhere, red_status::LogFile)?;
        stream.log = Some(file);
        Ok(())
    });
    w.judge(status, begun, Some(at));
}

pub(crate) fn end(w: &mut World<'_>) {
    w.begin("red_record_end");
    let (handle, at) = w.handle(Kind::Scheduler);
    let now = w.clock();
    let dropped = w.out();
    let status = red_record_end(handle, now, dropped.pointer);
    let ended = w.expected(|w| w.twin(at).1.log.take().ok_or(red_status::Idle));
    let ended = ended.inspect(|_| w.put(dropped, &0_u64));
    w.judge(status, ended.as_ref().map(|_| ()).map_err(|status| *status), Some(at));
    if let Ok(file) = ended {
        let log = fs::read(&file).expect("a log that was ended");
        fs::remove_file(&file).expect("a log that was ended");
        w.twin(at).0.replays(&log);
    }
}
