//! The result: parameters with standard deviations, the model chosen, the friction ratio of ON over OFF, and what to be careful about.

use serde::Serialize;
use serde_json::{Map, Value as Json, json};

use super::certainty::{memory, of_mean};
use super::fit::{Searched, criterion, search};
use super::log::Log;
use super::maxwell;
use super::models::Model;
use crate::admittance::Value;
use crate::error::ImportError;

/// Part of its value up to which the standard deviation of a number that is determined goes.
const UNDETERMINED: f64 = 0.5;
/// Standard deviations from which a number of another fit is another one.
const APART: f64 = 2.0;

/// A model as fitted.
#[derive(Clone, Debug, PartialEq)]
pub struct Fitted {
    /// The model.
    pub model: Model,
    /// Parameters by name, those of a coefficient of friction first; without a standard deviation where the log does not determine one.
    pub parameters: Vec<(String, f64, Option<f64>)>,
    /// Correlations of the parameters of the fit, in the order of [`Fitted::names`].
    pub correlations: Vec<Vec<f64>>,
    /// Names of the parameters of the fit.
    pub names: Vec<&'static str>,
    /// Parameters that have another value in a fit that explains the log nearly as well; their standard deviations reach to it.
    pub ambiguous: Vec<String>,
    /// Root mean square of the residuals, N.
    pub rms_n: f64,
    /// Information criterion; the least is the best.
    pub criterion: f64,
    /// Friction of the model at every sample, N.
    pub force_n: Vec<f64>,
}

/// A friction log and its contact.
#[derive(Clone, Debug, PartialEq)]
pub struct Friction {
    /// Name of the contact: that of its file.
    pub name: String,
    /// The log.
    pub log: Log,
    /// All models, the best first.
    pub models: Vec<Fitted>,
    /// Friction ON over friction OFF, where the log has both.
    pub ratio: Option<Value>,
    /// What the reader should be careful about, a sentence each.
    pub warnings: Vec<String>,
}

impl Friction {
    pub(super) fn of(name: &str, log: Log) -> Result<Self, ImportError> {
        let used: Vec<bool> = log.on.iter().map(|on| !on).collect();
        let searched: Vec<Searched> = Model::SEARCHED.into_iter().filter_map(|model| search(model, &log, &used)).collect();
        let square = |residuals: &[f64]| residuals.iter().map(|r| r * r).sum::<f64>();
        let best = searched.iter().min_by(|a, b| square(&a.residuals).total_cmp(&square(&b.residuals)));
        let best = best.ok_or_else(|| ImportError::NoFit("no contact model leads to a finite friction".into()))?;
        let memory = memory(&best.residuals);
        let mut models: Vec<Fitted> = searched.iter().map(|found| fitted(found, &log, memory)).collect();
        models.extend(of_maxwell(&log, &used, memory));
        models.sort_by(|a, b| a.criterion.total_cmp(&b.criterion));
        // A scene has no generalised Maxwell slip: it is shown, and never chosen.
        models.sort_by_key(|model| model.model == Model::Maxwell);
        let warnings = warnings(&models);
        Ok(Friction { name: name.to_owned(), ratio: ratio(&log), log, models, warnings })
    }

    /// The model chosen.
    pub fn chosen(&self) -> &Fitted {
        &self.models[0]
    }

    /// The result for programs; `scene` is where its scene was written.
    pub fn json(&self, scene: Option<&str>) -> Json {
        let of = |fitted: &Fitted| {
            let mut object = Map::new();
            object.insert("model".into(), json!(fitted.model.name()));
            for (name, value, sd) in &fitted.parameters {
                object.insert(name.clone(), json!({ "value": value, "sd": sd }));
            }
            object.insert("rms_n".into(), json!(fitted.rms_n));
            object.insert("criterion".into(), json!(fitted.criterion));
            object.insert("correlation".into(), json!({ "names": fitted.names, "matrix": fitted.correlations }));
            Json::Object(object)
        };
        #[derive(Serialize)]
        struct Ratio {
            friction_ratio: Value,
        }
        json!({
            "contact": of(self.chosen()), "models": self.models.iter().map(of).collect::<Vec<_>>(), "scene": scene,
            "normal_n": self.log.normal_n, "samples": self.log.force_n.len(), "on": self.ratio.map(|friction_ratio| Ratio { friction_ratio }),
            "remarks": self.log.remarks, "warnings": self.warnings,
        })
    }
}

