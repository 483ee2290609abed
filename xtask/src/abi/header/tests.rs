use super::*;

fn header(doc: &str) -> Declared {
    Declared::of(&format!("/**\n * Opens.\n *\n * {doc}\n */\nred_status red_open(void);\n"))
}

#[test]
fn a_function_says_who_may_call_it_from_where_how_long_it_takes_and_how_it_fails() {
    let whole = header("Threads: any. Real time: yes. Time: O(1). Errors: none.");
    assert_eq!(unsaid(&whole), Vec::<String>::new());
    for (doc, lacks) in [
        ("Threads: any. Real time: yes. Errors: none.", vec!["red_open: Time:"]),
        ("Time: O(1).", vec!["red_open: Threads:", "red_open: Real time:", "red_open: Errors:"]),
    ] {
        assert_eq!(unsaid(&header(doc)), lacks);
    }
}
