//! Inherited parts of a scene, and its changes relative to its base.
//!
//! Title, source, notes and expectations are written for certain inputs. A text with a `base`, or
//! `--set` on a built-in scene, can change these inputs. Then the parts that it does not state
//! itself still describe the other scene. A user's own text without a base states all of them
//! itself, so they remain valid with any `--set`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::{Loaded, ReadScene, builtin, load_text, read};
use crate::resolved::resolved_json;
use crate::tree::{Node, Value};

/// Keys of a scene that are not inputs of its run.
const NON_INPUT_KEYS: [&str; 9] = ["title", "source", "notes", "expect", "seed", "trace", "overlay", "grid", "comparison"];

/// Inherited parts of a scene, and its differences from its base.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Inherited {
    /// Name or file of the base.
    pub base: String,
    /// Values that differ, sorted by key.
    pub changes: Vec<Change>,
    /// `true` if the title is that of the base, but inputs were changed.
    pub title: bool,
    /// `true` if the source is that of the base, but inputs were changed.
    pub source: bool,
    /// `true` if the notes are those of the base, but inputs were changed.
    pub notes: bool,
    /// `true` if the expectations are those of the base, but inputs were changed.
    pub expect: bool,
}

/// A value that differs from the base.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Change {
    /// Path of the key.
    pub key: String,
    /// Value in the base, or `None` if it does not have the key.
    pub was: Option<String>,
    /// Value here, or `None` if the key was removed.
    pub is: Option<String>,
}

impl Loaded {
    /// Returns the inherited parts and the changes of the scene, or `None` if it has no base.
    pub fn inherited(&self) -> Option<Inherited> {
        if self.repeats.is_some() {
            return self.repeats.clone();
        }
        let (sources, read_whole) = read(&self.origin, &self.input, &self.sets);
        let ReadScene { root, texts, .. } = read_whole.ok()?;
        let built_in = builtin::text(&self.origin).is_some();
        let reference = if built_in || texts == 2 { 1 } else { 2 };
        let source = &sources[reference];
        let (given, sets) = self.sets.split_at(self.defaults);
        if reference == 1 && sets.is_empty() {
            return None;
        }
        let base = load_text(&source.name, &source.text, given).ok()?;
        let (_, under) = read(&source.name, &source.text, given);
        let (ours, theirs) = (leaves(&root), leaves(&under.ok()?.root));
        let (here, there) = (resolved_json(&self.scene), resolved_json(&base.scene));
        let mut changes: Vec<Change> = Vec::new();
        for (key, value) in &ours {
            let was = theirs.get(key).cloned().or_else(|| at(&there, key));
            if was.as_ref() != Some(value) {
                changes.push(Change { key: key.clone(), was, is: Some(value.clone()) });
            }
        }
        let gone = theirs.iter().filter(|(key, _)| !ours.contains_key(*key));
        changes.extend(gone.map(|(key, value)| Change { key: key.clone(), was: Some(value.clone()), is: at(&here, key) }));
        changes.retain(|change| change.was != change.is);
        changes.sort_by(|a, b| a.key.cmp(&b.key));
        let changed = changes.iter().any(|change| !NON_INPUT_KEYS.contains(&change.key.split('.').next().unwrap_or_default()));
        // A user's own text is always about its own inputs.
        let foreign = changed && (built_in || reference == 2);
        let of_base = |key: &str| foreign && root.entry(key).is_some_and(|entry| newest(&entry.node) >= reference);
        Some(Inherited {
            base: source.name.clone(),
            title: of_base("title"),
            source: of_base("source"),
            notes: of_base("notes"),
            expect: of_base("expect"),
            changes,
        })
    }
}

/// Returns the newest text that contributes to a value.
fn newest(node: &Node) -> usize {
    let inner = match &node.value {
        Value::List(list) => list.iter().map(newest).min(),
        Value::Table(table) => table.values().map(|entry| newest(&entry.node)).min(),
        _ => None,
    };
    inner.map_or(node.place.source, |inner| inner.min(node.place.source))
}

/// Returns every value of a tree by its path.
fn leaves(root: &Node) -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    collect(root, "", &mut found);
    found
}

fn collect(node: &Node, path: &str, found: &mut BTreeMap<String, String>) {
    let join = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
    match &node.value {
        Value::Table(table) => table.iter().for_each(|(key, entry)| collect(&entry.node, &join(key), found)),
        Value::List(list) if list.iter().any(|node| matches!(node.value, Value::Table(_))) => {
            list.iter().enumerate().for_each(|(index, node)| collect(node, &join(&index.to_string()), found));
        }
        value => {
            found.insert(path.to_owned(), shown(value));
        }
    }
}

/// Returns a value in its JSON form, so that equal numbers have equal texts.
fn shown(value: &Value) -> String {
    match value {
        Value::Flag(flag) => flag.to_string(),
        Value::Integer(number) => shown_number(*number as f64),
        Value::Number(number) => shown_number(*number),
        Value::Text(text) | Value::Date(text) => text.clone(),
        Value::List(list) => format!("[{}]", list.iter().map(|node| shown(&node.value)).collect::<Vec<_>>().join(", ")),
        Value::Samples(samples) => format!("{} numbers", samples.len()),
        Value::Table(_) => String::new(),
    }
}

fn shown_number(number: f64) -> String {
    let size = number.abs();
    if size == 0.0 || (1e-4..1e9).contains(&size) { number.to_string() } else { format!("{number:e}") }
}

/// Returns the value at a path of a resolved scene.
fn at(json: &serde_json::Value, path: &str) -> Option<String> {
    let found = path.split('.').try_fold(json, |value, key| match value {
        serde_json::Value::Array(list) => list.get(key.parse::<usize>().ok()?),
        value => value.get(key),
    })?;
    json_text(found)
}

