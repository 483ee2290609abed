//! Fixes that name this executable, where it lies: it need not be on the PATH.

use std::env;

/// How a fix names the command where nothing is known about its place.
const ANYWHERE: &str = "$(which redrt)";

/// A message whose fixes go for the running executable.
pub(crate) fn named_in(message: &str) -> String {
    let path = env::current_exe().ok();
    match path.as_ref().and_then(|path| path.to_str()).and_then(quoted) {
        // A new file has none of the rights of the old one.
        Some(path) => message.replace(ANYWHERE, &format!("{path} (a rebuild loses it)")),
        None => message.to_owned(),
    }
}

/// A path as a shell takes it; `None` for one that no terminal should get.
fn quoted(path: &str) -> Option<String> {
    (!path.contains(char::is_control)).then(|| format!("'{}'", path.replace('\'', r"'\''")))
}

#[cfg(test)]
mod tests;
