//! The policies by their names on the command line.

use red_core::Config;
use std::fmt;
use std::str::FromStr;

/// A named configuration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Policy {
    /// The paper's baseline: unrefined graphs, one deadline per job.
    Edf,
    /// The paper's RED-FG: refined, level shares, level barrier.
    RedFg,
    /// The paper's RED-IDA: RED-FG with re-assignment at each dispatch.
    RedIda,
    /// The paper's RED.
    Red,
    /// Ours.
    #[default]
    Redrt,
    /// Ours, with lanes that wait for a pressing node that is soon ready.
    RedrtLookahead,
}

impl Policy {
    /// What the paper's tables compare, in its order, ours last.
    pub const ALL: [Self; 5] = [Self::Edf, Self::RedFg, Self::RedIda, Self::Red, Self::Redrt];

    /// Everything that has a name.
    pub const NAMED: [Self; 6] =
        [Self::Edf, Self::RedFg, Self::RedIda, Self::Red, Self::Redrt, Self::RedrtLookahead];

    /// Name on the command line and in JSON.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Edf => "edf",
            Self::RedFg => "red-fg",
            Self::RedIda => "red-ida",
            Self::Red => "red",
            Self::Redrt => "redrt",
            Self::RedrtLookahead => "redrt-lookahead",
        }
    }

    /// What it configures.
    #[must_use]
    pub const fn config(self) -> Config {
        match self {
            Self::Edf => Config::EDF,
            Self::RedFg => Config::RED_FG,
            Self::RedIda => Config::RED_IDA,
            Self::Red => Config::RED,
            Self::Redrt => Config::REDRT,
            Self::RedrtLookahead => Config::REDRT_LOOKAHEAD,
        }
    }

    /// Whether the periodic barrier of a `[sync]` table holds for it: the paper's baselines.
    #[must_use]
    pub const fn has_barrier(self) -> bool {
        matches!(self, Self::Edf | Self::RedFg | Self::RedIda)
    }
}

impl fmt::Display for Policy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Policy {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let known = Self::NAMED.into_iter().find(|p| p.name() == name);
        known.ok_or_else(|| "expected one of edf, red-fg, red-ida, red, redrt, redrt-lookahead".to_owned())
    }
}
