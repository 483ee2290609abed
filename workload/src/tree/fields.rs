//! Reading a table by its keys: each value has the type that its reader asks for, or the refusal says which.

use std::ops::RangeInclusive;

use super::{Key, Tree, Value};
use crate::error::{Fault, Refusal, shown};
use crate::units::{self, QuantityError};

/// A table whose keys are known to be among those that its owner takes.
#[derive(Clone, Copy)]
pub(crate) struct Fields<'t> {
    /// What the table describes, with an article.
    owner: &'static str,
    /// Byte offset of the table.
    pub(crate) at: usize,
    entries: &'t [(Key<'t>, Tree<'t>)],
}

impl<'t> Fields<'t> {
    /// Opens a table that may have these keys and no others.
    pub(crate) fn open(
        tree: &'t Tree<'t>,
        owner: &'static str,
        keys: &[&'static str],
    ) -> Result<Self, Fault> {
        let Value::Table(entries) = &tree.value else {
            let problem = format!("{owner} is written as {}", tree.description());
            return Err(Fault::new(
                tree.at,
                Refusal::Type,
                problem,
                format!("a table with {}", one_of(keys)),
            ));
        };
        match entries.iter().find(|(key, _)| !keys.contains(&key.name.as_ref())) {
            None => Ok(Self { owner, at: tree.at, entries }),
            Some((key, _)) => {
                let problem = format!("{owner} has no key `{}`", shown(&key.name));
                Err(Fault::new(key.at, Refusal::UnknownKey, problem, one_of(keys))
                    .with_nearest(&key.name, keys.iter().copied()))
            }
        }
    }

    /// The value of a key that may be absent.
    pub(crate) fn get(&self, key: &'static str) -> Option<Field<'t>> {
        self.entries.iter().find(|(entry, _)| entry.name == key).map(|(_, tree)| Field { key, tree })
    }

    /// The value of a key that must be there.
    pub(crate) fn need(&self, key: &'static str) -> Result<Field<'t>, Fault> {
        self.get(key).ok_or_else(|| {
            let problem = format!("{} has no `{key}`", self.owner);
            Fault::new(self.at, Refusal::Missing, problem, format!("the key `{key}` in this table"))
        })
    }

    /// The only one of these keys that is there.
    pub(crate) fn exactly_one(&self, keys: &[&'static str]) -> Result<Field<'t>, Fault> {
        let mut present = keys.iter().filter_map(|key| self.get(key));
        let expected = format!("exactly {}", one_of(keys));
        match (present.next(), present.next()) {
            (Some(only), None) => Ok(only),
            (Some(first), Some(second)) => {
                let problem = format!("{} has both `{}` and `{}`", self.owner, first.key, second.key);
                Err(Fault::new(second.at(), Refusal::Conflict, problem, expected))
            }
            (None, _) => {
                let problem = format!("{} has none of {}", self.owner, listed(keys));
                Err(Fault::new(self.at, Refusal::Missing, problem, expected))
            }
        }
    }

    /// Refuses this key if it is there, because of what else is.
    pub(crate) fn refuse(&self, key: &'static str, expected: &str) -> Result<(), Fault> {
        match self.get(key) {
            None => Ok(()),
            Some(field) => {
                let problem = format!("{} has `{key}` here", self.owner);
                Err(Fault::new(field.at(), Refusal::Conflict, problem, expected))
            }
        }
    }

    /// Offset of the key's value, or of the table where the key is absent.
    pub(crate) fn place(&self, key: &'static str) -> usize {
        self.get(key).map_or(self.at, |field| field.at())
    }
}

/// A value and the key that it stands under, also where it is an element of that key's list.
#[derive(Clone, Copy)]
pub(crate) struct Field<'t> {
    pub(crate) key: &'static str,
    pub(crate) tree: &'t Tree<'t>,
}

impl<'t> Field<'t> {
    pub(crate) fn at(&self) -> usize {
        self.tree.at
    }

    /// A refusal of this value.
    pub(crate) fn fault(&self, refusal: Refusal, expected: impl Into<String>) -> Fault {
        let problem = format!("`{}` is {}", self.key, self.tree.description());
        Fault::new(self.at(), refusal, problem, expected)
    }

    pub(crate) fn text(&self) -> Result<&'t str, Fault> {
        match &self.tree.value {
            Value::Text(text) => Ok(text),
            _ => Err(self.fault(Refusal::Type, "a text: put it in quotes")),
        }
    }

    /// A text that is a name.
    pub(crate) fn name(&self) -> Result<&'t str, Fault> {
        let name = self.text()?;
        let is_allowed = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'_' || byte == b'-';
        if (1..=64).contains(&name.len()) && name.bytes().all(is_allowed) {
            return Ok(name);
        }
        Err(self.fault(Refusal::Name, "a name of 1 to 64 letters, digits, `_` and `-`"))
    }

    pub(crate) fn is_table(&self) -> bool {
        matches!(self.tree.value, Value::Table(_))
    }

    pub(crate) fn boolean(&self) -> Result<bool, Fault> {
        match self.tree.value {
            Value::Boolean(value) => Ok(value),
            _ => Err(self.fault(Refusal::Type, "`true` or `false`")),
        }
    }

    pub(crate) fn integer(&self) -> Result<i64, Fault> {
        match self.tree.value {
            Value::Integer(Some(value)) => Ok(value),
            Value::Integer(None) => Err(self.fault(Refusal::Range, "an integer of 64 bits")),
            _ => Err(self.fault(Refusal::Type, "an integer without quotes and unit")),
        }
    }

    /// An integer of this range.
    pub(crate) fn count(&self, range: RangeInclusive<u32>) -> Result<u32, Fault> {
        let out_of_range = |_| {
            let expected = format!("an integer from {} to {}", range.start(), range.end());
            self.fault(Refusal::Range, expected)
        };
        let value = match self.tree.value {
            // Too long for the tree is also out of range.
            Value::Integer(None) => return Err(out_of_range(())),
            _ => self.integer()?,
        };
        match u32::try_from(value) {
            Ok(count) if range.contains(&count) => Ok(count),
            _ => Err(out_of_range(())),
        }
    }

    /// A time in nanoseconds.
    pub(crate) fn time(&self) -> Result<u64, Fault> {
        let expected = "a whole number with a unit (ns, us, ms, s) such as \"5ms\"";
        self.quantity(units::time_ns, expected)
    }

    /// A time of this range, in nanoseconds.
    pub(crate) fn time_in(&self, range: RangeInclusive<u64>) -> Result<u64, Fault> {
        let time = self.time()?;
        if range.contains(&time) {
            return Ok(time);
        }
        let expected = format!("a time from {}ns to {}ns", range.start(), range.end());
        Err(self.fault(Refusal::Range, expected))
    }

    /// An amount of memory in bytes.
    pub(crate) fn memory(&self) -> Result<u64, Fault> {
        let expected = "a whole number with a unit (B, KiB, MiB, GiB) such as \"8MiB\"";
        self.quantity(units::memory_bytes, expected)
    }

    fn quantity(&self, read: fn(&str) -> Result<u64, QuantityError>, expected: &str) -> Result<u64, Fault> {
        let Value::Text(text) = &self.tree.value else {
            return Err(self.fault(Refusal::Quantity, expected));
        };
        read(text).map_err(|error| {
            let problem = format!("`{}` is `{}`, {error}", self.key, shown(text));
            Fault::new(self.at(), Refusal::Quantity, problem, expected)
        })
    }

    /// The elements of a list.
    pub(crate) fn list(&self) -> Result<impl ExactSizeIterator<Item = Self> + use<'t>, Fault> {
        let key = self.key;
        match &self.tree.value {
            Value::List(items) => Ok(items.iter().map(move |tree| Self { key, tree })),
            _ => Err(self.fault(Refusal::Type, "a list")),
        }
    }
}

fn one_of(keys: &[&str]) -> String {
    format!("one of {}", listed(keys))
}

fn listed(keys: &[&str]) -> String {
    keys.iter().map(|key| format!("`{key}`")).collect::<Vec<_>>().join(", ")
}
