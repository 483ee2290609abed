//! How far the bounded steps go.

/// How far a step goes that could go on for ever.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Depth {
    /// As far as every change can wait for.
    Quick,
    /// As far as is worth a night.
    Deep,
}

impl Depth {
    /// Takes `--deep` out of the words.
    pub(crate) fn of<'a>(words: &[&'a str]) -> (Self, Vec<&'a str>) {
        let rest: Vec<&str> = words.iter().filter(|word| **word != "--deep").copied().collect();
        (if rest.len() < words.len() { Self::Deep } else { Self::Quick }, rest)
    }
}
