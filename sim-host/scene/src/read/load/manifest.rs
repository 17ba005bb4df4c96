//! The scene in the manifest of a run, so that the run can be repeated from that file alone.

use serde::Deserialize;
use serde_json::Value;

use super::{Assumed, Inherited};

/// Name and text of a scene, its inherited parts, and its assumed values.
type Repeated = (String, String, Option<Inherited>, Vec<Assumed>);

/// Returns the scene of a manifest, or an error if the manifest is not usable. `None` if the text
/// is not JSON.
pub(super) fn scene(text: &str) -> Option<Result<Repeated, String>> {
    let manifest: Value = serde_json::from_str(text).ok().filter(Value::is_object)?;
    if is_unchanged(text, &manifest) == Some(false) {
        return Some(Err("it was changed after it was written: to use it as it is, delete `checksums` in it".to_owned()));
    }
    Some(from_manifest(&manifest))
}

/// Returns `true` if a manifest matches its own checksum, which is that of the text with an empty
/// string in its place; `None` if it has none.
pub fn is_unchanged(text: &str, manifest: &Value) -> Option<bool> {
    let own = manifest["checksums"]["manifest.json"].as_str()?;
    let sum = crc::Crc::<u64>::new(&crc::CRC_64_XZ).checksum(text.replacen(own, "", 1).as_bytes());
    Some(format!("{sum:016x}") == own)
}

fn from_manifest(manifest: &Value) -> Result<Repeated, String> {
    let scene = manifest.get("resolved_scene").filter(|_| manifest.get("program") == Some(&"sim-host".into()));
    let scene = scene.ok_or("JSON, but not the manifest of a run; a scene is TOML text")?;
    let name = manifest.get("scene").and_then(Value::as_str).unwrap_or("manifest");
    let text = toml::to_string(&without_nulls(scene)).map_err(|error| format!("its resolved scene is invalid: {error}"))?;
    let inherited = manifest.get("inherited").and_then(|inherited| Inherited::deserialize(inherited).ok());
    let assumed = manifest.get("assumed").and_then(|assumed| Vec::deserialize(assumed).ok()).unwrap_or_default();
    Ok((name.to_owned(), text, inherited, assumed))
}

/// Removes nulls, which TOML cannot represent.
fn without_nulls(value: &Value) -> Value {
    match value {
        Value::Object(map) => {
            map.iter().filter(|(_, value)| !value.is_null()).map(|(key, value)| (key.clone(), without_nulls(value))).collect()
        }
        Value::Array(list) => list.iter().map(without_nulls).collect(),
        value => value.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::{load, load_text};
    use super::*;
    use crate::resolved::resolved_json;
    use serde_json::json;

    /// Every built-in scene is restored unchanged from its manifest.
    #[test]
    fn scenes_are_restored_from_manifests() {
        for (name, _) in crate::builtin::all() {
            let sets = ["seed=123456789012345", "duration_s=0.6000000000000001"].map(str::to_owned);
            // Some scenes restrict their duration.
            let loaded = load(name, &sets).or_else(|_| load(name, &sets[..1])).expect("built in");
            let manifest = json!({ "program": "sim-host", "scene": name, "resolved_scene": resolved_json(&loaded.scene) });
            let (found, text, ..) = scene(&format!("{manifest:#}")).expect("JSON").expect("a manifest");
            assert_eq!(found, *name);
            let again = load_text(&found, &text, &[]).unwrap_or_else(|error| panic!("{name}: {error}"));
            assert_eq!(again.scene, loaded.scene, "{name}");
        }
    }

    #[test]
    fn other_json_is_refused_and_toml_ignored() {
        assert!(scene("title = \"a\"").is_none());
        let changed = r#"{"checksums": {"manifest.json": "0123456789abcdef"}}"#;
        assert!(scene(changed).is_some_and(|scene| scene.is_err_and(|why| why.contains("delete `checksums`"))));
        assert!(scene("{\"a\": 1}").is_some_and(|scene| scene.is_err_and(|why| why.contains("not the manifest"))));
    }
}