/// The parameters that a scene has, from those of the fit.
fn fitted(found: &Searched, log: &Log, memory: f64) -> Fitted {
    let parameters = found.model.parameters();
    let variance = |i: usize, j: usize| found.covariance[(i, j)];
    let of = |fitted: &[f64]| named(found.model, fitted, &variance, log.normal_n);
    let rivals: Vec<Vec<Number>> = found.rivals.iter().map(|rival| of(rival)).collect();
    let mut ambiguous = Vec::new();
    let number = |(at, (name, value, sd)): (usize, Number)| {
        let apart = rivals.iter().map(|rival| (rival[at].1 - value).abs()).fold(0.0, f64::max);
        if apart > APART * sd {
            ambiguous.push(name.clone());
        }
        let sd = if apart > APART * sd { apart } else { sd };
        let is_determined = sd.is_finite() && sd <= UNDETERMINED * value.abs();
        (name, value, is_determined.then_some(sd))
    };
    let named = of(&found.fitted).into_iter().enumerate().map(number).collect();
    // A logarithm is determined to a part of the value, anything else to a part of itself.
    let is_determined = |at: usize| {
        let size = if parameters[at].1 { 1.0 } else { found.fitted[at].abs() };
        variance(at, at).sqrt() <= UNDETERMINED * size
    };
    let correlation = |i: usize, j: usize| {
        if is_determined(i) && is_determined(j) { variance(i, j) / (variance(i, i) * variance(j, j)).sqrt() } else { 0.0 }
    };
    let all = 0..parameters.len();
    let rms_n = (found.residuals.iter().map(|r| r * r).sum::<f64>() / found.residuals.len().max(1) as f64).sqrt();
    Fitted {
        model: found.model,
        parameters: named,
        correlations: all.clone().map(|i| all.clone().map(|j| correlation(i, j)).collect()).collect(),
        names: parameters.iter().map(|(name, _)| *name).collect(),
        ambiguous,
        rms_n,
        criterion: criterion(&found.residuals, parameters.len(), memory),
        force_n: found.model.force(&found.fitted, log),
    }
}

/// A number of a contact: its name, its value and its standard deviation.
type Number = (String, f64, f64);

/// The numbers that a scene has of a model, from the parameters of the fit and their covariance.
pub(crate) fn named(model: Model, fitted: &[f64], covariance: &impl Fn(usize, usize) -> f64, normal_n: f64) -> Vec<Number> {
    let values = model.values(fitted);
    // A logarithm's deviation is a part of the value.
    let slope = |at: usize| if model.parameters()[at].1 { values[at] } else { 1.0 };
    let common = |i: usize, j: usize| slope(i) * slope(j) * covariance(i, j);
    let sd = |at: usize| common(at, at).sqrt();
    let mut named = Vec::new();
    for (at, (name, _)) in model.parameters().iter().enumerate() {
        match *name {
            "coulomb_n" => named.push(("mu".to_owned(), values[at] / normal_n, sd(at) / normal_n)),
            "static_excess_n" => {
                // The static friction is a sum of two parameters, which are not independent.
                let both = (common(0, 0) + common(at, at) + 2.0 * common(0, at)).max(0.0).sqrt();
                named.push(("static_mu".to_owned(), (values[0] + values[at]) / normal_n, both / normal_n));
            }
            "initial_force_n" => {}
            // A contact that pushes is none of a scene.
            "sigma2" => named.push(("sigma2".to_owned(), values[at].max(0.0), sd(at))),
            name => named.push((name.to_owned(), values[at], sd(at))),
        }
    }
    named
}

