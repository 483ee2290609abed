//! What can be reached in an archive of object files: sections, and from each the symbols that its relocations name.

use std::collections::{BTreeMap, BTreeSet, HashMap, VecDeque};

use object::read::archive::ArchiveFile;
use object::{Object, ObjectSection, ObjectSymbol, RelocationTarget, SectionIndex, SymbolIndex};

/// What was found from the entries on.
pub(crate) struct Found {
    /// Names of the entries.
    pub(crate) entries: BTreeSet<String>,
    /// How many sections were reached; a function has one of its own.
    pub(crate) reached: usize,
    /// The way from an entry to each function that uses something forbidden, and that.
    pub(crate) paths: Vec<String>,
}

/// A section of a member of the archive.
type Place = (usize, SectionIndex);

/// Follows all references from the symbols that `is_entry` names. Forbidden is a name that contains one of
/// `forbidden`, or that is defined nowhere and not one of `outside`.
///
/// # Errors
/// The archive cannot be read.
pub(crate) fn from_entries(
    bytes: &[u8],
    is_entry: &dyn Fn(&str) -> bool,
    outside: &[&str],
    forbidden: &[&str],
) -> object::Result<Found> {
    let archive = ArchiveFile::parse(bytes)?;
    let mut files = Vec::new();
    for member in archive.members() {
        files.push(object::File::parse(member?.data(bytes)?)?);
    }
    let mut defined: BTreeMap<&str, Place> = BTreeMap::new();
    let (mut entries, mut open) = (BTreeSet::new(), VecDeque::new());
    // How each place was reached first: names from the entry on.
    let mut ways: HashMap<Place, String> = HashMap::new();
    for (number, file) in files.iter().enumerate() {
        for symbol in file.symbols().filter(|symbol| symbol.is_definition() && symbol.is_global()) {
            let (Some(section), name) = (symbol.section_index(), symbol.name()?) else { continue };
            defined.entry(name).or_insert((number, section));
            if is_entry(name) {
                entries.insert(name.to_owned());
                ways.insert((number, section), name.to_owned());
                open.push_back((number, section));
            }
        }
    }
    let mut paths = BTreeMap::new();
    while let Some((number, section)) = open.pop_front() {
        let (file, way) = (&files[number], ways[&(number, section)].clone());
        for (_, relocation) in file.section_by_index(section)?.relocations() {
            let RelocationTarget::Symbol(index) = relocation.target() else { continue };
            let (name, place) = follow(file, number, index, &defined)?;
            let is_forbidden = forbidden.iter().any(|part| name.contains(part))
                || place.is_none() && !outside.contains(&name);
            if is_forbidden {
                paths.insert((name.to_owned(), way.clone()), format!("{way} -> {name}"));
            } else if let Some(place) = place
                && !ways.contains_key(&place)
            {
                ways.insert(place, format!("{way} -> {name}"));
                open.push_back(place);
            }
        }
    }
    Ok(Found { entries, reached: ways.len(), paths: paths.into_values().collect() })
}

/// The name of a symbol and where it is defined, in its own file or another. What has no name but that of its section
/// goes by that one, which ends with the function's.
fn follow<'a>(
    file: &object::File<'a>,
    number: usize,
    index: SymbolIndex,
    defined: &BTreeMap<&str, Place>,
) -> object::Result<(&'a str, Option<Place>)> {
    let symbol = file.symbol_by_index(index)?;
    let mut name = symbol.name()?;
    if let (true, Some(section)) = (name.is_empty(), symbol.section_index()) {
        name = file.section_by_index(section)?.name()?;
    }
    let here = symbol.section_index().map(|section| (number, section));
    Ok((name, here.or_else(|| defined.get(name).copied())))
}
