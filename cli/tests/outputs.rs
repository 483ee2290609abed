//! No output takes the place of an input, and none that of a file that is there, unless `--force` says so.

#[path = "process/alone.rs"]
mod alone;
mod process;

use alone::alone;
use process::{command, ended, file, run};
use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};

const WORKLOAD: &str = "pool = [{ name = \"cpu\", lanes = 1 }]\n[[task]]\nname = \"t\"\nperiod = \"10ms\"\ndeadline = \"5s\"\n\
                        node = [{ name = \"a\", wcet = \"1ms\", body = { spin = \"10us\" } }]\n";

/// What a file has that nobody may lose.
const MINE: &str = "mine";

/// An option of a subcommand that names a file to write.
struct Row {
    option: &'static str,
    /// All of the command but the option. `IN` is the input.
    before: &'static [&'static str],
    input: Input,
}

enum Input {
    None,
    Workload,
    Log,
}

const ROWS: [Row; 6] = [
    Row { option: "--certificate", before: &["plan", "IN"], input: Input::Workload },
    Row { option: "--trace", before: RUN, input: Input::Workload },
    Row { option: "--record", before: RUN, input: Input::Workload },
    Row { option: "--out", before: &["report", "IN"], input: Input::Log },
    Row {
        option: "--out",
        before: &["profile", "IN", "--best-effort", "--runs", "3", "--budget", "0s"],
        input: Input::Workload,
    },
    Row { option: "--report", before: &["paper", "worked-example", "--seeds", "2"], input: Input::None },
];
const RUN: &[&str] = &["run", "IN", "--best-effort", "--duration", "100ms"];

/// Options that name a folder to write into: a case of its own, below.
const FOLDERS: [(&str, &str); 2] = [("demo", "--out"), ("paper", "--out")];

/// Options with a value that names no place. One that is not here, and in no row, has to get one of both.
const NO_PLACES: [&str; 11] = [
    "--policy",
    "--duration",
    "--horizon",
    "--seed",
    "--seeds",
    "--execution",
    "--what-if",
    "--runs",
    "--budget",
    "--timeout",
    "--margin",
];

/// An empty folder of this name.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _none_there = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).expect("the folder for tests takes folders");
    folder
}

fn text(path: &Path) -> &str {
    path.to_str().expect("the path is text")
}

/// The end of a path, which every message shows.
fn name(path: &Path) -> &str {
    path.file_name().and_then(|name| name.to_str()).expect("the name is text")
}

impl Row {
    /// Runs it, with this output.
    fn run(&self, input: &Path, output: &Path, more: &[&str]) -> (i32, String, String) {
        let words = self.before.iter().map(|word| if *word == "IN" { text(input) } else { word });
        let words: Vec<&str> = words.chain([self.option, text(output)]).chain(more.iter().copied()).collect();
        run(&words)
    }

    /// It is refused before anything is done, with these words.
    fn refused(&self, input: &Path, output: &Path, more: &[&str], words: &[&str]) {
        let (status, out, err) = self.run(input, output, more);
        let row = (self.before[0], self.option, output);
        assert_eq!((status, &*out), (2, ""), "{row:?}: {err}");
        assert!(words.iter().all(|word| err.contains(word)), "{row:?}: {err}");
    }
}

/// A log of a run.
fn log(folder: &Path, workload: &Path) -> PathBuf {
    let log = folder.join("input.redlog");
    let (status, _, err) = ROWS[2].run(workload, &log, &[]);
    assert_eq!(status, 0, "{err}");
    log
}

