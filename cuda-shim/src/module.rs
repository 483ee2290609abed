//! Modules and their kernels.

use crate::error::CudaError;
use crate::{Device, result};
use std::ffi::{CStr, CString};
use std::fmt;
use std::sync::Arc;

/// Loaded kernels, of PTX text or a cubin.
#[derive(Clone, Debug)]
pub struct Module(Arc<Loaded>);

#[derive(Debug)]
struct Loaded {
    handle: result::Module,
    _device: Device,
}

/// A module could not be loaded.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ModuleError {
    /// It is neither PTX text nor a whole cubin.
    Format(&'static str),
    /// The driver does not take it; what its assembler found wrong.
    Driver(CudaError, String),
}

impl fmt::Display for ModuleError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Format(expected) => f.write_str(expected),
            Self::Driver(error, words) if words.is_empty() => error.fmt(f),
            Self::Driver(error, words) => write!(f, "{error}; its assembler said: {}", words.trim_end()),
        }
    }
}

impl std::error::Error for ModuleError {}

impl Module {
    /// Loads what a file holds: PTX text, which the driver assembles for its device, or a cubin.
    ///
    /// # Errors
    /// [`ModuleError`].
    pub fn load(device: Device, image: &[u8]) -> Result<Self, ModuleError> {
        let loaded = if image.starts_with(MAGIC) {
            is_whole(image).ok_or(ModuleError::Format("a cubin that is cut short"))?;
            result::module_load_binary(image)
        } else {
            let text = CString::new(image).map_err(|_| NEITHER)?;
            if !text.to_str().is_ok_and(|text| text.contains(".version")) {
                return Err(NEITHER);
            }
            result::module_load(&text)
        };
        let handle = loaded.map_err(|(error, words)| ModuleError::Driver(error, words))?;
        Ok(Self(Arc::new(Loaded { handle, _device: device })))
    }

    /// A kernel of the module, to be run with so many blocks of so many threads.
    ///
    /// # Errors
    /// The driver's: not found, where there is none of this name.
    pub fn kernel(&self, name: &CStr, grid: [u32; 3], block: [u32; 3]) -> Result<Kernel, CudaError> {
        let function = result::module_function(&self.0.handle, name)?;
        Ok(Kernel { function, grid, block, _module: self.clone() })
    }
}

const NEITHER: ModuleError = ModuleError::Format("neither PTX text nor a cubin");
/// Of an ELF file of 64 bits in little endian, as cubins are.
const MAGIC: &[u8] = b"\x7fELF\x02\x01";

/// Whether the driver stays within a cubin when it follows the tables: of segments and of sections, and what they name.
fn is_whole(image: &[u8]) -> Option<()> {
    /// Bytes of an entry of the tables.
    const SEGMENT: u64 = 56;
    const SECTION: u64 = 64;
    /// A section of this type has no bytes in the file.
    const NO_BITS: u64 = 8;
    let number = |at: u64, bytes: usize| {
        let at = usize::try_from(at).ok()?;
        let field = image.get(at..at.checked_add(bytes)?)?;
        Some(field.iter().rev().fold(0_u64, |number, byte| number << 8 | u64::from(*byte)))
    };
    let is_within = |at: u64, bytes: u64| {
        at.checked_add(bytes).is_some_and(|end| end <= image.len() as u64).then_some(())
    };
    let (segments, sections) = (number(32, 8)?, number(40, 8)?);
    let [segment_size, segment_count, section_size, section_count] =
        [number(54, 2)?, number(56, 2)?, number(58, 2)?, number(60, 2)?];
    for segment in 0..segment_count {
        let at = segments.checked_add(segment * segment_size)?;
        is_within(at, SEGMENT)?;
        is_within(number(at.checked_add(8)?, 8)?, number(at.checked_add(32)?, 8)?)?;
    }
    for section in 0..section_count {
        let at = sections.checked_add(section * section_size)?;
        is_within(at, SECTION)?;
        if number(at.checked_add(4)?, 4)? != NO_BITS {
            is_within(number(at.checked_add(24)?, 8)?, number(at.checked_add(32)?, 8)?)?;
        }
    }
    Some(())
}

/// A kernel, and how many threads run it.
#[derive(Debug)]
pub struct Kernel {
    function: result::Function,
    pub(crate) grid: [u32; 3],
    pub(crate) block: [u32; 3],
    _module: Module,
}

impl Kernel {
    pub(crate) const fn function(&self) -> &result::Function {
        &self.function
    }
}

/// Arguments of a kernel, of eight bytes at most each: numbers, and addresses of buffers. A kernel that has more
/// parameters finds zeros.
#[derive(Debug)]
pub struct Arguments(pub(crate) result::Arguments);

impl Arguments {
    /// So many zeros.
    #[must_use]
    pub fn new(count: usize) -> Self {
        Self(result::Arguments::new(count))
    }

    /// Sets one by its bits; a parameter shorter than eight bytes takes the low ones.
    ///
    /// # Panics
    /// There are not so many.
    pub fn set(&mut self, at: usize, bits: u64) {
        self.0.set(at, bits);
    }
}
