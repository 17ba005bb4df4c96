//! Values that decide a result although the user did not set them for this transducer or contact.
//!
//! A force factor cannot be found by an electrical measurement, and a contact needs a measurement
//! of friction. Such a value is assumed if it is the default of the program, or if it comes from a
//! built-in base and other keys of the same table were changed: the result then describes a
//! transducer or a contact that is only partly the user's.

use serde::{Deserialize, Serialize};

use super::pair;
use crate::builtin;
use crate::diagnostic::Source;
use crate::keys::contact::Pair;
use crate::tree::{Entry, Node, Value};

/// Table of a stack, and the only key of it that no electrical measurement determines.
const STACK: (&str, &str) = ("stack.bvd", "force_factor_n_per_v");

/// A value that the user did not set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Assumed {
    /// Path of the key.
    pub key: String,
    /// Value of the key, in the unit of its name.
    pub value: f64,
    /// Built-in scene that the value is from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub base: Option<String>,
    /// Pair of materials whose published friction it is, for a range its middle. Without scene and
    /// pair, the value is a default of the program.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pair: Option<Pair>,
}

impl Assumed {
    /// Describes the value and its origin.
    pub fn text(&self) -> String {
        let (origin, range) = match (&self.base, self.pair.map(|pair| (pair.name(), pair.mu()))) {
            (_, Some((pair, range))) => (format!("the pair {pair}"), range),
            (Some(base), None) => (format!("from the scene {base}"), [self.value; 2]),
            (None, None) => ("the default".to_owned(), [self.value; 2]),
        };
        let value = if range[0] < range[1] { format!("{} to {}", range[0], range[1]) } else { self.value.to_string() };
        format!("{} = {value} ({origin})", self.key)
    }

    /// Returns a remark on these values, if there are any.
    pub fn remark(all: &[Self]) -> Option<String> {
        let values: Vec<String> = all.iter().map(Assumed::text).collect();
        let follow = "Results that follow from them are marked \"assumed\"";
        (!values.is_empty()).then(|| format!("Assumed, because you did not set them: {}. {follow}.", values.join(", ")))
    }

    /// Returns `true` if the value belongs to a contact, `false` if it belongs to a stack.
    pub fn is_contact(&self) -> bool {
        self.key.starts_with("contact.")
    }
}

/// Returns the assumed values of a scene's tree.
pub(super) fn find(root: &Node, sources: &[Source]) -> Vec<Assumed> {
    let base =
        |node: &Node| sources.get(node.place.source).map(|source| &source.name).filter(|name| builtin::text(name).is_some());
    // The table at a path, if the user gave a part of it.
    let inherited = |path: &str, only: Option<&str>| {
        let table = root.at(path).and_then(Node::table);
        let own = table.is_some_and(|table| table.values().any(|entry| base(&entry.node).is_none()));
        let entries = table.filter(|_| own).into_iter().flatten();
        let assumed = entries.filter(|(key, _)| only.is_none_or(|only| *key == only)).filter_map(|(key, entry)| {
            let base = Some(base(&entry.node)?.clone());
            Some(Assumed { key: format!("{path}.{key}"), value: entry.node.number()?, base, pair: None })
        });
        assumed.collect::<Vec<_>>()
    };
    let (stack, key) = STACK;
    let mut found = inherited(stack, Some(key));
    if root.at(stack).and_then(Node::table).is_some_and(|table| !table.contains_key(key)) {
        found.push(Assumed {
            key: format!("{stack}.{key}"),
            value: crate::keys::plant::DEFAULT_FORCE_FACTOR_N_PER_V,
            base: None,
            pair: None,
        });
    }
    let contacts = root.at("contact").and_then(Node::table).into_iter().flatten();
    let laws = contacts.filter(|(_, entry)| matches!(entry.node.value, Value::Table(_)));
    found.extend(laws.flat_map(|(law, _)| inherited(&format!("contact.{law}"), None)));
    found.extend(of_pair(root));
    found
}

