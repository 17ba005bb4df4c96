//! `plan.json`: plan of a sweep, which distinguishes its parts from those of another. It is the
//! same for all shards.

use std::fs;
use std::io::ErrorKind;
use std::ops::Range;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use serde::Deserialize;
use serde_json::{Value, json};

use super::rows_file::{Layout, RowsFile, RowsWriter};
use super::{FolderError, PLAN, Part};
use crate::record::text_hash;
use crate::study::sweep::design::Shape;
use crate::study::sweep::{Sweep, unit};
use crate::tables::mark;
use scene::load::Assumed;
use scene::resolved::resolved_json;

/// Field with the hash of all others.
const HASH: &str = "plan_hash";
/// Fields in which two plans may differ, and the difference in words.
const FIELDS: [(&str, &str); 7] = [
    ("program", "different program"),
    ("version", "different version of sim-host"),
    ("scene", "different scene"),
    ("resolved_scene", "different values of the scene"),
    ("design", "different points"),
    ("metrics", "different metrics"),
    ("all_metrics", "different metrics"),
];

/// Plan of a sweep.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanFile {
    json: Value,
    layout: Layout,
    hash: String,
    count: u64,
}

impl PlanFile {
    /// Creates the plan of a sweep.
    pub fn new(sweep: &Sweep) -> Self {
        let keys: Vec<Value> = sweep.design.keys().iter().map(|key| json!({ "key": key, "unit": unit(key) })).collect();
        let metrics: Vec<Value> = sweep.metrics.iter().map(|metric| json!({ "metric": metric, "unit": unit(metric) })).collect();
        let mut json = json!({
            "program": "sim-host", "version": crate::VERSION, "scene": sweep.loaded.name, "set": sweep.loaded.sets, "points": sweep.design.count(),
            "keys": keys, "metrics": metrics, "all_metrics": sweep.all, "design": sweep.design.json(),
            "resolved_scene": resolved_json(&sweep.loaded.scene),
        });
        let assumed = sweep.loaded.assumed_with(&sweep.design.keys());
        if !assumed.is_empty() {
            json["assumed"] = json!(assumed);
        }
        json[HASH] = hash(&json);
        Self::from_json(json).unwrap_or_else(|| unreachable!("a plan has all its fields"))
    }

    /// Reads the plan in a folder, if there is one.
    ///
    /// # Errors
    /// If the plan cannot be read, or was changed.
    pub fn find(dir: &Path) -> Result<Option<Self>, FolderError> {
        let path = dir.join(PLAN);
        let text = match fs::read_to_string(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(super::read(&path)(error)),
        };
        let why = match serde_json::from_str(&text).ok().and_then(Self::from_json) {
            Some(plan) if hash(&plan.json) == plan.json[HASH] => return Ok(Some(plan)),
            Some(_) => {
                "it was changed after it was written: copy it from the folder of another shard, or start in another folder"
            }
            None => "it is not a plan of a sweep",
        };
        Err(FolderError::Read { path, why: why.to_owned() })
    }

    fn from_json(json: Value) -> Option<Self> {
        let names = |list: &str, name: &str| {
            let names = json[list].as_array()?.iter().map(|entry| Some(entry[name].as_str()?.to_owned()));
            names.collect::<Option<Vec<String>>>()
        };
        let layout = Layout { keys: names("keys", "key")?, metrics: names("metrics", "metric")? };
        let (hash, count) = (json[HASH].as_str()?.to_owned(), json["points"].as_u64()?);
        Some(PlanFile { layout, hash, count, json })
    }

    /// Returns the text of the file.
    pub fn text(&self) -> String {
        format!("{:#}\n", self.json)
    }

    /// Returns the difference to another plan in words, if there is one.
    pub fn differs(&self, other: &Self) -> Option<String> {
        if self.hash == other.hash {
            return None;
        }
        let field = FIELDS.iter().find(|(field, _)| self.json[field] != other.json[field]);
        Some(field.map_or("different plan", |&(_, differs)| differs).to_owned())
    }

