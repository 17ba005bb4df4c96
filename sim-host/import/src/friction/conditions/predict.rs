//! Prediction of the friction ratio at a condition, with a band of the fit and of the scatter.

use std::str::FromStr;

use super::Conditions;
use super::interval::{Interval, interval, interval_of_new};
use super::measurement::Measurement;
use super::model::{Parameters, Point};
use crate::error::ImportError;
use crate::friction::quantity::Quantity;
use columns::Unit;
use report::significant;

/// Condition to be predicted, such as `speed=0.15,amplitude=5um,normal=10`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Request {
    speed_m_per_s: f64,
    normal_n: Option<f64>,
    /// Name, number and unit as given.
    level: Option<(String, f64, String)>,
}

/// SI units of the strength of a vibration, by the beginnings of its names.
const STRENGTHS: [(&str, &str); 6] =
    [("amp", "m"), ("volt", "V"), ("drive v", "V"), ("curr", "A"), ("tip", "m/s"), ("vibration", "m/s")];

/// Predicted friction ratio.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Prediction {
    /// Condition, for a reader.
    pub condition: String,
    /// Sliding speed, m/s.
    pub speed_m_per_s: f64,
    /// Normal force, N; `None` if it is unknown.
    pub normal_n: Option<f64>,
    /// Peak tip velocity, m/s.
    pub tip_m_per_s: f64,
    /// Friction ratio, with the uncertainty of the fit.
    pub fit: Interval,
    /// Friction ratio of a single new measurement, with the uncertainty of fit and scatter; `None`
    /// if the scatter is unknown.
    pub fit_and_scatter: Option<Interval>,
    /// Measured ranges that the condition is outside of.
    pub outside: Vec<String>,
}

impl FromStr for Request {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut request = Request::default();
        for part in text.split(',') {
            let wrong = || format!("`{part}` is not a condition; give speed=0.15, and if needed amplitude=5um, normal=10");
            let (name, value) = part.split_once('=').ok_or_else(wrong)?;
            let value = value.trim();
            let split = (1..=value.len()).rev().find(|at| value.is_char_boundary(*at) && value[..*at].parse::<f64>().is_ok());
            let (number, unit) = value.split_at(split.ok_or_else(wrong)?);
            let number = number.parse::<f64>().ok().filter(|number| *number > 0.0 && number.is_finite()).ok_or_else(wrong)?;
            let si = |base: &str| match unit.trim() {
                "" => Ok(number),
                unit => {
                    let base = Unit::parse(base).ok_or_else(wrong)?;
                    Unit::parse_like(unit, &base)
                        .and_then(|unit| unit.factor_to(&base))
                        .map(|factor| factor * number)
                        .ok_or_else(wrong)
                }
            };
            match Quantity::parse(name) {
                Some(Quantity::Velocity) => request.speed_m_per_s = si("m/s")?,
                Some(Quantity::Normal) => request.normal_n = Some(si("N")?),
                Some(Quantity::Level | Quantity::Tip) => {
                    request.level = Some((name.trim().to_lowercase(), number, unit.trim().to_owned()));
                }

                _ => return Err(wrong()),
            }
        }
        if request.speed_m_per_s == 0.0 { Err(format!("`{text}` has no speed; give speed=0.15")) } else { Ok(request) }
    }
}

