use super::*;

#[test]
fn code_is_taken_from_its_section_only() {
    let readme = "# RED\n```cpp\nother\n```\n## From C++\nText\n```cmake\nproject()\n```\n\n```cpp\nint main() {}\n```\n## Next\n\
                  ```rust\nlast\n```\n";
    assert_eq!(code(readme, "cmake"), Ok("project()\n"));
    assert_eq!(code(readme, "cpp"), Ok("int main() {}\n"));
    assert!(code(readme, "rust").unwrap_err().contains("rust"));
    assert!(code("nothing", "cpp").is_err());
}
