//! The statuses that the header allows each function: those of its `Errors:`, and what may be wrong with the kinds of
//! arguments that it has.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use red_ffi::red_status;

const TEXT: &str = include_str!("../../../ffi/include/red.h");

/// Several statuses, a bit each.
#[derive(Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Statuses(u128);

impl Statuses {
    pub(crate) const NONE: Self = Self(0);

    pub(crate) const fn of(all: &[red_status]) -> Self {
        let (mut bits, mut i) = (0, 0);
        while i < all.len() {
            bits |= 1 << all[i] as u32;
            i += 1;
        }
        Self(bits)
    }

    pub(crate) const fn add(&mut self, status: red_status) {
        self.0 |= 1 << status as u32;
    }

    pub(crate) const fn join(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    pub(crate) const fn has(self, status: red_status) -> bool {
        self.0 >> status as u32 & 1 != 0
    }

    pub(crate) const fn is_empty(self) -> bool {
        self.0 == 0
    }
}

impl std::fmt::Debug for Statuses {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_set().entries(red_status::ALL.iter().filter(|status| self.has(**status))).finish()
    }
}

/// Of every function that answers a status: which.
static ALLOWED: LazyLock<BTreeMap<&str, Statuses>> = LazyLock::new(read);

/// Names of all functions that answer a status.
pub(crate) fn functions() -> impl Iterator<Item = &'static str> {
    ALLOWED.keys().copied()
}

pub(crate) fn allows(function: &str, status: red_status) -> bool {
    let allowed = ALLOWED.get(function).unwrap_or_else(|| panic!("{function} is not in the header"));
    status == red_status::Ok || allowed.has(status)
}

/// A status by the word that the header has for it.
fn by_name(word: &str) -> Option<red_status> {
    let plain = |name: &str| name.replace('_', "").to_lowercase();
    let name = word.strip_prefix("RED_STATUS_")?;
    red_status::ALL.iter().copied().find(|status| plain(&format!("{status:?}")) == plain(name))
}

struct Function {
    name: &'static str,
    comment: String,
    parameters: &'static str,
}

fn read() -> BTreeMap<&'static str, Statuses> {
    let functions: Vec<Function> = TEXT.split("/**").filter_map(function).collect();
    let errors = |function: &Function| {
        let words = function.comment.split_once("Errors:").map_or("", |(_, errors)| errors);
        words.split(|c: char| !c.is_ascii_alphanumeric() && c != '_').map(str::to_owned).collect::<Vec<_>>()
    };
    // "as red_x" may lead to another "as"; "those of the nodes" are those of adding one.
    let named = |function: &Function| {
        let mut found = Statuses::NONE;
        let mut open = vec![function.name];
        let mut seen: Vec<&str> = Vec::new();
        while let Some(name) = open.pop() {
            let Some(function) = functions.iter().find(|f| f.name == name).filter(|_| !seen.contains(&name))
            else {
                continue;
            };
            seen.push(name);
            for word in errors(function) {
                by_name(&word).into_iter().for_each(|status| found.add(status));
                open.extend(functions.iter().find(|f| f.name == word).map(|f| f.name));
                if word == "nodes" {
                    open.push("red_dag_add_node");
                }
            }
        }
        found
    };
    functions.iter().map(|f| (f.name, named(f).join(of_arguments(f.parameters)))).collect()
}

/// A comment and the prototype behind it.
fn function(piece: &'static str) -> Option<Function> {
    let (comment, rest) = piece.split_once("*/")?;
    let prototype = rest.trim_start().strip_prefix("red_status ")?;
    let (name, parameters) = prototype.split_once('(')?;
    let parameters = parameters.split_once(");")?.0;
    Some(Function { name, comment: comment.replace("\n *", " "), parameters })
}

/// What can be wrong with any argument of these types.
fn of_arguments(parameters: &str) -> Statuses {
    use red_status::*;
    let mut found = Statuses::NONE;
    for parameter in parameters.split(',').filter(|parameter| parameter.contains('*')) {
        found = found.join(Statuses::of(&[NullPointer, Misaligned]));
        let of = parameter.split('*').next().unwrap_or("").trim();
        let kind = of.strip_prefix("const ").unwrap_or(of);
        if matches!(kind, "red_scheduler" | "red_dag" | "red_runtime") {
            found = found.join(Statuses::of(&[Closed, Foreign, OtherKind]));
        }
        if matches!(kind, "red_scheduler" | "red_dag") {
            found.add(Busy);
        }
        let body = TEXT
            .split_once(&format!("}} {kind};"))
            .and_then(|(before, _)| before.rsplit("typedef struct").next());
        if body.is_some_and(|body| body.contains("uint32_t struct_size;")) {
            found = found.join(Statuses::of(&[StructSize, Version]));
            if of != kind {
                found.add(UnknownField);
            }
        }
    }
    // Arrays, and memory: something has a length.
    if parameters.contains("size_t ") {
        found.add(TooLong);
    }
    found
}
