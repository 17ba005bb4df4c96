//! The JSON Schema of a scene, with methods to query it.
//!
//! The schema is derived from the types of [`Scene`](crate::Scene). This module names no key of a
//! scene except `base`, which is removed before a scene becomes a value.

use std::sync::LazyLock;

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde_json::{Value, json};

/// Top-level key that names the scene to start from.
pub const BASE: &str = "base";

/// Returns the JSON Schema of a scene file.
pub fn schema() -> Value {
    ROOT.clone()
}

/// Returns the schema of a type, without references.
pub(crate) fn of_type<T: JsonSchema>() -> Value {
    let mut settings = SchemaSettings::draft2020_12();
    settings.inline_subschemas = true;
    settings.into_generator().into_root_schema_for::<T>().to_value()
}

static ROOT: LazyLock<Value> = LazyLock::new(|| {
    let mut schema = of_type::<crate::Scene>();
    schema["properties"][BASE] = json!({
        "description": "Scene to start from: a built-in name, or a file relative to this one.",
        "type": "string",
    });
    schema
});

/// Type of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A table of keys.
    Table,
    /// A list of values or tables.
    List,
    /// A finite number.
    Number,
    /// A number without a fraction.
    Integer,
    /// A string without restriction.
    Text,
    /// A flag, `true` or `false`.
    Flag,
    /// A string out of several.
    Choice,
}

/// The part of the schema that describes one value.
#[derive(Clone, Copy, Debug)]
pub struct Schema(&'static Value);

impl Schema {
    /// Returns the schema of the whole scene.
    pub fn root() -> Self {
        Self(&ROOT)
    }

    /// Wraps the schema of another type than a scene.
    pub(crate) fn new(schema: &'static Value) -> Self {
        Self(schema)
    }

    /// Returns the schema at a dotted path such as `disturbance.0.to`; a list accepts any index.
    pub fn at(self, path: &str) -> Option<Self> {
        path.split('.').filter(|name| !name.is_empty()).try_fold(self, |schema, name| match schema.kind() {
            Kind::List if is_index(name) => schema.items(),
            _ => schema.entry(name),
        })
    }

    /// Returns the type of the value.
    pub fn kind(self) -> Kind {
        if self.0.get("oneOf").is_some() || self.0.get("enum").is_some() {
            return Kind::Choice;
        }
        let named = |name: &str| match &self.0["type"] {
            Value::Array(types) => types.iter().any(|t| t == name),
            single => single == name,
        };
        let kinds = [
            ("object", Kind::Table),
            ("array", Kind::List),
            ("integer", Kind::Integer),
            ("number", Kind::Number),
            ("boolean", Kind::Flag),
        ];
        kinds.into_iter().find(|(name, _)| named(name)).map_or(Kind::Text, |(_, kind)| kind)
    }

    /// Returns `true` for a number, whole or not.
    pub fn is_number(self) -> bool {
        matches!(self.kind(), Kind::Number | Kind::Integer)
    }

    /// Returns `true` if the value may be absent and has no default.
    pub fn is_optional(self) -> bool {
        self.0["type"].as_array().is_some_and(|types| types.iter().any(|name| name == "null"))
    }

    /// Returns the keys of a table, in alphabetical order.
    pub fn properties(self) -> impl Iterator<Item = (&'static str, Self)> {
        self.0["properties"].as_object().into_iter().flatten().map(|(name, schema)| (name.as_str(), Self(schema).value()))
    }

    /// Returns the schema of a key of a table.
    pub fn property(self, name: &str) -> Option<Self> {
        self.0.get("properties")?.get(name).map(|schema| Self(schema).value())
    }

    /// Returns the schema of a key of a table, also of a table whose names the user chooses.
    pub(crate) fn entry(self, name: &str) -> Option<Self> {
        let of_any_name = || self.0.get("additionalProperties").filter(|schema| schema.is_object());
        self.property(name).or_else(|| of_any_name().map(|schema| Self(schema).value()))
    }

    /// Returns the required keys of a table.
    pub fn required(self) -> impl Iterator<Item = &'static str> {
        self.0["required"].as_array().into_iter().flatten().filter_map(Value::as_str)
    }

    /// Returns the schema of the entries of a list.
    pub fn items(self) -> Option<Self> {
        self.0.get("items").map(|schema| Self(schema).value())
    }

    /// Returns the smallest and the largest number.
    pub fn range(self) -> (Option<f64>, Option<f64>) {
        (self.0["minimum"].as_f64(), self.0["maximum"].as_f64())
    }

    /// Returns the smallest and the largest number of entries of a list.
    pub fn lengths(self) -> (Option<u64>, Option<u64>) {
        (self.0["minItems"].as_u64(), self.0["maxItems"].as_u64())
    }

    /// Returns the possible strings of a choice, in the order of the type.
    pub fn choices(self) -> Vec<&'static str> {
        let own = self.0["enum"].as_array().into_iter().flatten();
        let branches = self.0["oneOf"].as_array().into_iter().flatten();
        let in_branches = branches.flat_map(|b| b.get("const").into_iter().chain(b["enum"].as_array().into_iter().flatten()));
        own.chain(in_branches).filter_map(Value::as_str).collect()
    }

    /// Returns the possible strings of a choice, each with its meaning.
    pub fn described_choices(self) -> Vec<(&'static str, &'static str)> {
        let branches = self.0["oneOf"].as_array().into_iter().flatten();
        branches
            .filter_map(|branch| Some((branch["const"].as_str()?, branch["description"].as_str().unwrap_or_default())))
            .collect()
    }

    /// Returns the documentation of the value: meaning and unit.
    pub fn description(self) -> Option<&'static str> {
        self.0["description"].as_str()
    }

    /// Returns the default of the value, if it has one.
    pub fn default(self) -> Option<&'static Value> {
        self.0.get("default")
    }

    /// Returns every table of a scene with its path; entries of a list of tables have the path of
    /// the list.
    pub fn tables() -> Vec<(String, Self)> {
        Self::root().tables_within()
    }

    /// Returns every table within this schema with its path, as [`Schema::tables`] does.
    pub(crate) fn tables_within(self) -> Vec<(String, Self)> {
        let mut found = vec![(String::new(), self)];
        let mut next = 0;
        while let Some((path, table)) = found.get(next).cloned() {
            next += 1;
            for (name, schema) in table.properties() {
                let schema = schema.items().unwrap_or(schema);
                if schema.kind() == Kind::Table {
                    found.push((join(&path, name), schema));
                }
            }
        }
        found
    }

    /// Returns the paths of all numbers of a scene.
    pub fn numbers() -> Vec<String> {
        let keys = Self::tables().into_iter().flat_map(|(path, table)| {
            let numbers = table.properties().filter(|(_, schema)| schema.is_number());
            numbers.map(|(key, _)| join(&path, key)).collect::<Vec<_>>()
        });
        keys.collect()
    }

    /// Returns the schema of the value itself if the schema is "this or null".
    fn value(self) -> Self {
        let branches = self.0["anyOf"].as_array().into_iter().flatten();
        branches.into_iter().find(|branch| branch["type"] != "null").map_or(self, Self)
    }
}

