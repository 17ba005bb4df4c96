//! Memory layout of the image's types (DWARF 5, chapter 5: data types; 5.7.10: variants).

use std::collections::HashMap;
use std::sync::Arc;

use gimli::{DebuggingInformationEntry, Dwarf, Reader, Unit, UnitOffset};

/// Type of the image: its size and the meaning of its bytes.
#[derive(Clone, Debug)]
pub struct Layout {
    /// Name from the compiler.
    pub name: String,
    /// Size, bytes.
    pub bytes: u32,
    /// Meaning of the bytes.
    pub kind: Kind,
}

/// Meaning of the bytes of a type.
#[derive(Clone, Debug)]
pub enum Kind {
    /// Unsigned number.
    Unsigned,
    /// Signed number.
    Signed,
    /// Floating-point number.
    Float,
    /// Boolean.
    Bool,
    /// Structure, tuple or union; in a union all offsets are zero.
    Struct(Vec<Member>),
    /// Enumeration without values: numbers and names.
    Names(Vec<(u64, String)>),
    /// Enumeration with values: discriminant and variants.
    Variants(Option<Member>, Vec<Variant>),
    /// Array: type and number of its elements.
    Array(Arc<Layout>, u32),
    /// Reference or pointer to one value of this layout.
    Pointer(Arc<Layout>),
    /// Type that is never read: a function, a slice, a type within itself.
    Opaque,
}

/// Field of a type.
#[derive(Clone, Debug)]
pub struct Member {
    /// Name; `__0` and so on in a tuple.
    pub name: String,
    /// Offset from the start of the type, bytes.
    pub offset: u32,
    /// Type of the field.
    pub layout: Arc<Layout>,
}

/// Variant of an enumeration with values.
#[derive(Clone, Debug)]
pub struct Variant {
    /// Discriminant of the variant; `None` for the variant of all other discriminants.
    pub discriminant: Option<u64>,
    /// Name, and the structure of its values.
    pub member: Member,
}

/// Types of one unit; the layout of each is computed once.
pub(super) struct Types<'a, R: Reader<Offset = usize>> {
    dwarf: &'a Dwarf<R>,
    unit: &'a Unit<R>,
    known: HashMap<UnitOffset, Arc<Layout>>,
    /// Types whose layout is being computed: a type within itself ends here.
    open: Vec<UnitOffset>,
}

/// Returns the type that an entry refers to.
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

    /// Returns the name of an entry.
    pub(super) fn name_of(&self, entry: &DebuggingInformationEntry<R>) -> Result<Option<String>, gimli::Error> {
        let Some(value) = entry.attr_value(gimli::DW_AT_name) else { return Ok(None) };
        Ok(Some(self.dwarf.attr_string(self.unit, value)?.to_string_lossy()?.into_owned()))
    }

    /// Returns the layout of the type at an offset of the unit.
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

    /// Returns the layout of the type that an entry refers to.
    fn named(&mut self, entry: &DebuggingInformationEntry<R>) -> Result<Arc<Layout>, gimli::Error> {
        match type_of(entry) {
            Some(at) => self.layout(at),
            None => Ok(Arc::new(Layout { name: String::new(), bytes: 0, kind: Kind::Opaque })),
        }
    }

    /// Returns the direct children of an entry.
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
