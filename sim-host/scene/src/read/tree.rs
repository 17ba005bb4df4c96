//! A scene as a tree of values with their places, so that texts can be merged and every problem
//! still points to its own text.

use std::collections::BTreeMap;
use std::sync::Arc;

use toml::Spanned;
use toml::de::{DeFloat, DeInteger, DeTable, DeValue};

use crate::diagnostic::Place;

/// A value and its place.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    pub(crate) place: Place,
    pub(crate) value: Value,
}

/// A value of a scene file.
#[derive(Clone, Debug)]
pub(crate) enum Value {
    Flag(bool),
    Integer(i64),
    Number(f64),
    Text(String),
    Date(String),
    List(Vec<Node>),
    /// The numbers of a long list, without individual places.
    Samples(Arc<[f64]>),
    Table(Table),
}

/// The keys of a table.
pub(crate) type Table = BTreeMap<String, Entry>;

/// Place of a key, and its value.
#[derive(Clone, Debug)]
pub(crate) struct Entry {
    pub(crate) key: Place,
    pub(crate) node: Node,
}

/// Source of a text, and offset of the text in it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Origin {
    pub(crate) source: usize,
    pub(crate) offset: usize,
}

impl Origin {
    /// Converts a span of the text to a place in the source.
    pub(crate) fn place(self, span: std::ops::Range<usize>) -> Place {
        Place::new(self.source, span.start + self.offset..span.end + self.offset)
    }
}

impl Node {
    /// Parses a text. The root table has the place at the end of the text, where a missing key
    /// would be added.
    pub(crate) fn parse(text: &str, origin: Origin) -> Result<Self, toml::de::Error> {
        let table = DeTable::parse(text)?;
        Ok(Self { place: origin.place(text.len()..text.len()), value: Value::Table(convert_table(table.get_ref(), origin)) })
    }

    /// Returns the entry at a dotted path, if it is a key of a table.
    pub(crate) fn entry(&self, path: &str) -> Option<&Entry> {
        let (table, key) = path.rsplit_once('.').map_or((self, path), |(table, key)| (self.at(table).unwrap_or(self), key));
        table.table()?.get(key)
    }

    /// Returns mutable access to the value of a key of this table.
    pub(crate) fn entry_mut(&mut self, key: &str) -> Option<&mut Self> {
        match &mut self.value {
            Value::Table(table) => table.get_mut(key).map(|entry| &mut entry.node),
            _ => None,
        }
    }

    /// Returns mutable access to the value at a dotted path.
    pub(crate) fn at_mut(&mut self, path: &str) -> Option<&mut Self> {
        path.split('.').filter(|name| !name.is_empty()).try_fold(self, |node, name| match &mut node.value {
            Value::Table(table) => table.get_mut(name).map(|entry| &mut entry.node),
            Value::List(list) => list.get_mut(name.parse::<usize>().ok()?),
            _ => None,
        })
    }

    /// Returns the value at a dotted path.
    pub(crate) fn at(&self, path: &str) -> Option<&Self> {
        path.split('.').filter(|name| !name.is_empty()).try_fold(self, |node, name| match &node.value {
            Value::Table(table) => table.get(name).map(|entry| &entry.node),
            Value::List(list) => list.get(name.parse::<usize>().ok()?),
            _ => None,
        })
    }

    /// Returns the keys of a table.
    pub(crate) fn table(&self) -> Option<&Table> {
        match &self.value {
            Value::Table(table) => Some(table),
            _ => None,
        }
    }

    /// Returns the entries of a list; empty for other values.
    pub(crate) fn list(&self) -> &[Self] {
        match &self.value {
            Value::List(list) => list,
            _ => &[],
        }
    }

    /// Returns the samples of a long list of numbers.
    pub(crate) fn samples(&self) -> Option<&Arc<[f64]>> {
        match &self.value {
            Value::Samples(samples) => Some(samples),
            _ => None,
        }
    }

    /// Returns the number, if it is one.
    pub(crate) fn number(&self) -> Option<f64> {
        match self.value {
            Value::Integer(number) => Some(number as f64),
            Value::Number(number) => Some(number),
            _ => None,
        }
    }

    /// Returns the string, if it is one.
    pub(crate) fn text(&self) -> Option<&str> {
        match &self.value {
            Value::Text(text) => Some(text),
            _ => None,
        }
    }

    /// Describes the type, for a message.
    pub(crate) fn kind(&self) -> &'static str {
        match &self.value {
            Value::Flag(_) => "true or false",
            Value::Integer(_) => "a whole number",
            Value::Number(_) => "a number",
            Value::Text(_) => "a string",
            Value::Date(_) => "a date or time",
            Value::List(list) if !list.is_empty() && list.iter().all(|node| node.table().is_some()) => "a list of tables",
            Value::List(_) | Value::Samples(_) => "a list",
            Value::Table(_) => "a table",
        }
    }

    /// Converts the value to TOML, without places and without samples, which a scene takes
    /// directly.
    pub(crate) fn to_toml(&self) -> toml::Value {
        match &self.value {
            Value::Flag(flag) => toml::Value::Boolean(*flag),
            Value::Integer(number) => toml::Value::Integer(*number),
            Value::Number(number) => toml::Value::Float(*number),
            Value::Text(text) | Value::Date(text) => toml::Value::String(text.clone()),
            Value::List(list) => toml::Value::Array(list.iter().map(Self::to_toml).collect()),
            Value::Samples(_) => toml::Value::Array(Vec::new()),
            Value::Table(table) => toml::Value::Table(table.iter().map(|(k, entry)| (k.clone(), entry.node.to_toml())).collect()),
        }
    }
}

fn convert_table(table: &DeTable<'_>, origin: Origin) -> Table {
    let entry = |key: &Spanned<_>, value| Entry { key: origin.place(key.span()), node: convert(value, origin) };
    table.iter().map(|(key, value)| (key.get_ref().to_string(), entry(key, value))).collect()
}

fn convert(value: &Spanned<DeValue<'_>>, origin: Origin) -> Node {
    let converted = match value.get_ref() {
        DeValue::Boolean(flag) => Value::Flag(*flag),
        DeValue::Integer(number) => integer(number),
        DeValue::Float(number) => Value::Number(float(number)),
        DeValue::String(text) => Value::Text(text.to_string()),
        DeValue::Datetime(date) => Value::Date(date.to_string()),
        DeValue::Array(list) => Value::List(list.iter().map(|node| convert(node, origin)).collect()),
        DeValue::Table(table) => Value::Table(convert_table(table, origin)),
    };
    Node { place: origin.place(value.span()), value: converted }
}

/// Converts an integer. One that is too large becomes a float, so that its range can be checked.
fn integer(number: &DeInteger<'_>) -> Value {
    let exact = i64::from_str_radix(number.as_str(), number.radix());
    let rounded = |_| number.as_str().parse().unwrap_or(f64::INFINITY);
    exact.map_or_else(|error| Value::Number(rounded(error)), Value::Integer)
}

fn float(number: &DeFloat<'_>) -> f64 {
    number.as_str().parse().unwrap_or(f64::NAN)
}
