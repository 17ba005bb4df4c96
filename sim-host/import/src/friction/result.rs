//! Result of a log: parameters with standard deviations, the chosen model, and warnings.

use serde_json::{Map, Value as Json, json};

use super::fit::{MU, Searched, criterion, search};
use super::log::Log;
use super::maxwell;
use super::models::{Model, Parameter};
use super::motion;
use crate::error::ImportError;
use crate::rows::memory;
use report::stated;

/// Largest standard deviation of a determined value, relative to the value.
const MAX_DETERMINED_SD_REL: f64 = 0.5;
/// Difference above which the value of another fit is ambiguous, standard deviations.
const AMBIGUOUS_SIGMAS: f64 = 2.0;
/// Residuals of the generalised Maxwell slip, relative to those of the chosen model, below which a
/// warning names the shape of the presliding.
const MAX_SHAPE_REL: f64 = 0.8;
/// Smallest offset that a warning names, standard deviations.
const OFFSET_SIGMAS: f64 = 5.0;
/// Smallest offset that a warning names, relative to the Coulomb friction.
const MIN_OFFSET_REL: f64 = 0.02;
/// Decrease of the criterion by a model that no scene can have, above which a warning names it.
const MIN_DECREASE: f64 = 6.0;

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
    /// Root mean square of the errors at samples that the fit has not seen, N; `None` if the model
    /// is never chosen.
    pub held_out_n: Option<f64>,
    /// `true` if a scene can have all parameters, and none is at its bound.
    pub is_within_bounds: bool,
    /// Force of the model at every sample, N.
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
    /// Warnings for the reader, one sentence each.
    pub warnings: Vec<String>,
}

impl Friction {
    pub(super) fn from_log(name: &str, log: Log) -> Result<Self, ImportError> {
        let mut log = log.checked()?;
        let is_turned = log.turn();
        let baseline = motion::baseline(&log);
        let searched = search(&log, baseline);
        let best = searched.iter().min_by(|a, b| rms(&a.residuals).total_cmp(&rms(&b.residuals)));
        let best = best.ok_or_else(|| ImportError::NoFit("no contact model leads to a finite friction".into()))?;
        // All models are compared at the same number of samples.
        let count = log.on.iter().filter(|on| !**on).count() as f64 / memory(&[&best.residuals]).1;
        let mut models: Vec<Fitted> = searched.iter().map(|found| fitted(found, &log, count)).collect();
        models.sort_by(|a, b| a.criterion.total_cmp(&b.criterion));
        models.sort_by_key(|model| !model.is_within_bounds);
        // More parameters must also improve the prediction of samples that the fit has not seen.
        let (most, held_out_n) = (models[0].names.len(), models[0].held_out_n);
        let is_better = |model: &Fitted| model.is_within_bounds && model.names.len() < most && model.held_out_n < held_out_n;
        if let Some(at) = models.iter().position(is_better) {
            models[..=at].rotate_right(1);
        }
        let chosen = &models[0];
        if !chosen.is_within_bounds {
            let text = format!(
                "no model of a scene fits: {} would need a parameter at the bound of a scene; check the unit of the force, the \
                 normal force, and if the force is the friction",
                chosen.model.name()
            );
            return Err(ImportError::NoFit(text));
        }
        let friction_n = without_baseline(&log, chosen);
        models.extend(fit_maxwell(&log, &friction_n, count));
        let mut warnings = warnings(&models, log.normal_n);
        if is_turned {
            warnings.push("the force is with the motion: its sign was turned".into());
        }
        if baseline == 0 {
            warnings.push("the log slides in one direction: an offset of the force would be a part of the friction".into());
        }
        Ok(Friction { name: name.to_owned(), log, models, warnings })
    }

    /// Returns the chosen model.
    pub fn chosen(&self) -> &Fitted {
        &self.models[0]
    }

    /// Returns the logarithm of the stiffness over angular frequency and its standard deviation, if
    /// the log determines it.
    pub(super) fn stiffness_s(&self, frequency_hz: f64) -> Option<(f64, f64)> {
        let (_, value, sd) = self.chosen().parameters.iter().find(|(name, ..)| name == "stiffness_n_per_m")?;
        Some((libm::log(value / (std::f64::consts::TAU * frequency_hz)), (*sd)? / value))
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
            object.insert("held_out_n".into(), json!(fitted.held_out_n));
            object.insert("correlation".into(), json!({ "names": fitted.names, "matrix": fitted.correlations }));
            Json::Object(object)
        };
        json!({
            "contact": of(self.chosen()), "models": self.models.iter().map(of).collect::<Vec<_>>(), "scene": scene,
            "normal_n": self.log.normal_n, "samples": self.log.force_n.len(),
            "remarks": self.log.remarks, "warnings": self.warnings,
        })
    }
}

