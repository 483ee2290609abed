//! A parsed file as a tree of values that know where they stand, the same for TOML and YAML.

mod fields;
mod from_toml;
mod from_yaml;

use std::borrow::Cow;

pub(crate) use fields::{Field, Fields};

use crate::error::shown;

/// How deep tables and lists may nest. A workload needs ten levels.
const MAX_NESTING: usize = 16;

/// A value and its place.
#[derive(Debug)]
pub(crate) struct Tree<'s> {
    /// Byte offset in the text.
    pub(crate) at: usize,
    /// The value as written, for messages.
    source: &'s str,
    value: Value<'s>,
}

#[derive(Debug)]
enum Value<'s> {
    Text(Cow<'s, str>),
    /// `None` does not fit.
    Integer(Option<i64>),
    Boolean(bool),
    List(Vec<Tree<'s>>),
    Table(Vec<(Key<'s>, Tree<'s>)>),
    /// A key without a value, in YAML.
    Nothing,
    /// A type that no key takes, such as a fraction or a date: its name.
    Other(&'static str),
}

#[derive(Debug)]
struct Key<'s> {
    name: Cow<'s, str>,
    at: usize,
}

impl Tree<'_> {
    /// What stands here, for a message.
    fn description(&self) -> String {
        let source = shown(self.source);
        match &self.value {
            Value::Text(text) => format!("the text `{}`", shown(text)),
            Value::Integer(_) => format!("the integer `{source}`"),
            Value::Boolean(_) => format!("`{source}`"),
            Value::List(_) => "a list".to_owned(),
            Value::Table(_) => "a table".to_owned(),
            Value::Nothing => "an empty value".to_owned(),
            Value::Other(kind) => format!("{kind} `{source}`"),
        }
    }
}

#[cfg(test)]
mod tests;
