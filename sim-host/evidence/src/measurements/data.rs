//! Published data, one file for each source: what was measured, and laws apart from it.
//!
//! | kind | what it is |
//! |---|---|
//! | number | a measured number, read in its source |
//! | words | a sentence of the source about what was measured, read there |
//! | abstract | the same, of the abstract alone |
//!
//! A number that was not read in its source is not here: such a datum has no `value`, and its prediction is open.

use std::collections::BTreeMap;

use serde::Deserialize;

/// Every file of data, by its name.
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

/// A publication with what it states.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Source {
    /// Name of the file.
    #[serde(skip)]
    pub name: &'static str,
    /// Authors, title and place.
    pub cite: String,
    /// Digital object identifier, where it is known.
    pub doi: Option<String>,
    /// What of the source was read.
    pub read: String,
    /// What it states.
    #[serde(rename = "datum")]
    pub data: Vec<Datum>,
}

/// Kind of a datum.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// A measured number, read in its source.
    Number,
    /// A sentence about what was measured, read in its source.
    Words,
    /// A sentence of an abstract.
    Abstract,
}

/// Where an uncertainty is from.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum UncertaintyIs {
    /// The source states it.
    Stated,
    /// Half of the last printed digit: the source states none.
    Rounding,
    /// Assumed here: the source states none.
    Assumed,
}

/// A measured number, or a sentence about what was measured.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Datum {
    /// Short name of the datum.
    pub id: String,
    /// Kind of the datum.
    pub kind: Kind,
    /// What is stated.
    pub says: String,
    /// Under which conditions.
    pub conditions: String,
    /// The number, if it is one that was read.
    pub value: Option<f64>,
    /// Unit of the number.
    pub unit: Option<String>,
    /// Half width of the interval that the number stands for.
    pub uncertainty: Option<f64>,
    /// Where that is from.
    pub uncertainty_is: Option<UncertaintyIs>,
    /// Sliding speed of the datum, m/s, where a law over the speed is judged.
    pub at: Option<f64>,
    /// Why no model can be held against it.
    pub not_comparable: Option<String>,
    /// The experiment that would decide where models disagree with it.
    pub decides: Option<String>,
}

/// A published law, at some points.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Law {
    /// Short name of the law.
    pub id: String,
    /// The formula.
    pub says: String,
    /// Under which conditions it holds.
    pub conditions: String,
    /// Authors and place.
    pub cite: String,
    /// Formula, or formula from memory.
    pub kind: String,
    /// Largest deviation of a model that has the law.
    pub tolerance: f64,
    /// Argument, and the value to four digits that was computed elsewhere, where there is one.
    pub points: Vec<Vec<f64>>,
    /// Why the law does not claim to hold there.
    pub outside: Option<String>,
}

impl UncertaintyIs {
    /// The word in tables.
    pub fn word(self) -> &'static str {
        match self {
            UncertaintyIs::Stated => "stated",
            UncertaintyIs::Rounding => "rounding",
            UncertaintyIs::Assumed => "ASSUMED",
        }
    }
}

impl Kind {
    /// The word in tables.
    pub fn word(self) -> &'static str {
        match self {
            Kind::Number => "number",
            Kind::Words => "words",
            Kind::Abstract => "abstract",
        }
    }
}

impl Datum {
    /// The number with its unit and uncertainty, or that it is not at hand; what is stated of a sentence stands elsewhere.
    pub fn number(&self) -> String {
        let unit = self.unit.as_deref().unwrap_or_default();
        match (self.kind, self.value, self.uncertainty.zip(self.uncertainty_is)) {
            (Kind::Number, Some(value), Some((within, is))) => format!("{value} ± {within} {unit} ({})", is.word()),
            (Kind::Number, Some(value), None) => format!("{value} {unit}"),
            (Kind::Number, None, _) => "not at hand".into(),
            _ => "in words".into(),
        }
    }
}

/// All sources.
pub fn sources() -> Result<Vec<Source>, toml::de::Error> {
    FILES.iter().map(|&(name, text)| Ok(Source { name, ..toml::from_str(text)? })).collect()
}

/// All laws.
pub fn laws() -> Result<Vec<Law>, toml::de::Error> {
    let mut laws: BTreeMap<String, Vec<Law>> = toml::from_str(LAWS)?;
    Ok(laws.remove("law").unwrap_or_default())
}