#[test]
fn an_output_is_no_input_and_replaces_nothing_unless_it_is_told_to() {
    let _alone = alone();
    for row in ROWS {
        let folder = folder(&format!("outputs-{}{}", row.before[0], row.option));
        let workload = folder.join("input.toml");
        fs::write(&workload, WORKLOAD).unwrap();
        let input = match row.input {
            Input::Log => Some(log(&folder, &workload)),
            Input::Workload => Some(workload.clone()),
            Input::None => None,
        };
        if let Some(input) = &input {
            let [soft, hard, other] = ["soft", "hard", "other"].map(|name| folder.join(name));
            symlink(input, &soft).unwrap();
            fs::hard_link(input, &hard).unwrap();
            fs::hard_link(input, &other).unwrap();
            let about = folder.join("..").join(folder.file_name().unwrap()).join(input.file_name().unwrap());
            let before = fs::read(input).unwrap();
            for more in [&[][..], &["--force"]] {
                for output in [input, &soft, &hard, &about] {
                    row.refused(input, output, more, &["itself, which stays as it is", name(output)]);
                }
                // By another of its names as the input.
                row.refused(&other, &hard, more, &["itself, which stays as it is"]);
            }
            assert!(fs::read(input).unwrap() == before, "{}: the input is what it was", row.option);
        }
        let input = input.as_ref().unwrap_or(&workload);
        let [output, link, linked] = ["output", "link", "linked"].map(|name| folder.join(name));
        fs::write(&output, MINE).unwrap();
        fs::write(&linked, MINE).unwrap();
        symlink(&linked, &link).unwrap();
        for output in [&output, &link] {
            row.refused(input, output, &[], &["there already", "another name", "`--force`", name(output)]);
            assert_eq!(fs::read_to_string(output).unwrap(), MINE);
        }
        let done = |output: &Path, more: &[&str]| {
            let (status, _, err) = row.run(input, output, more);
            assert_eq!(status, 0, "{}: {err}", row.option);
            fs::read(output).expect("it was written")
        };
        for output in [&output, &link] {
            assert!(done(output, &["--force"]).len() > MINE.len());
        }
        assert_eq!(
            fs::read_to_string(&linked).unwrap(),
            MINE,
            "a link is replaced, and not what it leads to"
        );
        assert!(done(&folder.join("new"), &[]).len() > MINE.len());
        let hidden = |entry: &fs::DirEntry| entry.file_name().as_encoded_bytes().starts_with(b".");
        let left = fs::read_dir(&folder).unwrap().map(Result::unwrap).filter(hidden).count();
        assert_eq!(left, 0, "{}: nothing is left beside what was written", row.option);
    }
}

#[test]
fn places_that_are_not_told_are_held_to_the_same() {
    let _alone = alone();
    let folder = folder("outputs-untold");
    let workload = folder.join("input.toml");
    fs::write(&workload, WORKLOAD).unwrap();
    let log = log(&folder, &workload);
    let (page, copy, tables) =
        (log.with_extension("html"), folder.join("input.profiled.toml"), folder.join("redrt-paper.html"));
    for (words, output) in [
        (&["report", text(&log)][..], &page),
        (&["profile", text(&workload), "--best-effort"], &copy),
        (&["paper"], &tables),
    ] {
        fs::write(output, MINE).unwrap();
        let output_of = command(words).current_dir(&folder).output().expect("the command starts");
        let (status, out, err) = ended(&output_of);
        assert_eq!((status, &*out), (2, ""), "{err}");
        assert!(err.contains(name(output)) && err.contains("--force"), "{err}");
        assert_eq!(fs::read_to_string(output).unwrap(), MINE);
    }
}

#[test]
fn files_of_bodies_are_inputs_and_two_outputs_are_two_files() {
    let folder = folder("outputs-bodies");
    let (workload, body) = (folder.join("input.toml"), folder.join("body.so"));
    let plugin = "{ plugin = \"body.so\", symbol = \"step\" }";
    fs::write(&workload, WORKLOAD.replace("{ spin = \"10us\" }", plugin)).unwrap();
    fs::write(&body, MINE).unwrap();
    for row in ROWS.iter().filter(|row| matches!(row.input, Input::Workload)) {
        row.refused(&workload, &body, &["--force"], &["the file of the body of `a` itself"]);
    }
    assert_eq!(fs::read_to_string(&body).unwrap(), MINE);
    let both = folder.join("both");
    let again = folder.join("./both");
    ROWS[1].refused(&workload, &both, &["--record", text(&again), "--force"], &["are one file"]);
    assert!(!both.exists());
}

