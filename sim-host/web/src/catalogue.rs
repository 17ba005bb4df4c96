//! The list of built-in scenes for the page.

use scene::builtin;
use scene::load::load;
use serde::Serialize;

/// A scene in the list.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Entry {
    /// Name of the scene.
    pub name: &'static str,
    /// Title of the scene.
    pub title: String,
    /// Heading in the list.
    pub group: &'static str,
    /// `true` if a controller drives, so that the run has a drive hash.
    pub driven: bool,
    /// Changes with which the page opens it, as `key=value`.
    pub sets: Vec<String>,
    /// Text of the scene.
    pub text: &'static str,
}

/// First scene of the page: friction falls, and the result is visible within a second.
pub const FIRST_SCENE: &str = "experiment-1";

/// Changes with which the page opens a scene, so that its first result comes quickly. They are
/// shown like all changes, and a button undoes them.
const OPENING_CHANGES: [(&str, &[&str]); 3] = [
    // As in the cells of the scene's own grid.
    ("experiment-1", &["duration_s=0.7", "controller.burst.on_s=[0.4]", "controller.burst.off_s=[0.6]"]),
    ("lock-any", &["runs=8"]),
    ("lock-cold", &["runs=8"]),
];

/// Returns the built-in scenes, starting with those for a beginner.
pub fn scenes() -> Vec<Entry> {
    let mut entries: Vec<Entry> = builtin::all().iter().map(|&(name, text)| entry(name, text)).collect();
    entries.sort_by_key(|entry| GROUPS.iter().position(|&(group, _)| group == entry.group));
    entries
}

/// Headings, with the prefixes of the names of their scenes.
const GROUPS: [(&str, &[&str]); 10] = [
    ("Friction, switched", &["experiment", "friction", "least-power"]),
    ("Find and hold a resonance", &["lock", "burst", "waveforms", "dummy", "self-heating", "derating"]),
    ("A belt stops", &["belt-stop"]),
    ("A crash", &["dring"]),
    ("A seat", &["seat"]),
    ("A knob", &["haptic"]),
    ("A motor", &["usm"]),
    ("Measured transducers", &["transducer"]),
    ("A design", &["langevin", "dring-bar"]),
    ("A contact without a controller", &["contact"]),
];

fn entry(name: &'static str, text: &'static str) -> Entry {
    let loaded = load(name, &[]).ok();
    let longest = |starts: &[&str]| starts.iter().filter(|start| name.starts_with(**start)).map(|start| start.len()).max();
    let group = GROUPS.iter().max_by_key(|(_, starts)| longest(starts)).filter(|(_, starts)| longest(starts).is_some());
    let group = group.map_or("Others", |(group, _)| *group);
    let opened = OPENING_CHANGES.iter().find(|(opened, _)| *opened == name).map_or(&[][..], |(_, sets)| sets);
    Entry {
        name,
        title: loaded.as_ref().map_or_else(String::new, |loaded| loaded.scene.title.clone()),
        group,
        driven: loaded.is_some_and(|loaded| loaded.scene.controller.is_some()),
        sets: opened.iter().map(|&set| set.to_owned()).collect(),
        text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_scene_has_a_heading() {
        let others: Vec<_> = scenes().into_iter().filter(|entry| entry.group == "Others").map(|entry| entry.name).collect();
        assert!(others.is_empty(), "{others:?}");
    }

    #[test]
    fn every_scene_opens_as_the_page_opens_it() {
        for entry in scenes() {
            load(entry.name, &entry.sets).unwrap_or_else(|error| panic!("{error}"));
        }
        assert!(OPENING_CHANGES.iter().all(|(name, _)| builtin::text(name).is_some()) && builtin::text(FIRST_SCENE).is_some());
    }
}
