//! Values of an image's variables, by the debug information of its ELF.
//!
//! The image is not modified: DWARF contains the address of a static and the meaning of each byte
//! of its type. A value is read into any type that derives `Deserialize`, by field names, so that
//! the host does not depend on the layout that the compiler chose.
//!
//! ```text
//! ELF .debug_info --> Layout (offsets, variants) --+
//!                                                  +--> serde --> firmware::seam::block::Orders
//! memory of the model --> bytes -------------------+
//! ```

mod layout;
mod read;

use std::collections::HashMap;

use object::{Object, ObjectSection};

use std::sync::Arc;

use serde::de::DeserializeOwned;

pub use layout::{Kind, Layout, Member, Variant};
pub use read::{Memory, ReadError};

use layout::Types;

/// Error that prevents reading the variables of an image.
#[derive(Debug, thiserror::Error)]
pub enum DebugInfoError {
    /// File that is not an ELF file.
    #[error("not an ELF file: {0}")]
    Elf(#[from] object::Error),
    /// Damaged debug information.
    #[error("its debug information cannot be read: {0}")]
    Dwarf(#[from] gimli::Error),
    /// Image without debug information.
    #[error("it has no debug information (.debug_info): it was stripped, or built without `debug = \"full\"`")]
    Stripped,
}

/// Statics of an image, by name.
#[derive(Clone, Debug, Default)]
pub struct Variables {
    statics: HashMap<String, Place>,
}

/// Address and type of a value in the image's memory.
#[derive(Clone, Debug)]
pub struct Place {
    /// Address of the first byte.
    pub address: u32,
    /// Type of the value.
    pub layout: Arc<Layout>,
}

impl Place {
    /// Returns a field of a structure.
    pub fn field(&self, name: &str) -> Option<Place> {
        let Kind::Struct(members) = &self.layout.kind else { return None };
        let member = members.iter().find(|member| member.name == name)?;
        Some(Place { address: self.address + member.offset, layout: member.layout.clone() })
    }

    /// Returns an element of an array, through wrappers of one field.
    pub fn element(&self, index: usize) -> Option<Place> {
        match &self.layout.kind {
            Kind::Array(layout, count) if index < *count as usize => {
                Some(Place { address: self.address + index as u32 * layout.bytes, layout: layout.clone() })
            }
            Kind::Struct(members) => {
                let member = members.iter().find(|member| member.layout.bytes > 0)?;
                Place { address: self.address + member.offset, layout: member.layout.clone() }.element(index)
            }
            _ => None,
        }
    }

    /// Returns the target of a reference or of an `Option` of one; `None` for a null reference.
    pub fn target(&self, memory: &dyn Memory) -> Option<Place> {
        let mut bytes = [0; 4];
        let layout = pointed(&self.layout)?;
        memory.copy(self.address, &mut bytes);
        let address = u32::from_le_bytes(bytes);
        (address != 0).then_some(Place { address, layout })
    }

    /// Reads the value.
    pub fn read<T: DeserializeOwned>(&self, memory: &dyn Memory) -> Result<T, ReadError> {
        read::read(&self.layout, self.address, memory)
    }
}

/// Returns the target type of a pointer that fills all of `layout`.
fn pointed(layout: &Layout) -> Option<Arc<Layout>> {
    match &layout.kind {
        Kind::Pointer(target) => Some(target.clone()),
        Kind::Struct(members) => members.iter().find_map(|member| pointed(&member.layout)),
        Kind::Variants(_, variants) => variants.iter().find_map(|variant| pointed(&variant.member.layout)),
        _ => None,
    }
}

impl Variables {
    /// Finds the statics of an ELF file with these names.
    pub fn from_elf(elf: &[u8], names: &[&str]) -> Result<Self, DebugInfoError> {
        let file = object::File::parse(elf)?;
        if file.section_by_name(".debug_info").is_none() {
            return Err(DebugInfoError::Stripped);
        }
        let section = |id: gimli::SectionId| -> Result<_, gimli::Error> {
            let data = file.section_by_name(id.name()).and_then(|section| section.data().ok()).unwrap_or(&[]);
            Ok(gimli::EndianSlice::new(data, gimli::LittleEndian))
        };
        let dwarf = gimli::Dwarf::load(section)?;
        let mut statics = HashMap::new();
        let mut units = dwarf.units();
        while let Some(header) = units.next()? {
            let unit = dwarf.unit(header)?;
            let mut types = Types::new(&dwarf, &unit);
            let mut entries = unit.entries();
            while let Some(entry) = entries.next_dfs()? {
                if entry.tag() != gimli::DW_TAG_variable {
                    continue;
                }
                let Some(name) = types.name_of(entry)?.filter(|name| names.contains(&name.as_str())) else { continue };
                let (Some(address), Some(type_at)) = (address_of(entry, &unit)?, layout::type_of(entry)) else { continue };
                statics.insert(name, Place { address, layout: types.layout(type_at)? });
            }
        }
        Ok(Variables { statics })
    }

    /// Returns a static by its name.
    pub fn get(&self, name: &str) -> Option<&Place> {
        self.statics.get(name)
    }
}

/// Returns the fixed address of a variable: `DW_OP_addr`, plus `DW_OP_plus_uconst` if statics were
/// merged into one.
fn address_of<R: gimli::Reader<Offset = usize>>(
    entry: &gimli::DebuggingInformationEntry<R>,
    unit: &gimli::Unit<R>,
) -> Result<Option<u32>, gimli::Error> {
    let Some(expression) = entry.attr_value(gimli::DW_AT_location).and_then(|value| value.exprloc_value()) else {
        return Ok(None);
    };
    let (mut operations, mut address) = (expression.operations(unit.encoding()), None);
    while let Some(operation) = operations.next()? {
        address = match (operation, address) {
            (gimli::Operation::Address { address }, None) => Some(address as u32),
            (gimli::Operation::PlusConstant { value }, Some(address)) => Some(address + value as u32),
            _ => return Ok(None),
        };
    }
    Ok(address)
}
