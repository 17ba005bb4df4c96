//! Deserializer from the image's memory to types of the host, by [serde].

use serde::de::value::StrDeserializer;
use serde::de::{self, DeserializeOwned, DeserializeSeed, IntoDeserializer, Visitor};

use super::layout::{Kind, Layout, Member, Variant};

/// Memory that contains the values.
pub trait Memory {
    /// Copies the bytes at `address`; returns `false` if a memory does not contain all of them.
    fn copy(&self, address: u32, into: &mut [u8]) -> bool;
}

impl Memory for cortex_m4::Memory {
    fn copy(&self, address: u32, into: &mut [u8]) -> bool {
        self.get(address, into.len()).map(|bytes| into.copy_from_slice(bytes)).is_some()
    }
}

/// Error that prevents reading a value.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct ReadError(String);

impl de::Error for ReadError {
    fn custom<T: std::fmt::Display>(message: T) -> Self {
        ReadError(message.to_string())
    }
}

/// Reads the value of `layout` at `address`. `Deserialize` selects fields by name.
pub fn read<T: DeserializeOwned>(layout: &Layout, address: u32, memory: &dyn Memory) -> Result<T, ReadError> {
    T::deserialize(Value { layout, address, memory })
}

/// Value in memory.
#[derive(Clone, Copy)]
struct Value<'a> {
    layout: &'a Layout,
    address: u32,
    memory: &'a dyn Memory,
}

impl<'a> Value<'a> {
    fn member(&self, member: &'a Member) -> Value<'a> {
        Value { layout: &member.layout, address: self.address + member.offset, memory: self.memory }
    }

    /// Returns the number in the value's first bytes.
    fn number(&self) -> Result<u64, ReadError> {
        let mut bytes = [0; 8];
        let wide = (self.layout.bytes as usize).min(8);
        if self.memory.copy(self.address, &mut bytes[..wide]) { Ok(u64::from_le_bytes(bytes)) } else { Err(self.outside()) }
    }

    fn outside(&self) -> ReadError {
        ReadError(format!("{} at {:#010x} is outside the memories", self.layout.name, self.address))
    }

    fn unlike(&self, expected: &str) -> ReadError {
        ReadError(format!("{} is not a {expected}", self.layout.name))
    }

    /// Returns the value inside wrappers of one field: `ManuallyDrop`, `MaybeUninit`, `UnsafeCell`,
    /// and newtypes.
    fn peeled(self) -> Value<'a> {
        let Kind::Struct(members) = &self.layout.kind else { return self };
        let mut solid = members.iter().filter(|member| member.layout.bytes > 0);
        match (solid.next(), solid.next()) {
            (Some(member), None) => self.member(member).peeled(),
            _ => self,
        }
    }

    /// Returns the value inside the wrappers of an element that may be uninitialised.
    fn unwrapped(self) -> Value<'a> {
        let Kind::Struct(members) = &self.layout.kind else { return self };
        let wraps = ["MaybeUninit<", "ManuallyDrop<", "MaybeDangling<"].iter().any(|name| self.layout.name.starts_with(name));
        match members.iter().find(|member| wraps && member.layout.bytes > 0) {
            Some(member) => self.member(member).unwrapped(),
            None => self,
        }
    }

    /// Returns the only field of a newtype, or of a variant with one value.
    fn only(self) -> Result<Value<'a>, ReadError> {
        match &self.layout.kind {
            Kind::Struct(members) if members.len() == 1 => Ok(self.member(&members[0])),
            _ => Err(self.unlike("type with one field")),
        }
    }

    fn variant(&self) -> Result<&'a Variant, ReadError> {
        let Kind::Variants(discriminant, variants) = &self.layout.kind else { return Err(self.unlike("type with variants")) };
        let value = discriminant.as_ref().map(|member| self.member(member).number()).transpose()?;
        let named = variants.iter().find(|variant| variant.discriminant.is_some() && variant.discriminant == value);
        named
            .or(variants.iter().find(|variant| variant.discriminant.is_none()))
            .ok_or_else(|| self.unlike("type with a variant of this value"))
    }

    /// Returns the used elements of a list with its own length (`heapless::Vec`).
    fn list(&self) -> Result<Elements<'a>, ReadError> {
        let Kind::Struct(members) = &self.layout.kind else { return Err(self.unlike("list")) };
        let field = |name: &str| members.iter().find(|member| member.name == name).map(|member| self.member(member));
        let (Some(len), Some(buffer)) = (field("len"), field("buffer")) else { return Err(self.unlike("list")) };
        let buffer = buffer.peeled();
        let Kind::Array(layout, capacity) = &buffer.layout.kind else { return Err(self.unlike("list")) };
        let len = len.peeled().number()?;
        if len > u64::from(*capacity) {
            return Err(ReadError(format!("{} has {len} elements, but a capacity of {capacity}", self.layout.name)));
        }
        Ok(Elements { next: Value { layout, address: buffer.address, ..*self }, left: len as u32 })
    }
}

