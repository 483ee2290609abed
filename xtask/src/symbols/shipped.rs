//! The functions of the C ABI, in the very archive that the library of the core is made of.

use std::fs;

use super::{FORBIDDEN, OUTSIDE, reach};
use crate::abi;
use crate::cross::CORTEX_M4;
use crate::process::Failure;
use crate::workspace::Workspace;

/// What the functions do reach: with it forbidden, the look has to find it.
const PLANTED: &str = "memcpy";

/// Looks at what they can reach here and on a microcontroller; how many looks there were.
///
/// # Errors
/// A function is missing, something forbidden is reached, or what is planted is not seen.
pub(super) fn check(workspace: &Workspace) -> Result<u32, Failure> {
    let functions = abi::functions_of_the_core(workspace)?;
    for target in [None, Some(CORTEX_M4)] {
        let place = target.unwrap_or("here");
        let wrong = |what: String| Failure::Wrong(format!("C ABI, {place}: {what}"));
        let path = abi::archive_of_the_core(workspace, target)?;
        let bytes = fs::read(&path).map_err(Failure::of_file(&path))?;
        let look = |forbidden: &[&str]| {
            reach::from_entries(&bytes, &|name| name.starts_with("red_"), OUTSIDE, forbidden)
                .map_err(|reason| wrong(reason.to_string()))
        };
        let found = look(FORBIDDEN)?;
        let missing: Vec<_> =
            functions.iter().filter(|name| !found.entries.contains(*name)).cloned().collect();
        if !missing.is_empty() {
            return Err(wrong(format!("no function {}", missing.join(", "))));
        }
        if !found.paths.is_empty() {
            let (count, list) = (found.paths.len(), found.paths.join("\n  "));
            return Err(wrong(format!("{count} ways to what nothing may reach:\n  {list}")));
        }
        say!(
            "C ABI, {place}: {} functions reach {}, no panic and no allocation",
            functions.len(),
            found.reached
        );
        let seen = look(&[FORBIDDEN, &[PLANTED]].concat())?.paths.into_iter().next();
        let seen = seen.ok_or_else(|| wrong(format!("{PLANTED} is not seen, so this check sees nothing")))?;
        say!("C ABI, {place}: seen, as it should: {seen}");
    }
    Ok(4)
}
