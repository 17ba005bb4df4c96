//! A suite: cases of scenes with targets for their metrics, as one TOML file that can be copied and
//! edited.
//!
//! ```toml
//! title = "Lock times of two loads"
//! scene = "lock-cold"
//! runs = 50
//!
//! [[case]]
//! name = "Q 65"
//!
//! [[case]]
//! name = "Q 200"
//! set = ["stack.bvd.q=200", "controller.tracking.nominal_q=200"]
//!
//! [[target]]
//! metric = "lock_time_20hz_ms_p95"
//! max = 0.5
//! source = "our requirement"
//! ```

mod cases;
pub(crate) mod file;
mod rules;

use std::path::Path;

use crate::diagnostic::{Problem, Report, Source};
use crate::load::{LoadError, read_source};
use crate::overlay::syntax;
use crate::schema::join;
use crate::tree::{Entry, Node, Origin, Value};
use crate::walk::{Findings, walk_by};

pub use cases::ReadyCase;
pub use file::{Column, DERIVED, Preset, Quick, STEPS, Statistic, Suite, SuiteCase, SuiteTable, Target, schema};

/// A suite, and its cases as scenes.
#[derive(Clone, Debug)]
pub struct LoadedSuite {
    /// Name of the suite: that of the file without folder and extension.
    pub name: String,
    /// The suite as its file describes it.
    pub suite: Suite,
    /// Every case as a scene, in the order of the file.
    pub cases: Vec<ReadyCase>,
}

/// Loads a suite from a file.
pub fn load(path: &str, quick: bool) -> Result<LoadedSuite, LoadError> {
    load_text(path, &read_source(path, path)?, quick)
}

/// Loads a suite from its text. Relative scenes are relative to the folder of `name`.
pub fn load_text(name: &str, text: &str, quick: bool) -> Result<LoadedSuite, LoadError> {
    let sources = vec![Source { name: name.to_owned(), text: text.to_owned() }];
    let stem = Path::new(name).file_stem().map_or_else(|| name.to_owned(), |stem| stem.to_string_lossy().into_owned());
    let (suite, cases) = read(name, text, quick).map_err(|problems| LoadError::Invalid(Report::new(sources, problems)))?;
    Ok(LoadedSuite { name: stem, suite, cases })
}

fn read(name: &str, text: &str, quick: bool) -> Result<(Suite, Vec<ReadyCase>), Vec<Problem>> {
    let origin = Origin { source: 0, offset: 0 };
    let mut root = Node::parse(text, origin).map_err(|error| vec![syntax(&error, text, origin)])?;
    let mut found = walk_by(&mut root, file::root());
    if found.problems.is_empty() {
        rules::check(&root, &mut found);
    }
    if SHARED_KEYS.iter().any(|key| !found.clean(key)) {
        return Err(found.problems);
    }
    let sound = without_mistakes(root, &found);
    let mut problems = found.problems;
    let suite: Suite = match sound.to_toml().try_into() {
        Ok(suite) => suite,
        Err(_) if !problems.is_empty() => return Err(problems),
        Err(error) => return Err(vec![Problem::new(sound.place.clone(), toml::de::Error::message(&error), "")]),
    };
    match cases::ready(name, &sound, &suite, quick) {
        Ok(cases) if problems.is_empty() => return Ok((suite, cases)),
        Ok(_) => {}
        Err(of_cases) => problems.extend(of_cases),
    }
    Err(problems)
}

/// Keys that every case needs: if one is wrong, no case can be checked.
const SHARED_KEYS: [&str; 5] = ["scene", "set", "runs", "quick", "preset"];

/// Removes the keys and list entries that have a problem, so that the remaining cases can be
/// checked.
fn without_mistakes(mut root: Node, found: &Findings) -> Node {
    let Value::Table(table) = &mut root.value else { return root };
    table.retain(|key, entry| match &mut entry.node.value {
        Value::List(entries) if !found.marked(key) => {
            let mut indices = 0..;
            entries.retain(|_| indices.next().is_some_and(|index: usize| found.clean(&join(key, &index.to_string()))));
            true
        }
        _ => found.clean(key),
    });
    if !found.clean("title") {
        let title = Node { place: root.place.clone(), value: Value::Text(String::new()) };
        table.insert("title".to_owned(), Entry { key: root.place.clone(), node: title });
    }
    root
}

#[cfg(test)]
mod tests;
