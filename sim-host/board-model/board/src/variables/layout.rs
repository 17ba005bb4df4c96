//! How a type of the image lies in memory (DWARF 5, chapter 5: data types; 5.7.10: variants).

use std::collections::HashMap;
use std::sync::Arc;

use gimli::{DebuggingInformationEntry, Dwarf, Reader, Unit, UnitOffset};

/// A type of the image: its size and what its bytes are.
#[derive(Clone, Debug)]
pub struct Layout {
    /// Name, as the compiler wrote it.
    pub name: String,
    /// Size, bytes.
    pub bytes: u32,
    /// What the bytes are.
    pub kind: Kind,
}

/// What the bytes of a type are.
#[derive(Clone, Debug)]
pub enum Kind {
    /// An unsigned number.
    Unsigned,
    /// A signed number.
    Signed,
    /// A floating-point number.
    Float,
    /// True or false.
    Bool,
    /// A structure, a tuple or a union; in a union all offsets are zero.
    Struct(Vec<Member>),
    /// An enumeration without values: numbers and names.
    Names(Vec<(u64, String)>),
    /// An enumeration with values: where its discriminant stands, and the variants.
    Variants(Option<Member>, Vec<Variant>),
    /// An array, by the type and the number of its elements.
    Array(Arc<Layout>, u32),
    /// A reference or pointer to one value. What it points to is read by its own layout, which is looked up only when it is followed.
    Pointer(Arc<Layout>),
    /// Something that is never read: a function, a slice, a type within itself.
    Opaque,
}

/// A field.
#[derive(Clone, Debug)]
pub struct Member {
    /// Its name; `__0` and so on in a tuple.
    pub name: String,
    /// Where it begins, bytes from the start of the type.
    pub offset: u32,
    /// Its type.
    pub layout: Arc<Layout>,
}

/// One variant of an enumeration with values.
#[derive(Clone, Debug)]
pub struct Variant {
    /// The discriminant that selects it; none for the one that all other discriminants select.
    pub discriminant: Option<u64>,
    /// Its name, and the structure of its values.
    pub member: Member,
}

/// The types of one unit, each laid out once.
pub(super) struct Types<'a, R: Reader<Offset = usize>> {
    dwarf: &'a Dwarf<R>,
    unit: &'a Unit<R>,
    known: HashMap<UnitOffset, Arc<Layout>>,
    /// Types that are being laid out: a type within itself ends here.
    open: Vec<UnitOffset>,
}

/// The type that an entry names.
pub(super) fn type_of<R: Reader<Offset = usize>>(entry: &DebuggingInformationEntry<R>) -> Option<UnitOffset> {
    match entry.attr_value(gimli::DW_AT_type)? {
        gimli::AttributeValue::UnitRef(at) => Some(at),
        _ => None,
    }
}

fn number<R: Reader<Offset = usize>>(entry: &DebuggingInformationEntry<R>, attribute: gimli::DwAt) -> Option<u64> {
    let value = entry.attr_value(attribute)?;
    value.udata_value().or_else(|| value.sdata_value().map(|signed| signed as u64))
}

impl<'a, R: Reader<Offset = usize>> Types<'a, R> {
    pub(super) fn new(dwarf: &'a Dwarf<R>, unit: &'a Unit<R>) -> Self {
        Types { dwarf, unit, known: HashMap::new(), open: Vec::new() }
    }

    /// The name of an entry.
    pub(super) fn name_of(&self, entry: &DebuggingInformationEntry<R>) -> Result<Option<String>, gimli::Error> {
        let Some(value) = entry.attr_value(gimli::DW_AT_name) else { return Ok(None) };
        Ok(Some(self.dwarf.attr_string(self.unit, value)?.to_string_lossy()?.into_owned()))
    }