/// Returns the unit at the end of a name.
pub fn unit_of(name: &str) -> Option<String> {
    columns::unit::split(name).1.map(|unit| unit.symbol)
}

/// Returns the last name of a path; for an entry of a list, the name of the list.
pub fn last_name(path: &str) -> &str {
    path.rsplit('.').find(|name| !is_index(name)).unwrap_or(path)
}

/// Returns the shortest end of a path, beginning with a name, that distinguishes it from the other
/// paths.
pub fn tail<'a>(path: &'a str, paths: &[String]) -> &'a str {
    let ends_so =
        |path: &String, tail: &str| path.strip_suffix(tail).is_some_and(|tables| tables.is_empty() || tables.ends_with('.'));
    let tails = path.rmatch_indices('.').map(|(at, _)| &path[at + 1..]);
    let mut of_a_name = tails.filter(|tail| !tail.starts_with(|c: char| c.is_ascii_digit()));
    of_a_name.find(|tail| paths.iter().filter(|path| ends_so(path, tail)).count() <= 1).unwrap_or(path)
}

/// Returns the quantity in a name: its words without the unit at the end.
pub fn words_of(name: &str) -> String {
    columns::unit::split(name).0.replace('_', " ")
}

/// Returns the dotted path of a key in a table.
pub(crate) fn join(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") }
}

/// Returns `true` if a part of a path is the index of a list entry.
pub(crate) fn is_index(name: &str) -> bool {
    !name.is_empty() && name.bytes().all(|b| b.is_ascii_digit())
}

/// Removes the indices from a path: the result is the path of the table's description.
pub(crate) fn without_indices(path: &str) -> String {
    path.split('.').filter(|name| !is_index(name)).collect::<Vec<_>>().join(".")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn schema_follows_the_types() {
        let root = Schema::root();
        let block = root.at("controller.block_samples").unwrap();
        assert_eq!(block.kind(), Kind::Integer);
        assert_eq!(block.range(), (Some(8.0), Some(100.0)));
        assert_eq!(block.default(), Some(&json!(32)));
        assert_eq!(block.description(), Some("Samples in a block."));
        assert_eq!(root.at("controller.drive.shape").unwrap().choices(), ["sine", "square", "sawtooth", "noise"]);
        assert_eq!(root.at("disturbance.3.to").unwrap().kind(), Kind::Number);
        assert_eq!(root.at("controller.burst.on_s").unwrap().lengths(), (None, Some(8)));
        assert!(root.at("controller.drive.nothing").is_none());
        assert!(root.at("disturbance.to").is_none());
    }

    #[test]
    fn names_are_words_and_a_unit() {
        for (name, words, unit) in [
            ("stiffness_n_per_m", "stiffness", Some("N/m")),
            ("reduction_percent_at_0.038", "reduction percent at 0.038", None),
            ("friction_ratio", "friction ratio", None),
            ("lock_time_20hz_ms", "lock time 20hz", Some("ms")),
        ] {
            assert_eq!((words_of(name).as_str(), unit_of(name).as_deref()), (words, unit));
        }
    }

    #[test]
    fn path_tails_are_unique() {
        let paths = ["stack.bvd.q", "stack.mode.0.q", "stack.mode.1.q", "rig.slider.load_n", "burst.on_s.1"].map(str::to_owned);
        let tails = paths.each_ref().map(|path| tail(path, &paths));
        assert_eq!(tails, ["bvd.q", "mode.0.q", "mode.1.q", "load_n", "on_s.1"]);
        assert_eq!(paths.each_ref().map(|path| last_name(path)), ["q", "q", "q", "load_n", "on_s"]);
    }

    #[test]
    fn tables_are_all_found() {
        let paths: Vec<_> = Schema::tables().into_iter().map(|(path, _)| path).collect();
        for path in ["", "controller.burst", "rig.slider", "expect"] {
            assert!(paths.iter().any(|p| p == path), "{path} is missing in {paths:?}");
        }
    }
}
