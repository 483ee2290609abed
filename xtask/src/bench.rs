//! The bench, with the C ABI as it ships where it measures that.

use crate::abi;
use crate::process::Failure;
use crate::report::Tally;
use crate::workspace::Workspace;

/// What the bench loads the library by.
const LIBRARY: &str = "RED_BENCH_LIBRARY";

/// Whether these words leave out the section of the C ABI.
fn is_of_others(words: &[&str]) -> bool {
    let mut sections = words.windows(2).filter(|pair| pair[0] == "--section").map(|pair| pair[1]).peekable();
    sections.peek().is_some() && sections.all(|section| section != "abi")
}

/// `cargo xtask bench`.
///
/// # Errors
/// The library does not build, or the bench ends with a status of its own, and has said why.
pub(crate) fn run(workspace: &Workspace, words: &[&str]) -> Result<Tally, Failure> {
    let bench = workspace.cargo(&["run", "--release", "-p", "red-benches", "--"]).args(words);
    if is_of_others(words) {
        return bench.stream();
    }
    let prefix = workspace.target.join("bench");
    abi::installed(workspace, &prefix, &[])?;
    bench.env(LIBRARY, prefix.join("lib/libred_core.so")).stream()
}

#[cfg(test)]
mod tests {
    use super::is_of_others;

    #[test]
    fn the_library_is_built_where_it_is_measured() {
        assert!(!is_of_others(&[]) && !is_of_others(&["--quick", "--section", "abi"]));
        assert!(is_of_others(&["--section", "record"]) && !is_of_others(&["--section"]));
        assert!(!is_of_others(&["--section", "record", "--section", "abi"]));
    }
}
