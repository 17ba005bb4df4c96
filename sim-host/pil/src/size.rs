//! Memory use of an image, by the sections of its ELF file.

use object::{Object as _, ObjectSection as _, SectionFlags, SectionKind, elf};

/// Address range of the machine's RAM. All loaded data are in the flash as well.
const RAM: std::ops::Range<u64> = 0x2000_0000..0x4000_0000;

/// Memory use of an image, bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Size {
    /// Size of vectors, code, constants, and initial values of static variables, bytes.
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