/// Converts a fit to the parameters of a scene.
fn fitted(found: &Searched, log: &Log, count: f64) -> Fitted {
    let parameters = &found.parameters;
    let variance = |i: usize, j: usize| found.covariance[(i, j)];
    let of = |fitted: &[f64]| named(parameters, fitted, &variance, log.normal_n);
    let rivals: Vec<Vec<Number>> = found.rivals.iter().map(|rival| of(rival)).collect();
    let mut ambiguous = Vec::new();
    let number = |(at, (name, value, sd)): (usize, Number)| {
        let apart = rivals.iter().map(|rival| (rival[at].1 - value).abs()).fold(0.0, f64::max);
        if apart > AMBIGUOUS_SIGMAS * sd {
            ambiguous.push(name.clone());
        }
        let sd = if apart > AMBIGUOUS_SIGMAS * sd { apart } else { sd };
        let size = if is_baseline(&name) { f64::INFINITY } else { value.abs() };
        (name, value, Some(sd).filter(|sd| sd.is_finite() && *sd <= MAX_DETERMINED_SD_REL * size))
    };
    let named: Vec<_> = of(&found.fitted).into_iter().enumerate().map(number).collect();
    // The deviation of a logarithm is relative to the value already.
    let is_determined = |at: usize| {
        let size = match parameters[at] {
            (_, true) => 1.0,
            (name, _) if is_baseline(name) => f64::INFINITY,
            _ => found.fitted[at].abs(),
        };
        !found.at_bound[at] && variance(at, at).sqrt() <= MAX_DETERMINED_SD_REL * size
    };
    let correlation = |i: usize, j: usize| {
        if is_determined(i) && is_determined(j) { variance(i, j) / (variance(i, i) * variance(j, j)).sqrt() } else { 0.0 }
    };
    let all = 0..parameters.len();
    let is_steep = |(name, value, _): &(String, f64, Option<f64>)| name == "static_mu" && *value > MU.1;
    Fitted {
        model: found.model,
        is_within_bounds: !found.is_bounded() && !named.iter().any(is_steep),
        parameters: named,
        correlations: all.clone().map(|i| all.clone().map(|j| correlation(i, j)).collect()).collect(),
        names: parameters.iter().map(|(name, _)| *name).collect(),
        ambiguous,
        rms_n: rms(&found.residuals),
        criterion: criterion(rms(&found.residuals), parameters.len(), count),
        held_out_n: Some(found.held_out_n),
        force_n: found.force_n.clone(),
    }
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|r| r * r).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

/// Returns `true` for the parameters of the baseline of the force, which may be zero.
fn is_baseline(name: &str) -> bool {
    matches!(name, "offset_n" | "drift_n")
}

/// Value of a contact: its name, the value and its standard deviation.
type Number = (String, f64, f64);

/// Returns the values of a model in a scene, from the parameters of the fit and their covariance.
pub(crate) fn named(
    parameters: &[Parameter],
    fitted: &[f64],
    covariance: &impl Fn(usize, usize) -> f64,
    normal_n: f64,
) -> Vec<Number> {
    let values: Vec<f64> = parameters.iter().zip(fitted).map(|((_, log), p)| if *log { libm::exp(*p) } else { *p }).collect();
    // The deviation of a logarithm is relative to the value.
    let slope = |at: usize| if parameters[at].1 { values[at] } else { 1.0 };
    let common = |i: usize, j: usize| slope(i) * slope(j) * covariance(i, j);
    let sd = |at: usize| common(at, at).sqrt();
    let mut named = Vec::new();
    for (at, (name, _)) in parameters.iter().enumerate() {
        match *name {
            "coulomb_n" => named.push(("mu".to_owned(), values[at] / normal_n, sd(at) / normal_n)),
            "static_excess_n" => {
                // The static friction is a sum of two correlated parameters.
                let both = (common(0, 0) + common(at, at) + 2.0 * common(0, at)).max(0.0).sqrt();
                named.push(("static_mu".to_owned(), (values[0] + values[at]) / normal_n, both / normal_n));
            }
            "initial_force_n" => {}
            name => named.push((name.to_owned(), values[at], sd(at))),
        }
    }
    named
}

