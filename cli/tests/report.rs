//! `redrt report`, as a user meets it: numbers against those of the run, chains that add up, and what is refused.

#[path = "process/alone.rs"]
mod alone;
#[path = "process/page.rs"]
mod page;
mod process;
#[path = "process/refused.rs"]
mod refused;

use alone::alone;
use page::data;
use process::{file, run};
use refused::refused;
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

/// One lane for more than it can do: `long` starts just before each job of `late` but the first; a node comes and goes.
const FILE: &str = r#"
pool = [{ name = "cpu", lanes = 1 }]
[[task]]
name = "late"
deadline = "12ms"
period = "20ms"
[[task.node]]
name = "camera"
wcet = "1ms"
body = { spin = "1ms" }
[[task.node]]
name = "see"
after = ["camera"]
wcet = "2ms"
body = { spin = "6ms" }
[[task]]
name = "long"
offset = "18ms"
deadline = "200ms"
period = "20ms"
node = [{ name = "map", wcet = "9ms", body = { spin = "9ms" } }]
[[event]]
at = "100ms"
task = "late"
add = [ { name = "extra", wcet = "2ms", after = ["camera"], body = { spin = "2ms" } } ]
[[event]]
at = "200ms"
task = "late"
remove = ["extra"]
"#;

/// Records a run under EDF, which misses; its log, and what it said in numbers. The file has a name that is no text of HTML.
fn recorded(name: &str) -> (String, Value) {
    let _alone = alone();
    let workload = file(&format!("report-<b>&'{name}.toml"), FILE.as_bytes());
    let log = file(&format!("report-{name}.redlog"), b"");
    let _none_there = fs::remove_file(log.with_extension("html"));
    let (workload, log) = (workload.to_str().expect("text"), log.to_str().expect("text").to_owned());
    let options =
        ["--policy", "edf", "--duration", "400ms", "--best-effort", "--json", "--force", "--record", &log];
    let (status, out, err) = run(&[&["run", workload], &options[..]].concat());
    assert_eq!(status, 0, "{err}");
    (log, serde_json::from_str(&out).expect("one JSON object"))
}

/// Makes the report of a log; what it says in numbers, and the page.
fn report(log: &str) -> (Value, String) {
    let (status, out, err) = run(&["report", log, "--json"]);
    assert_eq!((status, out.lines().count()), (0, 1), "{err}");
    let place = log.replace(".redlog", ".html");
    assert!(err.contains("report: ") && err.contains(".html"), "{err}");
    (serde_json::from_str(&out).expect("one JSON object"), fs::read_to_string(place).expect("the page"))
}

/// The numbers of a run that a log knows.
const KEYS: [&str; 6] =
    ["policy", "horizon_ns", "tasks", "nodes_missed", "units_dispatched", "encoder_runs_saved"];

fn differs(one: &Value, other: &Value) -> Option<&'static str> {
    KEYS.into_iter().find(|key| one[key].is_null() || one[key] != other[key])
}

/// A miss whose parts are not as long together as the time to its end.
fn with_a_hole(misses: &Value) -> Option<&Value> {
    let sum = |miss: &Value| {
        miss["parts"].as_array().expect("parts").iter().map(|part| part["ns"].as_u64().unwrap()).sum::<u64>()
    };
    let until = |miss: &Value| miss["until_ns"].as_u64().unwrap() - miss["release_ns"].as_u64().unwrap();
    misses
        .as_array()
        .expect("misses")
        .iter()
        .find(|miss| sum(miss) != until(miss) || miss["response_ns"] != until(miss))
}

#[test]
fn a_report_has_the_numbers_of_its_run_and_chains_that_add_up() {
    let (log, told) = recorded("numbers");
    let (answer, page) = report(&log);
    assert_eq!(differs(&told, &answer), None, "{told}\n{answer}");
    assert_eq!(data(&page), answer, "the page has what was printed");
    let mut planted = answer.clone();
    planted["tasks"][0]["on_time"] = json!(planted["tasks"][0]["on_time"].as_u64().unwrap() + 1);
    assert_eq!(differs(&told, &planted), Some("tasks"), "a difference is found");

    let misses = answer["misses"].as_array().expect("misses");
    let missed: u64 =
        answer["tasks"].as_array().unwrap().iter().map(|task| task["missed"].as_u64().unwrap()).sum();
    assert!(missed > 0 && misses.len() as u64 == missed, "{answer}");
    assert_eq!(with_a_hole(&answer["misses"]), None);
    let mut planted = answer["misses"].clone();
    planted[0]["parts"].as_array_mut().unwrap().pop();
    assert!(with_a_hole(&planted).is_some(), "a hole is found");
    let kinds = |kind: &str| {
        misses.iter().flat_map(|miss| miss["parts"].as_array().unwrap()).any(|part| part["kind"] == *kind)
    };
    assert!(kinds("execution") && kinds("overrun") && kinds("lane"), "{answer}");
    let edits: Vec<&Value> = answer["edits"].as_array().unwrap().iter().map(|edit| &edit["change"]).collect();
    assert_eq!(edits, ["late: +extra", "late: −extra"]);
    assert!(!answer["tried"].as_array().unwrap().is_empty());
    assert!(misses.iter().any(|miss| miss["saved_by"].is_string()), "{answer}");
}

