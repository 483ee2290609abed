//! Rows 69 to 74: files that somebody else wrote.

use crate::alone::alone;
use crate::plugin;
use crate::process::{command, ended, file};
use crate::redrt;
use crate::refusal::refused;
use red_record::{LogError, Reader};
use red_workload::{Refusal, Source, load};
use std::fs::{self, File};
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

const GOOD: &str = "pool = [{ name = 'p', lanes = 1 }]\n[[task]]\nname = 't'\nperiod = '10ms'\ndeadline = '10ms'\n\
                    node = [{ name = 'a', wcet = '1ms', body = { spin = '1us' } }]\n";

fn scratch(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _none_there = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).expect("the folder for tests takes folders");
    folder
}

/// The command in half a GiB of memory and within half a minute.
fn bounded(arguments: &[&str]) -> (i32, String, String) {
    let bare = command(arguments);
    let mut bounded = Command::new("timeout");
    bounded.args(["--signal=KILL", "30", "prlimit", "--as=536870912", "--"]);
    bounded.arg(bare.get_program()).args(bare.get_args());
    bounded.current_dir(bare.get_current_dir().expect("the root of the repository"));
    ended(
        &bounded
            .output()
            .expect("no timeout or prlimit; install them with: apt-get install coreutils util-linux"),
    )
}

/// Refused by `plan`, `sim` and `run` with all of `words`.
fn refuses(path: &Path, words: &[&str]) {
    for subcommand in ["plan", "sim", "run"] {
        refused(bounded(&[subcommand, path.to_str().unwrap()]), 2, words);
    }
}

#[test]
fn row_69_files_that_are_no_text_are_refused_and_marks_and_line_ends_move_no_line() {
    let utf16 = |from: fn(u16) -> [u8; 2]| -> Vec<u8> { GOOD.encode_utf16().flat_map(from).collect() };
    let (little, big) = (utf16(u16::to_le_bytes), utf16(u16::to_be_bytes));
    let cases: [(&str, Vec<u8>, &str); 8] = [
        ("empty", vec![], "empty"),
        ("blank", b" \r\n\t\n".to_vec(), "empty"),
        ("truncated", GOOD.as_bytes()[..GOOD.len() - 8].to_vec(), "expected"),
        ("binary", vec![0x7f, b'E', b'L', b'F', 2, 1, 1, 0], "binary"),
        ("latin", b"pool = '\xe9'\n".to_vec(), "not UTF-8"),
        ("utf-16-le", little.clone(), "UTF-16"),
        ("utf-16-be", big, "UTF-16"),
        ("utf-16-mark", [&b"\xff\xfe"[..], &little].concat(), "UTF-16"),
    ];
    for (name, bytes, word) in &cases {
        refuses(&file(&format!("row-69-{name}.toml"), bytes), &[word, "expected"]);
    }
    for bytes in [
        GOOD.replace('\n', "\r\n"),
        format!("\u{feff}{GOOD}"),
        format!("\u{feff}{}", GOOD.replace('\n', "\r\n")),
    ] {
        assert!(load(&file("row-69-good.toml", bytes.as_bytes())).is_ok());
        let misspelt = bytes.replace("deadline", "dedline");
        let error = load(&file("row-69-place.toml", misspelt.as_bytes())).expect_err("a key that nobody has");
        assert_eq!(error.place.map(|place| (place.line, place.column)), Some((5, 1)), "{error}");
    }
}

#[test]
fn row_70_what_is_too_large_is_refused_before_memory_is_taken_for_it() {
    let folder = scratch("row-70");
    let sparse = folder.join("gigabyte.toml");
    File::create(&sparse).and_then(|file| file.set_len(1 << 30)).expect("a sparse file");
    refuses(&sparse, &["too large", "at most 4 MiB"]);
    let write = |name: &str, text: &str| {
        let path = folder.join(name);
        fs::write(&path, text).expect("the folder takes files");
        path
    };
    let nodes = |count: usize| {
        let nodes: String = (0..count).map(|n| format!("{{name='{n}',wcet='1ns'}},")).collect();
        GOOD.replace("{ name = 'a', wcet = '1ms', body = { spin = '1us' } }", &nodes)
    };
    refuses(&write("million.toml", &nodes(1_000_000)), &["too large", "at most 4 MiB"]);
    // As many as fit the file.
    refuses(&write("nodes.toml", &nodes(140_000)), &["256"]);
    let deep = 100_000;
    let brackets = format!("pool = {}{}\n", "[".repeat(deep), "]".repeat(deep));
    refuses(&write("lists.toml", &brackets), &["nest too deeply", "at most 16 levels"]);
    refuses(&write("dots.toml", &format!("{}x = 1\n", "a.".repeat(deep))), &["nest too deeply"]);
    refuses(
        &write("lists.yaml", &format!("pool: {}{}\n", "[".repeat(deep), "]".repeat(deep))),
        &["nest too deeply"],
    );
    let digits = "9".repeat(1_000_000);
    refuses(
        &write("value.toml", &GOOD.replace("name = 't'", &format!("name = 't'\nvalue = {digits}"))),
        &["`value` is ", "…"],
    );
    refuses(
        &write("time.toml", &GOOD.replace("'10ms'", &format!("'{digits}ms'"))),
        &["too large for 64 bits"],
    );
    refuses(&write("name.toml", &GOOD.replace("'t'", &format!("'{digits}'"))), &["1 to 64 letters"]);
}

