//! All keys of a scene, each with what the schema says of it.

use crate::schema::{Kind, Schema, join};
use crate::settings_page::{default, range};
use crate::units;

/// A key of a scene, or a table of keys.
#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    /// Tables and key, with points between.
    pub path: String,
    /// Whether it is a table, and may be there several times.
    pub table: Option<Repeats>,
    /// Meaning of the key or table.
    pub meaning: String,
    /// The unit that its name ends in.
    pub unit: Option<String>,
    /// Which values it may have.
    pub range: String,
    /// What it is where a scene does not say.
    pub default: String,
}

/// Whether a table is there once or several times.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Repeats {
    /// The table is there once, as `[table]`.
    Once,
    /// The table may be there several times, as `[[table]]`.
    Several,
}

/// All keys and tables, each table before its keys.
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

/// Its description, in one line.
fn text(schema: Schema) -> String {
    schema.description().unwrap_or_default().replace('\n', " ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_have_what_the_schema_says() {
        let keys = keys();
        let key = |path: &str| keys.iter().find(|key| key.path == path).unwrap_or_else(|| panic!("{path}"));
        let block = key("controller.block_samples");
        assert_eq!((block.range.as_str(), block.default.as_str(), block.table), ("8 to 100", "32", None));
        assert_eq!(key("rig.slider.speed_m_per_s").unit.as_deref(), Some("m/s"));
        assert_eq!((key("rig.slider").table, key("expect").table), (Some(Repeats::Once), Some(Repeats::Several)));
        assert!(keys.iter().all(|key| !key.meaning.is_empty()), "{:?}", keys.iter().find(|key| key.meaning.is_empty()));
    }
}
