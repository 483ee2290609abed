//! A library made here, beside another one written in Rust and C++ that throws, in one program: panics end where they are
//! caught, exceptions too. Nothing of the header panics, so the library is a small one, made as ours are.

use std::path::Path;

use super::binutils::Target;
use super::build::{Care, folder_at, one_object, write};
use crate::process::Failure;
use crate::workspace::Workspace;

/// A function that catches a panic of its own: 1 if it did.
const CATCHES: &str = "#[unsafe(no_mangle)]\n\
    pub extern \"C\" fn NAME(count: i32) -> i32 {\n\
        i32::from(std::panic::catch_unwind(|| assert!(count == 0, \"planted\")).is_err())\n\
    }\n";
const MAIN: &str = "#include <cstdio>\n\
    extern \"C\" int red_planted(int);\n\
    extern \"C\" int other_planted(int);\n\
    extern \"C\" unsigned red_abi_version();\n\
    struct Unwound { int &count; ~Unwound() { ++count; } };\n\
    int main(int count, char **) {\n\
        int unwound = 0;\n\
        try { Unwound here{unwound}; if (count > 0) throw 1; } catch (int) { ++unwound; }\n\
        std::printf(\"%d %d %d %u\\n\", unwound, other_planted(count), red_planted(count), red_abi_version());\n\
    }\n";
/// Of an exception: a destructor and a handler; a panic caught by each library; the version of the ABI.
const SAID: &str = "2 1 1 ";

/// Links and runs the program in each order of the libraries; how many times.
///
/// # Errors
/// It does not link or says something else, or it does although the library was made without care.
pub(crate) fn check(workspace: &Workspace, prefix: &Path) -> Result<u32, Failure> {
    let folder = workspace.target.join("abi/beside");
    folder_at(&folder)?;
    let [ours, other] =
        ["red_planted", "other_planted"].map(|name| folder.join(format!("lib{name}.whole.a")));
    for (name, archive) in [("red_planted", &ours), ("other_planted", &other)] {
        let source = folder.join(format!("{name}.rs"));
        write(&source, &CATCHES.replace("NAME", name))?;
        let rustc =
            workspace.command("rustc").args(&["--edition=2024", "-O", "--crate-type=staticlib", "-o"]);
        rustc.args(&[archive, &source]).text()?;
    }
    let main = folder.join("main.cpp");
    write(&main, MAIN)?;
    let [archive, program] = ["libred_planted.a", "main"].map(|name| folder.join(name));
    let mut tried = 0;
    for care in [Care::NoGroups, Care::NoLeftovers, Care::All] {
        one_object(workspace, &Target::here(), &ours, &archive, care)?;
        let red = prefix.join("lib/libred.a");
        let mut well = 0;
        for libraries in [[&red, &archive, &other], [&other, &archive, &red]] {
            let link = workspace.command("c++").args(&["-o"]).args(&[&program, &main]).args(&libraries);
            let (said, links) = link.all_text()?;
            let said = if links { workspace.command(&program).all_text()?.0 } else { said };
            // Panics say where they were on standard error, which comes first.
            let runs = links && said.lines().any(|line| line.starts_with(SAID));
            if care == Care::All && !runs {
                return Err(Failure::Wrong(format!("beside another library of Rust:\n{said}")));
            }
            well += u32::from(runs);
        }
        if care == Care::All {
            tried += well;
        } else if well == 2 {
            return Err(Failure::Wrong(format!("{care:?} does no harm, so this check finds nothing")));
        } else {
            say!("{care:?}: found, as it should be: the program does not link, or does not unwind");
        }
    }
    say!("beside another library of Rust, and with exceptions of C++: all is unwound");
    Ok(tried)
}