#[test]
fn row_71_duplicate_and_unknown_keys_wrong_types_and_unknown_units_are_refused_at_their_place() {
    let cases = [
        ("name = 't'", "name = 't'\nname = 'u'", "4:1:", "twice"),
        ("period", "peroid", "4:1:", "did you mean `period`?"),
        ("name = 't'", "name = 5", "3:8:", "expected a text"),
        ("'10ms'", "10", "4:10:", "expected a whole number with a unit"),
        ("'10ms'", "'10 ms'", "4:10:", "in an unknown unit"),
        ("'10ms'", "'10min'", "4:10:", "in an unknown unit"),
        ("'10ms'", "'10'", "4:10:", "without a unit"),
        ("lanes = 1", "lanes = '1'", "1:31:", "expected an integer"),
        ("[[task]]", "[[taks]]", "2:3:", "did you mean `task`?"),
        ("node = [", "node = [{ name = 'a', wcet = '1ms' }, ", "6:48:", "already has a node named `a`"),
        ("body = {", "atomic = 'yes', body = {", "6:", "`true` or `false`"),
        ("pool = [{", "pool = {", "1:", "expected"),
    ];
    for (from, to, place, word) in cases {
        let text = GOOD.replacen(from, to, 1);
        assert_ne!(text, GOOD, "the plant took");
        refuses(&file("row-71.toml", text.as_bytes()), &[&format!("row-71.toml:{place}"), word]);
    }
    let yaml = "pool: [{ name: p, lanes: 1 }]\ntask:\n  - { name: t, name: t }\n";
    refuses(&file("row-71.yaml", yaml.as_bytes()), &["row-71.yaml:3:", "twice"]);
}

#[test]
fn row_72_what_is_no_file_or_changes_while_it_is_read_has_an_answer() {
    let folder = scratch("row-72");
    assert!(Command::new("mkfifo").arg(folder.join("fifo")).status().expect("coreutils").success());
    for link in ["loop", "gone"] {
        symlink(if link == "loop" { "loop" } else { "nowhere" }, folder.join(link)).expect("a link");
    }
    symlink("/dev/zero", folder.join("device")).expect("a link");
    for (name, word) in [
        ("", "a directory"),
        ("fifo", "a FIFO"),
        ("device", "a device"),
        ("loop", "cannot read"),
        ("gone", "cannot read"),
    ] {
        refuses(&folder.join(name), &[word, "expected"]);
    }
    // Root may read everything, unless it gives that right away.
    let closed = folder.join("closed.toml");
    fs::write(&closed, GOOD).expect("the folder takes files");
    fs::set_permissions(&closed, fs::Permissions::from_mode(0o000)).expect("our own file");
    let none = "-dac_override,-dac_read_search";
    let denied = crate::rights::without(&[], none, &["plan", closed.to_str().unwrap()]).output();
    refused(
        ended(&denied.expect("no prlimit or setpriv; install them with: apt-get install util-linux")),
        2,
        &["Permission denied"],
    );
    // Cut off, written anew and replaced, again and again, while it is read.
    let moving = folder.join("moving.toml");
    fs::write(&moving, GOOD).expect("the folder takes files");
    let large = format!("{GOOD}{}", "# a comment that makes it long\n".repeat(20_000));
    let is_over = AtomicBool::new(false);
    let mut answers = [0, 0];
    thread::scope(|scope| {
        scope.spawn(|| {
            while !is_over.load(Ordering::Relaxed) {
                for text in ["", &large, &large[..GOOD.len() / 2], GOOD] {
                    fs::write(&moving, text).expect("the folder takes files");
                }
                let other = folder.join("other.toml");
                fs::write(&other, &large)
                    .and_then(|()| fs::rename(&other, &moving))
                    .expect("the same folder");
            }
        });
        for _ in 0..2_000 {
            match Source::load(&moving) {
                Ok(source) => {
                    assert_eq!(source.workload.tasks.len(), 1, "whole or not at all");
                    answers[0] += 1;
                }
                Err(error) => {
                    let known = [
                        Refusal::Empty,
                        Refusal::Syntax,
                        Refusal::Missing,
                        Refusal::Unreadable,
                        Refusal::Encoding,
                    ];
                    assert!(known.contains(&error.refusal), "{error}");
                    answers[1] += 1;
                }
            }
        }
        is_over.store(true, Ordering::Relaxed);
    });
    assert!(answers[0] > 0 && answers[1] > 0, "it changed while it was read: {answers:?}");
}