/// Returns the coefficient of friction if it follows from a pair of materials.
fn of_pair(root: &Node) -> Option<Assumed> {
    let pair = root.at("contact.pair")?;
    let follows = |entry: &&Entry| entry.node.place == pair.place;
    let (model, mu) = root.at("contact")?.table()?.iter().find_map(|(model, entry)| {
        let mu = entry.node.table()?.get("mu").filter(follows)?;
        Some((model, mu.node.number()?))
    })?;
    Some(Assumed { key: format!("contact.{model}.mu"), value: mu, base: None, pair: Some(pair::from_name(pair.text()?)?.1) })
}

#[cfg(test)]
mod tests {
    use super::super::{load, load_text};

    fn assumed(text: &str, sets: &[&str]) -> Vec<String> {
        let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
        let loaded = load_text("mine.toml", text, &sets).unwrap_or_else(|error| panic!("{error}"));
        loaded.assumed.iter().map(super::Assumed::text).collect()
    }

    #[test]
    fn a_partly_given_contact_is_assumed_in_its_other_values() {
        let mine = "base = \"contact-kinematic\"\ngrid = false\n[contact.dahl]\nmu = 0.4\n";
        let [normal, stiffness] = assumed(mine, &[]).try_into().expect("two values");
        assert!(
            normal.starts_with("contact.dahl.normal_n = ") && normal.ends_with("(from the scene contact-kinematic)"),
            "{normal}"
        );
        assert!(stiffness.starts_with("contact.dahl.stiffness_n_per_m = "), "{stiffness}");
        let given = ["contact.dahl.stiffness_n_per_m=1e6", "contact.dahl.normal_n={ low = 1, high = 2 }"];
        assert!(assumed(mine, &given).is_empty());
        // Another excitation of the same contact.
        assert!(assumed("base = \"contact-kinematic\"\n", &["excitation.frequency_hz=70e3"]).is_empty());
    }

    #[test]
    fn a_key_of_a_sweep_is_given_and_the_rest_of_its_contact_assumed() {
        let loaded = load("contact-kinematic", &[]).expect("built in");
        let keys = |keys: &[&str]| loaded.assumed_with(keys).into_iter().map(|assumed| assumed.key).collect::<Vec<_>>();
        assert_eq!(keys(&["excitation.velocity_ratio"]), [""; 0]);
        assert_eq!(keys(&["contact.dahl.mu"]), ["contact.dahl.normal_n", "contact.dahl.stiffness_n_per_m"]);
        assert_eq!(keys(&["contact.dahl.mu", "contact.dahl.stiffness_n_per_m"]), ["contact.dahl.normal_n"]);
        let mine = load_text("mine.toml", "base = \"lock\"\n[stack.bvd]\nq = 200\n", &[]).expect("valid");
        assert_eq!(mine.assumed_with(&["stack.bvd.q"]).len(), 1);
        assert!(mine.assumed_with(&["stack.bvd.force_factor_n_per_v"]).is_empty());
    }

    #[test]
    fn a_force_factor_is_assumed_unless_it_is_given_for_this_stack() {
        let of_base = ["stack.bvd.force_factor_n_per_v = 5.566 (from the scene lock)"];
        assert_eq!(assumed("base = \"lock\"\n[stack.bvd]\nq = 200\n", &[]), of_base);
        assert_eq!(assumed("base = \"lock\"\n", &["stack.bvd.q=200"]), of_base);
        assert!(assumed("base = \"lock\"\n", &["stack.bvd.q=200", "stack.bvd.force_factor_n_per_v=2"]).is_empty());
        for (name, _) in crate::builtin::all() {
            // Those of an electrical measurement have no force factor.
            let assumed = load(name, &[]).expect("built in").assumed;
            assert!(assumed.is_empty() || name.starts_with("transducer-") && assumed[0].base.is_none(), "{name}");
        }
        let mut alone = crate::builtin::text("lock").expect("built in").to_owned();
        alone = alone.lines().filter(|line| !line.contains("force_factor_n_per_v")).map(|line| format!("{line}\n")).collect();
        assert_eq!(assumed(&alone, &[]), ["stack.bvd.force_factor_n_per_v = 1 (the default)"]);
    }
}