#[test]
fn a_page_needs_nothing_else_and_foreign_text_is_no_part_of_it() {
    let (log, _) = recorded("alone");
    let (_, page) = report(&log);
    for reference in ["http:", "https:", "src=", "@import", "url(", "<link"] {
        assert!(!page.contains(reference), "{reference}");
    }
    assert!(page.contains("report-&lt;b&gt;&amp;&#39;alone.toml") && !page.contains("<b>&'alone"));
    for words in
        ["<svg", "<canvas", "deadline 12.0 ms", "The critical chain of each", "together, of a deadline of"]
    {
        assert!(page.contains(words), "no `{words}`");
    }
}

#[test]
fn what_is_no_log_gets_no_page() {
    let text = file("report-none.redlog", FILE.as_bytes());
    refused(run(&["report", text.to_str().unwrap()]), 2, &["report-none.redlog", "no replay log"]);
    assert!(!text.with_extension("html").exists());
    refused(run(&["report", "/nowhere/at.all"]), 2, &["there is no such file"]);
    let (log, _) = recorded("cut");
    let bytes = fs::read(&log).unwrap();
    fs::write(&log, &bytes[..bytes.len() - 7]).unwrap();
    refused(run(&["report", &log, "--json"]), 2, &["truncated"]);
    refused(run(&["report", &log, "--out", &log]), 2, &["is the log itself"]);
    assert!(!Path::new(&log).with_extension("html").exists());
}

/// In the header the nodes have another order.
#[test]
fn a_log_that_differs_in_replay_gets_no_page() {
    let (log, _) = recorded("differs");
    let bytes = fs::read(&log).unwrap();
    let length = u32::from_le_bytes(bytes[8..12].try_into().unwrap()) as usize;
    let mut header: Value = serde_json::from_slice(&bytes[16..16 + length]).unwrap();
    let planted = header["workload"]
        .as_str()
        .unwrap()
        .replace("after = [\"camera\"]\nwcet = \"2ms\"", "wcet = \"2ms\"");
    let planted = planted.replace("name = \"camera\"\n", "name = \"camera\"\nafter = [\"see\"]\n");
    assert_ne!(header["workload"], *planted, "the plant took");
    header["workload"] = planted.into();
    let text = serde_json::to_vec(&header).unwrap();
    let crc = !text.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| (crc >> 1) ^ (0xEDB8_8320 & (crc & 1).wrapping_neg()))
    });
    let head = [&bytes[..8], &(text.len() as u32).to_le_bytes(), &crc.to_le_bytes(), &text].concat();
    fs::write(&log, [&head, &bytes[16 + length..]].concat()).unwrap();
    refused(run(&["report", &log, "--json"]), 1, &["differs in replay at input", "no page is written"]);
    assert!(!Path::new(&log).with_extension("html").exists());
}

#[test]
fn a_page_is_there_whole_or_not_at_all() {
    let (log, _) = recorded("place");
    refused(run(&["report", &log, "--out", "no-such-folder/r.html"]), 3, &["no-such-folder/r.html", "--out"]);
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("report-place");
    let _none_there = fs::remove_dir_all(&folder);
    fs::create_dir_all(folder.join("r.html/in-the-way")).unwrap();
    let place = folder.join("r.html");
    refused(run(&["report", &log, "--out", place.to_str().unwrap()]), 3, &["r.html", "--out"]);
    let left: Vec<_> = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(left, ["r.html"], "nothing is left beside it");
    let other = folder.join("s.html");
    assert_eq!(run(&["report", &log, "--out", other.to_str().unwrap()]).0, 0);
    assert!(fs::read_to_string(other).unwrap().ends_with("</html>\n"));
}

#[test]
fn tables_of_the_paper_are_a_page_where_one_is_asked_for() {
    let place = Path::new(env!("CARGO_TARGET_TMPDIR")).join("report-paper.html");
    let (status, out, err) = run(&[
        "paper",
        "worked-example",
        "--seeds",
        "2",
        "--json",
        "--force",
        "--report",
        place.to_str().unwrap(),
    ]);
    assert_eq!(status, 0, "{err}");
    let page = fs::read_to_string(&place).expect("the page");
    assert_eq!(data(&page), serde_json::from_str::<Value>(&out).expect("one JSON object"));
    assert!(page.contains("reproduced") && !page.contains("http"), "{page}");
    // The tables themselves were told before.
    let (status, _, err) =
        run(&["paper", "worked-example", "--seeds", "2", "--report", "no-such-folder/p.html"]);
    refused((status, String::new(), err), 3, &["no-such-folder/p.html", "--report"]);
}