#[test]
fn devices_and_standard_output_take_what_comes() {
    let workload = file("outputs-devices.toml", WORKLOAD.as_bytes());
    let plan = |place: &str| command(&["plan", text(&workload), "--json", "--certificate", place]);
    assert_eq!(ended(&plan("/dev/null").output().unwrap()).0, 0);
    let (status, out, err) = ended(&plan("/dev/stdout").output().unwrap());
    assert_eq!(status, 0, "{err}");
    // A file that standard output goes to gets the same.
    let there = Path::new(env!("CARGO_TARGET_TMPDIR")).join("outputs-devices.out");
    let to_file = plan("/dev/stdout").stdout(fs::File::create(&there).unwrap()).output().unwrap();
    assert_eq!(ended(&to_file).0, 0);
    assert_eq!(fs::read_to_string(&there).unwrap(), out);
    let (certificate, answer) = out.rsplit_once("}\n{").expect("two objects");
    assert!(certificate.contains("margin_ns") && answer.contains("\"certificate\""), "{out}");
}

#[test]
fn files_in_a_folder_that_was_named_are_kept_and_the_folder_of_the_demo_is_written_anew() {
    let _alone = alone();
    let folder = folder("outputs-folder");
    let names = ["demo.toml", "encoder.onnx", "edf.redlog", "report.html", "redrt.trace.json"];
    for (words, name) in
        names.map(|name| (&["demo"][..], name)).into_iter().chain([(&["paper", "real"][..], "encoder.onnx")])
    {
        let (out, kept) = (folder.join("named"), folder.join("named").join(name));
        fs::create_dir_all(&out).unwrap();
        fs::write(&kept, MINE).unwrap();
        let (status, told, err) = run(&[words, &["--out", text(&out), "--duration", "200ms"]].concat());
        assert_eq!((status, &*told), (2, ""), "{name}: {err}");
        assert!(err.contains(name) && err.contains("another folder") && err.contains("--force"), "{err}");
        assert_eq!(fs::read_to_string(&kept).unwrap(), MINE);
        assert_eq!(fs::read_dir(&out).unwrap().count(), 1, "{name}: nothing else is written");
        fs::remove_dir_all(&out).unwrap();
    }
    let own = folder.join("redrt-demo");
    fs::create_dir_all(&own).unwrap();
    for more in [&[][..], &["--out", "redrt-demo"], &["--out", "./redrt-demo/", "--force"]] {
        names.iter().for_each(|name| fs::write(own.join(name), MINE).unwrap());
        let words = [&["demo", "--duration", "200ms", "--json"], more].concat();
        let (status, _, err) = ended(&command(&words).current_dir(&folder).output().unwrap());
        assert_eq!(status, 0, "{err}");
        names
            .iter()
            .for_each(|name| assert_ne!(fs::read(own.join(name)).unwrap(), MINE.as_bytes(), "{name}"));
    }
}

/// Options with a value, as a help lists them.
fn valued(help: &str) -> Vec<&str> {
    let words = help.lines().map(str::split_whitespace).map(|mut line| (line.next(), line.next()));
    let option =
        |(option, value): (Option<_>, Option<&str>)| value.filter(|value| value.starts_with('<')).and(option);
    words.filter_map(option).filter(|option: &&str| option.starts_with("--")).collect()
}

#[test]
fn every_option_that_names_a_place_is_tried_here() {
    let (_, help, _) = run(&["--help"]);
    let (_, list) = help.split_once("Commands:\n").expect("a list of subcommands");
    let subcommands = list.lines().take_while(|line| !line.is_empty());
    let mut seen = 0;
    for subcommand in
        subcommands.filter_map(|line| line.split_whitespace().next()).filter(|name| *name != "help")
    {
        let (_, help, _) = run(&[subcommand, "--help"]);
        let mut writes = false;
        for option in valued(&help) {
            let is_row = ROWS.iter().any(|row| row.before[0] == subcommand && row.option == option);
            let is_place = is_row || FOLDERS.contains(&(subcommand, option));
            assert!(
                is_place != NO_PLACES.contains(&option),
                "{subcommand} {option}: if it names an output, give it a row here"
            );
            writes |= is_place;
            seen += usize::from(is_place);
        }
        assert_eq!(help.contains("--force"), writes, "{subcommand} has --force where it writes");
    }
    assert_eq!(seen, ROWS.len() + FOLDERS.len());
    assert_eq!(valued("  --new <FILE>  a\n  --flag  b <c>"), ["--new"], "a new one is seen");
}
