//! Profiles of a scene: each file is replaced by the samples of its column, before the scene is
//! checked.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::column::{About, Measured, Refusal, speeds, text_of};
use crate::diagnostic::{Place, Problem, Source};
use crate::nearest::shown;
use crate::schema::{Schema, join};
use crate::tree::{Entry, Node, Table, Value};
use columns::unit::{self as units, Unit};

/// Keys of a table that is read from a file.
struct TableKeys {
    /// Keys that select the data.
    read: [&'static str; 5],
    /// Keys of the samples.
    samples: [&'static str; 2],
}

const PROFILE: TableKeys =
    TableKeys { read: ["file", "column", "unit", "time_column", "time_unit"], samples: ["time_s", "values"] };
const OVERLAY: TableKeys = TableKeys { read: ["file", "column", "unit", "x_column", "x_unit"], samples: ["x", "values"] };

impl TableKeys {
    /// Returns the keys of the axis column and of its unit.
    fn axis(&self) -> (&'static str, &'static str) {
        (self.read[3], self.read[4])
    }

    /// Returns `true` if the axis is time, in seconds and in ascending order.
    fn is_over_time(&self) -> bool {
        self.axis().0 == PROFILE.axis().0
    }
}

/// Path of a key, and its problem.
pub(crate) type PathProblem = (String, Problem);

/// Returns the paths of the profiles of a scene.
pub(crate) fn paths(root: &Node) -> Vec<String> {
    let disturbances = root.at("disturbance").map_or(0, |list| list.list().len());
    let courses = (0..disturbances).map(|index| format!("disturbance.{index}.profile"));
    let all = courses.chain(["excitation.profile", "rig.dring.pulse"].map(str::to_owned));
    all.filter(|path| root.at(path).is_some_and(|node| node.table().is_some())).collect()
}

/// Returns the paths of all tables that can name a file, with their forms.
fn tables_with_files(root: &Node) -> Vec<(String, &'static TableKeys)> {
    let overlays = (0..root.at("overlay").map_or(0, |list| list.list().len())).map(|index| format!("overlay.{index}"));
    paths(root).into_iter().map(|path| (path, &PROFILE)).chain(overlays.map(|path| (path, &OVERLAY))).collect()
}

/// Returns the files that the profiles and overlays name.
pub(crate) fn files(root: &Node, sources: &[Source]) -> Vec<PathBuf> {
    let named = tables_with_files(root).into_iter().filter_map(|(path, _)| root.at(&join(&path, PROFILE.read[0])));
    named.filter_map(|file| Some(path_of(file, file.text()?, sources))).collect()
}

/// Returns the path of a file that is named in a scene, relative to the text that names it.
pub(crate) fn path_of(file: &Node, name: &str, sources: &[Source]) -> PathBuf {
    sources.get(file.place.source).and_then(|source| Path::new(&source.name).parent()).unwrap_or(Path::new("")).join(name)
}

/// Returns the unit of the quantity that a profile describes, `None` for a number without a unit.
///
/// # Errors
/// If the quantity is unknown.
fn wanted(root: &Node, path: &str) -> Result<Option<Unit>, ()> {
    if path == "rig.dring.pulse" {
        return Ok(Unit::parse("m/s^2"));
    }
    if path == "excitation.profile" {
        let given = root.at("rig.kinematic").is_some();
        return Ok(Unit::parse(if given { "m/s" } else { "N" }));
    }
    if path.starts_with("overlay.") {
        let quantity = root.at(&join(path, "quantity")).and_then(Node::text).ok_or(())?;
        return Ok(units::split(quantity).1);
    }
    let (disturbance, _) = path.rsplit_once('.').ok_or(())?;
    let key = root.at(&join(disturbance, "key")).and_then(Node::text).ok_or(())?;
    let known = Schema::root().at("disturbance.0.key").is_some_and(|schema| schema.choices().contains(&key));
    let name = key.rsplit('.').next().unwrap_or(key);
    if known { Ok(units::split(name).1) } else { Err(()) }
}

/// Reads the files of all profiles. A profile with a problem is not changed, and the problem is
/// returned.
pub(crate) fn resolve(root: &mut Node, sources: &mut Vec<Source>) -> Vec<PathProblem> {
    let mut found = Vec::new();
    for (path, form) in tables_with_files(root) {
        let wanted = wanted(root, &path);
        let whole = root.at(&path).map(|node| node.place.clone());
        let Some(Value::Table(table)) = root.at_mut(&path).map(|node| &mut node.value) else { continue };
        for key in form.samples {
            if let Some(entry) = table.get_mut(key) {
                gather(&mut entry.node);
            }
        }
        match (table.get("file").map(|entry| entry.node.text()), wanted) {
            (Some(Some(_)), Ok(wanted)) => {
                if let Err(problem) = read(table, form, wanted.as_ref(), sources) {
                    found.push((path, problem));
                }
            }
            // A wrong file name and a wrong `key` are reported by other checks.
            (Some(_), _) => {}
            (None, _) => {
                if let Some(problem) = incomplete(table, form, whole) {
                    found.push((path, problem));
                }
            }
        }
    }
    found
}

/// Converts a list of finite numbers to samples.
fn gather(node: &mut Node) {
    let numbers: Option<Arc<[f64]>> = match &node.value {
        Value::List(list) => list.iter().map(|node| node.number().filter(|number| number.is_finite())).collect(),
        _ => None,
    };
    if let Some(samples) = numbers {
        node.value = Value::Samples(samples);
    }
}

/// Returns the problem of an incomplete profile without a file.
fn incomplete(table: &Table, form: &TableKeys, whole: Option<Place>) -> Option<Problem> {
    let [axis, values] = form.samples;
    let help = format!("`file` names a table of numbers; `{axis}` and `{values}` give the samples themselves");
    // Points over other axes than time keep the unit of their axis.
    let read = &form.read[..if form.is_over_time() { 5 } else { 4 }];
    if let Some((key, entry)) = read.iter().find_map(|key| Some((key, table.get(*key)?))) {
        return Some(Problem::new(entry.key.clone(), format!("`{key}` without `file`"), "there is no file").help(help));
    }
    match form.samples.map(|key| table.contains_key(key)) {
        [true, true] => None,
        [false, false] => Some(
            Problem::new(
                whole?,
                if form.is_over_time() { "a profile without samples" } else { "an overlay without points" },
                "needs `file`",
            )
            .help(help),
        ),
        [has_axis, _] => {
            let (given, lacks) = if has_axis { (axis, values) } else { (values, axis) };
            let entry = table.get(given)?;
            Some(
                Problem::new(entry.key.clone(), format!("`{given}` without `{lacks}`"), format!("needs `{lacks}` as well"))
                    .help(help),
            )
        }
    }
}

/// Replaces the name of a file by its samples.
fn read(table: &mut Table, form: &TableKeys, wanted: Option<&Unit>, sources: &mut Vec<Source>) -> Result<(), Problem> {
    let text = |key: &str| table.get(key).and_then(|entry| entry.node.text());
    let entry = |key: &str| table.get(key);
    let Some((file, name)) = entry("file").zip(text("file")) else { return Ok(()) };
    if let Some((key, samples)) = form.samples.iter().find_map(|key| Some((key, entry(key)?))) {
        let problem =
            Problem::new(samples.key.clone(), format!("`file` and `{key}` exclude each other"), "`file` is already given");
        return Err(problem.help("give either a file or the samples"));
    }
    let at = file.node.place.clone();
    let place = |about: About| {
        let key = match about {
            About::File | About::Line(_) => "file",
            About::Column => "column",
            About::Unit => "unit",
            About::Axis => form.axis().0,
            About::AxisUnit => form.axis().1,
        };
        entry(key).map_or_else(|| at.clone(), |entry| entry.node.place.clone())
    };
    let path = path_of(&file.node, name, sources);
    let mut refused = |refusal: Refusal, text: Option<&str>| {
        let at = match (refusal.about, text) {
            (About::Line(line), Some(text)) => {
                sources.push(Source { name: path.to_string_lossy().into_owned(), text: text.to_owned() });
                Place::new(sources.len() - 1, Measured::span(text, line))
            }
            (about, _) => place(about),
        };
        Problem { at, message: refusal.message, label: refusal.label, help: refusal.help }
    };
    let content = text_of(&path, name).map_err(|refusal| refused(refusal, None))?;
    let measured = Measured::from_text(name, content).map_err(|(refusal, text)| refused(refusal, Some(&text)))?;
    let (axis_key, axis_unit_key) = form.axis();
    let columns = || {
        let axis = measured.axis_index(text(axis_key), axis_key)?;
        let value = measured.value_index(text("column"), axis)?;
        let (axis, axis_unit) = if form.is_over_time() {
            (measured.column(axis, text(axis_unit_key), Unit::parse("s").as_ref(), Some(axis_unit_key))?, None)
        } else {
            measured.unconverted(axis, text(axis_unit_key))?
        };
        Ok((axis, axis_unit, measured.column(value, text("unit"), wanted, None)?))
    };
    let (axis, axis_unit, value) = columns().map_err(|refusal: Refusal| refused(refusal, Some(&measured.text)))?;
    if let Some(row) = first_not_rising(&axis.values).filter(|_| form.is_over_time()) {
        let (before, after) = (shown(axis.values[row - 1]), shown(axis.values[row]));
        let message = format!("the time in `{name}` does not increase: {after} s follows {before} s");
        let refusal = Refusal { about: About::Line(measured.line(row)), message, label: "must be later".to_owned(), help: None };
        return Err(refused(refusal, Some(&measured.text)));
    }
    let source = format!("{name}: {} over {}, {} samples", value.heading, axis.heading, value.values.len());
    if value.is_path && !form.is_over_time() {
        let message = format!("`{}` is a length, but a speed is needed", value.heading);
        let refusal = Refusal { about: About::Column, message, label: "must be a speed".to_owned(), help: None };
        return Err(refused(refusal, None));
    }
    let (along, values) = if value.is_path { speeds(&axis.values, &value.values) } else { (axis.values, value.values) };
    form.read.iter().for_each(|key| drop(table.remove(*key)));
    let mut put = |key: &str, value: Value| {
        table.insert(key.to_owned(), Entry { key: at.clone(), node: Node { place: at.clone(), value } });
    };
    put("source", Value::Text(source));
    if let Some(unit) = axis_unit {
        put(axis_unit_key, Value::Text(unit));
    }
    let [axis_samples, value_samples] = form.samples;
    put(axis_samples, Value::Samples(along.into()));
    put(value_samples, Value::Samples(values.into()));
    Ok(())
}

/// Returns the index of the first sample that is not later than the previous one.
pub(crate) fn first_not_rising(time_s: &[f64]) -> Option<usize> {
    time_s.windows(2).position(|pair| !pair.is_sorted_by(|a, b| a < b)).map(|at| at + 1)
}
