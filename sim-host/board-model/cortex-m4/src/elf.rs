//! The image: segments into memory, symbols for names.

use object::elf::{EM_ARM, FileHeader32, PT_LOAD};
use object::read::elf::{ElfFile32, FileHeader, ProgramHeader};
use object::{LittleEndian, Object, ObjectSymbol, SymbolKind};

use crate::memory::Memory;

/// Why an image is refused.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImageError {
    /// The file is no ELF file that can be read.
    #[error("not a readable ELF file")]
    Unreadable(#[from] object::read::Error),
    /// The file is for another word size, byte order or machine.
    #[error("not for a little-endian 32-bit ARM processor")]
    NotArm,
    /// The entry point is at an even address, as ARM instructions of 32 bits have it.
    #[error("the entry point {0:#010x} is not Thumb code")]
    NotThumb(u32),
    /// There are no symbols, which every finding and profile names functions by.
    #[error("stripped: there is no symbol table")]
    Stripped,
    /// A segment lies where the part has no memory.
    #[error("the segment of {len} bytes at {address:#010x} lies outside of the part's memories")]
    Outside {
        /// Load address of the segment.
        address: u32,
        /// Its length in the file.
        len: usize,
    },
    /// Nothing is to be loaded.
    #[error("nothing to load")]
    Empty,
}

/// A function of the image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Function {
    /// Address of its first instruction.
    pub address: u32,
    /// Length in bytes; 0 where the image does not say.
    pub size: u32,
    /// Its demangled name.
    pub name: String,
}

/// The functions and objects of the image by address and name.
#[derive(Clone, Debug, Default)]
pub struct Symbols {
    /// In order of addresses.
    functions: Vec<Function>,
    /// All symbols as they are spelt in the file.
    addresses: std::collections::BTreeMap<String, u32>,
}

impl Symbols {
    /// All functions, in order of their addresses.
    pub fn functions(&self) -> &[Function] {
        &self.functions
    }

    /// The function that holds `address`.
    pub fn function(&self, address: u32) -> Option<&Function> {
        self.index(address).map(|index| &self.functions[index])
    }

    pub(crate) fn index(&self, address: u32) -> Option<usize> {
        let index = self.functions.partition_point(|function| function.address <= address).checked_sub(1)?;
        let function = &self.functions[index];
        (function.size == 0 || address - function.address < function.size).then_some(index)
    }

    /// The address of a symbol by its name in the file; that of a function without its Thumb bit.
    pub fn address(&self, name: &str) -> Option<u32> {
        self.addresses.get(name).copied()
    }
}

/// Writes the segments to the memories; the symbols, and the lowest load address, where the vector table is.
pub(crate) fn load(file: &[u8], memory: &mut Memory) -> Result<(Symbols, u32), ImageError> {
    // The sixth byte says the byte order: 1 for little-endian.
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
        // `$t`, `$d`: marks of code and data.
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
    // Of several names for one address that with a size comes last and is found.
    symbols.functions.sort_by_key(|function| (function.address, function.size));
    symbols
}
