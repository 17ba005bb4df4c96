//! `contact.pair`: the coefficient of friction of a pair of materials, from published values.
//! The key remains in the tree, at the same place as the `mu` that follows from it.

use super::SET;
use crate::diagnostic::{Place, Problem};
use crate::keys::contact::Pair;
use crate::schema::join;
use crate::tree::{Entry, Node, Table, Value};
use serde::Deserialize;
use serde::de::value::{Error, StrDeserializer};

const CONTACT: &str = "contact";
const MU: &str = "mu";
/// Models whose friction a pair determines. The LuGre model needs a static coefficient too, and the
/// empirical law is that of a seat belt.
const MODELS: [&str; 5] = ["coulomb", "dahl", "hertz", "compliant", "expression"];

/// Adds the coefficient of friction that follows from `contact.pair`, or its range. A `mu` of a
/// newer text remains, and so does one of a later change.
///
/// # Errors
/// If the contact has no such model, or if the same text gives `mu` too.
pub(super) fn complete(root: &mut Node) -> Result<(), Problem> {
    let Some(node) = root.at("contact.pair").cloned() else { return Ok(()) };
    // An unknown name is reported by the schema.
    let Some((name, pair)) = node.text().and_then(from_name) else { return Ok(()) };
    if let Some(node) = root.at_mut("contact.pair") {
        node.value = Value::Text(name);
    }
    let path = MODELS.iter().map(|model| join(CONTACT, model)).find(|path| root.at(path).is_some());
    let Some(path) = path else { return other_model(root, &node) };
    let Some(Value::Table(table)) = root.at_mut(&path).map(|node| &mut node.value) else { return Ok(()) };
    if let Some(own) = table.get(MU).map(|own| own.node.place.clone()) {
        if is_newer(&own, &node.place) {
            return Ok(());
        }
        if own.source == node.place.source && own.source != SET.source {
            let message = format!("`{path}.mu` and `contact.pair` both give this value");
            return Err(Problem::new(own, message, "follows from the pair").help("remove one of the two"));
        }
    }
    let entry = |value| Entry { key: node.place.clone(), node: Node { place: node.place.clone(), value } };
    let [low, high] = pair.mu();
    let range = [("low", low), ("high", high)].map(|(end, value)| (end.to_owned(), entry(Value::Number(value))));
    let value = if low < high { Value::Table(Table::from_iter(range)) } else { Value::Number(low) };
    table.insert(MU.to_owned(), entry(value));
    Ok(())
}

/// Returns `true` if a value replaces another one: newer texts have lower numbers, and later
/// changes follow earlier ones.
fn is_newer(value: &Place, other: &Place) -> bool {
    value.source < other.source || value.source == SET.source && other.source == SET.source && value.start > other.start
}

/// Checks a contact whose friction no pair determines. One of a newer text replaces the pair.
fn other_model(root: &Node, pair: &Node) -> Result<(), Problem> {
    let table = root.at(CONTACT).and_then(Node::table);
    let model = table.into_iter().flatten().find(|(_, entry)| matches!(entry.node.value, Value::Table(_)));
    let Some((model, entry)) = model else {
        let message = "`contact.pair` gives `mu`, but the scene has no contact model";
        let problem = Problem::new(pair.place.clone(), message, "nothing to apply it to");
        return Err(problem.help("add a model, such as [contact.dahl] with `stiffness_n_per_m`"));
    };
    if entry.node.at(MU).is_some_and(|mu| is_newer(&mu.place, &pair.place)) {
        return Ok(());
    }
    let message = format!("`contact.pair` gives kinetic friction only, which is not enough for [contact.{model}]");
    let problem = Problem::new(pair.place.clone(), message, "not for this model");
    Err(problem.help("remove the pair, and write the numbers of the model; `sim-host explain contact.pair` lists the pairs"))
}

/// Returns the pair with this name, in either order, and the name of the schema.
pub(super) fn from_name(name: &str) -> Option<(String, Pair)> {
    let known = |name: &str| Pair::deserialize(StrDeserializer::<Error>::new(name)).ok().map(|pair| (name.to_owned(), pair));
    known(name).or_else(|| name.split_once('-').and_then(|(one, other)| known(&format!("{other}-{one}"))))
}

#[cfg(test)]
mod tests {
    use super::from_name;
    use crate::load::{load, load_text};
    use crate::schema::Schema;