/// Iterator over the elements of a list or an array.
struct Elements<'a> {
    next: Value<'a>,
    left: u32,
}

impl<'a> de::SeqAccess<'a> for Elements<'a> {
    type Error = ReadError;

    fn next_element_seed<T: DeserializeSeed<'a>>(&mut self, seed: T) -> Result<Option<T::Value>, ReadError> {
        if self.left == 0 {
            return Ok(None);
        }
        let here = self.next.unwrapped();
        self.left -= 1;
        self.next.address += self.next.layout.bytes;
        seed.deserialize(here).map(Some)
    }
}

/// Iterator over the fields of a structure, with their names.
struct Fields<'a> {
    of: Value<'a>,
    members: std::slice::Iter<'a, Member>,
    value: Option<Value<'a>>,
}

impl<'a> de::MapAccess<'a> for Fields<'a> {
    type Error = ReadError;

    fn next_key_seed<K: DeserializeSeed<'a>>(&mut self, seed: K) -> Result<Option<K::Value>, ReadError> {
        let Some(member) = self.members.next() else { return Ok(None) };
        self.value = Some(self.of.member(member));
        let name: StrDeserializer<ReadError> = member.name.as_str().into_deserializer();
        seed.deserialize(name).map(Some)
    }

    fn next_value_seed<V: DeserializeSeed<'a>>(&mut self, seed: V) -> Result<V::Value, ReadError> {
        let value = self.value.take().ok_or_else(|| self.of.unlike("structure"))?;
        seed.deserialize(value)
    }
}

/// Iterator over the fields of a tuple, in their order.
struct Places<'a>(Value<'a>, std::slice::Iter<'a, Member>);

impl<'a> de::SeqAccess<'a> for Places<'a> {
    type Error = ReadError;

    fn next_element_seed<T: DeserializeSeed<'a>>(&mut self, seed: T) -> Result<Option<T::Value>, ReadError> {
        self.1.next().map(|member| seed.deserialize(self.0.member(member))).transpose()
    }
}

/// Methods for numbers, which may be in wrappers of one field, such as elements of `MaybeUninit`.
macro_rules! of_numbers {
    ($($name:ident)*) => {
        $(fn $name<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, ReadError> {
            self.peeled().deserialize_any(visitor)
        })*
    };
}

