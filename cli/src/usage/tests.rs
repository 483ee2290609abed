use super::*;
use clap::{Arg, Command};

/// The message for these arguments of a small command.
fn with(arguments: &[&str]) -> String {
    let policy = Arg::new("policy").long("policy").value_parser(["edf", "redrt"]);
    let command = Command::new("redrt").subcommand_required(true).subcommand(Command::new("sim").arg(policy));
    let error = command.try_get_matches_from([&["redrt"], arguments].concat()).expect_err("wrong usage");
    message(error)
}

#[test]
fn plain_arguments_stay_as_they_are() {
    assert!(with(&["sim", "--polcy"]).starts_with("error: unexpected argument '--polcy' found\n"));
}

#[test]
fn foreign_text_is_escaped_and_cut_wherever_the_parser_quotes_it() {
    let long = "x".repeat(5_000);
    let hostile = ["\u{1b}[0m\nerror: forged", "\u{202e}\r\u{8}x", "\u{1b}[31mred", "a\u{9b}31m", &long];
    for foreign in hostile {
        let (equals, option) = (format!("--policy={foreign}"), format!("--{foreign}"));
        for arguments in [
            &[foreign][..],
            &["sim", foreign],
            &["sim", "--policy", foreign],
            &["sim", &equals],
            &["sim", &option],
            &["sim", "--", foreign],
        ] {
            let text = with(arguments);
            let is_hostile = |c: char| c != '\n' && (c.is_control() || c == '\u{202e}');
            assert!(!text.contains(is_hostile) && !text.contains("\nerror:"), "{text:?}");
            assert!(text.chars().count() < 500, "{text}");
            assert!(text.contains("\\u{") || text.contains('…'), "{text}");
        }
    }
}

#[test]
fn a_value_in_capitals_is_recognised() {
    assert!(with(&["sim", "--policy", "EDF"]).contains("a similar value exists: 'edf'"));
    assert!(with(&["sim", "--policy", "redtr"]).contains("a similar value exists: 'redrt'"));
}
