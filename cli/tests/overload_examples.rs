//! What `docs/overload.md` and README say of overload, from the files in `examples/overload`.

mod process;

use process::{file, run};
use serde_json::Value;

/// What says it.
const PAGE: &str = "docs/overload.md";
const README: &str = "README.md";

/// Jobs on time of each task of a file, or of one with other words in it, and where what is said of them.
struct Figure {
    file: &'static str,
    instead: &'static [(&'static str, &'static str)],
    options: &'static [&'static str],
    on_time: &'static [u64],
    says: &'static [(&'static str, &'static str)],
}

const FIGURES: [Figure; 25] = [
    Figure {
        file: "values",
        instead: &[],
        options: &["--horizon", "10s"],
        on_time: &[0, 1_000],
        says: &[
            (PAGE, "1000 of 1000, and none of the other; in the other order the same"),
            (README, "has 1000 of 1000 jobs on time, in either order"),
        ],
    },
    // The one of the higher rank comes first.
    Figure {
        file: "values",
        instead: &[("value = 1\n", "value = 2000\nfloor = [1, 1]\n")],
        options: &["--horizon", "10s"],
        on_time: &[1_000, 0],
        says: &[],
    },
    Figure {
        file: "perception",
        instead: &[],
        options: &["--horizon", "10s"],
        on_time: &[249],
        says: &[
            (PAGE, "249 of 334, where the lane has time for 250"),
            (README, "has 249 of 334 jobs on time, where there is time for 250"),
        ],
    },
    Figure {
        file: "brake",
        instead: &[],
        options: &["--horizon", "10s"],
        on_time: &[6_499, 500],
        says: &[
            (PAGE, "the brake 500 of 500, the sensor 6499 of 10000"),
            (README, "A brake of value 1000 has 500 of 500 jobs on time"),
        ],
    },
    Figure {
        file: "probes",
        instead: &[],
        options: &["--horizon", "20s"],
        on_time: &[992, 8],
        says: &[(
            PAGE,
            "992 of 1000 jobs on time beside nodes of 24 ms and value 1 every 24 ms or every 60 ms",
        )],
    },
    Figure {
        file: "probes",
        instead: &[
            ("period = \"24ms\"", "period = \"60ms\""),
            ("deadline = \"48ms\"", "deadline = \"120ms\""),
        ],
        options: &["--horizon", "20s"],
        on_time: &[992, 8],
        says: &[],
    },
    Figure {
        file: "probes",
        instead: &[
            ("period = \"24ms\"", "period = \"400ms\""),
            ("deadline = \"48ms\"", "deadline = \"800ms\""),
        ],
        options: &["--horizon", "20s"],
        on_time: &[999, 1],
        says: &[],
    },
    Figure {
        file: "probes",
        instead: &[("value = 1000", "value = 1000\nfloor = [1, 1]")],
        options: &["--horizon", "20s"],
        on_time: &[1_000, 0],
        says: &[(PAGE, "With `floor = [1, 1]` it loses none")],
    },
    Figure {
        file: "one-lane",
        instead: &[],
        options: &[],
        on_time: &[3_818],
        says: &[(PAGE, "3818 of 4455 jobs")],
    },
    Figure {
        file: "two-lanes",
        instead: &[],
        options: &["--horizon", "9s"],
        on_time: &[400],
        says: &[(PAGE, "400 of 600")],
    },
    Figure {
        file: "full-table",
        instead: &[],
        options: &["--horizon", "4s", "--execution", "uniform:0.97..0.97"],
        on_time: &[4_000, 4_412],
        says: &[(PAGE, "`sim` has 4412 of 10000 on time")],
    },
    Figure {
        file: "three-lanes",
        instead: &[],
        options: &["--horizon", "20s"],
        on_time: &[1_000, 0],
        says: &[(PAGE, "lose nothing, and a node of 24 ms and value 1 has 0 of 334 jobs on time")],
    },
    Figure {
        file: "times-vary",
        instead: &[],
        options: &["--execution", "uniform:0.5..1"],
        on_time: &[1_000, 20_451],
        says: &[(PAGE, "the graph 1000 of 1000, the others 20451 of")],
    },
    Figure {
        file: "together",
        instead: &[],
        options: &["--horizon", "20s"],
        on_time: &[1_000, 1_000, 0],
        says: &[(PAGE, "1000 and 1000 of 1000, and none of the third")],
    },
    Figure {
        file: "two-of-each",
        instead: &[],
        options: &["--horizon", "20s"],
        on_time: &[201, 200, 2_000, 2_000, 222, 177],
        says: &[(PAGE, "have 201 and 200 of 400 jobs on time beside two of value 2")],
    },
    Figure {
        file: "branches",
        instead: &[],
        options: &["--horizon", "4s"],
        on_time: &[200, 0, 0],
        says: &[(PAGE, "have 0 of 80 jobs on time each")],
    },
    Figure {
        file: "edf",
        instead: &[],
        options: &["--horizon", "20s"],
        on_time: &[1_880, 400, 1_177, 400],
        says: &[(PAGE, "one task has 1880 of 2000 here")],
    },
    Figure {
        file: "fewer-than-alone",
        instead: &[],
        options: &["--horizon", "12s"],
        on_time: &[7, 400, 0],
        says: &[(PAGE, "a task has 7 of 400")],
    },
    Figure {
        file: "fewer-than-alone",
        instead: &[("period = \"60ms\"", "once = true")],
        options: &["--horizon", "12s"],
        on_time: &[103, 400, 0],
        says: &[(PAGE, "and 103 without one of value 1")],
    },
    Figure {
        file: "floor-between",
        instead: &[],
        options: &["--horizon", "12s"],
        on_time: &[240, 1_020, 390],
        says: &[(PAGE, "240 of 240, the floor holds, and 390 of 750")],
    },
    Figure {
        file: "late-floor",
        instead: &[],
        options: &["--horizon", "12s"],
        on_time: &[400, 1_671, 364],
        says: &[(PAGE, "400 of 400, the floor holds, and 364 of 364")],
    },
    Figure {
        file: "wcet-too-long",
        instead: &[],
        options: &["--horizon", "20s", "--execution", "uniform:0.3..0.3"],
        on_time: &[585, 2_857],
        says: &[(PAGE, "`map` has 585 of 607")],
    },
    Figure {
        file: "luck",
        instead: &[],
        options: &["--horizon", "60s", "--execution", "uniform:0.9..1"],
        on_time: &[3_000, 15, 12, 4, 3, 1_322],
        says: &[(PAGE, "have 15, 12, 4, 3 and 1322 of 3000 jobs on time beside a floor")],
    },
    Figure {
        file: "floor-first",
        instead: &[],
        options: &["--horizon", "60s"],
        on_time: &[3_000, 4, 0],
        says: &[(PAGE, "makes somebody late all the time, and it has 4")],
    },
    Figure {
        file: "floor-first",
        instead: &[("name = \"low\"\nperiod = \"20ms\"", "name = \"low\"\nonce = true")],
        options: &["--horizon", "60s"],
        on_time: &[2_999, 548, 0],
        says: &[(PAGE, "has 548 of 3000 jobs on time beside it")],
    },
];

