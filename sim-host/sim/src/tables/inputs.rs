//! What a study was run with: the values that differ from its base, all of them, and what of its texts is of other inputs.

use crate::study::Study;
use report::TableBlock;
use scene::load::{Change, inputs};
use scene::schema::{last_name, unit_of};

/// Where the scene's numbers come from, as the line below its title.
pub(super) fn source(study: &Study) -> String {
    let source = &study.scene.source;
    match &study.inherited {
        _ if source.is_empty() => String::new(),
        Some(inherited) if inherited.source => format!("Source of the base scene `{}`: {source}", inherited.base),
        _ => format!("Source: {source}"),
    }
}

/// The scene's notes, unless they are written for other inputs.
pub(super) fn notes(study: &Study) -> Vec<String> {
    let of_base = study.inherited.as_ref().is_some_and(|inherited| inherited.notes);
    if of_base { Vec::new() } else { study.scene.notes.clone() }
}

/// What of the texts is of other inputs, in a sentence.
pub(super) fn remark(study: &Study) -> Option<String> {
    let inherited = study.inherited.as_ref()?;
    let base = &inherited.base;
    let has_expect = inherited.expect && !study.judged.is_empty();
    let expect = format!("the expectations of `{base}` are of its own inputs, and do not count");
    let notes = format!("its notes are left out (`sim-host show {base}` has them)");
    let parts = match (has_expect, inherited.notes && !study.scene.notes.is_empty()) {
        (true, true) => format!("{expect}; {notes}"),
        (true, false) => expect,
        (false, true) => format!("the notes of `{base}` are of its own inputs, and left out"),
        (false, false) => return None,
    };
    Some(format!("Inputs were changed: {parts}."))
}

/// The values that differ from the base.
pub(super) fn changed(study: &Study) -> Option<TableBlock> {
    let inherited = study.inherited.as_ref()?;
    let text = |value: &Option<String>| value.clone().unwrap_or_else(|| "–".to_owned());
    let words = ["title", "source", "notes", "expect"];
    let shown = |change: &&Change| !words.contains(&change.key.split('.').next().unwrap_or_default());
    let row = |change: &Change| vec![change.key.clone(), text(&change.was), text(&change.is), unit(&change.key)];
    let rows: Vec<_> = inherited.changes.iter().filter(shown).map(row).collect();
    let title = format!("Inputs changed from `{}`", inherited.base);
    let header = ["key", inherited.base.as_str(), "here", "unit"];
    (!rows.is_empty()).then(|| TableBlock::new("changed-inputs", &title, "", &header, rows))
}

/// Every key of the scene with its value.
pub(super) fn all(study: &Study) -> TableBlock {
    let rows = inputs(study.scene).into_iter().map(|(key, value)| {
        let unit = unit(&key);
        vec![key, value, unit]
    });
    let caption = "Every key with its value, defaults included; `sim-host explain KEY` says what one means, and `manifest.json` has them for programs.";
    TableBlock::new("inputs", "All inputs", caption, &["key", "value", "unit"], rows.collect())
}

/// The unit that a key ends in; of an entry of a list, that of the list.
fn unit(key: &str) -> String {
    unit_of(last_name(key)).unwrap_or_default()
}
