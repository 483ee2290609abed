use super::*;

#[test]
fn counts_of_all_processes_are_added() {
    let text = "==7== Events    : Ir\n==7== Collected : 1200\n==7== \n==9== Collected : 34\n";
    assert_eq!(collected(text), Some(1234));
    assert_eq!(collected("==7== Fatal error"), None);
}

#[test]
fn wrong_arguments_are_named() {
    let run = |words: [&str; 3]| super::run(&words.map(str::to_owned));
    assert!(run(["nobody", "chain256", "1"]).is_err_and(|why| why.contains("nobody")));
    assert!(run(["40-line EDF", "nothing", "1"]).is_err_and(|why| why.contains("nothing")));
    assert!(run(["40-line EDF", "chain256", "x"]).is_err_and(|why| why.contains("\"x\"")));
    assert_eq!(run(["40-line EDF", "chain256", "1"]), Ok(()));
}
