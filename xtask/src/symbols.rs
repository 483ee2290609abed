//! No reachable panic and no allocation in what ships: every public call of core and synchronizers, compiled as a
//! release is, and what those calls can reach in the object.
//!
//! What they may reach outside of themselves is a short list. An object without entries would reach nothing, so each
//! public function of the sources has to have its entry first, and a planted panic and a planted allocation have to be
//! found. The same is asked of the functions of the C ABI.

mod entries;
mod reach;
mod shipped;

use std::fs;

use crate::cross::{self, CORTEX_M4};
use crate::depth::Depth;
use crate::nightly::HOST;
use crate::process::Failure;
use crate::report::Tally;
use crate::workspace::Workspace;

/// What an object may leave to its system: copies and comparisons of memory that the compiler writes.
pub(crate) const OUTSIDE: &[&str] = &["memcpy", "memmove", "memset", "memcmp", "bcmp"];

/// Parts of names that nothing may reach.
pub(crate) const FORBIDDEN: &[&str] =
    &["9panicking", "panic_on_ord_violation", "rust_begin_unwind", "_Unwind", "rust_alloc", "rust_dealloc"];

/// Entries that the check has to find something in, and a part of its name.
const PLANTED: &[(&str, &str)] = &[("red_planted_panic", "panicking"), ("red_planted_allocation", "alloc")];

/// # Errors
/// An entry is missing, something forbidden is reached, or a planted bug is not seen.
pub(crate) fn check(workspace: &Workspace, _: Depth) -> Result<Tally, Failure> {
    cross::library(workspace, CORTEX_M4)?;
    let wanted = entries::wanted(workspace)?;
    for target in [HOST, CORTEX_M4] {
        let wrong = |what: String| Failure::Wrong(format!("{target}: {what}"));
        let build = ["build", "--quiet", "--release", "--package", "red-symbols", "--target", target];
        workspace.cargo(&build).stream()?;
        let archive = workspace.target.join(target).join("release/libred_symbols.a");
        let bytes = fs::read(&archive).map_err(Failure::of_file(&archive))?;
        let look = |is_entry: &dyn Fn(&str) -> bool| {
            reach::from_entries(&bytes, is_entry, OUTSIDE, FORBIDDEN)
                .map_err(|reason| wrong(reason.to_string()))
        };
        let is_planted = |name: &str| PLANTED.iter().any(|(entry, _)| *entry == name);
        let found = look(&|name| name.starts_with("red_") && !is_planted(name))?;
        let missing = wanted.iter().filter(|entry| !entry.is_in(&found.entries));
        let missing: Vec<_> = missing.map(ToString::to_string).collect();
        if !missing.is_empty() {
            let list = missing.join(", ");
            return Err(wrong(format!("no entry for {list}; write them in tests/symbols/src")));
        }
        if !found.paths.is_empty() {
            let (count, list) = (found.paths.len(), found.paths.join("\n  "));
            return Err(wrong(format!("{count} ways to what nothing may reach:\n  {list}")));
        }
        let (entries, functions) = (found.entries.len(), found.reached);
        say!("{target}: {entries} entries reach {functions} functions, no panic and no allocation");
        for (entry, part) in PLANTED {
            let found = look(&|name| name == *entry)?;
            let seen = found.paths.iter().find(|path| path.contains(part));
            let seen =
                seen.ok_or_else(|| wrong(format!("{entry} is not seen, so this check sees nothing")))?;
            say!("{target}: seen, as it should: {seen}");
        }
    }
    let shipped = shipped::check(workspace)?;
    Ok(Tally { passed: shipped + 2 * (1 + PLANTED.len()) as u32, ..Tally::default() })
}
