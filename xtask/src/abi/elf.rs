//! What object files and libraries say of themselves. Read with our own reader: binutils that have the plugin of another
//! compiler take bitcode for the object that it lies in.

use std::collections::{BTreeSet, HashSet};

use object::read::archive::ArchiveFile;
use object::read::elf::FileHeader;
use object::{Endianness, File, Object, ObjectSection, ObjectSymbol, RelocationTarget, elf};

/// What links with it sees of a library or an object file, and all names inside.
#[derive(Debug, Default)]
pub(crate) struct Names {
    /// Defined, for others.
    pub(crate) exports: BTreeSet<String>,
    /// To be defined by others.
    pub(crate) imports: BTreeSet<String>,
    /// Of anything that is there, also what nobody else sees.
    pub(crate) inside: BTreeSet<String>,
}

impl Names {
    fn take<'a>(&mut self, symbol: &impl ObjectSymbol<'a>) -> object::Result<()> {
        let name = symbol.name()?;
        if name.is_empty() {
            return Ok(());
        }
        if symbol.is_undefined() {
            self.imports.insert(name.to_owned());
        } else {
            self.inside.insert(name.to_owned());
            if symbol.is_global() {
                self.exports.insert(name.to_owned());
            }
        }
        Ok(())
    }
}

/// What the loader is told about a program or a shared library.
#[derive(Debug, Default)]
pub(crate) struct Loaded {
    pub(crate) soname: Option<String>,
    pub(crate) needed: Vec<String>,
}

/// The names of all members of an archive together.
///
/// # Errors
/// It is none.
pub(crate) fn archive(bytes: &[u8]) -> object::Result<Names> {
    let mut names = Names::default();
    for member in ArchiveFile::parse(bytes)?.members() {
        let file = File::parse(member?.data(bytes)?)?;
        for symbol in file.symbols() {
            names.take(&symbol)?;
        }
    }
    let Names { exports, imports, .. } = &mut names;
    imports.retain(|name| !exports.contains(name));
    Ok(names)
}

/// The names of a shared library: outside those that the loader sees, inside all.
///
/// # Errors
/// It is none.
pub(crate) fn shared(bytes: &[u8]) -> object::Result<Names> {
    let file = File::parse(bytes)?;
    let (mut seen, mut all) = (Names::default(), Names::default());
    for symbol in file.dynamic_symbols() {
        seen.take(&symbol)?;
    }
    for symbol in file.symbols() {
        all.take(&symbol)?;
    }
    Ok(Names { inside: all.inside, ..seen })
}

/// # Errors
/// It is no program or library of a 64-bit machine.
pub(crate) fn loaded(bytes: &[u8]) -> object::Result<Loaded> {
    let header = elf::FileHeader64::<Endianness>::parse(bytes)?;
    let endian = header.endian()?;
    let table = header.sections(endian, bytes)?.dynamic_table(endian, bytes)?;
    let mut loaded = Loaded::default();
    for entry in &table {
        let text = || table.string(entry).map(|text| String::from_utf8_lossy(text).into_owned());
        match entry.tag {
            elf::DT_NEEDED => loaded.needed.push(text()?),
            elf::DT_SONAME => loaded.soname = Some(text()?),
            _ => {}
        }
    }
    Ok(loaded)
}

/// Names to be defined by others that nothing in an object file uses any more: what used them was thrown away.
///
/// # Errors
/// It is none.
pub(crate) fn unused_imports(bytes: &[u8]) -> object::Result<Vec<String>> {
    let file = File::parse(bytes)?;
    let mut used = HashSet::new();
    for section in file.sections() {
        for (_, relocation) in section.relocations() {
            if let RelocationTarget::Symbol(index) = relocation.target() {
                used.insert(index);
            }
        }
    }
    let unused = file.symbols().filter(|symbol| symbol.is_undefined() && !used.contains(&symbol.index()));
    let names = unused.map(|symbol| symbol.name().map(str::to_owned)).collect::<object::Result<Vec<_>>>()?;
    Ok(names.into_iter().filter(|name| !name.is_empty()).collect())
}