    /// The layout of the type at an offset of the unit.
    pub(super) fn layout(&mut self, at: UnitOffset) -> Result<Arc<Layout>, gimli::Error> {
        if let Some(known) = self.known.get(&at) {
            return Ok(known.clone());
        }
        let entry = self.unit.entry(at)?;
        let name = self.name_of(&entry)?.unwrap_or_default();
        let bytes = number(&entry, gimli::DW_AT_byte_size).unwrap_or(0) as u32;
        if self.open.contains(&at) {
            return Ok(Arc::new(Layout { name, bytes, kind: Kind::Opaque }));
        }
        self.open.push(at);
        let (kind, bytes) = match entry.tag() {
            gimli::DW_TAG_base_type => (base(&entry), bytes),
            gimli::DW_TAG_structure_type | gimli::DW_TAG_union_type => (self.structure(at)?, bytes),
            gimli::DW_TAG_enumeration_type => (Kind::Names(self.enumerators(at)?), bytes),
            gimli::DW_TAG_array_type => {
                let (element, count) = (self.named(&entry)?, self.count(at)?);
                let bytes = element.bytes * count;
                (Kind::Array(element, count), bytes)
            }
            gimli::DW_TAG_pointer_type => (type_of(&entry).map_or(Ok(Kind::Opaque), |to| self.layout(to).map(Kind::Pointer))?, 4),
            _ => (Kind::Opaque, bytes),
        };
        self.open.pop();
        let layout = Arc::new(Layout { name, bytes, kind });
        self.known.insert(at, layout.clone());
        Ok(layout)
    }

    /// The layout of the type that an entry names.
    fn named(&mut self, entry: &DebuggingInformationEntry<R>) -> Result<Arc<Layout>, gimli::Error> {
        match type_of(entry) {
            Some(at) => self.layout(at),
            None => Ok(Arc::new(Layout { name: String::new(), bytes: 0, kind: Kind::Opaque })),
        }
    }

    /// The entries right below one.
    fn children(&self, at: UnitOffset) -> Result<Vec<DebuggingInformationEntry<R>>, gimli::Error> {
        let mut tree = self.unit.entries_tree(Some(at))?;
        let mut children = tree.root()?.children();
        let mut all = Vec::new();
        while let Some(child) = children.next()? {
            all.push(child.entry().clone());
        }
        Ok(all)
    }

    fn member(&mut self, entry: &DebuggingInformationEntry<R>) -> Result<Member, gimli::Error> {
        let offset = number(entry, gimli::DW_AT_data_member_location).unwrap_or(0) as u32;
        Ok(Member { name: self.name_of(entry)?.unwrap_or_default(), offset, layout: self.named(entry)? })
    }

    fn structure(&mut self, at: UnitOffset) -> Result<Kind, gimli::Error> {
        let mut members = Vec::new();
        for child in self.children(at)? {
            match child.tag() {
                gimli::DW_TAG_member => members.push(self.member(&child)?),
                gimli::DW_TAG_variant_part => return self.variants(child.offset()),
                _ => (),
            }
        }
        Ok(Kind::Struct(members))
    }

    fn variants(&mut self, at: UnitOffset) -> Result<Kind, gimli::Error> {
        let (mut discriminant, mut variants) = (None, Vec::new());
        for child in self.children(at)? {
            match child.tag() {
                gimli::DW_TAG_member => discriminant = Some(self.member(&child)?),
                gimli::DW_TAG_variant => {
                    let value = number(&child, gimli::DW_AT_discr_value);
                    if let Some(member) = self.children(child.offset())?.first() {
                        variants.push(Variant { discriminant: value, member: self.member(member)? });
                    }
                }
                _ => (),
            }
        }
        Ok(Kind::Variants(discriminant, variants))
    }

    fn enumerators(&mut self, at: UnitOffset) -> Result<Vec<(u64, String)>, gimli::Error> {
        let children = self.children(at)?;
        let names = children.iter().filter(|child| child.tag() == gimli::DW_TAG_enumerator);
        names
            .map(|child| Ok((number(child, gimli::DW_AT_const_value).unwrap_or(0), self.name_of(child)?.unwrap_or_default())))
            .collect()
    }

    fn count(&self, at: UnitOffset) -> Result<u32, gimli::Error> {
        let children = self.children(at)?;
        let range = children.iter().find(|child| child.tag() == gimli::DW_TAG_subrange_type);
        Ok(range.and_then(|range| number(range, gimli::DW_AT_count)).unwrap_or(0) as u32)
    }
}

fn base<R: Reader<Offset = usize>>(entry: &DebuggingInformationEntry<R>) -> Kind {
    match entry.attr_value(gimli::DW_AT_encoding) {
        Some(gimli::AttributeValue::Encoding(gimli::DW_ATE_boolean)) => Kind::Bool,
        Some(gimli::AttributeValue::Encoding(gimli::DW_ATE_float)) => Kind::Float,
        Some(gimli::AttributeValue::Encoding(gimli::DW_ATE_signed | gimli::DW_ATE_signed_char)) => Kind::Signed,
        _ => Kind::Unsigned,
    }
}