/// Returns a JSON value as text, or `None` for null.
pub(super) fn json_text(value: &serde_json::Value) -> Option<String> {
    match value {
        serde_json::Value::Null => None,
        serde_json::Value::Number(number) => number.as_f64().map(shown_number),
        serde_json::Value::String(text) => Some(text.clone()),
        serde_json::Value::Array(list) => Some(format!("[{}]", list.iter().filter_map(json_text).collect::<Vec<_>>().join(", "))),
        other => Some(other.to_string()),
    }
}

/// Returns every key of a scene with its value, in the order of the scene, defaults included.
pub fn inputs(scene: &crate::Scene) -> Vec<(String, String)> {
    let mut found = Vec::new();
    flatten(&resolved_json(scene), "", &mut found);
    found.retain(|(key, _)| !["title", "source", "notes", "expect"].contains(&key.split('.').next().unwrap_or_default()));
    found
}

fn flatten(value: &serde_json::Value, path: &str, found: &mut Vec<(String, String)>) {
    let join = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
    match value {
        serde_json::Value::Object(map) => map.iter().for_each(|(key, value)| flatten(value, &join(key), found)),
        serde_json::Value::Array(list) if list.iter().any(serde_json::Value::is_object) => {
            list.iter().enumerate().for_each(|(index, value)| flatten(value, &join(&index.to_string()), found));
        }
        value => found.extend(json_text(value).map(|text| (path.to_owned(), text))),
    }
}

#[cfg(test)]
mod tests {
    use super::super::{load, load_text};
    use super::*;

    fn inherited_by(text: &str, sets: &[&str]) -> Option<Inherited> {
        let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
        let loaded = if text.contains('=') { load_text("mine.toml", text, &sets) } else { load(text, &sets) };
        loaded.unwrap_or_else(|error| panic!("{error}")).inherited()
    }

    fn flags(of: &Inherited) -> [bool; 4] {
        [of.title, of.source, of.notes, of.expect]
    }

    #[test]
    fn unstated_parts_are_inherited_from_the_base() {
        let found = inherited_by("base = \"contact\"\ntitle = \"mine\"\n[contact.dahl]\nmu = 0.15\n", &[]).unwrap();
        assert_eq!((found.base.as_str(), flags(&found)), ("contact", [false, true, true, true]));
        let change = |key: &str, was: &str, is: &str| Change { key: key.into(), was: Some(was.into()), is: Some(is.into()) };
        assert_eq!(found.changes[0], change("contact.dahl.mu", "0.1", "0.15"));
        assert_eq!(found.changes.len(), 2);
    }

    #[test]
    fn stated_expectations_are_not_inherited() {
        let text = "base = \"contact\"\n[contact.dahl]\nmu = 0.15\n[[expect]]\nmetric = \"friction_ratio\"\nmax = 1\n";
        assert!(!inherited_by(text, &[]).unwrap().expect);
        // The same after a `--set` on top of it.
        assert!(!inherited_by(text, &["rig.sdof.mass_kg=0.03"]).unwrap().expect);
        assert!(!inherited_by("contact", &["contact.dahl.mu=0.15", "expect.0.tolerance=1"]).unwrap().expect);
        assert!(inherited_by("contact", &["contact.dahl.mu=0.15"]).unwrap().expect);
    }

    #[test]
    fn changes_without_inputs_inherit_nothing() {
        assert_eq!(inherited_by("contact", &[]), None);
        for sets in [&["seed=7"][..], &["contact.dahl.mu=0.1"], &["contact.dahl.mu=1e-1", "title=other"]] {
            assert_eq!(flags(&inherited_by("contact", sets).unwrap()), [false; 4], "{sets:?}");
        }
    }

    #[test]
    fn a_text_without_base_inherits_nothing() {
        let text = builtin::text("contact").unwrap();
        assert_eq!(inherited_by(text, &[]), None);
        let found = inherited_by(text, &["contact.dahl.mu=0.15"]).unwrap();
        assert_eq!((flags(&found), found.changes.len()), ([false; 4], 1));
    }

    #[test]
    fn a_key_replaces_those_that_it_excludes() {
        let found = inherited_by("lock", &["stack.bvd.rm_ohm=4", "stack.bvd.lm_h=7.7e-4", "stack.bvd.cm_f=20e-9"]).unwrap();
        let keys: Vec<&str> = found.changes.iter().map(|change| change.key.as_str()).collect();
        assert!(["rm_ohm", "lm_h", "q"].iter().all(|key| keys.contains(&format!("stack.bvd.{key}").as_str())), "{keys:?}");
    }

    #[test]
    fn program_defaults_are_not_changes() {
        let loaded = load("lock", &[]).unwrap().with_defaults(&["amplifier.delay_s=1e-6".to_owned()]).unwrap();
        assert_eq!((loaded.defaults, loaded.inherited()), (1, None));
        let changed = loaded.changed(&["stack.bvd.q=60".to_owned()]).unwrap().inherited().unwrap();
        assert_eq!((changed.changes.len(), changed.expect), (1, true));
    }

    #[test]
    fn inputs_are_all_keys_with_their_defaults() {
        let inputs = inputs(&load("lock", &[]).unwrap().scene);
        let value = |key: &str| inputs.iter().find(|(name, _)| name == key).map(|(_, value)| value.as_str());
        assert_eq!(value("controller.block_samples"), Some("32"));
        assert!(value("title").is_none() && value("stack.bvd.q").is_some());
    }
}
