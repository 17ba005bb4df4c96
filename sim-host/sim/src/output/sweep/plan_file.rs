//! `plan.json`: what a sweep is, so that its parts can be told from those of another. The same of all shards.

use std::fs;
use std::io::ErrorKind;
use std::ops::Range;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use serde_json::{Value, json};

use super::rows_file::{Layout, RowsFile, RowsWriter};
use super::{FolderError, PLAN, Part};
use crate::record::text_hash;
use crate::study::sweep::design::Shape;
use crate::study::sweep::{Sweep, unit};
use scene::resolved::resolved_json;

/// The fields in which two plans may differ, and what a reader calls them.
const FIELDS: [(&str, &str); 7] = [
    ("program", "of another program"),
    ("version", "of another version of sim-host"),
    ("scene", "of another scene"),
    ("resolved_scene", "of a scene with other values"),
    ("design", "of other points"),
    ("metrics", "of other metrics"),
    ("all_metrics", "of other metrics"),
];

/// The plan of a sweep.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanFile {
    json: Value,
    layout: Layout,
    hash: String,
    count: u64,
}

impl PlanFile {
    /// The plan of a sweep.
    pub fn new(sweep: &Sweep) -> Self {
        let keys: Vec<Value> = sweep.design.keys().iter().map(|key| json!({ "key": key, "unit": unit(key) })).collect();
        let metrics: Vec<Value> = sweep.metrics.iter().map(|metric| json!({ "metric": metric, "unit": unit(metric) })).collect();
        let mut json = json!({
            "program": "sim-host", "version": crate::VERSION, "scene": sweep.loaded.name, "set": sweep.loaded.sets, "points": sweep.design.count(),
            "keys": keys, "metrics": metrics, "all_metrics": sweep.all, "design": sweep.design.json(),
            "resolved_scene": resolved_json(&sweep.loaded.scene),
        });
        json["plan_hash"] = json!(format!("{:016x}", text_hash(&json.to_string())));
        Self::of(json).unwrap_or_else(|| unreachable!("a plan has all its fields"))
    }

    /// The plan in a folder, if it has one.
    ///
    /// # Errors
    /// If it cannot be read.
    pub fn find(dir: &Path) -> Result<Option<Self>, FolderError> {
        let path = dir.join(PLAN);
        let text = match fs::read_to_string(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(super::read(&path)(error)),
        };
        let plan = serde_json::from_str(&text).ok().and_then(Self::of);
        plan.map(Some).ok_or_else(|| FolderError::Read { path, why: "it is no plan of a sweep".to_owned() })
    }

    fn of(json: Value) -> Option<Self> {
        let names = |list: &str, name: &str| {
            let names = json[list].as_array()?.iter().map(|entry| Some(entry[name].as_str()?.to_owned()));
            names.collect::<Option<Vec<String>>>()
        };
        let layout = Layout { keys: names("keys", "key")?, metrics: names("metrics", "metric")? };
        let (hash, count) = (json["plan_hash"].as_str()?.to_owned(), json["points"].as_u64()?);
        Some(PlanFile { layout, hash, count, json })
    }

    /// The file's text.
    pub fn text(&self) -> String {
        format!("{:#}\n", self.json)
    }

    /// In what another plan differs, if it does.
    pub fn differs(&self, other: &Self) -> Option<String> {
        if self.hash == other.hash {
            return None;
        }
        let field = FIELDS.iter().find(|(field, _)| self.json[field] != other.json[field]);
        Some(field.map_or("of another plan", |&(_, differs)| differs).to_owned())
    }

    /// A part of this sweep, opened.
    ///
    /// # Errors
    /// If it cannot be read, is of another plan, or has not as many rows as its name says.
    pub fn check(&self, part: &Part) -> Result<RowsFile, FolderError> {
        let file = RowsFile::open(&part.path)?;
        let fits = file.plan_hash().as_ref() == Some(&self.hash) && file.count() == part.points.end - part.points.start;
        if fits { Ok(file) } else { Err(FolderError::Part { path: part.path.clone() }) }
    }

    /// Runs some points of the sweep, and writes their part into a folder; none if it is stopped. `done` is called after each point.
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
        let part = Part::new(dir, points);
        let mut file = RowsWriter::create(&part.path, &self.layout, &self.hash, true)?;
        file.write(&rows)?;
        file.finish()?;
        Ok(Some(part))
    }

    /// Names of the columns.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Hash of the plan.
    pub fn hash(&self) -> &str {
        &self.hash
    }

    /// How many points there are.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Whether all metrics were asked for, rather than some by name.
    pub fn is_of_all_metrics(&self) -> bool {
        self.json["all_metrics"] == true
    }

    /// Name of the scene.
    pub fn scene(&self) -> &str {
        self.json["scene"].as_str().unwrap_or_default()
    }

    /// The title of the scene, and where it comes from.
    pub fn title(&self) -> (&str, &str) {
        let scene = &self.json["resolved_scene"];
        (scene["title"].as_str().unwrap_or_default(), scene["source"].as_str().unwrap_or_default())
    }

    /// Changes of the scene by hand.
    pub fn changes(&self) -> Vec<&str> {
        self.json["set"].as_array().into_iter().flatten().filter_map(Value::as_str).collect()
    }

    /// How many runs of the scene a point is.
    pub fn runs(&self) -> u64 {
        self.json["resolved_scene"]["runs"].as_u64().unwrap_or(1)
    }

    /// How the points lie.
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

    /// Whether the points are a sample with the points that Sobol indices need.
    pub fn is_sample(&self) -> bool {
        self.json["design"]["sample"].is_string()
    }
}
