//! Scenes: a changed text, or values set by the schema, are either refused with a reason or a valid
//! scene, whose printed form is read as the same scene.

use std::sync::LazyLock;

use hal_mock::chance::Chance;
use scene::load::{LoadError, Loaded, load_text};
use scene::resolved::{resolved_json, resolved_toml};
use scene::schema::{Kind, Schema};
use scene::{all_keys, builtin};
use serde_json::Value;

use super::corpus;
use super::target::{Tally, Target};
use super::text::{changed, kind, kinds, pick};

pub(super) const TARGET: Target = Target {
    name: "scenes",
    what: "texts of scenes, and values set by the schema",
    seeds_per_million: 20,
    feed,
    corpus: |tally| corpus::SCENES.iter().try_for_each(|(name, text)| judge(name, text, &[], tally)),
};

/// Number of texts of each seed.
const TEXTS: usize = 10;

/// Names of all keys, and all strings that choices allow.
static WORDS: LazyLock<Vec<String>> = LazyLock::new(|| {
    let choices = Schema::tables().into_iter().flat_map(|(_, table)| {
        table.properties().flat_map(|(_, schema)| schema.choices()).map(|choice| format!("\"{choice}\"")).collect::<Vec<_>>()
    });
    all_keys::keys().into_iter().map(|key| key.path).chain(choices).collect()
});

/// The built-in scenes, with the keys that each of them has once it is resolved.
static KEYS: LazyLock<Vec<(&str, Vec<String>)>> = LazyLock::new(|| {
    let scenes = builtin::all().iter().filter_map(|(name, text)| Some((*text, load_text(name, text, &[]).ok()?)));
    let keys = scenes.map(|(text, loaded)| {
        let mut found = Vec::new();
        paths(&resolved_json(&loaded.scene), "", &mut found);
        (text, found)
    });
    keys.collect()
});

fn feed(seed: u64, tally: &mut Tally) -> Result<(), String> {
    let mut chance = Chance::new(seed);
    let texts: Vec<&str> = builtin::all().iter().chain(corpus::SCENES).map(|(_, text)| *text).collect();
    for _ in 0..TEXTS {
        if chance.strikes(0.4) {
            let Some((text, keys)) = pick(&mut chance, &KEYS) else { continue };
            let count = 1 + chance.below(4);
            let sets: Vec<String> = (0..count).map(|_| set(&mut chance, &keys)).collect();
            judge("fuzzed", text, &sets, tally)?;
            continue;
        }
        let [text, other] = [(); 2].map(|()| pick(&mut chance, &texts).unwrap_or_default());
        judge("fuzzed", &changed(&mut chance, text, other, &WORDS), &[], tally)?;
    }
    Ok(())
}

/// Draws an argument of `--set`: a key with a value of its kind.
fn set(chance: &mut Chance, keys: &[String]) -> String {
    // Mostly a key that the scene has; the table of any other one would be incomplete.
    let any = all_keys::keys();
    let key = if chance.strikes(0.2) { pick(chance, &any).map(|key| key.path) } else { pick(chance, keys) }.unwrap_or_default();
    let Some(schema) = Schema::root().at(&key) else { return format!("{key}=1") };
    format!("{key}={}", value(chance, schema))
}

/// Collects the paths of all values within a value.
fn paths(value: &Value, path: &str, found: &mut Vec<String>) {
    let join = |name: &str| if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") };
    match value {
        Value::Object(table) => table.iter().for_each(|(name, value)| paths(value, &join(name), found)),
        Value::Array(list) if list.iter().any(Value::is_object) => {
            list.iter().enumerate().for_each(|(n, value)| paths(value, &join(&n.to_string()), found));
        }
        _ => found.push(path.to_owned()),
    }
}

fn value(chance: &mut Chance, schema: Schema) -> String {
    if chance.strikes(0.1) {
        return pick(chance, &WORDS).unwrap_or_default();
    }
    match schema.kind() {
        Kind::Number | Kind::Integer => {
            let (least, most) = schema.range();
            let (least, most) = (least.unwrap_or(0.0), most.unwrap_or(1e3));
            let part = 1e-3 * chance.below(1001) as f64;
            let value = match chance.below(5) {
                0 => least,
                1 => most,
                2 => 10_f64.powf(20.0 * part - 10.0),
                3 => most + 1.0,
                _ => least + part * (most - least),
            };
            if schema.kind() == Kind::Integer { format!("{value:.0}") } else { format!("{value:?}") }
        }
        Kind::Flag => chance.strikes(0.5).to_string(),
        Kind::Choice => format!("\"{}\"", pick(chance, &schema.choices()).unwrap_or("none")),
        Kind::Text => "\"a text\"".to_owned(),
        Kind::List => {
            let items: Vec<String> =
                schema.items().map_or(Vec::new(), |items| (0..chance.below(4)).map(|_| value(chance, items)).collect());
            format!("[{}]", items.join(", "))
        }
        Kind::Table => "{}".to_owned(),
    }
}

fn judge(name: &str, text: &str, sets: &[String], tally: &mut Tally) -> Result<(), String> {
    tally.input(text.len() + sets.iter().map(String::len).sum::<usize>());
    let of_input = |failure: &str| format!("{failure}\n--set {sets:?}\n{text}");
    match load_text(name, text, sets) {
        Ok(loaded) => {
            tally.outcome("a scene");
            read_again(&loaded).map_err(|failure| of_input(&failure))
        }
        Err(LoadError::Invalid(report)) => {
            kinds(&report).map_err(|failure| of_input(&failure))?.iter().for_each(|kind| tally.outcome(kind));
            Ok(())
        }
        Err(error) => {
            tally.outcome(&kind(&error.to_string()));
            Ok(())
        }
    }
}

/// Checks that the output of `sim-host show` for a scene is read as the same scene.
fn read_again(loaded: &Loaded) -> Result<(), String> {
    let shown = resolved_toml(&loaded.scene);
    let again = load_text("shown", &shown, &[]).map_err(|error| format!("its printed form is refused: {error}"))?;
    if again.scene == loaded.scene { Ok(()) } else { Err("its printed form is another scene".into()) }
}
