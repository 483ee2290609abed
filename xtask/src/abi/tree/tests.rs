use super::*;

#[test]
fn folders_differ_in_what_one_lacks_and_in_what_is_another_thing() {
    let tree = |files: &[(&str, &str)]| -> Tree {
        files.iter().map(|(path, text)| (PathBuf::from(path), text.as_bytes().to_vec())).collect()
    };
    let one = tree(&[("a", "1"), ("b", "2")]);
    assert_eq!(differences(&one, &one), Vec::<String>::new());
    assert_eq!(differences(&one, &tree(&[("a", "1")])), ["b"]);
    assert_eq!(differences(&tree(&[("a", "1")]), &tree(&[("a", "2"), ("c", "")])), ["a", "c"]);
}