/// Returns the measured force without the offset and the drift of a fit, N.
fn without_baseline(log: &Log, fitted: &Fitted) -> Vec<f64> {
    let value = |wanted: &str| fitted.parameters.iter().find(|(name, ..)| name == wanted).map_or(0.0, |(_, value, _)| *value);
    let (offset, drift, count) = (value("offset_n"), value("drift_n"), log.force_n.len());
    log.force_n.iter().enumerate().map(|(at, force)| force - offset - drift * motion::drift(at, count)).collect()
}

fn fit_maxwell(log: &Log, friction_n: &[f64], count: f64) -> Option<Fitted> {
    let used: Vec<bool> = log.on.iter().map(|on| !on).collect();
    let mut found = maxwell::fit(log, friction_n, &used)?;
    let residuals: Vec<f64> =
        found.force_n.iter().zip(friction_n).zip(&used).filter(|(_, used)| **used).map(|((f, m), _)| f - m).collect();
    let rms_n = rms(&residuals);
    // With the baseline again, as the forces of the other models.
    found.force_n.iter_mut().zip(log.force_n.iter().zip(friction_n)).for_each(|(force, (all, own))| *force += all - own);
    let springs = found.stiffnesses.iter().zip(&found.deflections_m).zip(&found.variances);
    let mut parameters = Vec::new();
    let mut names = Vec::new();
    for (at, ((k, deflection), variance)) in springs.enumerate().filter(|(_, ((k, _), _))| **k > 0.0) {
        parameters.push((
            format!("stiffness_{at}_n_per_m"),
            *k,
            Some(rms_n * (residuals.len() as f64 / count * variance).sqrt()),
        ));
        parameters.push((format!("deflection_{at}_m"), *deflection, None));
        names.push("stiffness_n_per_m");
    }
    Some(Fitted {
        model: Model::Maxwell,
        criterion: criterion(rms_n, names.len(), count),
        parameters,
        correlations: Vec::new(),
        names,
        ambiguous: Vec::new(),
        rms_n,
        held_out_n: None,
        is_within_bounds: false,
        force_n: found.force_n,
    })
}

fn warnings(models: &[Fitted], normal_n: f64) -> Vec<String> {
    let chosen = &models[0];
    let mut warnings = Vec::new();
    let open: Vec<&str> = chosen.parameters.iter().filter(|(.., sd)| sd.is_none()).map(|(name, ..)| name.as_str()).collect();
    if !open.is_empty() {
        warnings.push(format!(
            "the log does not determine {} of the model `{}`: a stiffness needs samples within the presliding, a Stribeck \
             velocity needs slow and fast sliding, and a value of 0 is the bound of a scene",
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
    let value = |wanted: &str| chosen.parameters.iter().find(|(name, ..)| name == wanted).map(|(_, value, sd)| (*value, *sd));
    if let (Some((offset, Some(sd))), Some(first)) = (value("offset_n"), chosen.parameters.first())
        && offset.abs() > (OFFSET_SIGMAS * sd).max(MIN_OFFSET_REL * first.1 * normal_n)
    {
        let (offset, sd) = stated(offset, sd);
        warnings.push(format!("the force has an offset of {offset} N with a standard deviation of {sd} N: it is not friction"));
    }
    for model in models.iter().filter(|model| !model.is_within_bounds && chosen.criterion - model.criterion > MIN_DECREASE) {
        if model.model != Model::Maxwell {
            warnings.push(format!(
                "`{}` explains the log better than `{}`, but with a parameter at the bound of a scene, which is not identified",
                model.model.name(),
                chosen.model.name()
            ));
        }
    }
    if let Some(next) = models.iter().filter(|model| model.is_within_bounds).nth(1)
        && (next.criterion - chosen.criterion).abs() < MIN_DECREASE
    {
        warnings.push(format!("`{}` explains the log nearly as well as `{}`", next.model.name(), chosen.model.name()));
    }
    if let Some(maxwell) = models.iter().find(|model| model.model == Model::Maxwell)
        && maxwell.rms_n < MAX_SHAPE_REL * chosen.rms_n
    {
        warnings.push(format!(
            "`{}` cannot describe the shape of the presliding: the residuals of the generalised Maxwell slip are {:.2} times \
             as large",
            chosen.model.name(),
            maxwell.rms_n / chosen.rms_n
        ));
    }
    warnings
}
