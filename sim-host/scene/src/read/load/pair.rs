//! `contact.pair`: the coefficient of friction of a pair of materials, from published values.
//! The key remains in the tree, at the same place as the `mu` that follows from it.

use crate::diagnostic::Problem;
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
/// newer text remains.
///
/// # Errors
/// If the contact has no such model, or if the same text gives `mu` too.
pub(super) fn complete(root: &mut Node) -> Result<(), Problem> {
    let Some(node) = root.at("contact.pair").cloned() else { return Ok(()) };
    // An unknown name is reported by the schema.
    let Some(pair) = node.text().and_then(from_name) else { return Ok(()) };
    let path = MODELS.iter().map(|model| join(CONTACT, model)).find(|path| root.at(path).is_some());
    let table = path.as_ref().and_then(|path| match root.at_mut(path).map(|node| &mut node.value) {
        Some(Value::Table(table)) => Some(table),
        _ => None,
    });
    let Some((path, table)) = path.as_ref().zip(table) else {
        let problem = Problem::new(node.place, "`contact.pair` gives `mu`, but the contact has no model for it", "no model");
        return Err(problem.help("add a model that needs no static friction, such as [contact.dahl] with `stiffness_n_per_m`"));
    };
    match table.get(MU).map(|own| (own.node.place.source, own.key.clone())) {
        Some((source, _)) if source < node.place.source => return Ok(()),
        Some((source, own)) if source == node.place.source => {
            let message = format!("`{path}.mu` and `contact.pair` both give this value");
            return Err(Problem::new(own, message, "follows from the pair").help("remove one of the two"));
        }
        _ => {}
    }
    let entry = |value| Entry { key: node.place.clone(), node: Node { place: node.place.clone(), value } };
    let [low, high] = pair.mu();
    let range = [("low", low), ("high", high)].map(|(end, value)| (end.to_owned(), entry(Value::Number(value))));
    let value = if low < high { Value::Table(Table::from_iter(range)) } else { Value::Number(low) };
    table.insert(MU.to_owned(), entry(value));
    Ok(())
}

fn from_name(name: &str) -> Option<Pair> {
    Pair::deserialize(StrDeserializer::<Error>::new(name)).ok()
}

#[cfg(test)]
mod tests {
    use super::from_name;
    use crate::load::load_text;
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
            for end in from_name(name).expect("a pair").mu() {
                assert!(text.contains(&format!("{end:.2}")), "{name}: {end} is not in \"{text}\"");
            }
            assert!(text.contains('('), "{name}: no source");
        }
    }

    #[test]
    fn a_pair_is_refused_where_it_does_not_determine_the_friction() {
        for (own, says) in [
            ("contact.pair = \"steel-ptfe\"\ncontact.dahl.mu = 0.2\n", "`contact.dahl.mu` and `contact.pair` both give"),
            ("contact.pair = \"steel-pfte\"\n", "steel-ptfe"),
            ("[contact]\npair = \"steel-ptfe\"\n[contact.lugre]\nstatic_mu = 0.3\n", "has no model for it"),
        ] {
            let error = loaded(own, &[]).expect_err(own);
            assert!(error.contains(says), "{own}: {error}");
        }
    }

    #[test]
    fn the_friction_of_a_pair_is_named_as_assumed() {
        let text = "base = \"contact-kinematic\"\ngrid = false\nexpect = []\ncontact.pair = \"steel-steel\"\n";
        let assumed = load_text("mine.toml", text, &[]).expect("valid").assumed;
        let texts: Vec<String> = assumed.iter().map(super::super::Assumed::text).collect();
        assert!(texts.contains(&"contact.dahl.mu = 0.485 (of the pair steel-steel)".to_owned()), "{texts:?}");
        assert!(texts.iter().any(|text| text.starts_with("contact.dahl.stiffness_n_per_m")), "{texts:?}");
    }
}
