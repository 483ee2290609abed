//! What a terminal may get that a file must not: moves of the cursor, colours, wrapped lines.

use std::env;
use std::io::{self, IsTerminal, Write};
use std::sync::mpsc::{self, SyncSender};
use std::thread::{self, JoinHandle};

/// Width that lines are wrapped to: every terminal has it.
const COLUMNS: usize = 80;

/// Whether a stream is a terminal whose cursor can be moved.
pub(crate) fn moves(stream: &impl IsTerminal) -> bool {
    stream.is_terminal() && env::var_os("TERM").is_some_and(|term| term != "dumb")
}

/// Writes to standard error at once. Where nobody listens, nobody misses it.
pub(crate) fn tell(text: &str) {
    let mut err = io::stderr().lock();
    let _told = err.write_all(text.as_bytes()).and_then(|()| err.flush());
}

/// Texts that wait while standard error takes none.
const WAITING: usize = 64;

/// Tells on standard error for who must not wait: a terminal that was halted, or a pipe that nobody reads, holds a
/// thread of its own. What finds no room is not told.
pub(crate) struct Teller {
    texts: Option<SyncSender<String>>,
    thread: Option<JoinHandle<()>>,
}

impl Teller {
    pub(crate) fn new() -> Self {
        let (texts, told) = mpsc::sync_channel::<String>(WAITING);
        let writes = move || told.iter().for_each(|text| tell(&text));
        // Without the thread nothing is told, and everything else goes on.
        Self { texts: Some(texts), thread: thread::Builder::new().spawn(writes).ok() }
    }

    pub(crate) fn tell(&self, text: String) {
        let _room = self.texts.as_ref().map(|texts| texts.try_send(text));
    }
}

impl Drop for Teller {
    /// What is told after this comes after what was told before.
    fn drop(&mut self) {
        self.texts = None;
        let _written = self.thread.take().map(JoinHandle::join);
    }
}

/// Colours, where a terminal shows them and NO_COLOR does not forbid them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Paint {
    on: bool,
}

impl Paint {
    /// For what goes to `stream`.
    pub(crate) fn on(stream: &impl IsTerminal) -> Self {
        Self { on: moves(stream) && env::var_os("NO_COLOR").is_none_or(|value| value.is_empty()) }
    }

    pub(crate) fn red(self, text: &str) -> String {
        self.with("31", text)
    }

    pub(crate) fn green(self, text: &str) -> String {
        self.with("32", text)
    }

    pub(crate) fn yellow(self, text: &str) -> String {
        self.with("33", text)
    }

    fn with(self, colour: &str, text: &str) -> String {
        if self.on && !text.is_empty() { format!("\x1b[{colour}m{text}\x1b[0m") } else { text.to_owned() }
    }
}

/// Breaks a line between words; what follows a break is indented. A word that is too long stays whole, so that it
/// can be copied.
pub(crate) fn wrap(line: &str, indent: usize) -> String {
    let mut wrapped = String::new();
    let mut column = indent;
    for (i, word) in line.split(' ').enumerate() {
        let len = word.chars().count();
        if i > 0 && column + 1 + len > COLUMNS {
            wrapped.push('\n');
            wrapped.push_str(&" ".repeat(indent));
            column = indent;
        } else if i > 0 {
            wrapped.push(' ');
            column += 1;
        }
        wrapped.push_str(word);
        column += len;
    }
    wrapped
}

#[cfg(test)]
mod tests;