    /// Opens a part of this sweep.
    ///
    /// # Errors
    /// If it cannot be read, is damaged, belongs to another plan, or its number of rows does not
    /// match its name.
    pub fn check(&self, part: &Part) -> Result<RowsFile, FolderError> {
        let file = RowsFile::new(&part.path, part.read()?)?;
        let fits = file.plan_hash().as_ref() == Some(&self.hash) && file.count() == part.points.end - part.points.start;
        if fits { Ok(file) } else { Err(FolderError::Part { path: part.path.clone() }) }
    }

    /// Runs points of the sweep and writes their part into a folder; `None` if it is stopped.
    /// `done` is called after each point.
    ///
    /// # Errors
    /// If the scene cannot be run at all, or the part cannot be written.
    pub fn write_part(
        &self,
        sweep: &Sweep,
        points: Range<u64>,
        dir: &Path,
        (stop, done): (&AtomicBool, &(dyn Fn() + Sync)),
    ) -> Result<Option<Part>, FolderError> {
        let Some(rows) = sweep.rows(points.clone(), stop, done)? else { return Ok(None) };
        let path = Part::new(dir, points.clone(), None).path;
        let mut file = RowsWriter::create(&path, &self.layout, &self.hash, true)?;
        file.write(&rows)?;
        file.finish_part(|sum| Part::new(dir, points, Some(sum))).map(Some)
    }

    /// Returns the names of the columns.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Returns the hash of the plan.
    pub fn hash(&self) -> &str {
        &self.hash
    }

    /// Returns the number of points.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Returns `true` if all metrics were requested, not some by name.
    pub fn is_of_all_metrics(&self) -> bool {
        self.json["all_metrics"] == true
    }

    /// Returns the name of the scene.
    pub fn scene(&self) -> &str {
        self.json["scene"].as_str().unwrap_or_default()
    }

    /// Returns the scene with all its defaults.
    pub fn resolved_scene(&self) -> &Value {
        &self.json["resolved_scene"]
    }

    /// Returns the values that the user did not set.
    pub fn assumed(&self) -> Vec<Assumed> {
        self.json.get("assumed").and_then(|assumed| Vec::deserialize(assumed).ok()).unwrap_or_default()
    }

    /// Returns a metric's mark, if it follows from one of them.
    pub fn mark(&self, metric: &str) -> &'static str {
        mark(&self.assumed(), self.resolved_scene().get("controller").is_some(), metric)
    }

    /// Returns title and source of the scene.
    pub fn title(&self) -> (&str, &str) {
        let scene = &self.json["resolved_scene"];
        (scene["title"].as_str().unwrap_or_default(), scene["source"].as_str().unwrap_or_default())
    }

    /// Returns the changes of the scene by `--set`.
    pub fn changes(&self) -> Vec<&str> {
        self.json["set"].as_array().into_iter().flatten().filter_map(Value::as_str).collect()
    }

    /// Returns the number of runs per point.
    pub fn runs(&self) -> u64 {
        self.json["resolved_scene"]["runs"].as_u64().unwrap_or(1)
    }

    /// Returns the arrangement of the points.
    pub fn shape(&self) -> Shape {
        let design = &self.json["design"];
        let axes = design["axes"].as_array();
        let spread = axes.or_else(|| design["ranges"].as_array());
        let log = |key: usize| spread.is_some_and(|spread| spread.get(key).is_some_and(|of| of["log"] == true));
        Shape {
            counts: axes.and_then(|axes| axes.iter().map(|axis| axis["count"].as_u64()).collect()),
            logs: (0..self.layout.keys.len()).map(log).collect(),
            uneven: axes.is_some_and(|axes| axes.iter().any(|axis| axis["list"] == true)),
            sample: self.is_sample(),
        }
    }

    /// Returns `true` if the points are a sample arranged for Sobol indices.
    pub fn is_sample(&self) -> bool {
        self.json["design"]["sample"].is_string()
    }
}

/// Returns the hash of all fields but the hash.
fn hash(json: &Value) -> Value {
    let mut json = json.clone();
    json.as_object_mut().map(|fields| fields.remove(HASH));
    json!(format!("{:016x}", text_hash(&json.to_string())))
}
