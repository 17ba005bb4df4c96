//! The page of all keys of a scene, from its schema.

use std::fmt::Write as _;

use crate::all_keys::{Key, Repeats, keys};

const HEAD: &str = "\
# Keys of a scene

Which keys may a scene have, and what may they be? Every table is generated from the types that a scene is read into; `sim-host explain KEY` says the same of one key, `sim-host show NAME` prints a scene with all of
its keys, and `sim-host schema` is the JSON Schema for an editor. Without a default a key is either required by its table or not there. `[table]` is there once, `[[table]]` as often as wanted. The settings of the controller have a [page of their own](settings.md), with what can be set over the link.
";

/// The page, in Markdown.
pub fn page() -> String {
    let mut page = format!("{HEAD}\n## Of the scene itself\n");
    let mut head = true;
    let of_others = |key: &&Key| !(key.path == "controller" || key.path.starts_with("controller."));
    for key in keys().iter().filter(of_others) {
        if let Some(repeats) = key.table {
            let name = match repeats {
                Repeats::Once => format!("[{}]", key.path),
                Repeats::Several => format!("[[{}]]", key.path),
            };
            let _ = write!(page, "\n## `{name}`\n\n{}\n", key.meaning);
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
    page
}

#[cfg(test)]
mod tests {
    /// `UPDATE_DOCS=1 cargo test docs -- --include-ignored` regenerates the page.
    #[test]
    fn docs_of_the_keys_are_generated_from_the_schema() {
        report::docs::page("scene-keys.md", &super::page());
    }
}