    fn loaded(own: &str, sets: &[&str]) -> Result<crate::Scene, String> {
        let text = format!("base = \"contact-kinematic\"\ngrid = false\nexpect = []\n{own}");
        let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
        load_text("mine.toml", &text, &sets).map(|loaded| loaded.scene).map_err(|error| error.to_string())
    }

    fn mu(scene: &crate::Scene) -> f64 {
        scene.contact.as_ref().and_then(|contact| contact.model()).map_or(f64::NAN, |model| model.mu())
    }

    #[test]
    fn a_pair_gives_its_published_friction_to_any_model() {
        for model in
            ["", "[contact.coulomb]\nnormal_n = 1\n", "[contact.expression]\nnormal_n = 1\nforce = \"mu * N * sign(v)\"\n"]
        {
            let one = loaded(&format!("contact.pair = \"steel-ptfe\"\n{model}"), &[]).expect("one number");
            assert_eq!((mu(&one), one.vary.len()), (0.16, 0));
        }
        let range = loaded("contact.pair = \"steel-steel\"\n", &[]).expect("a range");
        assert_eq!((mu(&range), range.vary.len(), range.vary[0].key.as_str()), (0.485, 1, "contact.dahl.mu"));
        // Newer texts replace older ones, in both directions.
        let own = loaded("contact.pair = \"steel-steel\"\n", &["contact.dahl.mu=0.2"]).expect("valid");
        assert_eq!((mu(&own), own.vary.len()), (0.2, 0));
        let set = loaded("contact.dahl.mu = 0.2\n", &["contact.pair=steel-ptfe"]).expect("valid");
        assert_eq!(mu(&set), 0.16);
    }

    #[test]
    fn every_number_is_in_the_text_with_its_source() {
        let described = Schema::root().at("contact.pair").expect("a key").described_choices();
        assert!(described.len() > 5);
        for (name, text) in described {
            for end in from_name(name).expect("a pair").1.mu() {
                assert!(text.contains(&format!("{end:.2}")), "{name}: {end} is not in \"{text}\"");
            }
            assert!(text.contains('('), "{name}: no source");
        }
    }

    #[test]
    fn a_pair_without_a_fitting_model_is_refused() {
        for (own, says) in [
            ("contact.pair = \"steel-ptfe\"\ncontact.dahl.mu = 0.2\n", "`contact.dahl.mu` and `contact.pair` both give"),
            ("contact.pair = \"steel-pfte\"\n", "steel-ptfe"),
            ("[contact]\npair = \"steel-ptfe\"\n[contact.lugre]\nstatic_mu = 0.3\n", "not enough for [contact.lugre]"),
        ] {
            let error = loaded(own, &[]).expect_err(own);
            assert!(error.contains(says) && error.contains("--> mine.toml"), "{own}: {error}");
        }
        let error = load("lock", &["contact.pair=steel-ptfe".to_owned()]).expect_err("no contact").to_string();
        assert!(error.contains("the scene has no contact model"), "{error}");
    }

    #[test]
    fn the_last_of_pair_and_friction_counts() {
        let last = |sets: &[&str]| mu(&loaded("contact.dahl.mu = 0.3\n", sets).expect("valid"));
        assert_eq!(last(&["contact.pair=steel-ptfe", "contact.dahl.mu=0.2"]), 0.2);
        assert_eq!(last(&["contact.dahl.mu=0.2", "contact.pair=ptfe-steel"]), 0.16);
        let text = "base = \"contact-kinematic\"\ngrid = false\nexpect = []\ncontact.pair = \"steel-ptfe\"\n";
        let mine = load_text("mine.toml", text, &[]).expect("valid");
        let template = mine.template().expect("valid");
        for (set, expected) in [("contact.dahl.mu=0.2", 0.2), ("contact.pair=steel-glass", 0.12)] {
            assert_eq!(mu(&template.scene(&[set.to_owned()]).expect("valid")), expected, "{set}");
        }
    }

    #[test]
    fn the_friction_of_a_pair_is_named_as_assumed() {
        let text = "base = \"contact-kinematic\"\ngrid = false\nexpect = []\ncontact.pair = \"steel-steel\"\n";
        let assumed = load_text("mine.toml", text, &[]).expect("valid").assumed;
        let texts: Vec<String> = assumed.iter().map(super::super::Assumed::text).collect();
        assert!(texts.contains(&"contact.dahl.mu = 0.23 to 0.74 (the pair steel-steel)".to_owned()), "{texts:?}");
        assert!(texts.iter().any(|text| text.starts_with("contact.dahl.stiffness_n_per_m")), "{texts:?}");
    }
}