impl Conditions {
    /// Predicts the friction ratio at a condition.
    ///
    /// # Errors
    /// Returns [`ImportError`] if the condition does not state a quantity that varies, or has
    /// another unit.
    pub fn predict(&self, request: &Request) -> Result<Prediction, ImportError> {
        let on = || self.measurements.iter().filter(|m| m.on);
        let range = |of: &dyn Fn(&Measurement) -> Option<f64>| {
            let values = on().filter_map(of);
            values.fold(None, |range: Option<(f64, f64)>, v| Some(range.map_or((v, v), |(a, b)| (a.min(v), b.max(v)))))
        };
        let (normals, levels, tips) = (range(&|m| m.normal_n), range(&|m| m.level), range(&|m| m.tip_m_per_s));
        let only = |range: Option<(f64, f64)>, name: &str| match range {
            Some((low, high)) if high > 1.05 * low => {
                let why = format!("--predict needs {name}=…: it was measured from {} to {}", significant(low), significant(high));
                Err(ImportError::NoFit(why))
            }
            range => Ok(range.map(|(low, high)| 0.5 * (low + high))),
        };
        let normal_n = match (request.normal_n, normals) {
            (Some(_), None) => return Err(ImportError::NoFit("--predict normal=…: no normal force was measured".into())),
            (Some(normal), _) => Some(normal),
            (None, normals) => only(normals, "normal")?,
        };
        let unit = self.level_unit.as_deref().unwrap_or("");
        let base = if levels.is_some() { unit } else { "m/s" };
        let strengths = levels.or(tips);
        let strength = match &request.level {
            None => only(strengths, "amplitude")?,
            Some(_) if strengths.is_none() => {
                return Err(ImportError::NoFit("--predict amplitude=…: no strength of the vibration was measured".into()));
            }
            Some((name, value, unit)) => Some(in_unit_of(name, *value, unit, base)?),
        };
        // The drive of the model is a tip velocity if that was measured.
        let drive = match (strength, levels, tips) {
            (Some(strength), Some((low, _)), Some((tip, _))) => strength * tip / low,
            (Some(strength), ..) => strength,
            (None, ..) => 1.0,
        };
        let point = Point { speed_m_per_s: request.speed_m_per_s, normal_n: normal_n.unwrap_or(1.0), drive: Some(drive) };
        let slice = &self.fit.slices[self.fit.chosen];
        let of = self.fit.model.parameters(&slice.fitted, slice.ln_compliance);
        let ratio = |of: &Parameters| self.fit.model.ratio(of, &point);
        let fit = interval(&self.fit, ratio);
        let fit_and_scatter = self.scatter.map(|_| interval_of_new(&self.fit, ratio));
        let mut outside = Vec::new();
        let ranges = [
            ("speed", Some(request.speed_m_per_s), range(&|m| Some(m.speed_m_per_s)), "m/s"),
            ("normal force", normal_n, normals, "N"),
            ("strength of the vibration", strength, strengths, base),
        ];
        for (name, value, range, unit) in ranges {
            if let (Some(value), Some((low, high))) = (value, range)
                && !(0.99 * low..=1.01 * high).contains(&value)
            {
                outside.push(
                    format!("{name}, measured from {} to {} {unit}", significant(low), significant(high)).trim_end().to_owned(),
                );
            }
        }
        let condition = self.describe(Some(request.speed_m_per_s), normal_n, strength, "");
        let tip_m_per_s = drive * libm::exp(of.ln_tip);
        Ok(Prediction { condition, speed_m_per_s: request.speed_m_per_s, normal_n, tip_m_per_s, fit, fit_and_scatter, outside })
    }
}

/// Returns a strength of the vibration in the unit of the measurements.
fn in_unit_of(name: &str, value: f64, unit: &str, base: &str) -> Result<f64, ImportError> {
    let refuse = |why: String| Err(ImportError::NoFit(format!("--predict {name}={value}{unit}: {why}")));
    let own = STRENGTHS.iter().find(|(begin, _)| name.starts_with(begin)).map(|(_, base)| *base);
    if !base.is_empty() && base != "%" && own.is_some_and(|own| own != base) {
        return refuse(format!("the strength of the vibration was measured in {base}"));
    }
    match (unit, base) {
        ("", "" | "%") => Ok(value),
        ("", base) => refuse(format!("give the unit, such as {}", if base == "m" { "um" } else { base })),
        (unit, base) if unit == base => Ok(value),
        (unit, base) => {
            let factor = Unit::parse(base).and_then(|base| Unit::parse_like(unit, &base)?.factor_to(&base));
            factor.map_or_else(|| refuse(format!("the unit of the measurements is `{base}`")), |factor| Ok(value * factor))
        }
    }
}
