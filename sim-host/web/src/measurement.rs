//! Files that the page opens: scenes, and measurements as scenes of their fit.

use import::admittance::{fit, measured::Measured};
use import::error::ImportError;
use import::friction::{Found, Options, has_friction, import_content};
use report::TableBlock;
use serde::Deserialize;
use serde_json::{Value, json};

use crate::outcome::table;
use crate::request::stem;
use crate::series::{Shown, is_over_time};

/// Lines in which the heading of a file is searched for.
const HEAD_LINES: usize = 50;

/// Opened file, with values of a friction measurement that no column contains.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub struct OpenedFile {
    /// Name of the file.
    pub name: String,
    /// Normal force, N.
    pub normal_n: Option<f64>,
    /// Frequency of the vibration, Hz.
    pub frequency_hz: Option<f64>,
    /// Peak velocity of the vibration, m/s.
    pub tip_m_per_s: Option<f64>,
}

impl OpenedFile {
    /// Returns the text of a scene, or the fit of a measurement with the text of its scene. If the
    /// fit has no scene, its `why` has the reason. A time series is drawn over the last run,
    /// `shown`.
    ///
    /// # Errors
    /// If the content is neither a scene nor a measurement, in the words of the command line.
    pub(crate) fn read(&self, content: Vec<u8>, shown: Option<&Shown>) -> Result<Value, String> {
        let (name, text) = (&self.name, columns::decode(&content));
        let heads: Vec<String> =
            text.lines().take(HEAD_LINES).map(|line| line.trim_start_matches([' ', '"']).to_lowercase()).collect();
        let begins = |word: &str| {
            let is_end = |rest: &str| !rest.starts_with(char::is_alphanumeric);
            heads.iter().any(|line| line.strip_prefix(word).is_some_and(is_end))
        };
        let (_, ending) = name.rsplit_once('.').unwrap_or_default();
        let is_table = ["csv", "tsv", "txt", "dat", "s1p", "s2p"].contains(&ending.to_lowercase().as_str());
        if !is_table || heads.iter().any(|line| line.starts_with('[')) || begins("base") {
            let text = columns::file::text(content).map_err(|why| format!("error: cannot read the scene `{name}`: {why}"))?;
            return Ok(json!({ "text": text }));
        }
        match Measured::parse(name, &content, &Default::default()).and_then(|measured| fit(stem(name), measured, None)) {
            Ok(found) => {
                let why = "`--force`, because the circuit does not describe the measurements";
                let scene = found.scene(name).filter(|_| !found.is_doubtful()).ok_or(why.to_owned());
                let mut fit = fitted(format!("Circuit fitted to {name}"), scene, &found.tables(), [&found.warnings, &[]], false);
                // A circuit outside the range of a scene has a warning of its own.
                if let Some(warning) = found.warnings.iter().find(|warning| warning.starts_with("no scene is written")) {
                    fit["fit"]["why"] = json!(format!("note: {warning}"));
                }
                Ok(fit)
            }
            // The columns decide only about a file that is not an admittance.
            Err(_) if has_friction(&content) => Ok(self.friction(content)),
            Err(error) => match columns::parse(&content, None).ok().filter(is_over_time) {
                Some(table) => shown.and_then(|shown| shown.with_series(name, &table)).ok_or_else(|| not_compared(name, shown)),
                None => Err(format!("error: {error}\n`sim-host import admittance {name}` has options for columns and units.")),
            },
        }
    }

    /// Fits a friction measurement.
    fn friction(&self, content: Vec<u8>) -> Value {
        let Self { normal_n, frequency_hz, tip_m_per_s, .. } = *self;
        let (name, title) = (&self.name, format!("Friction fitted to {}", self.name));
        let options = Options { normal_n, frequency_hz, tip_m_per_s, ..Options::default() };
        match import_content(name, content, &options) {
            Ok(Found::Log(log)) => fitted(title, log.scene(name, &options), &log.tables(), [&log.warnings, &[]], true),
            Ok(Found::Conditions(found, _)) => {
                let scene = match found.is_doubtful {
                    true => Err("`--force`, because the fit does not describe the measurements".to_owned()),
                    false => found.scene(name, &[]),
                };
                fitted(title, scene, &found.tables(&[]), [&found.warnings, &found.assumptions], true)
            }
            Err(error) => {
                let file = if matches!(error, ImportError::InFile { .. }) { String::new() } else { format!("{name}: ") };
                let fit = json!({ "title": title, "tables": [], "notes": [], "why": format!("error: {file}{error}"), "is_friction": true });
                json!({ "text": null, "fit": fit })
            }
        }
    }
}

/// Returns the reason why a time series is compared with nothing.
fn not_compared(name: &str, shown: Option<&Shown>) -> String {
    let curves = shown.map(|shown| shown.curves_at(&[]));
    let why = match curves.as_deref() {
        None => "there is no run to compare it with".to_owned(),
        Some([]) => "this run has no curve over time".to_owned(),
        Some(curves) => {
            let mut curves = curves.to_vec();
            curves.sort_unstable();
            curves.dedup();
            format!("no column has the name of a curve of this run over time, or its unit alone: {}", curves.join(", "))
        }
    };
    format!("error: {name}: {why}\n`sim-host spectrum {name}` shows the frequencies of any time series.")
}

/// Returns a fit with its scene, or with the options that a scene needs.
fn fitted(
    title: String,
    scene: Result<String, String>,
    tables: &[TableBlock],
    [notes, assumed]: [&[String]; 2],
    is_friction: bool,
) -> Value {
    let notes = notes.iter().map(|note| format!("note: {note}")).chain(assumed.iter().map(|words| format!("assumed: {words}")));
    let (tables, notes): (Vec<_>, Vec<_>) = (tables.iter().map(table).collect(), notes.collect());
    let why = scene.as_ref().err().map(|needed| format!("note: no scene is written: it needs {needed}"));
    json!({ "text": scene.ok(), "fit": { "title": title, "tables": tables, "notes": notes, "why": why, "is_friction": is_friction } })
}
