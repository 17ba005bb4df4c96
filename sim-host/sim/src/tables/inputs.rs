//! Inputs of a study: all values, those that differ from its base, and inherited texts that apply
//! to other inputs.

use crate::numbers::number;
use crate::study::Study;
use report::TableBlock;
use scene::load::{Change, inputs};
use scene::schema::{last_name, unit_of};

/// Returns the source of the scene's numbers, as the line below its title.
pub(super) fn source(study: &Study) -> String {
    let source = &study.scene.source;
    match &study.inherited {
        _ if source.is_empty() => String::new(),
        Some(inherited) if inherited.source => format!("Source of the base scene `{}`: {source}", inherited.base),
        _ => format!("Source: {source}"),
    }
}

/// Returns the scene's notes, unless they apply to other inputs.
pub(super) fn notes(study: &Study) -> Vec<String> {
    let of_base = study.inherited.as_ref().is_some_and(|inherited| inherited.notes);
    if of_base { Vec::new() } else { study.scene.notes.clone() }
}

/// Returns a sentence about texts that apply to other inputs.
pub(super) fn remark(study: &Study) -> Option<String> {
    let inherited = study.inherited.as_ref()?;
    let base = &inherited.base;
    let has_expect = inherited.expect && !study.judged.is_empty();
    let expect = format!("the expectations of `{base}` apply to its own inputs and do not count");
    let notes = format!("its notes are omitted (see `sim-host show {base}`)");
    let parts = match (has_expect, inherited.notes && !study.scene.notes.is_empty()) {
        (true, true) => format!("{expect}; {notes}"),
        (true, false) => expect,
        (false, true) => format!("the notes of `{base}` apply to its own inputs and are omitted"),
        (false, false) => return None,
    };
    Some(format!("Inputs were changed: {parts}."))
}

/// Returns the table of the values that differ from the base.
pub(super) fn changed(study: &Study) -> Option<TableBlock> {
    let inherited = study.inherited.as_ref()?;
    let text = |value: &Option<String>| value.clone().unwrap_or_else(|| "–".to_owned());
    let words = ["title", "source", "notes", "expect", "grid", "comparison", "vary"];
    let shown = |change: &&Change| !words.contains(&change.key.split('.').next().unwrap_or_default());
    let here = |change: &Change| match study.scene.vary.iter().any(|vary| vary.key == change.key) {
        // Its value is only the centre of the distribution.
        true => {
            change.is.iter().filter_map(|value| value.parse().ok()).map(number).collect::<String>()
                + " (centre; drawn in each run)"
        }
        false => text(&change.is),
    };
    let row = |change: &Change| vec![change.key.clone(), text(&change.was), here(change), unit(&change.key)];
    let rows: Vec<_> = inherited.changes.iter().filter(shown).map(row).collect();
    let title = format!("Inputs changed from `{}`", inherited.base);
    let header = ["key", inherited.base.as_str(), "here", "unit"];
    (!rows.is_empty()).then(|| TableBlock::new("changed-inputs", &title, "", &header, rows))
}

/// Returns the table of every key of the scene with its value.
pub(super) fn all(study: &Study) -> TableBlock {
    let rows = inputs(study.scene).into_iter().map(|(key, value)| {
        let unit = unit(&key);
        vec![key, value, unit]
    });
    let caption = "Every key with its value, including defaults. `sim-host explain KEY` explains a key; `manifest.json` contains \
                   them for programs.";
    TableBlock::new("inputs", "All inputs", caption, &["key", "value", "unit"], rows.collect())
}

/// Returns the unit in the suffix of a key; for an entry of a list, that of the list.
fn unit(key: &str) -> String {
    unit_of(last_name(key)).unwrap_or_default()
}
