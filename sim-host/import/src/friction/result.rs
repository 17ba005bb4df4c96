//! Result of an import: parameters with standard deviations, the chosen model, the friction ratio
//! of ON over OFF, and warnings.

use serde::Serialize;
use serde_json::{Map, Value as Json, json};

use super::certainty::sd_of_mean;
use super::fit::{Searched, criterion, search};
use super::log::Log;
use super::maxwell;
use super::models::Model;
use crate::admittance::Value;
use crate::error::ImportError;
use crate::rows::memory;

/// Largest standard deviation of a determined value, relative to the value.
const MAX_DETERMINED_SD_REL: f64 = 0.5;
/// Difference above which the value of another fit is ambiguous, standard deviations.
const AMBIGUOUS_SIGMAS: f64 = 2.0;

/// Fitted model.
#[derive(Clone, Debug, PartialEq)]
pub struct Fitted {
    /// Model.
    pub model: Model,
    /// Parameters by name, those of a coefficient of friction first, with their standard
    /// deviations. The deviation is `None` if the log does not determine the parameter.
    pub parameters: Vec<(String, f64, Option<f64>)>,
    /// Correlations of the fitted parameters, in the order of [`Fitted::names`].
    pub correlations: Vec<Vec<f64>>,
    /// Names of the fitted parameters.
    pub names: Vec<&'static str>,
    /// Parameters with another value in a fit that explains the log nearly as well. Their standard
    /// deviations include the difference.
    pub ambiguous: Vec<String>,
    /// Root mean square of the residuals, N.
    pub rms_n: f64,
    /// Information criterion; the smallest is the best.
    pub criterion: f64,
    /// Friction of the model at every sample, N.
    pub force_n: Vec<f64>,
}

/// Friction log with its contact.
#[derive(Clone, Debug, PartialEq)]
pub struct Friction {
    /// Name of the contact, from its file.
    pub name: String,
    /// Friction log.
    pub log: Log,
    /// All models, the best first.
    pub models: Vec<Fitted>,
    /// Friction ON over friction OFF, if the log has both.
    pub ratio: Option<Value>,
    /// Warnings for the reader, one sentence each.
    pub warnings: Vec<String>,
}

impl Friction {
    pub(super) fn from_log(name: &str, log: Log) -> Result<Self, ImportError> {
        let used: Vec<bool> = log.on.iter().map(|on| !on).collect();
        let searched: Vec<Searched> = Model::SEARCHED.into_iter().filter_map(|model| search(model, &log)).collect();
        let square = |residuals: &[f64]| residuals.iter().map(|r| r * r).sum::<f64>();
        let best = searched.iter().min_by(|a, b| square(&a.residuals).total_cmp(&square(&b.residuals)));
        let best = best.ok_or_else(|| ImportError::NoFit("no contact model leads to a finite friction".into()))?;
        let (_, memory) = memory(&[&best.residuals]);
        let mut models: Vec<Fitted> = searched.iter().map(|found| fitted(found, &log, memory)).collect();
        models.extend(fit_maxwell(&log, &used, memory));
        models.sort_by(|a, b| a.criterion.total_cmp(&b.criterion));
        // The generalised Maxwell slip is not available in scenes: it is shown, but never chosen.
        models.sort_by_key(|model| model.model == Model::Maxwell);
        let warnings = warnings(&models);
        Ok(Friction { name: name.to_owned(), ratio: ratio(&log), log, models, warnings })
    }

    /// Returns the chosen model.
    pub fn chosen(&self) -> &Fitted {
        &self.models[0]
    }

