//! File of a field update: a manifest followed by the image, as in the slot of a board.
//!
//! ```text
//! ELF file of `cargo field` -> bytes from ORIGIN on + SONOGLIDE_IDENTITY -> signed manifest -> file
//! ```

use nucleo_g474re::pages::{FLASH, SETTINGS};
use nucleo_g474re::slots::{MANIFEST, ORIGIN, SLOT};
use object::elf::{PT_LOAD, ProgramHeader32};
use object::read::elf::{ElfFile32, ProgramHeader as _};
use object::{LittleEndian, Object as _, ObjectSymbol as _};
use update::identity::{Identity, SIZE, SYMBOL};
use update::manifest::Manifest;

/// Reason why an ELF file cannot be packed as an update.
#[derive(Debug, thiserror::Error)]
pub enum PackError {
    /// The file is not a 32-bit ELF file.
    #[error("this is not an ELF file for the board: {0}")]
    Elf(#[from] object::Error),
    /// A segment lies outside the slot, or the part of the flash before the settings.
    #[error(
        "this image is not linked for {origin:#010x}: it has {len} bytes at {address:#010x}. `cargo field` builds for the slot \
         after the first stage ({ORIGIN:#010x}), `cargo fw` for a board without one ({FLASH:#010x})"
    )]
    Elsewhere {
        /// First address of the file.
        origin: u32,
        /// Address of the segment.
        address: u32,
        /// Length of the segment, bytes.
        len: usize,
    },
    /// The image does not begin at the beginning of the flash.
    #[error("this image does not start by itself: it has nothing at {FLASH:#010x}. Build it with `cargo fw`")]
    NotAlone,
    /// The image does not contain its identity.
    #[error("this image does not contain its identity, the constant `{SYMBOL}`. Build it with `cargo field`")]
    Anonymous,
}

/// Packs an ELF file as an update. It is not signed if no seed of a key is given.
pub fn pack(elf: &[u8], seed: Option<&[u8; 32]>) -> Result<Vec<u8>, PackError> {
    let file: ElfFile32<'_, LittleEndian> = ElfFile32::parse(elf)?;
    let image = image(&file, elf, ORIGIN, SLOT.size - MANIFEST)?;
    let symbol = file.symbols().find(|symbol| symbol.name() == Ok(SYMBOL)).ok_or(PackError::Anonymous)?;
    let place = (symbol.address() as u32).checked_sub(ORIGIN).ok_or(PackError::Anonymous)? as usize;
    let identity = image.get(place..place + SIZE).and_then(|bytes| bytes.try_into().ok()).ok_or(PackError::Anonymous)?;
    let manifest = Manifest::of(Identity::decode(identity), ORIGIN, &image);
    let manifest = seed.map_or(manifest, |seed| manifest.signed_by(seed));
    Ok([manifest.encode().as_slice(), &image].concat())
}

/// Returns the bytes of the flash from its beginning, for a programmer that takes no ELF file: the
/// ST-LINK of a Nucleo shows a drive to which such a file is copied.
pub fn flash_bytes(elf: &[u8]) -> Result<Vec<u8>, PackError> {
    let file: ElfFile32<'_, LittleEndian> = ElfFile32::parse(elf)?;
    if segments(&file).all(|header| header.p_paddr(LittleEndian) != FLASH) {
        return Err(PackError::NotAlone);
    }
    image(&file, elf, FLASH, SETTINGS.start - FLASH)
}

/// Returns the loaded bytes of an ELF file from an address on.
fn image(file: &ElfFile32<'_, LittleEndian>, elf: &[u8], origin: u32, room: u32) -> Result<Vec<u8>, PackError> {
    let mut image = Vec::new();
    for header in segments(file) {
        let (address, len) = (header.p_paddr(LittleEndian), header.p_filesz(LittleEndian) as usize);
        let elsewhere = || PackError::Elsewhere { address, len, origin };
        let from = address.checked_sub(origin).map(|from| from as usize).filter(|from| from + len <= room as usize);
        let from = from.ok_or_else(elsewhere)?;
        let bytes = header.data(LittleEndian, elf).map_err(|()| elsewhere())?;
        if image.len() < from + len {
            image.resize(from + len, 0xff);
        }
        image[from..from + len].copy_from_slice(bytes);
    }
    Ok(image)
}

/// Returns the offset of the identity in an ELF file, at which a test can change the version.
pub fn identity_offset(elf: &[u8]) -> Result<usize, PackError> {
    let file: ElfFile32<'_, LittleEndian> = ElfFile32::parse(elf)?;
    let symbol = file.symbols().find(|symbol| symbol.name() == Ok(SYMBOL)).ok_or(PackError::Anonymous)?;
    let address = symbol.address() as u32;
    let holds = |header: &&ProgramHeader32<LittleEndian>| {
        let from = header.p_paddr(LittleEndian);
        (from..from + header.p_filesz(LittleEndian)).contains(&address)
    };
    let header = segments(&file).find(holds).ok_or(PackError::Anonymous)?;
    Ok((header.p_offset(LittleEndian) + address - header.p_paddr(LittleEndian)) as usize)
}

/// Returns the loaded segments.
fn segments<'a>(file: &'a ElfFile32<'_, LittleEndian>) -> impl Iterator<Item = &'a ProgramHeader32<LittleEndian>> {
    file.elf_program_headers().iter().filter(|header| header.p_type(LittleEndian) == PT_LOAD && header.p_filesz(LittleEndian) > 0)
}