fn of_maxwell(log: &Log, used: &[bool], memory: f64) -> Option<Fitted> {
    let found = maxwell::fit(log, used)?;
    let residuals: Vec<f64> =
        found.force_n.iter().zip(&log.force_n).zip(used).filter(|(_, used)| **used).map(|((f, m), _)| f - m).collect();
    let mean = residuals.iter().map(|r| r * r).sum::<f64>() / residuals.len().max(1) as f64;
    let springs = found.stiffnesses.iter().zip(&found.deflections_m).zip(&found.variances);
    let mut parameters = Vec::new();
    let mut names = Vec::new();
    for (at, ((k, deflection), variance)) in springs.enumerate().filter(|(_, ((k, _), _))| **k > 0.0) {
        parameters.push((format!("stiffness_{at}_n_per_m"), *k, Some((mean * memory * variance).sqrt())));
        parameters.push((format!("deflection_{at}_m"), *deflection, None));
        names.push("stiffness_n_per_m");
    }
    let count = names.len();
    Some(Fitted {
        model: Model::Maxwell,
        parameters,
        correlations: Vec::new(),
        names,
        ambiguous: Vec::new(),
        rms_n: mean.sqrt(),
        criterion: criterion(&residuals, count, memory),
        force_n: found.force_n,
    })
}

/// Mean friction ON over OFF, each along its slip.
fn ratio(log: &Log) -> Option<Value> {
    let mean_and_variance = |wanted: bool| {
        let is_part = |at: &usize| log.on[*at] == wanted && log.slip_m[*at] != 0.0;
        let places: Vec<usize> = (0..log.on.len()).filter(is_part).collect();
        let values: Vec<f64> = places.iter().map(|at| log.force_n[*at] * log.slip_m[*at].signum()).collect();
        let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
        let sd = of_mean(values.iter().map(|value| mean - value).collect(), &places)?;
        (values.len() >= 3).then_some((mean, sd * sd))
    };
    let ((on, of_on), (off, of_off)) = (mean_and_variance(true)?, mean_and_variance(false)?);
    let value = on / off;
    Some(Value { value, sd: value.abs() * (of_on / (on * on) + of_off / (off * off)).sqrt() })
}

fn warnings(models: &[Fitted]) -> Vec<String> {
    let chosen = &models[0];
    let mut warnings = Vec::new();
    let open: Vec<&str> = chosen.parameters.iter().filter(|(.., sd)| sd.is_none()).map(|(name, ..)| name.as_str()).collect();
    if !open.is_empty() {
        warnings.push(format!(
            "the log does not determine {} of the model `{}`: a stiffness needs samples within the presliding, a Stribeck velocity needs slow and fast sliding",
            open.join(", "),
            chosen.model.name()
        ));
    }
    if !chosen.ambiguous.is_empty() {
        warnings.push(format!(
            "`{}` explains the log nearly as well with another {}: the standard deviation reaches to it",
            chosen.model.name(),
            chosen.ambiguous.join(" and another ")
        ));
    }
    if let Some(next) = models.iter().filter(|model| model.model != Model::Maxwell).nth(1)
        && next.criterion - chosen.criterion < 6.0
    {
        warnings.push(format!("`{}` explains the log nearly as well as `{}`", next.model.name(), chosen.model.name()));
    }
    if let Some(maxwell) = models.iter().find(|model| model.model == Model::Maxwell)
        && maxwell.rms_n < 0.7 * chosen.rms_n
    {
        warnings.push(format!(
            "the presliding has a shape that `{}` does not have: the generalised Maxwell slip leaves {:.2} of its residuals",
            chosen.model.name(),
            maxwell.rms_n / chosen.rms_n
        ));
    }
    warnings
}
