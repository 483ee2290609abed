use std::env;
use std::process::{self, Command};
use std::sync::atomic::{AtomicU32, Ordering};

use super::*;

/// Counts its steps per lane, releases task 7 in the first one, and fails in the third.
const GOOD: &str = r#"
#include "red_plugin.h"
#include <stddef.h>
static struct { uint32_t lane; int steps; } lanes[2];
int closed;
int step_open(uint32_t lane, void **user) {
    if (lane > 1) return 5;
    lanes[lane].lane = lane;
    *user = &lanes[lane];
    return 0;
}
int step(void *user, const red_plugin_context *c) {
    int *steps = &lanes[c->lane].steps;
    if (user != &lanes[c->lane] || c->size != sizeof *c || c->abi != RED_PLUGIN_ABI) return 1;
    if (c->now_ns != 11 || c->release_ns != 12 || c->deadline_ns != 13 || c->job != 14 || c->task != 15) return 2;
    if (++*steps == 1 && c->release(c->host, 7) != 0) return 3;
    if (*steps == 2 && c->release(c->host, 8) != -1) return 4;
    return *steps == 3 ? 42 : 0;
}
void step_close(void *user) { closed += user == &lanes[0] || user == &lanes[1]; }
int closings(void *user, const red_plugin_context *c) { (void)c; return user == NULL ? closed : -1; }
"#;

/// Compiles `source` to a shared object named after the test.
pub(super) fn build(test: &str, source: &str) -> PathBuf {
    let stem = env::temp_dir().join(format!("red-plugin-{}-{test}", process::id()));
    let (code, object) = (stem.with_extension("c"), stem.with_extension("so"));
    fs::write(&code, source).expect("the temporary directory is writable");
    let include = Path::new(env!("CARGO_MANIFEST_DIR")).join("include");
    let status = Command::new("cc")
        .args(["-std=c11", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC", "-I"])
        .args([&include, Path::new("-o"), &object, &code])
        .status()
        .expect("no C compiler: apt-get install gcc libc6-dev");
    assert!(status.success(), "cc: {status}");
    fs::remove_file(code).expect("the source was there");
    object
}

pub(super) fn nobody() -> Arc<Host> {
    Host::new(|_| false)
}

#[test]
fn steps_have_their_lane_their_context_and_a_way_to_release() {
    static RELEASED: AtomicU32 = AtomicU32::new(0);
    let object = build("good", GOOD);
    let host = Host::new(|task| task == 7 && RELEASED.fetch_add(1, Ordering::Relaxed) < 2);
    let plugin = Plugin::load(&object, "step", &host).expect("loads");
    let closings = Plugin::load(&object, "closings", &host).expect("loads");
    fs::remove_file(object).expect("the object was there");
    let call = |lane| Call { now_ns: 11, release_ns: 12, deadline_ns: 13, job: 14, task: 15, lane };

    let mut bodies = [0, 1].map(|lane| plugin.instance(lane).expect("opens"));
    for step in 1..=3 {
        for (lane, body) in (0..).zip(&mut bodies) {
            match body.run(&call(lane)) {
                Ok(()) => assert_ne!(step, 3),
                Err(BodyError::Returned { code }) => assert_eq!((step, code), (3, 42)),
                Err(error) => panic!("{error}"),
            }
        }
    }
    assert_eq!(RELEASED.load(Ordering::Relaxed), 2);
    assert!(matches!(plugin.instance(2), Err(BodyError::Open { code: 5, .. })));

    drop(bodies);
    // Has no `_open`, so that its `user` is NULL; returns how often the other one was closed.
    let mut count = closings.instance(0).expect("opens");
    assert!(matches!(count.run(&call(0)), Err(BodyError::Returned { code: 2 })));
}

#[test]
fn a_missing_object_or_symbol_is_named() {
    let object = build("names", "int present(void) { return 0; }");
    let error = Plugin::load(&object, "control_step", &nobody()).err().expect("no such symbol");
    assert!(matches!(&error, BodyError::Symbol { symbol, .. } if symbol == "control_step"));
    assert!(error.to_string().contains("red_plugin.h"));
    assert!(matches!(Plugin::load(&object, "with\0nul", &nobody()), Err(BodyError::Symbol { .. })));
    fs::remove_file(&object).expect("the object was there");

    let error = Plugin::load(&object, "present", &nobody()).err().expect("no such file");
    assert!(matches!(&error, BodyError::Read { path, .. } if *path == object));

    fs::write(&object, "not an object").expect("the temporary directory is writable");
    assert!(matches!(Plugin::load(&object, "present", &nobody()), Err(BodyError::Plugin { .. })));
    fs::remove_file(object).expect("the text was there");
}

#[test]
fn the_header_is_c_and_cpp() {
    let header = Path::new(env!("CARGO_MANIFEST_DIR")).join("include/red_plugin.h");
    for language in [["-xc", "-std=c11"], ["-xc++", "-std=c++17"]] {
        let status = Command::new("cc")
            .args(language)
            .args(["-Wall", "-Wextra", "-Werror", "-pedantic", "-fsyntax-only"])
            .arg(&header)
            .status()
            .expect("no C compiler: apt-get install gcc g++ libc6-dev");
        assert!(status.success(), "{language:?}: {status}");
    }
}
