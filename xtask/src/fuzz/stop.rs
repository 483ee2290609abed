//! Why a fuzzer stopped, from its log.

/// What a panic's message ends before.
const AFTER_A_PANIC: [&str; 3] = ["note: ", "stack backtrace:", "=="];

/// What libFuzzer says before the path of the input.
const WRITTEN: &str = "Test unit written to ";

pub(super) struct Stop<'t> {
    /// Panics with their places, and what libFuzzer itself says went wrong.
    pub(super) why: Vec<&'t str>,
    /// Where the input is kept.
    pub(super) input: Option<&'t str>,
}

impl<'t> Stop<'t> {
    pub(super) fn of(log: &'t str) -> Self {
        let (mut why, mut panics) = (Vec::new(), false);
        for line in log.lines().map(str::trim_end) {
            panics &= !AFTER_A_PANIC.iter().any(|after| line.starts_with(after));
            panics |= line.contains("panicked at ");
            if panics || line.contains("ERROR: ") || line.starts_with("SUMMARY: ") {
                why.push(line);
            }
        }
        let input = log.lines().find_map(|line| line.split_once(WRITTEN)).map(|(_, path)| path.trim_end());
        Self { why, input }
    }

    /// The line of it that has one of these.
    pub(super) fn line_with(&self, words: &[&str]) -> Option<&'t str> {
        self.why.iter().find(|line| words.iter().any(|word| line.contains(word))).copied()
    }
}
