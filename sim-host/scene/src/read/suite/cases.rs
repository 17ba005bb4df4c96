//! The cases of a suite as scenes.

use std::path::Path;

use super::{Suite, SuiteCase};
use crate::builtin;
use crate::diagnostic::Problem;
use crate::load::{LoadError, Loaded, load};
use crate::tree::Node;

/// A case that is a scene.
#[derive(Clone, Debug)]
pub struct ReadyCase {
    /// Name of the case; if it is one of several, followed by the name of its preset.
    pub name: String,
    /// Name of the case in the suite.
    pub base: String,
    /// Group of the case.
    pub group: String,
    /// The scene, with the number of runs of the case.
    pub loaded: Loaded,
    /// Command that runs the case alone.
    pub command: String,
}

/// Returns every case, or the problems of all cases that are not valid scenes.
pub(super) fn ready(suite_name: &str, root: &Node, suite: &Suite, quick: bool) -> Result<Vec<ReadyCase>, Vec<Problem>> {
    let (mut cases, mut problems) = (Vec::new(), Vec::new());
    for (index, case) in suite.case.iter().enumerate() {
        let each: Vec<Option<&String>> = if case.each.is_empty() { vec![None] } else { case.each.iter().map(Some).collect() };
        for preset in each {
            let name = preset.map_or_else(|| case.name.clone(), |preset| format!("{}, {preset}", case.name));
            let listed =
                |quick: &super::Quick| quick.cases.is_empty() || quick.cases.iter().any(|one| *one == name || *one == case.name);
            if quick && !suite.quick.as_ref().is_none_or(listed) {
                continue;
            }
            match load_case(suite_name, suite, case, preset, quick) {
                Ok((loaded, command)) => {
                    let (base, group) = (case.name.clone(), case.group.clone());
                    cases.push(ReadyCase { name, base, group, loaded, command });
                }
                Err(error) => problems.extend(suite_problems(root, index, &name, &error)),
            }
        }
    }
    if problems.is_empty() { Ok(cases) } else { Err(problems) }
}

fn load_case(
    suite_name: &str,
    suite: &Suite,
    case: &SuiteCase,
    preset: Option<&String>,
    quick: bool,
) -> Result<(Loaded, String), LoadError> {
    let asked = case.scene.as_ref().unwrap_or(&suite.scene);
    let source = match builtin::text(asked) {
        Some(_) => asked.clone(),
        None => Path::new(suite_name).parent().unwrap_or(Path::new("")).join(asked).to_string_lossy().into_owned(),
    };
    let presets = preset.into_iter().chain(&case.presets);
    let presets =
        presets.filter_map(|name| suite.preset.iter().find(|preset| preset.name == *name)).flat_map(|preset| &preset.set);
    let mut sets: Vec<String> = suite.set.iter().chain(presets).chain(&case.set).cloned().collect();
    let runs = case.runs.unwrap_or(suite.runs);
    let by_itself = load(&source, &sets)?;
    if by_itself.scene.runs != runs {
        sets.push(format!("runs={runs}"));
    }
    let quoted = |set: &String| if set.contains([' ', '"', '[']) { format!(" --set '{set}'") } else { format!(" --set {set}") };
    let command = format!("sim-host run {source}{}", sets.iter().map(quoted).collect::<String>());
    let most = suite.quick.as_ref().filter(|_| quick).and_then(|quick| quick.runs).unwrap_or(u32::MAX);
    let loaded = if runs > most { load(&source, &[sets, vec![format!("runs={most}")]].concat())? } else { load(&source, &sets)? };
    Ok((loaded, command))
}

/// Converts the error of a case's scene to problems of the suite, each at the string that causes
/// it, or at the case.
fn suite_problems(root: &Node, index: usize, name: &str, error: &LoadError) -> Vec<Problem> {
    let path = format!("case.{index}");
    let case = root.entry(&format!("{path}.name")).map_or_else(|| root.place.clone(), |entry| entry.node.place.clone());
    let LoadError::Invalid(report) = error else {
        let at =
            [format!("{path}.scene"), "scene".to_owned()].iter().find_map(|path| root.at(path)).map(|node| node.place.clone());
        return vec![Problem::new(at.unwrap_or(case), error.to_string(), "not a scene")];
    };
    let lists = [format!("{path}.set"), "set".to_owned()];
    let presets = (0..root.at("preset").map_or(0, |list| list.list().len())).map(|preset| format!("preset.{preset}.set"));
    let strings: Vec<&Node> =
        lists.into_iter().chain(presets).filter_map(|path| root.at(&path)).flat_map(|list| list.list().iter()).collect();
    let one = |problem: &Problem| {
        // The first source of a scene contains its changes, one per line.
        let text = report.sources().first().filter(|_| problem.at.source == 0).map_or("", |source| source.text.as_str());
        let begins = text.get(..problem.at.start).and_then(|before| before.rfind('\n')).map_or(0, |end| end + 1);
        let set = text.get(begins..).and_then(|rest| rest.lines().next());
        let place = set.and_then(|set| strings.iter().find(|node| node.text() == Some(set))).map(|node| {
            let mut place = node.place.clone();
            // The place is within the quotes.
            place.end = place.start + 1 + (problem.at.end - begins);
            place.start += 1 + (problem.at.start - begins);
            place
        });
        Problem {
            at: place.unwrap_or_else(|| case.clone()),
            message: format!("in the case `{name}`: {}", problem.message),
            ..problem.clone()
        }
    };
    report.problems().iter().map(one).collect()
}
