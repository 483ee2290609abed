//! ThreadSanitizer on lanes under stress, AddressSanitizer on everything that is unsafe.

use crate::depth::Depth;
use crate::nightly::{HOST, Nightly, hear};
use crate::process::{Failure, Run};
use crate::report::Tally;
use crate::workspace::Workspace;

/// A sanitizer sees only the interleavings that happen: a planted race is tried so often.
const TRIES: u32 = 20;

/// # Errors
/// A sanitizer speaks, a test fails, or a planted bug is not seen.
pub(crate) fn step(workspace: &Workspace, depth: Depth) -> Result<Tally, Failure> {
    let nightly = Nightly::with(workspace, &["rust-src"])?;
    let threads = threads(&nightly, depth)?;
    Ok(threads + addresses(&nightly)?)
}

/// The standard library is built anew, so that its own synchronisation is seen.
fn threads(nightly: &Nightly<'_>, depth: Depth) -> Result<Tally, Failure> {
    let cargo = |command: &str| {
        let cargo = sanitized(nightly, "thread", command).args(&["-Zbuild-std"]);
        cargo.env("TSAN_OPTIONS", "halt_on_error=1")
    };
    let planted = |bug: &str| cargo("run").args(&["--quiet", "--package", "red-planted", "--", bug]);
    hear(planted("sound"))?.well("a lock that is right")?;
    let mut race = hear(planted("race"))?;
    for _ in 1..TRIES {
        if !race.status.success() {
            break;
        }
        race = hear(planted("race"))?;
    }
    race.found("race", "WARNING: ThreadSanitizer: data race")?;
    let rounds = match depth {
        Depth::Quick => "20",
        Depth::Deep => "400",
    };
    say!(
        "lanes run best effort, {rounds} rounds, every other recorded; not in real time, which wants settings of \
         glibc's allocator, and ThreadSanitizer has its own"
    );
    let stress = ["--package", "red-rt", "--test", "stress"];
    let tally = cargo("test").args(&stress).env("RED_STRESS_ROUNDS", rounds).stream()?;
    Ok(Tally { passed: tally.passed + 2, ..tally })
}

fn addresses(nightly: &Nightly<'_>) -> Result<Tally, Failure> {
    // Frames stay on the stack, whose size the runtime measures.
    let cargo = |command: &str| {
        sanitized(nightly, "address", command).env("ASAN_OPTIONS", "detect_stack_use_after_return=0")
    };
    let planted = |bug: &str| cargo("run").args(&["--quiet", "--package", "red-planted", "--", bug]);
    hear(planted("sound"))?.well("a lock that is right")?;
    hear(planted("freed"))?.found("freed", "AddressSanitizer: heap-use-after-free")?;
    let tests = [
        "--lib",
        "--tests",
        "--package",
        "red-sync",
        "--package",
        "red-rt",
        "--package",
        "red-bodies",
        "--no-fail-fast",
        "--",
        // They ask glibc's allocator, which the sanitizer replaces, and for locked memory, which it does not give.
        "--skip",
        "after_a_warm_up_a_body_that_allocates_faults_no_page",
        "--skip",
        "locked_memory_is_locked",
        "--skip",
        "a_lane_in_real_time_runs_errands_between_its_bodies",
        "--skip",
        "memory_is_locked_and_kept_as_long_as_a_run_in_real_time_lasts",
    ];
    let tally = cargo("test").args(&tests).stream()?;
    Ok(Tally { passed: tally.passed + 2, ..tally })
}

/// A command of cargo with a sanitizer in what it builds, in a folder for all that is built so. Addresses are not drawn
/// where it runs a program: a sanitizer's own memory has its fixed place.
pub(crate) fn sanitized(nightly: &Nightly<'_>, sanitizer: &str, command: &str) -> Run {
    // With a target, or the macros of the build would be sanitized too, which no compiler can load.
    nightly
        .cargo(&[command, "--target", HOST])
        .env("RUSTFLAGS", format!("-Zsanitizer={sanitizer}"))
        .env("CARGO_TARGET_DIR", nightly.target(sanitizer))
        .env("CARGO_TARGET_X86_64_UNKNOWN_LINUX_GNU_RUNNER", "setarch -R")
}
