//! `[stack.design]`: the circuit of a stack from its mechanical design.

use std::path::PathBuf;

use super::{loaded, merge_bases, read_source};
use crate::builtin;
use crate::circuit::Elements;
use crate::diagnostic::{Problem, Source};
use crate::profile::resolve::path_of;
use crate::tree::{Entry, Node, Table, Value};
use design::{Circuit, Solved};

const STACK: &str = "stack";
const DESIGN: &str = "design";
const BVD: &str = "bvd";

/// Replaces `[stack.design]` by the circuit that follows from its file, and returns the file. A
/// circuit of a base scene is removed; values of a newer text remain.
///
/// # Errors
/// If the file is not the scene of a design with piezoelectric rings, or if the same text gives a
/// value of the circuit too.
pub(super) fn replace(root: &mut Node, sources: &[Source]) -> Result<Option<PathBuf>, Problem> {
    // A design has no stack: it is refused later, and does not refer to itself here.
    let Some(node) = root.at("stack.design").filter(|_| root.at(DESIGN).is_none()) else { return Ok(None) };
    let Some((file, name)) = node.at("file").and_then(|file| Some((file.clone(), file.text()?.to_owned()))) else {
        return Ok(None);
    };
    let source = file.place.source;
    let problem = |message: String, label: &str| Problem::new(file.place.clone(), message, label);
    let path = if builtin::text(&name).is_some() { PathBuf::from(&name) } else { path_of(&file, &name, sources) };
    let shown = path.to_string_lossy().into_owned();
    let solved = read(&shown, &name).map_err(|why| problem(why, "the design of the stack"))?;
    let Some(values) = values(&solved) else {
        return Err(problem(format!("the design `{name}` has no piezoelectric rings"), "cannot be driven"));
    };
    let Some(Value::Table(stack)) = root.at_mut(STACK).map(|node| &mut node.value) else { return Ok(None) };
    stack.remove(DESIGN);
    stack.retain(|key, entry| key != "mode" || entry.node.place.source <= source);
    let entry = |value: Value| Entry { key: file.place.clone(), node: Node { place: file.place.clone(), value } };
    let bvd = stack.entry(BVD.to_owned()).or_insert_with(|| entry(Value::Table(Table::new())));
    let Value::Table(bvd) = &mut bvd.node.value else { return Ok(None) };
    bvd.retain(|_, entry| entry.node.place.source <= source);
    for (key, value) in values {
        if let Some(own) = bvd.get(key).filter(|own| own.node.place.source == source) {
            let message = format!("`stack.bvd.{key}` and `stack.design` both give this value");
            return Err(Problem::new(own.key.clone(), message, "follows from the design").help("remove one of the two"));
        }
        bvd.entry(key.to_owned()).or_insert_with(|| entry(Value::Number(value)));
    }
    let modes = further(&solved).map(|keys| {
        let table: Table = keys.map(|(key, value)| (key.to_owned(), entry(Value::Number(value)))).into_iter().collect();
        Node { place: file.place.clone(), value: Value::Table(table) }
    });
    let modes: Vec<Node> = modes.collect();
    stack.entry("mode".to_owned()).or_insert_with(|| entry(Value::List(modes)));
    Ok(Some(path))
}

/// Reads and solves the scene of a design.
fn read(path: &str, asked: &str) -> Result<Solved, String> {
    let text = read_source(path, asked).map_err(|error| error.to_string())?;
    let mut sources = vec![Source { name: "--set".to_owned(), text: String::new() }];
    sources.push(Source { name: path.to_owned(), text: text.clone() });
    if merge_bases(&mut sources).is_ok_and(|root| root.at(DESIGN).is_none()) {
        return Err(format!("`{asked}` is not a design: it has no [design]"));
    }
    let scene = loaded(path, &text, &[], |_| ()).map_err(|error| {
        let first = error.to_string().lines().next().unwrap_or_default().trim_start_matches("error: ").to_owned();
        format!("the design `{asked}` is not valid: {first}")
    })?;
    if !scene.scene.vary.is_empty() {
        return Err(format!("the design `{asked}` has distributions: a driven scene takes one value of each key"));
    }
    scene.scene.design.map_or_else(|| Err(String::new()), |design| design::solve(&design).map_err(|error| error.to_string()))
}

/// Returns the values of the circuit, if there is one.
fn values(solved: &Solved) -> Option<[(&'static str, f64); 6]> {
    let (branch, Circuit { c0_f, loss_tangent, .. }) = (solved.working().branch?, solved.circuit.as_ref()?);
    let elements = Elements { c0_f: *c0_f, cm_f: branch.cm_f, lm_h: branch.lm_h, rm_ohm: branch.rm_ohm };
    Some([
        ("c0_f", *c0_f),
        ("series_resonance_hz", elements.series_resonance_hz()),
        ("q", elements.q()),
        ("coupling", elements.coupling()),
        ("force_factor_n_per_v", branch.force_factor_n_per_v),
        ("loss_tangent", *loss_tangent),
    ])
}

/// Returns the values of the further branches.
fn further(solved: &Solved) -> impl Iterator<Item = [(&'static str, f64); 3]> {
    let modes = solved.circuit.iter().flat_map(|circuit| &circuit.further).map(|&index| &solved.modes[index]);
    modes.filter_map(|mode| {
        let branch = mode.branch?;
        let elements = Elements { c0_f: 1.0, cm_f: branch.cm_f, lm_h: branch.lm_h, rm_ohm: branch.rm_ohm };
        Some([("series_resonance_hz", elements.series_resonance_hz()), ("q", elements.q()), ("lm_h", branch.lm_h)])
    })
}
