use super::*;

#[test]
fn a_fix_names_the_running_executable() {
    let fix = named_in("sudo setcap cap_sys_nice=ep $(which redrt); or else");
    let path = env::current_exe().unwrap();
    let expected = format!("ep '{}' (a rebuild loses it); or else", path.display());
    assert!(fix.ends_with(&expected), "{fix}");
}

#[test]
fn a_path_is_quoted_for_the_shell() {
    assert_eq!(quoted("/a b/it's").as_deref(), Some(r"'/a b/it'\''s'"));
    assert_eq!(quoted("/a\u{1b}[31m"), None);
}
