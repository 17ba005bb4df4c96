//! Published data, one file for each source: measurements, and laws separately.
//!
//! | kind | content |
//! |---|---|
//! | number | a measured number, read in its source |
//! | words | a sentence about the measurement, read in its source |
//! | abstract | a sentence about the measurement, read in the abstract only |
//!
//! Only numbers that were read in their source are given. A datum whose number was not read has no
//! `value`, and its prediction is open.

use std::collections::BTreeMap;

use serde::Deserialize;

/// All data files, by name.
const FILES: [(&str, &str); 12] = [
    ("thesis-experiment-1", include_str!("../../measurements/thesis-experiment-1.toml")),
    ("thesis-experiment-2", include_str!("../../measurements/thesis-experiment-2.toml")),
    ("dong-dapino-2015", include_str!("../../measurements/dong-dapino-2015.toml")),
    ("hess-soom-1991", include_str!("../../measurements/hess-soom-1991.toml")),
    ("dinelli-1997", include_str!("../../measurements/dinelli-1997.toml")),
    ("leus-gutowski-2008", include_str!("../../measurements/leus-gutowski-2008.toml")),
    ("luo-2025", include_str!("../../measurements/luo-2025.toml")),
    ("dong-dapino-poisson", include_str!("../../measurements/dong-dapino-poisson.toml")),
    ("mao-popov-2017", include_str!("../../measurements/mao-popov-2017.toml")),
    ("chatterjee-2004", include_str!("../../measurements/chatterjee-2004.toml")),
    ("friesen", include_str!("../../measurements/friesen.toml")),
    ("piezo-at-power", include_str!("../../measurements/piezo-at-power.toml")),
];
const LAWS: &str = include_str!("../../measurements/laws.toml");

/// Publication with its data.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Source {
    /// Name of the file.
    #[serde(skip)]
    pub name: &'static str,
    /// Authors, title and place.
    pub cite: String,
    /// Digital object identifier, if known.
    pub doi: Option<String>,
    /// Parts of the source that were read.
    pub read: String,
    /// Data of the source.
    #[serde(rename = "datum")]
    pub data: Vec<Datum>,
}

/// Kind of a datum.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// A measured number, read in its source.
    Number,
    /// A sentence about the measurement, read in its source.
    Words,
    /// A sentence of an abstract.
    Abstract,
}

/// Origin of an uncertainty.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum UncertaintyOrigin {
    /// Stated by the source.
    Stated,
    /// Half of the last printed digit, as the source states none.
    Rounding,
    /// Assumed here, as the source states none.
    Assumed,
}

/// Measured number, or sentence about a measurement.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Datum {
    /// Short name of the datum.
    pub id: String,
    /// Kind of the datum.
    pub kind: Kind,
    /// Statement of the source.
    pub says: String,
    /// Conditions of the measurement.
    pub conditions: String,
    /// Measured number, if it was read.
    pub value: Option<f64>,
    /// Unit of the number.
    pub unit: Option<String>,
    /// Half width of the uncertainty interval of the number.
    pub uncertainty: Option<f64>,
    /// Origin of the uncertainty.
    pub uncertainty_is: Option<UncertaintyOrigin>,
    /// Sliding speed of the datum, m/s, for laws over speed.
    pub at: Option<f64>,
    /// Reason why no model can be compared with the datum.
    pub not_comparable: Option<String>,
    /// Experiment that would decide between models that disagree with the datum.
    pub decides: Option<String>,
}

/// Published law, evaluated at some points.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Law {
    /// Short name of the law.
    pub id: String,
    /// The formula.
    pub says: String,
    /// Conditions under which the law holds.
    pub conditions: String,
    /// Authors and place.
    pub cite: String,
    /// "formula" or "formula from memory".
    pub kind: String,
    /// Largest deviation of a model that obeys the law.
    pub tolerance: f64,
    /// Argument and, if available, the value to four digits that was computed elsewhere.
    pub points: Vec<Vec<f64>>,
    /// Reason why the law does not claim to hold at these points.
    pub outside: Option<String>,
}

impl UncertaintyOrigin {
    /// Returns the word for tables.
    pub fn word(self) -> &'static str {
        match self {
            UncertaintyOrigin::Stated => "stated",
            UncertaintyOrigin::Rounding => "rounding",
            UncertaintyOrigin::Assumed => "ASSUMED",
        }
    }
}

impl Kind {
    /// Returns the word for tables.
    pub fn word(self) -> &'static str {
        match self {
            Kind::Number => "number",
            Kind::Words => "words",
            Kind::Abstract => "abstract",
        }
    }
}

impl Datum {
    /// Returns the number with its unit and uncertainty, or a note that it was not available or
    /// that the datum is a sentence.
    pub fn number(&self) -> String {
        let unit = self.unit.as_deref().unwrap_or_default();
        match (self.kind, self.value, self.uncertainty.zip(self.uncertainty_is)) {
            (Kind::Number, Some(value), Some((within, is))) => format!("{value} ± {within} {unit} ({})", is.word()),
            (Kind::Number, Some(value), None) => format!("{value} {unit}"),
            (Kind::Number, None, _) => "not available".into(),
            _ => "in words".into(),
        }
    }
}

/// Reads all sources.
pub fn sources() -> Result<Vec<Source>, toml::de::Error> {
    FILES.iter().map(|&(name, text)| Ok(Source { name, ..toml::from_str(text)? })).collect()
}

/// Reads all laws.
pub fn laws() -> Result<Vec<Law>, toml::de::Error> {
    let mut laws: BTreeMap<String, Vec<Law>> = toml::from_str(LAWS)?;
    Ok(laws.remove("law").unwrap_or_default())
}