    /// Returns the result for programs. `scene` is the path of the written scene.
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

/// Converts a fit to the parameters of a scene.
fn fitted(found: &Searched, log: &Log, memory: f64) -> Fitted {
    let parameters = found.model.parameters();
    let variance = |i: usize, j: usize| found.covariance[(i, j)];
    let of = |fitted: &[f64]| named(found.model, fitted, &variance, log.normal_n);
    let rivals: Vec<Vec<Number>> = found.rivals.iter().map(|rival| of(rival)).collect();
    let mut ambiguous = Vec::new();
    let number = |(at, (name, value, sd)): (usize, Number)| {
        let apart = rivals.iter().map(|rival| (rival[at].1 - value).abs()).fold(0.0, f64::max);
        if apart > AMBIGUOUS_SIGMAS * sd {
            ambiguous.push(name.clone());
        }
        let sd = if apart > AMBIGUOUS_SIGMAS * sd { apart } else { sd };
        let is_determined = sd.is_finite() && sd <= MAX_DETERMINED_SD_REL * value.abs();
        (name, value, is_determined.then_some(sd))
    };
    let named = of(&found.fitted).into_iter().enumerate().map(number).collect();
    // The deviation of a logarithm is relative to the value already.
    let is_determined = |at: usize| {
        let size = if parameters[at].1 { 1.0 } else { found.fitted[at].abs() };
        variance(at, at).sqrt() <= MAX_DETERMINED_SD_REL * size
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

/// Value of a contact: its name, the value and its standard deviation.
type Number = (String, f64, f64);

/// Returns the values of a model in a scene, from the parameters of the fit and their covariance.
pub(crate) fn named(model: Model, fitted: &[f64], covariance: &impl Fn(usize, usize) -> f64, normal_n: f64) -> Vec<Number> {
    let values = model.values(fitted);
    // The deviation of a logarithm is relative to the value.
    let slope = |at: usize| if model.parameters()[at].1 { values[at] } else { 1.0 };
    let common = |i: usize, j: usize| slope(i) * slope(j) * covariance(i, j);
    let sd = |at: usize| common(at, at).sqrt();
    let mut named = Vec::new();
    for (at, (name, _)) in model.parameters().iter().enumerate() {
        match *name {
            "coulomb_n" => named.push(("mu".to_owned(), values[at] / normal_n, sd(at) / normal_n)),
            "static_excess_n" => {
                // The static friction is a sum of two correlated parameters.
                let both = (common(0, 0) + common(at, at) + 2.0 * common(0, at)).max(0.0).sqrt();
                named.push(("static_mu".to_owned(), (values[0] + values[at]) / normal_n, both / normal_n));
            }
            "initial_force_n" => {}
            // A scene does not accept a contact with negative viscous friction.
            "sigma2" => named.push(("sigma2".to_owned(), values[at].max(0.0), sd(at))),
            name => named.push((name.to_owned(), values[at], sd(at))),
        }
    }
    named
}

fn fit_maxwell(log: &Log, used: &[bool], memory: f64) -> Option<Fitted> {
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

/// Returns the mean friction ON over OFF, each in the direction of the slip.
fn ratio(log: &Log) -> Option<Value> {
    let mean_and_variance = |wanted: bool| {
        let is_part = |at: &usize| log.on[*at] == wanted && log.slip_m[*at] != 0.0;
        let places: Vec<usize> = (0..log.on.len()).filter(is_part).collect();
        let values: Vec<f64> = places.iter().map(|at| log.force_n[*at] * log.slip_m[*at].signum()).collect();
        let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
        let sd = sd_of_mean(values.iter().map(|value| mean - value).collect(), &places)?;
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
            "the log does not determine {} of the model `{}`: a stiffness needs samples within the presliding, a Stribeck \
             velocity needs slow and fast sliding",
            open.join(", "),
            chosen.model.name()
        ));
    }
    if !chosen.ambiguous.is_empty() {
        warnings.push(format!(
            "`{}` explains the log nearly as well with another {}: the standard deviation includes the difference",
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
            "`{}` cannot describe the shape of the presliding: the residuals of the generalised Maxwell slip are {:.2} times as \
             large",
            chosen.model.name(),
            maxwell.rms_n / chosen.rms_n
        ));
    }
    warnings
}
