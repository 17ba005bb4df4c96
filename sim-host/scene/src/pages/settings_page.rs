//! Sections with all settings of the controller, from the tables in the firmware.

use std::fmt::Write as _;
use std::sync::LazyLock;

use firmware::board::parameters::PARAMETERS;
use firmware::seam::config::{FrontEnd, HeatSink, Link, Supply};
use firmware::seam::config::{Parameter, Range};
use schemars::generate::SchemaSettings;
use serde_json::Value;

use crate::nearest::shown;
use crate::schema::{Kind, Schema, join};

const HEAD: &str = "
## Settings of the controller

A scene has these keys in the table `[controller]`; a name ends with its unit.
A board has them as **parameters**: `sim-host link PORT settings set NAME VALUE`, with table and key as NAME, such as `drive.amplitude_v`.
A parameter takes effect after `settings store` and `reset`. Its number never changes its meaning.

Over the link, a limit can be lowered, but never raised above the value that is built into the image (`lowered only`).
For limits of voltage, current and power, this ceiling is a fixed number of converter codes, independent of the scale factors.
";

/// Settings of the front end, which only a board has.
static FRONT_END: LazyLock<Value> =
    LazyLock::new(|| SchemaSettings::draft2020_12().into_generator().into_root_schema_for::<FrontEnd>().to_value());
/// Settings of the heat sink, which only a board has.
static HEAT_SINK: LazyLock<Value> =
    LazyLock::new(|| SchemaSettings::draft2020_12().into_generator().into_root_schema_for::<HeatSink>().to_value());
/// Settings of the supply, which only a board has.
static SUPPLY: LazyLock<Value> =
    LazyLock::new(|| SchemaSettings::draft2020_12().into_generator().into_root_schema_for::<Supply>().to_value());
/// Settings of the link, which only a board has.
static LINK: LazyLock<Value> =
    LazyLock::new(|| SchemaSettings::draft2020_12().into_generator().into_root_schema_for::<Link>().to_value());

/// Returns the sections, in Markdown.
pub fn sections() -> String {
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
    page += "\n## Settings of a board only\n\n";
    page += "A scene does not have these: its converters and sensors give the scale factors, and it needs no link.\n";
    for (path, value) in [("front_end", &FRONT_END), ("heat_sink", &HEAT_SINK), ("supply", &SUPPLY), ("link", &LINK)] {
        section(&mut page, &format!("`{path}`"), path, Schema::new(value), &mut listed);
    }
    page += "\n### Other parameters\n\n| name | range | parameter |\n|---|---|---|\n";
    for parameter in PARAMETERS.iter().filter(|parameter| !listed.contains(&parameter.key)) {
        let (least, most) = parameter.range.of(f32::INFINITY);
        // Shortest form of a single-precision number.
        let [least, most] = [least, most].map(|end| end.to_string().parse().ok());
        let range = written_range(least, most);
        let _ = writeln!(page, "| `{}` | {range} | {} |", parameter.name, held(parameter));
    }
    page
}

fn section(page: &mut String, title: &str, path: &str, table: Schema, listed: &mut Vec<u8>) {
    let _ = write!(page, "\n### {title}\n\n{}\n\n", table.description().unwrap_or_default().replace('\n', " "));
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

/// Returns the range of a key in words.
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

/// Returns the default of a key in words.
pub(crate) fn default(schema: Schema, required: bool) -> String {
    match schema.default() {
        Some(Value::Number(number)) => number.as_f64().map(shown).unwrap_or_default(),
        Some(Value::String(text)) if text.is_empty() => "empty".to_owned(),
        Some(Value::String(text)) => format!("`{text}`"),
        Some(Value::Bool(flag)) => format!("`{flag}`"),
        _ if required => "must be given".to_owned(),
        // Serde omits these keys if they have their default: false or, if that is allowed, zero.
        _ if schema.kind() == Kind::Flag => "`false`".to_owned(),
        _ if schema.is_number() && schema.range().0.is_some_and(|least| least > 0.0) && !schema.is_optional() => String::new(),
        _ if schema.is_number() && !schema.is_optional() => "0".to_owned(),
        _ => "none".to_owned(),
    }
}

/// Returns the number of a parameter, and its restriction in addition to the range.
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
    fn choices_have_equal_names_in_link_and_scene() {
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
        // A scene has no `enabled` keys: the table is present or absent.
        let in_scenes =
            |parameter: &&Parameter| matches!(parameter.range, Range::Choice(_)) && !parameter.name.ends_with(".enabled");
        assert_eq!(choices, PARAMETERS.iter().filter(in_scenes).count());
    }
}
