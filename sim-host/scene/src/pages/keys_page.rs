//! The page of all keys of a scene and all settings of the controller, from the schema.

use std::fmt::Write as _;

use super::settings_page;
use crate::all_keys::{Key, Repeats, keys};
use crate::schema::Schema;

const HEAD: &str = "\
# Keys of a scene and settings of the controller

Every key of a scene with its meaning, unit, range and default, and every setting of the controller.
`sim-host explain KEY` prints the same for one key.
`sim-host show lock` prints a scene with all its keys, and `sim-host schema` the JSON Schema for an editor.

A key with the default `none` is optional. `[table]` occurs once, `[[table]]` any number of times.
The settings of the controller are a table of a scene, `[controller]`, and parameters of a board: [below](#settings-of-the-controller).
";

/// Returns the page, in Markdown.
pub fn page() -> String {
    let keys = keys();
    let of_scene = |key: &&Key| !(key.path == "controller" || key.path.starts_with("controller."));
    let mut page = format!("{HEAD}\nTables of a scene:\n");
    for key in keys.iter().filter(of_scene).filter(|key| key.table.is_some()) {
        let anchor: String = key.path.chars().filter(|letter| *letter != '.').collect();
        let _ = writeln!(page, "[`{}`](#{anchor})", key.path);
    }
    page += "\n## Keys at the top level\n";
    let mut head = true;
    for key in keys.iter().filter(of_scene) {
        if let Some(repeats) = key.table {
            let name = match repeats {
                Repeats::Once => format!("[{}]", key.path),
                Repeats::Several => format!("[[{}]]", key.path),
            };
            let _ = write!(page, "\n## `{name}`\n\n{}\n", key.meaning);
            if key.path == "contact" {
                page += &pairs();
            }
            head = true;
            continue;
        }
        if head {
            page += "\n| key | meaning | unit | range | default |\n|---|---|---|---|---|\n";
            head = false;
        }
        let name = key.path.rsplit('.').next().unwrap_or(&key.path);
        let unit = key.unit.as_deref().unwrap_or_default();
        let meaning = key.meaning.replace('|', "\\|");
        let _ = writeln!(page, "| `{name}` | {meaning} | {unit} | {} | {} |", key.range, key.default);
    }
    page + &settings_page::sections()
}

/// Returns the table of the pairs of materials.
fn pairs() -> String {
    let mut table =
        "\n`pair` is one of these. The parts of the sources that were read state no tangential stiffness.\n".to_owned();
    table += "\n| `pair` | kinetic friction, dry |\n|---|---|\n";
    let pairs = Schema::root().at("contact.pair").map_or_else(Vec::new, Schema::described_choices);
    for (name, meaning) in pairs {
        let _ = writeln!(table, "| `{name}` | {meaning} |");
    }
    table
}

#[cfg(test)]
mod tests {
    /// `UPDATE_DOCS=1 cargo test docs -- --include-ignored` regenerates the page.
    #[test]
    fn docs_of_the_keys_are_generated_from_the_schema() {
        report::docs::page("scene-keys.md", &super::page());
    }
}
