use super::*;

#[test]
fn code_is_taken_from_its_section_only() {
    let readme = "# RED\n```cpp\nother\n```\n## From C++\nText\n```cmake\nproject()\n```\n\n```cpp\nint main() {}\n```\n\
                  ```cpp\nint two;\n```\n## Next\n```rust\nlast\n```\n";
    assert_eq!(code(readme, "cmake"), ["project()\n"]);
    assert_eq!(code(readme, "cpp"), ["int main() {}\n", "int two;\n"]);
    assert!(code(readme, "rust").is_empty());
    assert!(code("nothing", "cpp").is_empty());
}
