//! Image loader: segments to memory, and symbols for names.

use object::elf::{EM_ARM, FileHeader32, PT_LOAD};
use object::read::elf::{ElfFile32, FileHeader, ProgramHeader};
use object::{LittleEndian, Object, ObjectSymbol, SymbolKind};

use crate::memory::Memory;

/// Reason for which an image is refused.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImageError {
    /// File that is not a readable ELF file.
    #[error("not a readable ELF file")]
    Unreadable(#[from] object::read::Error),
    /// File for another word size, byte order or machine.
    #[error("not for a little-endian 32-bit ARM processor")]
    NotArm,
    /// Entry point at an even address, which means 32-bit ARM code.
    #[error("the entry point {0:#010x} is not Thumb code")]
    NotThumb(u32),
    /// Image without symbols, which findings and profiles need for function names.
    #[error("stripped: there is no symbol table")]
    Stripped,
    /// Segment at an address without memory.
    #[error("the segment of {len} bytes at {address:#010x} lies outside of the part's memories")]
    Outside {
        /// Load address of the segment.
        address: u32,
        /// Length in the file.
        len: usize,
    },
    /// Image without a segment to load.
    #[error("nothing to load")]
    Empty,
}

/// Function of the image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Function {
    /// Address of the first instruction.
    pub address: u32,
    /// Length in bytes; 0 if the image does not state it.
    pub size: u32,
    /// Demangled name.
    pub name: String,
}

/// Functions and objects of the image by address and name.
#[derive(Clone, Debug, Default)]
pub struct Symbols {
    /// In order of addresses.
    functions: Vec<Function>,
    /// All symbols by their name in the file.
    addresses: std::collections::BTreeMap<String, u32>,
}

impl Symbols {
    /// Returns all functions, in order of their addresses.
    pub fn functions(&self) -> &[Function] {
        &self.functions
    }

    /// Returns the function that contains `address`.
    pub fn function(&self, address: u32) -> Option<&Function> {
        self.index(address).map(|index| &self.functions[index])
    }

    pub(crate) fn index(&self, address: u32) -> Option<usize> {
        let index = self.functions.partition_point(|function| function.address <= address).checked_sub(1)?;
        let function = &self.functions[index];
        (function.size == 0 || address - function.address < function.size).then_some(index)
    }

    /// Returns the address of a symbol by its name in the file; that of a function without its
    /// Thumb bit.
    pub fn address(&self, name: &str) -> Option<u32> {
        self.addresses.get(name).copied()
    }
}

/// Writes the segments to the memories. Returns the symbols and the lowest load address, which is
/// the address of the vector table.
pub(crate) fn load(file: &[u8], memory: &mut Memory) -> Result<(Symbols, u32), ImageError> {
    // The sixth byte is the byte order: 1 for little-endian.
    if object::FileKind::parse(file)? != object::FileKind::Elf32 || file.get(5) != Some(&1) {
        return Err(ImageError::NotArm);
    }
    let elf: ElfFile32<'_, LittleEndian> = ElfFile32::parse(file)?;
    let header: &FileHeader32<LittleEndian> = elf.elf_header();
    if header.e_machine(LittleEndian) != EM_ARM {
        return Err(ImageError::NotArm);
    }
    let entry = header.e_entry(LittleEndian);
    if entry & 1 == 0 {
        return Err(ImageError::NotThumb(entry));
    }
    let mut lowest = None;
    for segment in elf.elf_program_headers() {
        let (address, len) = (segment.p_paddr(LittleEndian), segment.p_filesz(LittleEndian) as usize);
        if segment.p_type(LittleEndian) != PT_LOAD || len == 0 {
            continue;
        }
        let bytes = segment.data(LittleEndian, file).map_err(|()| ImageError::Outside { address, len })?;
        memory.get_mut(address, len).ok_or(ImageError::Outside { address, len })?.copy_from_slice(bytes);
        lowest = Some(lowest.unwrap_or(address).min(address));
    }
    let symbols = symbols(&elf);
    if elf.symbol_table().is_none() || symbols.addresses.is_empty() {
        return Err(ImageError::Stripped);
    }
    Ok((symbols, lowest.ok_or(ImageError::Empty)?))
}

fn symbols(elf: &ElfFile32<'_, LittleEndian>) -> Symbols {
    let mut symbols = Symbols::default();
    for symbol in elf.symbols() {
        let Ok(name) = symbol.name() else { continue };
        // `$t` and `$d` mark code and data.
        let is_place = !symbol.is_undefined() && !matches!(symbol.kind(), SymbolKind::File | SymbolKind::Section);
        if name.is_empty() || name.starts_with('$') || !is_place {
            continue;
        }
        let is_code = symbol.kind() == SymbolKind::Text;
        let address = symbol.address() as u32 & if is_code { !1 } else { !0 };
        symbols.addresses.insert(name.to_owned(), address);
        if is_code {
            let name = format!("{:#}", rustc_demangle::demangle(name));
            symbols.functions.push(Function { address, size: symbol.size() as u32, name });
        }
    }
    // If an address has several names, one with a size comes last and is found.
    symbols.functions.sort_by_key(|function| (function.address, function.size));
    symbols
}
