//! The command `red-gpu-tests`.

use red_gpu_tests::{Bench, CHECKS, Check};
use red_rt::cuda;
use std::env;
use std::path::PathBuf;
use std::process::ExitCode;

const HELP: &str = "\
What only a CUDA device can show.

usage: red-gpu-tests [--redrt PATH] [CHECK]...

  CHECK         one of those below; all of them unless told
  --redrt PATH  the command redrt; the one in this program's folder unless told

Both programs are all it needs: build them with `cargo build --release -p redrt -p red-gpu-tests` and copy them from
target/release. Times are printed and judge nothing. Real time is used where it is granted.

Exit status: 0 every check held, 1 one did not, 2 wrong arguments, 3 no CUDA device.

checks:
";

fn help() -> String {
    let line = |check: &Check| format!("  {:<12}{}\n", check.name, check.claim);
    CHECKS.iter().fold(HELP.to_owned(), |text, check| text + &line(check))
}

fn wish(words: &[String]) -> Result<(Option<PathBuf>, Vec<Check>), String> {
    let (mut redrt, mut checks, mut words) = (None, Vec::new(), words.iter());
    while let Some(word) = words.next() {
        if word == "--redrt" {
            redrt = Some(words.next().ok_or("--redrt takes a path")?.into());
        } else {
            let known = CHECKS.iter().find(|check| check.name == word);
            checks.push(*known.ok_or_else(|| format!("there is no check {word}; --help lists them"))?);
        }
    }
    Ok((redrt, if checks.is_empty() { CHECKS.to_vec() } else { checks }))
}

fn main() -> ExitCode {
    let words: Vec<String> = env::args().skip(1).collect();
    if words.iter().any(|word| word == "--help" || word == "-h") {
        print!("{}", help());
        return ExitCode::SUCCESS;
    }
    let (redrt, checks) = match wish(&words) {
        Ok(wish) => wish,
        Err(reason) => {
            eprintln!("red-gpu-tests: {reason}");
            return ExitCode::from(2);
        }
    };
    let device = match cuda::open(0) {
        Ok(device) => device,
        Err(why) => {
            eprintln!("red-gpu-tests: {why}");
            return ExitCode::from(3);
        }
    };
    let beside = || env::current_exe().unwrap_or_default().with_file_name("redrt");
    let bench = Bench { device, redrt: redrt.unwrap_or_else(beside) };
    let capability = bench.device.capability().unwrap_or_default();
    println!("{}, compute capability {}.{}", bench.device.name(), capability.0, capability.1);
    let mut all_hold = true;
    for check in checks {
        println!("\n{}: {}", check.name, check.claim);
        match (check.run)(&bench) {
            Ok(figures) => figures.iter().for_each(|line| println!("  {line}")),
            Err(why) => {
                println!("  FAILED: {why}");
                all_hold = false;
            }
        }
    }
    println!("\n{}", if all_hold { "every check held" } else { "NOT every check held" });
    if all_hold { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
