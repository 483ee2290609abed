//! How large executions are.

/// Of so many inputs that ask for what costs much, one gets it.
const SELDOM: u32 = 4;

/// How large an execution is.
#[derive(Clone, Copy)]
pub(crate) struct Sizes {
    /// Classes that take part, from the smallest on.
    pub(crate) classes: usize,
    /// What is out of the ordinary.
    pub(crate) more: More,
}

/// What costs too much for every execution.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum More {
    Nothing,
    /// Memory for more graphs than handles.
    Crowd,
    /// Runtimes, and graphs of their class.
    Runtimes,
    /// A log of the first scheduler.
    Log,
}

impl Sizes {
    /// What costs as much as ten executions is made small for most inputs. Which ones is for their bytes to say, not for
    /// what ran before: an input that fails has to fail again when it is run alone.
    pub(crate) fn affordable(self, input: &[u8]) -> Self {
        let is_dear = self.classes > 2 || self.more != More::Nothing;
        let is_its_turn = crc32fast::hash(input).is_multiple_of(SELDOM);
        if is_dear && !is_its_turn { Self { classes: 1, more: More::Nothing } } else { self }
    }
}
