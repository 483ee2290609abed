//! Weakens every memory ordering of the modelled files once, each of which a model has to catch: what is not caught is
//! too strong, or not modelled.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::ExitCode;

use crate::copy;
use crate::loom::{Model, Models, Row, Verdict};
use crate::process::Failure;
use crate::workspace::{Workspace, entries};

/// Folders whose orderings are looked at.
const SOURCES: [&str; 2] = ["sync/src", "rt-linux/src"];
/// Where the models are, whose heads name the files that they are about.
const MODELS: &str = "loom-tests/tests";
const HEAD: &str = "//! *Sources.*";
/// What marks an ordering that matters only where a load takes effect after a later store, which the checker does not
/// try: in the comment above it.
const BEYOND: &str = "load buffering";
/// For a model, in seconds: how busy the machine is must not decide.
const PATIENCE: u32 = 1_200;

/// One ordering, and a weaker one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Mutant {
    file: String,
    line: usize,
    /// Where the ordering's name begins and ends in the file.
    at: (usize, usize),
    strong: &'static str,
    weak: &'static str,
    is_beyond: bool,
}

/// What an ordering may be weakened to: one step, and by what it does in its place.
const WEAKER: [(&str, &[&str]); 4] = [
    ("Acquire", &["Relaxed"]),
    ("Release", &["Relaxed"]),
    ("AcqRel", &["Acquire", "Release"]),
    ("SeqCst", &["Acquire", "Release", "AcqRel"]),
];

