//! All keys of a scene, with their descriptions from the schema.

use crate::schema::{Kind, Schema, join};
use crate::settings_page::{default, range};
use columns::unit as units;

/// A key of a scene, or a table of keys.
#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    /// Tables and key, separated by dots.
    pub path: String,
    /// Number of possible occurrences if it is a table, `None` if it is a key.
    pub table: Option<Repeats>,
    /// Meaning of the key or table.
    pub meaning: String,
    /// Unit at the end of its name.
    pub unit: Option<String>,
    /// Range of its values, in words.
    pub range: String,
    /// Default value, in words.
    pub default: String,
}

/// Number of possible occurrences of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Repeats {
    /// The table occurs once, as `[table]`.
    Once,
    /// The table can occur several times, as `[[table]]`.
    Several,
}

/// Returns all keys and tables, each table before its keys.
pub fn keys() -> Vec<Key> {
    let mut keys = Vec::new();
    for (path, table) in Schema::tables() {
        if !path.is_empty() {
            let several = Schema::root().at(&path).is_some_and(|schema| schema.kind() == Kind::List);
            keys.push(Key {
                table: Some(if several { Repeats::Several } else { Repeats::Once }),
                meaning: text(table),
                unit: None,
                range: String::new(),
                default: String::new(),
                path: path.clone(),
            });
        }
        for (name, schema) in table.properties().filter(|(_, schema)| schema.kind() != Kind::Table) {
            let of_tables = schema.items().is_some_and(|items| items.kind() == Kind::Table);
            if !of_tables {
                let required = table.required().any(|required| required == name);
                keys.push(Key {
                    path: join(&path, name),
                    table: None,
                    meaning: text(schema),
                    unit: units::split(name).1.map(|unit| unit.symbol),
                    range: range(schema),
                    default: default(schema, required),
                });
            }
        }
    }
    keys
}

/// Returns the description in one line.
fn text(schema: Schema) -> String {
    schema.description().unwrap_or_default().replace('\n', " ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_match_the_schema() {
        let keys = keys();
        let key = |path: &str| keys.iter().find(|key| key.path == path).unwrap_or_else(|| panic!("{path}"));
        let block = key("controller.block_samples");
        assert_eq!((block.range.as_str(), block.default.as_str(), block.table), ("8 to 100", "32", None));
        assert_eq!(key("rig.slider.speed_m_per_s").unit.as_deref(), Some("m/s"));
        assert_eq!((key("rig.slider").table, key("expect").table), (Some(Repeats::Once), Some(Repeats::Several)));
        assert!(keys.iter().all(|key| !key.meaning.is_empty()), "{:?}", keys.iter().find(|key| key.meaning.is_empty()));
    }
}
