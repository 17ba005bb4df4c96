//! Data of a scene that the page shows before a run.

use scene::load::Loaded;
use scene::resolved::{resolved_json, resolved_toml};
use scene::schema::Schema;
use scene::{FaultKind, Kind, Scene};
use serde_json::{Value, json};

use crate::controls::{self, at};
use crate::request::Request;

/// Returns the scene with its sliders, its bursts and its possible faults.
pub(crate) fn opened(request: &Request) -> Result<Value, String> {
    let loaded = Request { whole: true, ..request.clone() }.load()?;
    let scene = &loaded.scene;
    let resolved = resolved_json(scene);
    Ok(json!({
        "name": loaded.name,
        "title": scene.title,
        "source": scene.source,
        "kind": kind(scene),
        "duration_s": scene.duration_s,
        "has_cells": scene.grid.is_some() || scene.comparison.is_some(),
        "sliders": controls::sliders(scene, &resolved),
        "choices": controls::choices(&resolved),
        "burst": burst(scene, &resolved),
        "faults": faults(request, &loaded),
        "fault_count": scene.fault.len(),
        "toml": loaded.input,
        "resolved": resolved_toml(scene),
    }))
}

/// Returns the kind of a scene as a word.
fn kind(scene: &Scene) -> &'static str {
    match scene.kind() {
        _ if scene.runs > 1 => "runs",
        Some(Kind::Driven(_)) => "driven",
        _ => "contact",
    }
}

/// Returns the times at which the drive is ON, s. Null if no schedule determines them: for a
/// contact, a friction switch, or a crash.
fn burst(scene: &Scene, resolved: &Value) -> Value {
    let controller = at(resolved, "controller");
    let decided = |key: &str| controller.is_some_and(|controller| controller.get(key).is_some_and(|table| !table.is_null()));
    if scene.controller.is_none() || scene.runs > 1 || decided("friction") || decided("restraint") {
        return Value::Null;
    }
    let list = |key: &str| at(resolved, &format!("controller.burst.{key}")).cloned().unwrap_or_else(|| json!([]));
    json!({ "on_s": list("on_s"), "off_s": list("off_s"), "period_s": at(resolved, "controller.burst.period_s") })
}

/// Returns the faults with which the scene is still valid, each with its meaning.
fn faults(request: &Request, loaded: &Loaded) -> Vec<Value> {
    if loaded.scene.controller.is_none() || loaded.scene.runs > 1 {
        return Vec::new();
    }
    let place = loaded.scene.fault.len();
    let kinds = Schema::root().at("fault").and_then(Schema::items).and_then(|fault| fault.property("kind"));
    let known = kinds.map_or_else(Vec::new, Schema::described_choices);
    let possible = |&(kind, meaning): &(&'static str, &'static str)| {
        let fault = format!("kind=\"{kind}\"{}", lanes(kind));
        let set = format!("fault.{place}={{at_s={:e}, {fault}}}", 0.5 * loaded.scene.duration_s);
        let request = Request { sets: [request.sets.as_slice(), &[set]].concat(), ..request.clone() };
        request
            .load()
            .is_ok()
            .then(|| json!({ "kind": kind, "label": kind.replace('_', " "), "meaning": meaning, "fault": fault }))
    };
    known.iter().filter_map(possible).collect()
}

/// Returns the lanes for a fault of a lane.
fn lanes(kind: &str) -> &'static str {
    match serde_json::from_value(json!(kind)) {
        Ok(FaultKind::LaneOpen | FaultKind::LaneWeak | FaultKind::LaneReversed) => ", lane=1",
        Ok(FaultKind::LanesExchanged) => ", lane=0, other_lane=1",
        _ => "",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn open_scene(name: &str) -> Value {
        opened(&Request { name: name.into(), ..Request::default() }).unwrap_or_else(|error| panic!("{error}"))
    }

    #[test]
    fn a_stack_can_break_and_a_contact_cannot() {
        let kinds = |value: &Value| value["faults"].as_array().map_or(0, Vec::len);
        let lock = open_scene("lock");
        assert!(kinds(&lock) > 5 && lock["burst"]["on_s"] == json!([0.15, 0.26]), "{lock}");
        assert_eq!(kinds(&open_scene("contact")), 0);
        assert!(
            open_scene("usm")["faults"].as_array().is_some_and(|faults| faults.iter().any(|fault| fault["kind"] == "lane_open"))
        );
    }

    #[test]
    fn errors_match_the_command_line() {
        let text = Some("title = \"x\"\nduration = 1".to_owned());
        let error = opened(&Request { name: "mine.toml".into(), text, ..Request::default() }).unwrap_err();
        assert!(error.contains("--> mine.toml:2:1") && error.contains("^^^"), "{error}");
        let error = opened(&Request { name: "lok".into(), ..Request::default() }).unwrap_err();
        assert!(error.starts_with("error: there is no built-in scene `lok`"), "{error}");
    }
}
