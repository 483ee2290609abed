//! Source files as text, with comments and literals blanked out.

use std::fs;
use std::path::{Path, PathBuf};

/// One file.
pub(crate) struct Source {
    /// Relative to the workspace.
    pub(crate) path: String,
    text: String,
    /// The text with every comment, string and character blank; lines stay where they are.
    code: String,
}

impl Source {
    pub(crate) fn new(path: &str, text: &str) -> Self {
        Self { path: path.to_owned(), text: text.to_owned(), code: blank(text) }
    }

    pub(crate) fn is_in(&self, folder: &str) -> bool {
        self.path.starts_with(folder)
    }

    /// Whether the whole file is tests.
    pub(crate) fn is_test(&self) -> bool {
        self.path.ends_with("/tests.rs") || self.path.contains("/tests/")
    }

    /// The module of the crate that the file belongs to.
    pub(crate) fn module(&self) -> String {
        let inside = self.path.split_once("src/").map_or(self.path.as_str(), |(_, inside)| inside);
        inside.split('/').next().unwrap_or_default().trim_end_matches(".rs").to_owned()
    }

    /// Modules that `crate::` paths name, with their lines. Tests inside the file are left out.
    pub(crate) fn crate_paths(&self) -> Vec<(usize, String)> {
        let mut found = Vec::new();
        let code = &self.code[..self.end_of_code()];
        for (at, _) in code.match_indices("crate::").filter(|(at, _)| !code[..*at].ends_with(is_word)) {
            let line = code[..at].matches('\n').count() + 1;
            let rest = &code[at + "crate::".len()..];
            match rest.strip_prefix('{') {
                Some(list) => found.extend(top_level(list).into_iter().map(|name| (line, name))),
                None => found.push((line, word(rest))),
            }
        }
        found
    }

    /// Lines of code that contain a word, or words joined by `::`.
    pub(crate) fn lines_with(&self, word: &str) -> Vec<(usize, &str)> {
        let has = |line: &str| {
            line.match_indices(word).any(|(at, _)| {
                !line[..at].ends_with(is_word) && !line[at + word.len()..].starts_with(is_word)
            })
        };
        let lines = self.code.lines().zip(self.text.lines()).enumerate();
        lines.filter(|(_, (code, _))| has(code)).map(|(at, (_, text))| (at + 1, text)).collect()
    }

    /// Lines with a number that has a fraction.
    pub(crate) fn float_literals(&self) -> Vec<usize> {
        let is_float = |line: &str| {
            line.match_indices('.').any(|(at, _)| {
                let whole = line[..at].trim_end_matches(|c: char| c.is_ascii_digit() || c == '_');
                let is_field = whole.ends_with(|c: char| is_word(c) || c == '.');
                let has_digits = whole.len() < at && line[at + 1..].starts_with(|c: char| c.is_ascii_digit());
                has_digits && !is_field
            })
        };
        self.code.lines().enumerate().filter(|(_, line)| is_float(line)).map(|(at, _)| at + 1).collect()
    }

    pub(crate) fn lines_without_tests(&self) -> usize {
        self.text[..self.end_of_code()].lines().count()
    }

    /// Lines of code and of documentation; blank ones, plain comments and tests are not counted.
    pub(crate) fn lines_that_count(&self) -> usize {
        let counts = |line: &str| !line.is_empty() && (!line.starts_with("//") || is_doc(line));
        self.text[..self.end_of_code()].lines().filter(|line| counts(line.trim_start())).count()
    }

    /// Where the tests inside the file begin, their attribute included.
    fn end_of_code(&self) -> usize {
        let tests = self.code.find("\nmod tests {");
        tests.map_or(self.code.len(), |tests| {
            self.code[..tests].rfind('\n').map_or(0, |attribute| attribute + 1)
        })
    }
}

/// Every source file of the workspace.
pub(crate) fn read_all() -> Vec<Source> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("this package lies in the workspace");
    let mut files = Vec::new();
    for entry in fs::read_dir(root).expect("the workspace can be read") {
        let path = entry.expect("an entry").path();
        if path.join("Cargo.toml").exists() || path.ends_with("examples") {
            collect(&path, &mut files);
        }
    }
    files.sort();
    assert!(files.len() > 100, "only {} source files found: the gates look at the wrong place", files.len());
    let source = |path: &PathBuf| {
        let name = path.strip_prefix(root).expect("below the root").display().to_string();
        Source::new(&name, &fs::read_to_string(path).expect("sources are UTF-8"))
    };
    files.iter().map(source).collect()
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder of the workspace can be read") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            collect(&path, files);
        } else if path.extension().is_some_and(|kind| kind == "rs") {
            files.push(path);
        }
    }
}

fn is_doc(line: &str) -> bool {
    line.starts_with("///") || line.starts_with("//!")
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

fn word(text: &str) -> String {
    text.chars().take_while(|c| is_word(*c)).collect()
}

/// First words of the elements of a `use` list that begins here.
fn top_level(list: &str) -> Vec<String> {
    let (mut depth, mut names, mut begins) = (0, Vec::new(), true);
    for (at, c) in list.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => break,
            '}' => depth -= 1,
            ',' if depth == 0 => begins = true,
            c if begins && is_word(c) => {
                names.push(word(&list[at..]));
                begins = false;
            }
            _ => {}
        }
    }
    names
}

/// Blanks comments, strings and characters.
fn blank(text: &str) -> String {
    let mut code = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let hidden = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            block_comment(rest)
        } else if c == '"' {
            string(rest)
        } else if let Some(hashes) = raw_string(rest).filter(|_| !code.ends_with(is_word)) {
            let end = format!("\"{}", "#".repeat(hashes));
            let open = hashes + 2;
            rest[open..].find(&end).map_or(rest.len(), |at| open + at + end.len())
        } else if c == '\'' {
            character(rest)
        } else {
            0
        };
        let shown = if hidden == 0 { c.len_utf8() } else { 0 };
        code.push_str(&rest[..shown]);
        code.extend(rest[..hidden].chars().flat_map(|c| {
            let fill = if c == '\n' { '\n' } else { ' ' };
            std::iter::repeat_n(fill, c.len_utf8())
        }));
        rest = &rest[shown + hidden..];
    }
    code
}

fn block_comment(text: &str) -> usize {
    let mut depth = 0;
    for (at, _) in text.char_indices() {
        if text[at..].starts_with("/*") {
            depth += 1;
        } else if text[at..].starts_with("*/") {
            depth -= 1;
            if depth == 0 {
                return at + 2;
            }
        }
    }
    text.len()
}

fn string(text: &str) -> usize {
    let mut escaped = false;
    for (at, c) in text.char_indices().skip(1) {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            '"' => return at + 1,
            _ => {}
        }
    }
    text.len()
}

/// How many hashes a raw string that begins here has.
fn raw_string(text: &str) -> Option<usize> {
    let after = text.strip_prefix('r')?;
    let hashes = after.len() - after.trim_start_matches('#').len();
    after[hashes..].starts_with('"').then_some(hashes)
}

/// Length of a character literal; 0 for a lifetime or a label.
fn character(text: &str) -> usize {
    let inner: Vec<char> = text.chars().take(4).collect();
    match inner[..] {
        [_, '\\', ..] => {
            text[2..].char_indices().skip(1).find(|(_, c)| *c == '\'').map_or(0, |(at, _)| at + 3)
        }
        [_, c, '\'', ..] => c.len_utf8() + 2,
        _ => 0,
    }
}