impl<'de> de::Deserializer<'de> for Value<'de> {
    type Error = ReadError;

    /// Deserializes by the kind of the value in memory.
    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, ReadError> {
        match &self.layout.kind {
            Kind::Unsigned => visitor.visit_u64(self.number()?),
            Kind::Signed => {
                let unused = 64 - 8 * self.layout.bytes.clamp(1, 8);
                visitor.visit_i64((self.number()? << unused) as i64 >> unused)
            }
            Kind::Float if self.layout.bytes == 4 => visitor.visit_f32(f32::from_bits(self.number()? as u32)),
            Kind::Float => visitor.visit_f64(f64::from_bits(self.number()?)),
            Kind::Bool => visitor.visit_bool(self.number()? != 0),
            Kind::Array(layout, count) => visitor.visit_seq(Elements { next: Value { layout, ..self }, left: *count }),
            Kind::Struct(members) => visitor.visit_map(Fields { of: self, members: members.iter(), value: None }),
            Kind::Names(_) | Kind::Variants(..) => self.deserialize_enum("", &[], visitor),
            Kind::Pointer(layout) => Value { layout, address: self.number()? as u32, ..self }.deserialize_any(visitor),
            Kind::Opaque => Err(self.unlike("readable value")),
        }
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, ReadError> {
        let variant = self.variant()?;
        if variant.member.name == "None" {
            return visitor.visit_none();
        }
        visitor.visit_some(self.member(&variant.member).only()?)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, _name: &'static str, visitor: V) -> Result<V::Value, ReadError> {
        visitor.visit_newtype_struct(self.only()?)
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, ReadError> {
        match &self.layout.kind {
            Kind::Array(layout, count) => visitor.visit_seq(Elements { next: Value { layout, ..self }, left: *count }),
            _ => visitor.visit_seq(self.list()?),
        }
    }

    fn deserialize_tuple<V: Visitor<'de>>(self, _len: usize, visitor: V) -> Result<V::Value, ReadError> {
        match &self.layout.kind {
            Kind::Struct(members) => visitor.visit_seq(Places(self, members.iter())),
            _ => self.deserialize_any(visitor),
        }
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _name: &'static str,
        _variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, ReadError> {
        if let Kind::Names(names) = &self.layout.kind {
            let value = self.number()?;
            let name = names.iter().find(|(number, _)| *number == value).map(|(_, name)| name.as_str());
            let name = name.ok_or_else(|| self.unlike("type with a variant of this value"))?;
            let name: StrDeserializer<ReadError> = name.into_deserializer();
            return visitor.visit_enum(name);
        }
        visitor.visit_enum(Chosen { of: self, variant: self.variant()? })
    }

    serde::forward_to_deserialize_any! {
        bool i128 u128 char str string bytes byte_buf unit unit_struct tuple_struct map struct identifier ignored_any
    }

    of_numbers!(deserialize_u8 deserialize_u16 deserialize_u32 deserialize_u64
        deserialize_i8 deserialize_i16 deserialize_i32 deserialize_i64 deserialize_f32 deserialize_f64);
}

/// Active variant of an enumeration.
struct Chosen<'a> {
    of: Value<'a>,
    variant: &'a Variant,
}

impl<'a> de::EnumAccess<'a> for Chosen<'a> {
    type Error = ReadError;
    type Variant = Self;

    fn variant_seed<V: DeserializeSeed<'a>>(self, seed: V) -> Result<(V::Value, Self), ReadError> {
        let name: StrDeserializer<ReadError> = self.variant.member.name.as_str().into_deserializer();
        Ok((seed.deserialize(name)?, self))
    }
}

impl<'a> de::VariantAccess<'a> for Chosen<'a> {
    type Error = ReadError;

    fn unit_variant(self) -> Result<(), ReadError> {
        Ok(())
    }

    fn newtype_variant_seed<T: DeserializeSeed<'a>>(self, seed: T) -> Result<T::Value, ReadError> {
        seed.deserialize(self.of.member(&self.variant.member).only()?)
    }

    fn tuple_variant<V: Visitor<'a>>(self, len: usize, visitor: V) -> Result<V::Value, ReadError> {
        de::Deserializer::deserialize_tuple(self.of.member(&self.variant.member), len, visitor)
    }

    fn struct_variant<V: Visitor<'a>>(self, _fields: &'static [&'static str], visitor: V) -> Result<V::Value, ReadError> {
        de::Deserializer::deserialize_any(self.of.member(&self.variant.member), visitor)
    }
}
