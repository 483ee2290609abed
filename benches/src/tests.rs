use super::*;

fn words(words: &[&str]) -> Vec<String> {
    words.iter().map(|word| (*word).to_owned()).collect()
}

#[test]
fn the_help_lists_the_sections_in_their_order() {
    let listed = HELP.lines().filter_map(|line| line.strip_prefix("  ")?.split_whitespace().next());
    let listed: Vec<&str> = listed.filter(|word| !word.starts_with("--")).collect();
    assert_eq!(listed, SECTIONS.iter().map(|(name, _)| *name).collect::<Vec<_>>());
}

#[test]
fn a_section_wants_a_name_that_there_is() {
    for arguments in [&["--section"][..], &["--section", "no-such"]] {
        let refused = parse(&words(arguments)).expect_err("refused");
        assert!(refused.contains("dispatch, instructions"), "{refused}");
    }
    let (quick, chosen) = parse(&words(&["--quick", "--section", "edit"])).expect("two options");
    assert_eq!((quick, chosen.iter().map(|(name, _)| *name).collect::<Vec<_>>()), (true, vec!["edit"]));
}
