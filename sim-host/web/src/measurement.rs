//! Files that the page opens: scenes, and measurements as scenes of their fit.

use import::admittance::{fit, measured::Measured, options::Options};
use import::error::ImportError;
use import::friction::{self, has_friction, import_content};
use report::TableBlock;
use serde::Deserialize;
use serde_json::{Value, json};

use crate::outcome::table;
use crate::request::stem;

/// Lines in which the heading of a file is searched for.
const HEAD_LINES: usize = 50;

/// File that the page opens.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub struct OpenedFile {
    /// Name of the file.
    pub name: String,
    /// Normal force of a friction measurement, N, if no column contains it.
    pub normal_n: Option<f64>,
    /// Frequency of its vibration, Hz, if no column contains it.
    pub frequency_hz: Option<f64>,
    /// Peak velocity of its vibration, m/s, if no column contains it.
    pub tip_m_per_s: Option<f64>,
}

impl OpenedFile {
    /// Returns the text of a scene, or the fit of a measurement with the text of its scene. Without
    /// a scene, `why` has the reason in the words of `sim-host import`.
    ///
    /// # Errors
    /// If the content is neither a scene nor a measurement, in the words of the command line.
    pub fn read(&self, content: Vec<u8>) -> Result<Value, String> {
        let name = &self.name;
        let ending = name.rsplit('.').next().unwrap_or_default().to_lowercase();
        let text = columns::decode(&content);
        let is_head = |line: &str| line.starts_with('[') || line.split_once('=').is_some_and(|(key, _)| key.trim() == "base");
        let is_scene = text.lines().take(HEAD_LINES).any(|line| is_head(line.trim_start()));
        if is_scene || !["csv", "tsv", "txt", "dat", "s1p", "s2p"].contains(&ending.as_str()) {
            let text = columns::file::text(content);
            return text
                .map(|text| json!({ "text": text }))
                .map_err(|why| format!("error: cannot read the scene `{name}`: {why}"));
        }
        let measured = Measured::parse(name, &content, &Options::default());
        let error = match measured.and_then(|measured| fit(stem(name), measured, None)) {
            Ok(found) => {
                let doubtful = "note: no scene is written: it needs `--force`, because the circuit does not describe the measurements";
                let scene = found.scene(name).filter(|_| !found.is_doubtful()).ok_or_else(|| doubtful.to_owned());
                let notes = found.warnings.iter().map(|warning| format!("note: {warning}")).collect();
                return Ok(fitted(format!("Circuit fitted to {name}"), scene, &found.tables(), notes, false));
            }
            Err(error) => error,
        };
        // The columns decide only about a file that is not an admittance.
        if has_friction(&content) {
            return Ok(self.friction(content));
        }
        let first = |line: &str| line.split(|c: char| !c.is_alphanumeric()).find(|word| !word.is_empty()).map(str::to_lowercase);
        if text.lines().take(HEAD_LINES).any(|line| first(line).is_some_and(|word| ["t", "time"].contains(&word.as_str()))) {
            return Err(format!("Use the command `sim-host spectrum {name}` for this file."));
        }
        Err(format!("error: {error}\n`sim-host import admittance {name}` has options for columns and units."))
    }

    /// Fits a friction measurement.
    fn friction(&self, content: Vec<u8>) -> Value {
        let (name, title) = (&self.name, format!("Friction fitted to {}", self.name));
        let Self { normal_n, frequency_hz, tip_m_per_s, .. } = *self;
        let options = friction::Options { normal_n, frequency_hz, tip_m_per_s, ..friction::Options::default() };
        match import_content(name, content, &options) {
            Ok(found) => {
                let scene =
                    found.scene(name, &options, &[], false).map_err(|needed| format!("note: no scene is written: it needs {needed}"));
                fitted(title, scene, &found.tables(&[]), found.notes(), true)
            }
            Err(error @ ImportError::InFile { .. }) => fitted(title, Err(format!("error: {error}")), &[], Vec::new(), true),
            Err(error) => fitted(title, Err(format!("error: {name}: {error}")), &[], Vec::new(), true),
        }
    }
}

fn fitted(title: String, scene: Result<String, String>, tables: &[TableBlock], notes: Vec<String>, is_friction: bool) -> Value {
    let tables = tables.iter().map(table).collect::<Vec<_>>();
    let (text, why) = (scene.as_ref().ok(), scene.as_ref().err());
    json!({ "text": text, "fit": { "title": title, "tables": tables, "notes": notes, "why": why, "is_friction": is_friction } })
}
