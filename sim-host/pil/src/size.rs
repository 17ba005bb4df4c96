//! How much memory an image takes, by the sections of its ELF file.

use object::{Object as _, ObjectSection as _, SectionFlags, SectionKind, elf};

/// Where the RAM of the machine begins and ends: all that is loaded stands in the flash as well.
const RAM: std::ops::Range<u64> = 0x2000_0000..0x4000_0000;

/// Bytes of an image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Size {
    /// Vectors, code, constants, and what static variables begin with.
    pub flash: u64,
    /// Size of the static variables, bytes.
    pub ram: u64,
}

impl Size {
    /// Reads the sizes of an image, an ELF file.
    pub fn of(elf: &[u8]) -> Result<Self, object::Error> {
        let file = object::File::parse(elf)?;
        let mut size = Size::default();
        for section in file.sections() {
            let SectionFlags::Elf { sh_flags, .. } = section.flags() else { continue };
            if (sh_flags & elf::SHF_ALLOC).0 == 0 {
                continue;
            }
            if section.kind() != SectionKind::UninitializedData {
                size.flash += section.size();
            }
            if RAM.contains(&section.address()) {
                size.ram += section.size();
            }
        }
        Ok(size)
    }
}
