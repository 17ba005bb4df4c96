//! A scene with all defaults written out, for `sim-host show` and for the manifest of a run.

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::Scene;
use crate::schema::{Kind, Schema, join};

/// Longest comment line, characters.
const MAX_COMMENT_CHARS: usize = 110;
/// Longest key with value that has its comment on the same line, characters.
const MAX_INLINE_CHARS: usize = 44;

/// Largest number of choices that are listed in the comment.
const MAX_CHOICES: usize = 8;
/// Table that a design does not have.
const INTEGRATOR: &str = "integrator";

/// Returns the scene as TOML, every key with its meaning and unit. It can be read back as the same
/// scene.
pub fn resolved_toml(scene: &Scene) -> String {
    // Loading ensures that a scene holds only finite numbers and integers that TOML can represent.
    let text = toml::to_string(scene).unwrap_or_default();
    let mut out = String::new();
    if let Ok(table) = DeTable::parse(&text) {
        write_table(&mut out, &text, table.get_ref(), Schema::root(), "");
    }
    out
}

/// Returns the scene as JSON.
pub fn resolved_json(scene: &Scene) -> serde_json::Value {
    let mut json = serde_json::to_value(scene).unwrap_or_default();
    if let Some(table) = json.as_object_mut().filter(|_| scene.design.is_some()) {
        table.remove(INTEGRATOR);
    }
    json
}

fn write_table(out: &mut String, text: &str, table: &DeTable<'_>, schema: Schema, path: &str) {
    let is_shown = |key: &str| key != INTEGRATOR || !path.is_empty() || !table.contains_key("design");
    let mut entries: Vec<_> = table.iter().filter(|(key, _)| is_shown(key.get_ref())).collect();
    // In the order of the types, not alphabetically.
    entries.sort_by_key(|(key, _)| key.span().start);
    let (tables, values): (Vec<_>, Vec<_>) = entries.into_iter().partition(|(_, value)| holds_tables(value.get_ref()));
    write_values(out, text, &values, schema);
    for (key, value) in tables {
        let path = join(path, key.get_ref());
        let Some(schema) = schema.entry(key.get_ref()) else { continue };
        match value.get_ref() {
            DeValue::Table(table) => write_section(out, text, table, schema, &path, ("[", "]")),
            DeValue::Array(list) => {
                let Some(items) = schema.items() else { continue };
                list.iter().filter_map(|entry| entry.get_ref().as_table()).for_each(|table| {
                    write_section(out, text, table, items, &path, ("[[", "]]"));
                });
            }
            _ => {}
        }
    }
}

fn holds_tables(value: &DeValue<'_>) -> bool {
    value.is_table() || value.as_array().is_some_and(|list| list.iter().next().is_some_and(|entry| entry.get_ref().is_table()))
}

fn write_section(out: &mut String, text: &str, table: &DeTable<'_>, schema: Schema, path: &str, (open, close): (&str, &str)) {
    let only_tables = !table.is_empty() && table.iter().all(|(_, value)| holds_tables(value.get_ref()));
    if !only_tables {
        out.push('\n');
        comment(out, schema.description().unwrap_or_default());
        *out += &format!("{open}{path}{close}\n");
    }
    write_table(out, text, table, schema, path);
}

fn write_values(
    out: &mut String,
    text: &str,
    values: &[(&Spanned<toml::de::DeString<'_>>, &Spanned<DeValue<'_>>)],
    schema: Schema,
) {
    let lines = values.iter().map(|(key, value)| {
        let meaning = schema.property(key.get_ref()).map(meaning).unwrap_or_default();
        (format!("{} = {}", key.get_ref(), written(text, value)), meaning)
    });
    let lines: Vec<_> = lines.collect();
    let length = |text: &str| text.chars().count();
    let beside =
        |line: &str, meaning: &str| length(line) <= MAX_INLINE_CHARS && length(line) + length(meaning) <= MAX_COMMENT_CHARS;
    let column = lines.iter().filter(|(line, meaning)| beside(line, meaning)).map(|(line, _)| length(line)).max().unwrap_or(0);
    for (line, meaning) in &lines {
        if meaning.is_empty() {
            *out += &format!("{line}\n");
        } else if beside(line, meaning) {
            *out += &format!("{line:column$}  # {meaning}\n");
        } else {
            comment(out, meaning);
            *out += line;
            out.push('\n');
        }
    }
}

/// Returns the meaning of a key and its choices.
fn meaning(schema: Schema) -> String {
    let description = schema.description().unwrap_or_default().replace('\n', " ");
    let choices = schema.choices();
    if schema.kind() == Kind::Choice && choices.len() <= MAX_CHOICES {
        return format!("{}: {}.", description.trim_end_matches('.'), choices.join(" | "));
    }
    description
}

/// Returns a value as in the text, but numbers in their shortest form: `3e-7` instead of
/// `0.0000003`.
fn written(text: &str, value: &Spanned<DeValue<'_>>) -> String {
    match value.get_ref() {
        DeValue::Float(number) => {
            number.as_str().parse::<f64>().map_or_else(|_| number.as_str().to_owned(), |n| format!("{n:?}"))
        }
        DeValue::Array(list) => format!("[{}]", list.iter().map(|entry| written(text, entry)).collect::<Vec<_>>().join(", ")),
        _ => text.get(value.span()).unwrap_or_default().to_owned(),
    }
}

/// Appends a comment on its own lines, wrapped.
fn comment(out: &mut String, text: &str) {
    let mut line = String::new();
    for word in text.split_whitespace() {
        if !line.is_empty() && line.chars().count() + word.chars().count() + 3 > MAX_COMMENT_CHARS {
            *out += &format!("#{line}\n");
            line.clear();
        }
        line.push(' ');
        line += word;
    }
    if !line.is_empty() {
        *out += &format!("#{line}\n");
    }
}
