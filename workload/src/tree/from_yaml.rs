//! YAML to the common tree: one document of the core schema, without tags, anchors and aliases.

use std::borrow::Cow;
use std::collections::HashSet;

use granit_parser::{Event, Parser, ScalarStyle, Span, StrInput};

use super::{Key, MAX_NESTING, Tree, Value};
use crate::error::{Fault, Refusal, shown};

impl<'s> Tree<'s> {
    /// Parses YAML, unless it nests too deeply.
    pub(crate) fn from_yaml(text: &'s str) -> Result<Self, Fault> {
        let options = granit_parser::options! {
            flow_nesting_limit: MAX_NESTING,
            block_nesting_limit: MAX_NESTING,
            emit_unresolved_aliases: true,
        };
        let mut events = Events { text, parser: Parser::new_from_str_with_options(text, options) };
        let mut root = None;
        loop {
            let (event, at, span) = events.next()?;
            match event {
                Event::StreamEnd => break,
                event if event.is_node() && root.is_none() => root = Some(events.tree(event, at, span)?),
                event if event.is_node() => {
                    let problem = "a second document begins here";
                    return Err(Fault::new(at, Refusal::Syntax, problem, "one document"));
                }
                _ => {}
            }
        }
        // Only comments: a workload without any key.
        Ok(root.unwrap_or(Self { at: 0, source: "", value: Value::Table(Vec::new()) }))
    }
}

struct Events<'s> {
    text: &'s str,
    parser: Parser<'s, StrInput<'s>>,
}

impl<'s> Events<'s> {
    fn next(&mut self) -> Result<(Event<'s>, usize, Span), Fault> {
        match self.parser.next_event() {
            Some(Ok((event, span))) => Ok((event, span.start.byte_offset().unwrap_or(0), span)),
            Some(Err(error)) => Err(self.refused(&error)),
            None => Ok((Event::StreamEnd, self.text.len(), Span::default())),
        }
    }

    fn refused(&self, error: &granit_parser::ScanError) -> Fault {
        let at = error.marker().byte_offset().unwrap_or(0);
        let info = error.info();
        if *error.kind() == granit_parser::ErrorKind::RecursionLimitExceeded {
            let expected = format!("at most {MAX_NESTING} levels of tables and lists");
            return Fault::new(at, Refusal::Nesting, "tables or lists nest too deeply here", expected);
        }
        if at >= self.text.trim_end().len() {
            let problem = format!("the file ends in the middle of a value: {info}");
            return Fault::new(at, Refusal::Syntax, problem, "a complete file");
        }
        Fault::new(at, Refusal::Syntax, format!("this is not YAML: {info}"), "YAML, indented with spaces")
    }

    /// The value that starts with this event.
    fn tree(&mut self, event: Event<'s>, at: usize, span: Span) -> Result<Tree<'s>, Fault> {
        refuse_references(&event, at)?;
        let value = match event {
            Event::Scalar(text, ScalarStyle::Plain, ..) => plain(text),
            Event::Scalar(text, ..) => Value::Text(text),
            Event::SequenceStart(..) => self.list()?,
            _ => self.table()?,
        };
        Ok(Tree { at, source: span.slice(self.text).unwrap_or_default(), value })
    }

    fn list(&mut self) -> Result<Value<'s>, Fault> {
        let mut items = Vec::new();
        loop {
            match self.next()? {
                (Event::SequenceEnd, ..) => return Ok(Value::List(items)),
                (event, at, span) => items.push(self.tree(event, at, span)?),
            }
        }
    }

    fn table(&mut self) -> Result<Value<'s>, Fault> {
        let mut entries = Vec::new();
        let mut names = HashSet::new();
        loop {
            let key = match self.next()? {
                (Event::MappingEnd, ..) => return Ok(Value::Table(entries)),
                (event, at, _) => key(event, at)?,
            };
            if !names.insert(key.name.clone()) {
                let problem = format!("the key `{}` stands in this table twice", shown(&key.name));
                return Err(Fault::new(key.at, Refusal::DuplicateKey, problem, "each key once"));
            }
            let (event, at, span) = self.next()?;
            let value = self.tree(event, at, span)?;
            entries.push((key, value));
        }
    }
}

fn key(event: Event<'_>, at: usize) -> Result<Key<'_>, Fault> {
    refuse_references(&event, at)?;
    match event {
        Event::Scalar(name, ..) => Ok(Key { name, at }),
        _ => Err(Fault::new(at, Refusal::Syntax, "a key is a table or a list", "a word as the key")),
    }
}

/// Aliases are refused rather than followed: a few lines of them can stand for more values than memory holds.
fn refuse_references(event: &Event<'_>, at: usize) -> Result<(), Fault> {
    let problem = match event {
        Event::Alias(_) | Event::UnresolvedAlias(_) => "workload files have no aliases",
        event if event.anchor_id().is_some() => "workload files have no anchors",
        event if event.tag().is_some() => "workload files have no tags",
        _ => return Ok(()),
    };
    Err(Fault::new(at, Refusal::Syntax, problem, "the value itself, written out"))
}

/// What a scalar without quotes stands for in the core schema.
fn plain(text: Cow<'_, str>) -> Value<'_> {
    let (base, digits) = match text.as_bytes() {
        [b'0', b'x', ..] => (16, &text[2..]),
        [b'0', b'o', ..] => (8, &text[2..]),
        [b'+' | b'-', ..] => (10, &text[1..]),
        _ => (10, &text[..]),
    };
    if !digits.is_empty() && digits.chars().all(|c| c.is_digit(base)) {
        let number = if base == 10 { &text } else { digits };
        return Value::Integer(i64::from_str_radix(number, base).ok());
    }
    match text.as_ref() {
        "" | "~" | "null" | "Null" | "NULL" => Value::Nothing,
        "true" | "True" | "TRUE" => Value::Boolean(true),
        "false" | "False" | "FALSE" => Value::Boolean(false),
        _ if is_fraction(digits) => Value::Other("the fraction"),
        _ => Value::Text(text),
    }
}

fn is_fraction(unsigned: &str) -> bool {
    let is_number = unsigned.starts_with(|c: char| c == '.' || c.is_ascii_digit());
    let is_special = matches!(unsigned, ".inf" | ".Inf" | ".INF" | ".nan" | ".NaN" | ".NAN");
    is_special || (is_number && unsigned.parse::<f64>().is_ok())
}