#[test]
fn what_is_said_of_overload_is_what_the_files_show() {
    let read = |path: &str| {
        let path = format!("{}/../{path}", env!("CARGO_MANIFEST_DIR"));
        std::fs::read_to_string(&path).expect("a file of this repository")
    };
    // As it reads, wherever its lines end.
    let words = |path: &str| read(path).split_whitespace().collect::<Vec<_>>().join(" ");
    let papers = [PAGE, README].map(|path| (path, words(path)));
    for Figure { file: name, instead, options, on_time, says } in FIGURES {
        let mut text = read(&format!("examples/overload/{name}.toml"));
        for (old, new) in instead {
            assert!(text.contains(old), "{name}: {old}");
            text = text.replacen(old, new, 1);
        }
        let command = format!("redrt sim examples/overload/{name}.toml {}", options.join(" "));
        let is_told = text.contains(&format!("#   {}\n", command.trim_end()));
        assert!(is_told || !instead.is_empty(), "{name} has another command than {command}");
        let path = file(&format!("{name}.toml"), text.as_bytes());
        let path = path.to_string_lossy();
        let (status, out, err) = run(&[&["sim", &path, "--json"], options].concat());
        assert_eq!(status, 0, "{name}: {err}");
        let report: Value = serde_json::from_str(&out).expect("one JSON object");
        let tasks = report["tasks"].as_array().expect("a list").iter();
        let found: Vec<Option<u64>> = tasks.map(|task| task["on_time"].as_u64()).collect();
        assert_eq!(found, on_time.iter().copied().map(Some).collect::<Vec<_>>(), "{name}: {instead:?}");
        for (paper, says) in says {
            let said = papers.iter().any(|(path, words)| path == paper && words.contains(says));
            assert!(said, "{paper} no longer says: {says}");
        }
    }
}
