//! TOML to the common tree.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};
use toml_parser::Source;
use toml_parser::lexer::TokenKind;

use super::{Fields, Key, MAX_NESTING, Tree, Value};
use crate::error::{Fault, Refusal, shown};

impl<'s> Tree<'s> {
    /// Parses TOML, unless it nests too deeply. The whole is `owner`, with these keys.
    pub(crate) fn from_toml(
        text: &'s str,
        owner: &'static str,
        keys: &[&'static str],
    ) -> Result<Self, Fault> {
        refuse_deep_nesting(text)?;
        let (root, errors) = DeTable::parse_recoverable(text);
        let root = Self { at: 0, source: "", value: table(text, root.into_inner()) };
        let Some(error) = errors.first() else {
            return Ok(root);
        };
        let fault = refused(text, error);
        // Below a misspelt `[[Task]]`, a `[task.node]` makes the next `[[task]]` one too many.
        let misspelt = |first: &Fault| fault.refusal == Refusal::DuplicateKey && first.at < fault.at;
        Err(Fields::open(&root, owner, keys).err().filter(misspelt).unwrap_or(fault))
    }
}

/// Brackets and dotted keys both nest, and the parser recurses over dotted keys without a bound of its own.
fn refuse_deep_nesting(text: &str) -> Result<(), Fault> {
    let mut brackets = 0_usize;
    let mut dots = 0;
    for token in Source::new(text).lex() {
        match token.kind() {
            TokenKind::LeftSquareBracket | TokenKind::LeftCurlyBracket => brackets += 1,
            TokenKind::RightSquareBracket | TokenKind::RightCurlyBracket => {
                brackets = brackets.saturating_sub(1);
            }
            TokenKind::Dot => dots += 1,
            TokenKind::Newline | TokenKind::Comma | TokenKind::Equals => dots = 0,
            _ => {}
        }
        if brackets.max(dots) > MAX_NESTING {
            let expected = format!("at most {MAX_NESTING} levels of tables and lists");
            let problem = "tables or lists nest too deeply here";
            return Err(Fault::new(token.span().start(), Refusal::Nesting, problem, expected));
        }
    }
    Ok(())
}

fn refused(text: &str, error: &toml::de::Error) -> Fault {
    let span = error.span().unwrap_or(0..0);
    if error.message() == "duplicate key" {
        let problem = format!("the key `{}` stands in this table twice", shown(slice(text, span.clone())));
        return Fault::new(span.start, Refusal::DuplicateKey, problem, "each key once");
    }
    if span.start >= text.trim_end().len() {
        let problem = format!("the file ends in the middle of a value: {}", error.message());
        return Fault::new(span.start, Refusal::Syntax, problem, "a complete file");
    }
    let problem = format!("this is not TOML: {}", error.message());
    Fault::new(
        span.start,
        Refusal::Syntax,
        problem,
        "TOML; texts, times and amounts of memory stand in quotes",
    )
}

fn table<'s>(text: &'s str, entries: DeTable<'s>) -> Value<'s> {
    let mut entries: Vec<_> = entries
        .into_iter()
        .map(|(key, value)| {
            let at = key.span().start;
            (Key { name: key.into_inner(), at }, tree(text, value))
        })
        .collect();
    // The parser sorts by name; the first fault in the text should be the one that is told.
    entries.sort_by_key(|(key, _)| key.at);
    Value::Table(entries)
}

fn tree<'s>(text: &'s str, value: Spanned<DeValue<'s>>) -> Tree<'s> {
    let span = value.span();
    let at = span.start;
    let value = match value.into_inner() {
        DeValue::String(value) => Value::Text(value),
        DeValue::Integer(value) => Value::Integer(i64::from_str_radix(value.as_str(), value.radix()).ok()),
        DeValue::Boolean(value) => Value::Boolean(value),
        DeValue::Float(_) => Value::Other("the fraction"),
        DeValue::Datetime(_) => Value::Other("the date"),
        DeValue::Array(items) => Value::List(items.into_iter().map(|item| tree(text, item)).collect()),
        DeValue::Table(entries) => table(text, entries),
    };
    Tree { at, source: slice(text, span), value }
}

fn slice(text: &str, span: Range<usize>) -> &str {
    text.get(span).unwrap_or_default()
}
