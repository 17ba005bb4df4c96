//! The page of all settings of the controller, from the tables that the firmware describes them by.

use std::fmt::Write as _;
use std::sync::LazyLock;

use firmware::board::parameters::PARAMETERS;
use firmware::seam::config::{FrontEnd, HeatSink, Link, Supply};
use firmware::seam::config::{Parameter, Range};
use schemars::generate::SchemaSettings;
use serde_json::Value;

use crate::nearest::shown;
use crate::schema::{Kind, Schema, join};

const HEAD: &str = "\
# Settings of the controller

Every setting with its range, its default, and where it can be set. Every table is generated from
`firmware/src/seam/config`, where each setting is described once: the build's check, the scene's keys, the JSON Schema (`sim-host schema`) and the
parameters of the link follow from the same lines.

A **key** stands in the `[controller]` part of a scene; its unit is the end of its name. A **parameter** is set over the link with
`sim-host link PORT settings set NAME VALUE`, where its name is table and key, and acts after `store` and `reset`; its number never changes its
meaning. A limit can be lowered over the link and never raised beyond what is built into the image; the ceiling of a limit of
voltage, current or power is as many codes of the converters as what is built in, whatever their scale factors say that a code is worth.
";

/// The settings that only a board has.
static FRONT_END: LazyLock<Value> =
    LazyLock::new(|| SchemaSettings::draft2020_12().into_generator().into_root_schema_for::<FrontEnd>().to_value());
static HEAT_SINK: LazyLock<Value> =
    LazyLock::new(|| SchemaSettings::draft2020_12().into_generator().into_root_schema_for::<HeatSink>().to_value());
static SUPPLY: LazyLock<Value> =
    LazyLock::new(|| SchemaSettings::draft2020_12().into_generator().into_root_schema_for::<Supply>().to_value());
static LINK: LazyLock<Value> =
    LazyLock::new(|| SchemaSettings::draft2020_12().into_generator().into_root_schema_for::<Link>().to_value());

/// The page, in Markdown.
pub fn page() -> String {
    let mut page = HEAD.to_owned();
    let mut listed = Vec::new();
    let controller = Schema::tables().into_iter().filter_map(|(path, table)| {
        let inner = path.strip_prefix("controller")?;
        Some((inner.trim_start_matches('.').to_owned(), table))
    });
    for (path, table) in controller {
        let title = if path.is_empty() { "`[controller]`".to_owned() } else { format!("`[controller.{path}]`") };
        section(&mut page, &title, &path, table, &mut listed);
    }
    page += "\n## Of a board alone\n\nNo scene has these: its converters and sensors say what they are worth, and it is its own host.\n";
    for (path, value) in [("front_end", &FRONT_END), ("heat_sink", &HEAT_SINK), ("supply", &SUPPLY), ("link", &LINK)] {
        section(&mut page, &format!("`{path}`"), path, Schema::of(value), &mut listed);
    }
    page += "\n### Other parameters\n\n| name | range | parameter |\n|---|---|---|\n";
    for parameter in PARAMETERS.iter().filter(|parameter| !listed.contains(&parameter.key)) {
        let (least, most) = parameter.range.of(f32::INFINITY);
        // As short as a number of single precision is written.
        let [least, most] = [least, most].map(|end| end.to_string().parse().ok());
        let range = written_range(least, most);
        let _ = writeln!(page, "| `{}` | {range} | {} |", parameter.name, held(parameter));
    }
    page
}

fn section(page: &mut String, title: &str, path: &str, table: Schema, listed: &mut Vec<u8>) {
    let level = if title.contains('[') { "##" } else { "###" };
    let _ = write!(page, "\n{level} {title}\n\n{}\n\n", table.description().unwrap_or_default().replace('\n', " "));
    *page += "| key | meaning | range | default | parameter |\n|---|---|---|---|---|\n";
    for (key, schema) in table.properties().filter(|(_, schema)| schema.kind() != Kind::Table) {
        let name = join(path, key);
        let parameter = PARAMETERS.iter().find(|parameter| parameter.name == name);
        listed.extend(parameter.map(|parameter| parameter.key));
        let meaning = schema.description().unwrap_or_default().replace('\n', " ");
        let required = table.required().any(|required| required == key);
        let (range, default) = (range(schema), default(schema, required));
        let _ = writeln!(page, "| `{key}` | {meaning} | {range} | {default} | {} |", parameter.map(held).unwrap_or_default());
    }
}

/// Which values a key may have, in words.
pub(crate) fn range(schema: Schema) -> String {
    match schema.kind() {
        Kind::Choice => schema.choices().iter().map(|choice| format!("`{choice}`")).collect::<Vec<_>>().join(" "),
        Kind::Flag => "`true` `false`".to_owned(),
        Kind::List => {
            let most = schema.lengths().1.map(|most| format!("up to {most}"));
            let each = schema.items().map(range).filter(|range| !range.is_empty()).map(|range| format!("each {range}"));
            most.into_iter().chain(each).collect::<Vec<_>>().join(", ")
        }
        _ => written_range(schema.range().0, schema.range().1),
    }
}

fn written_range(least: Option<f64>, most: Option<f64>) -> String {
    match (least, most) {
        (Some(least), Some(most)) => format!("{} to {}", shown(least), shown(most)),
        _ => String::new(),
    }
}

/// What a key is where a scene does not say, in words.
pub(crate) fn default(schema: Schema, required: bool) -> String {
    match schema.default() {
        Some(Value::Number(number)) => number.as_f64().map(shown).unwrap_or_default(),
        Some(Value::String(text)) if text.is_empty() => "empty".to_owned(),
        Some(Value::String(text)) => format!("`{text}`"),
        Some(Value::Bool(flag)) => format!("`{flag}`"),
        _ if required => "must be given".to_owned(),
        // What a scene leaves out where it is zero.
        _ if schema.kind() == Kind::Flag => "`false`".to_owned(),
        _ if schema.is_number() && !schema.is_optional() => "0".to_owned(),
        _ => "none".to_owned(),
    }
}

/// The number of a parameter, and what holds it back besides its range.
fn held(parameter: &Parameter) -> String {
    match parameter.range {
        Range::Within(..) | Range::Scale(..) | Range::Choice(_) | Range::Whole(..) => parameter.key.to_string(),
        Range::UpToCeiling(..) => format!("{}, lowered only", parameter.key),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_choice_has_the_same_names_over_the_link_and_in_a_scene() {
        let mut choices = 0;
        for (path, table) in Schema::tables() {
            for (key, schema) in table.properties() {
                let name = join(path.strip_prefix("controller.").unwrap_or(&path), key);
                let Some(parameter) = PARAMETERS.iter().find(|parameter| parameter.name == name) else { continue };
                let Range::Choice(names) = parameter.range else { continue };
                choices += 1;
                let expected = if schema.kind() == Kind::Flag { vec!["false", "true"] } else { schema.choices() };
                assert_eq!(names, expected, "{name}");
            }
        }
        // A scene has a table or has it not.
        let in_scenes =
            |parameter: &&Parameter| matches!(parameter.range, Range::Choice(_)) && !parameter.name.ends_with(".enabled");
        assert_eq!(choices, PARAMETERS.iter().filter(in_scenes).count());
    }
}