#[test]
fn row_73_a_plugin_outside_of_the_workloads_folder_is_refused() {
    let folder = scratch("row-73/inside").canonicalize().expect("it is there");
    let object = Path::new(env!("CARGO_TARGET_TMPDIR")).join(plugin::built("faults", "row-73"));
    let outside = folder.parent().expect("two folders").join("out.so");
    fs::copy(&object, &outside).expect("the folder takes files");
    fs::copy(&object, folder.join("in.so")).expect("the folder takes files");
    symlink(&outside, folder.join("link.so")).expect("a link");
    symlink("..", folder.join("up")).expect("a link");
    symlink("in.so", folder.join("alias.so")).expect("a link");
    let path = folder.join("w.toml");
    let run = |plugin: &str| {
        let body = format!("plugin = {plugin:?}, symbol = 'good'");
        fs::write(&path, GOOD.replace("spin = '1us'", &body)).expect("the folder takes files");
        bounded(&["run", path.to_str().unwrap(), "--best-effort", "--duration", "20ms", "--json"])
    };
    let _alone = alone();
    let absolute = outside.to_str().expect("UTF-8");
    for escape in ["../out.so", "up/out.so", "link.so", "../inside/../out.so", absolute] {
        let message = refused(run(escape), 2, &["w.toml:6:", "expected"]);
        assert!(
            message.contains("leads out of the folder") || message.contains("without `..`"),
            "{escape}: {message}"
        );
    }
    for name in ["in.so", "alias.so"] {
        let (status, _, err) = run(name);
        assert_eq!(status, 0, "{name}: {err}");
    }
}

/// What a log says when it is read to its end.
fn read(bytes: &[u8]) -> Result<u64, LogError> {
    let mut log = Reader::new(bytes)?;
    let mut entries = 0;
    while log.next_entry()?.is_some() {
        entries += 1;
    }
    Ok(entries)
}

#[test]
fn row_74_logs_of_other_formats_and_with_flipped_bits_are_refused() {
    let path = redrt::workload("row-74", "good", 1, "");
    let log = path.with_extension("redlog");
    {
        let _alone = alone();
        let arguments =
            ["--best-effort", "--duration", "300ms", "--force", "--record", log.to_str().unwrap()];
        redrt::summary(&redrt::run(&path, &arguments).output().expect("the command starts"), 0);
    }
    let whole = fs::read(&log).expect("it was recorded");
    assert!(read(&whole).is_ok_and(|entries| entries > 10));
    assert_eq!(crate::process::run(&["replay", log.to_str().unwrap()]).0, 0);
    // Every bit of the beginning, and every byte of the rest in one of its bits.
    let mut rng = red_tests::rng::Rng::new(74);
    let beginning = (0..64).flat_map(|byte| (0..8).map(move |bit| (byte, bit)));
    let rest: Vec<(usize, u32)> = (64..whole.len()).map(|byte| (byte, rng.within(0, 7) as u32)).collect();
    for (byte, bit) in beginning.chain(rest) {
        let mut flipped = whole.clone();
        flipped[byte] ^= 1 << bit;
        assert!(read(&flipped).is_err(), "bit {bit} of byte {byte}");
    }
    for length in 0..whole.len() {
        assert!(read(&whole[..length]).is_err(), "cut at {length}");
    }
    let with = |at: usize, bytes: &[u8]| [&whole[..at], bytes, &whole[at + bytes.len()..]].concat();
    let cases = [
        (with(6, &[4, 0]), "the version that recorded it"),
        (with(6, &[6, 0]), "update the program"),
        (with(6, &[255, 255]), "update the program"),
        (with(0, b"NOTLOG"), "no replay log"),
        (whole[..whole.len() / 2].to_vec(), "truncated"),
        (with(whole.len() - 1, &[!whole[whole.len() - 1]]), "damaged"),
        (GOOD.as_bytes().to_vec(), "no replay log"),
        (Vec::new(), "no replay log"),
    ];
    for (bytes, word) in cases {
        fs::write(&log, bytes).expect("our own file");
        refused(bounded(&["replay", log.to_str().unwrap()]), 2, &["row-74.redlog", word]);
    }
    // What is no file has an answer, too.
    let fifo = scratch("row-74").join("fifo");
    assert!(Command::new("mkfifo").arg(&fifo).status().expect("coreutils").success());
    refused(bounded(&["replay", fifo.to_str().unwrap()]), 2, &["cannot read it"]);
    refused(bounded(&["replay", "/dev/zero"]), 2, &["cannot read it"]);
}
