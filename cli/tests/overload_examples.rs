//! What README says of overload, from the files in `examples/overload`.

mod process;

use process::{file, run};
use serde_json::Value;

/// Jobs on time of each task of a file, or of one with other words in it, and what README says of them.
struct Figure {
    file: &'static str,
    instead: &'static [(&'static str, &'static str)],
    options: &'static [&'static str],
    on_time: &'static [u64],
    says: &'static str,
}

const FIGURES: [Figure; 11] = [
    Figure {
        file: "probes",
        instead: &[],
        options: &["--horizon", "20s"],
        on_time: &[976, 24],
        says: "976 of 1000 jobs on time",
    },
    Figure {
        file: "probes",
        instead: &[
            ("period = \"24ms\"", "period = \"60ms\""),
            ("deadline = \"48ms\"", "deadline = \"120ms\""),
        ],
        options: &["--horizon", "20s"],
        on_time: &[990, 10],
        says: "990 beside those every 60 ms",
    },
    Figure {
        file: "probes",
        instead: &[
            ("period = \"24ms\"", "period = \"400ms\""),
            ("deadline = \"48ms\"", "deadline = \"800ms\""),
        ],
        options: &["--horizon", "20s"],
        on_time: &[999, 1],
        says: "999 every 400",
    },
    Figure {
        file: "probes",
        instead: &[("value = 1000", "value = 1000\nfloor = [1, 1]")],
        options: &["--horizon", "20s"],
        on_time: &[1_000, 0],
        says: "With `floor = [1, 1]` it loses none",
    },
    Figure {
        file: "one-lane",
        instead: &[],
        options: &[],
        on_time: &[3_818],
        says: "3818 of 4455 jobs on time",
    },
    Figure {
        file: "two-lanes",
        instead: &[],
        options: &["--horizon", "9s"],
        on_time: &[400],
        says: "400 of 600",
    },
    Figure {
        file: "full-table",
        instead: &[],
        options: &["--horizon", "4s", "--execution", "uniform:0.97..0.97"],
        on_time: &[4_000, 4_412],
        says: "`sim` has 4412 on time",
    },
    Figure {
        file: "three-lanes",
        instead: &[],
        options: &["--horizon", "20s"],
        on_time: &[1_000, 0],
        says: "lose nothing to a node of 24 ms and value 1",
    },
    Figure {
        file: "times-vary",
        instead: &[],
        options: &["--execution", "uniform:0.5..1"],
        on_time: &[958, 20_509],
        says: "loses 42 of 1000 to short nodes of value 1",
    },
    Figure {
        file: "branches",
        instead: &[],
        options: &["--horizon", "4s"],
        on_time: &[200, 0, 0],
        says: "have 0 of 80 jobs on time",
    },
    Figure {
        file: "edf",
        instead: &[],
        options: &["--horizon", "20s"],
        on_time: &[1_640, 400, 1_177, 400],
        says: "1640 of 2000 are on time",
    },
];

#[test]
fn readme_says_what_the_files_show() {
    let read = |path: &str| {
        let path = format!("{}/../{path}", env!("CARGO_MANIFEST_DIR"));
        std::fs::read_to_string(&path).expect("a file of this repository")
    };
    // As it reads, wherever its lines end.
    let readme = read("README.md").split_whitespace().collect::<Vec<_>>().join(" ");
    for Figure { file: name, instead, options, on_time, says } in FIGURES {
        let mut text = read(&format!("examples/overload/{name}.toml"));
        for (old, new) in instead {
            assert!(text.contains(old), "{name}: {old}");
            text = text.replacen(old, new, 1);
        }
        let path = file(&format!("{name}.toml"), text.as_bytes());
        let path = path.to_string_lossy();
        let (status, out, err) = run(&[&["sim", &path, "--json"], options].concat());
        assert_eq!(status, 0, "{name}: {err}");
        let report: Value = serde_json::from_str(&out).expect("one JSON object");
        let tasks = report["tasks"].as_array().expect("a list").iter();
        let found: Vec<Option<u64>> = tasks.map(|task| task["on_time"].as_u64()).collect();
        assert_eq!(found, on_time.iter().copied().map(Some).collect::<Vec<_>>(), "{name}: {instead:?}");
        assert!(readme.contains(says), "README no longer says: {says}");
    }
}