/// `cargo xtask loom --mutants [FILE]...`
pub(crate) fn run(workspace: &Workspace, files: &[&str]) -> Result<ExitCode, Failure> {
    let families = families(workspace)?;
    let mut mutants = Vec::new();
    let mut not_modelled = Vec::new();
    for file in sources(workspace)? {
        let found = mutants_of(&file, &read(&workspace.root.join(&file))?);
        if families.iter().any(|(of, _)| *of == file) {
            mutants.extend(found);
        } else if !found.is_empty() {
            not_modelled.push((file, found.len()));
        }
    }
    if let Some(unknown) = files.iter().find(|name| !mutants.iter().any(|m| m.file.contains(*name))) {
        let mut known: Vec<&str> = mutants.iter().map(|mutant| &*mutant.file).collect();
        known.dedup();
        return Err(Failure::Wrong(format!(
            "no modelled file {unknown:?} with an ordering to weaken; there are {}",
            known.join(", ")
        )));
    }
    mutants.retain(|mutant| files.is_empty() || files.iter().any(|file| mutant.file.contains(file)));
    if mutants.is_empty() {
        return Err(Failure::Wrong("there is no ordering to weaken in the modelled files".to_owned()));
    }
    let tree = copy::of(workspace, "loom-mutants")?;
    let models = Models { workspace, root: &tree, deep: false, seconds: Some(PATIENCE) };
    let belong = |mutant: &Mutant| -> Vec<String> {
        families.iter().filter(|(of, _)| *of == mutant.file).map(|(_, family)| family.clone()).collect()
    };
    let mut wanted: Vec<String> = mutants.iter().flat_map(belong).collect();
    wanted.sort();
    wanted.dedup();
    say!("{} weakenings; first the models where nothing is weakened", mutants.len());
    let costs = costs(&models.run(&without_planted(models.build(&wanted)?)))?;
    let (mut caught, mut beyond) = (0, 0);
    for (number, mutant) in mutants.iter().enumerate() {
        let mut belongs = belong(mutant);
        // The file's own models first, as they are made for it; then the cheapest.
        belongs.sort_by_key(|family| {
            let of_family = costs.iter().filter(|((of, _), _)| of == family).map(|(_, tenths)| *tenths);
            (!mutant.file.ends_with(&format!("/{family}.rs")), of_family.sum::<u64>())
        });
        let verdict = try_one(&models, mutant, &belongs, &costs)?;
        match &verdict {
            Some(_) => caught += 1,
            None if mutant.is_beyond => beyond += 1,
            None => {}
        }
        let words = match verdict {
            Some(model) => format!("caught by {model}"),
            None if mutant.is_beyond => "kept: load buffering, which the checker does not try".into(),
            None => "NOT CAUGHT".into(),
        };
        let Mutant { file, line, strong, weak, .. } = mutant;
        say!("{:>3}/{} {file}:{line} {strong} -> {weak}: {words}", number + 1, mutants.len());
    }
    let orderings: usize = not_modelled.iter().map(|(_, count)| count).sum();
    say!("\n{orderings} weakenings are of orderings that are not modelled");
    not_modelled.iter().for_each(|(file, count)| say!("  {file}: {count}"));
    let wanted = mutants.len() - beyond;
    say!("\n{caught} of {wanted} caught; {beyond} beyond what the checker tries");
    Ok(if caught == wanted { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// What each model costs where nothing is weakened, in tenths of a second, by its family and name.
type Costs = BTreeMap<(String, String), u64>;

/// # Errors
/// A model does not pass where nothing is weakened: it would catch everything, or nothing.
fn costs(rows: &[Row]) -> Result<Costs, Failure> {
    let wrong: Vec<String> =
        rows.iter().filter(|row| row.verdict != Verdict::Explored).map(Row::name).collect();
    if rows.is_empty() || !wrong.is_empty() {
        let list = if rows.is_empty() { "there are none".to_owned() } else { wrong.join(", ") };
        return Err(Failure::Wrong(format!("models that do not pass where nothing is weakened: {list}")));
    }
    Ok(rows.iter().map(|row| ((row.model.family.clone(), row.model.name.clone()), row.tenths())).collect())
}

/// A model with a planted fault fails by itself.
fn without_planted(mut models: Vec<Model>) -> Vec<Model> {
    models.retain(|model| !model.is_planted());
    models
}

/// The first model that fails with this mutant, if one does. Of each family the cheapest are tried first, and no family
/// is built before those ahead of it have let the mutant pass.
fn try_one(
    models: &Models<'_>,
    mutant: &Mutant,
    families: &[String],
    costs: &Costs,
) -> Result<Option<String>, Failure> {
    let (path, original) = (models.root.join(&mutant.file), models.workspace.root.join(&mutant.file));
    let text = read(&original)?;
    write(&path, &format!("{}{}{}", &text[..mutant.at.0], mutant.weak, &text[mutant.at.1..]))?;
    let mut caught = None;
    for family in families {
        let mut built = without_planted(models.build(std::slice::from_ref(family))?);
        built.sort_by_cached_key(|model| costs.get(&(model.family.clone(), model.name.clone())).copied());
        let fails = |model: &Model| models.run_one(model).verdict == Verdict::Failed;
        if let Some(model) = built.iter().find(|model| fails(model)) {
            caught = Some(format!("{}: {}", model.family, model.name));
            break;
        }
    }
    write(&path, &text)?;
    Ok(caught)
}

/// Every weakening of the orderings that are no part of a comment, and that stand before the file's tests.
pub(crate) fn mutants_of(file: &str, text: &str) -> Vec<Mutant> {
    let mut found = Vec::new();
    let (mut start, mut comment) = (0, String::new());
    for (number, line) in text.split_inclusive('\n').enumerate() {
        let code = line.split("//").next().unwrap_or_default();
        if line.trim_start().starts_with("//") {
            comment.push_str(line);
        }
        for (at, _) in code.match_indices("Ordering::") {
            let name = at + "Ordering::".len();
            let Some((strong, weaker)) = WEAKER.iter().find(|(strong, _)| {
                code[name..].strip_prefix(strong).is_some_and(|rest| !rest.starts_with(char::is_alphanumeric))
            }) else {
                continue;
            };
            found.extend(weaker.iter().map(|weak| Mutant {
                file: file.into(),
                line: number + 1,
                at: (start + name, start + name + strong.len()),
                strong,
                weak,
                is_beyond: comment.contains(BEYOND),
            }));
        }
        if code.trim_end().ends_with([';', '{', '}']) {
            comment.clear();
        }
        start += line.len();
    }
    // Only what the call allows: stores do not acquire, loads do not release.
    found.retain(|mutant| match (call(&text[..mutant.at.0]), mutant.weak) {
        ("store", weak) => !matches!(weak, "Acquire" | "AcqRel"),
        ("load", weak) => !matches!(weak, "Release" | "AcqRel"),
        _ => true,
    });
    found
}

/// The function whose arguments are open at the end of this text.
fn call(text: &str) -> &str {
    let mut closed = 0;
    let open = text.char_indices().rev().find(|(_, c)| {
        closed += i32::from(*c == ')') - i32::from(*c == '(');
        closed < 0
    });
    let name = open.map_or("", |(at, _)| &text[..at]);
    &name[name.rfind(|c: char| !c.is_alphanumeric() && c != '_').map_or(0, |at| at + 1)..]
}

/// Which models belong to which file, by what their heads say. Every file that they name is there.
fn families(workspace: &Workspace) -> Result<Vec<(String, String)>, Failure> {
    let mut families = Vec::new();
    for path in entries(&workspace.root.join(MODELS))? {
        let family = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let text = read(&path)?;
        let head = text
            .lines()
            .find_map(|line| line.strip_prefix(HEAD))
            .ok_or_else(|| Failure::Wrong(format!("{}: the head has no line `{HEAD}`", path.display())))?;
        for file in head.split('`').skip(1).step_by(2) {
            if !workspace.root.join(file).is_file() {
                return Err(Failure::Wrong(format!("{MODELS}/{family}.rs names {file}, which is not there")));
            }
            families.push((file.to_owned(), family.clone()));
        }
    }
    families.sort();
    Ok(families)
}

/// Source files, tests left out.
fn sources(workspace: &Workspace) -> Result<Vec<String>, Failure> {
    let mut found = Vec::new();
    for folder in SOURCES {
        for path in entries(&workspace.root.join(folder))? {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            if name.ends_with(".rs") {
                found.push(format!("{folder}/{name}"));
            }
        }
    }
    found.sort();
    Ok(found)
}

fn read(path: &Path) -> Result<String, Failure> {
    fs::read_to_string(path).map_err(Failure::of_file(path))
}

fn write(path: &Path, text: &str) -> Result<(), Failure> {
    fs::write(path, text).map_err(Failure::of_file(path))
}

#[cfg(test)]
mod tests;
