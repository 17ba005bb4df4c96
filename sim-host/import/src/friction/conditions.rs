//! Measurements at many conditions (speed, load, strength of the vibration), with and without
//! vibration, fitted together: [`Conditions`].
//!
//! ```text
//! files -> measurements (a row or a steady part each) -> one fit of OFF and ON -> ratio of each condition, predictions
//! ```

mod checks;
mod fit;
mod interval;
mod measurement;
mod model;
mod named;
mod predict;
mod steady;
mod table;
mod view;

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use super::log::Options;
use super::quantity::{Columns, file_name};
use crate::error::ImportError;
pub use fit::Stiffness;
pub use interval::Interval;
pub use measurement::Measurement;
pub use predict::{Prediction, Request};
pub use table::Condition;

/// Friction at many conditions, with its fit.
pub struct Conditions {
    /// Name, from the file.
    pub name: String,
    /// Measurements, in the order of the files.
    pub measurements: Vec<Measurement>,
    /// Measured and fitted friction ratio of each condition with vibration.
    pub conditions: Vec<Condition>,
    /// Frequency of the vibration, Hz, if it was measured.
    pub frequency_hz: Option<f64>,
    /// Unit of the strength of the vibration; `None` if it is not stated, empty without a unit.
    pub level_unit: Option<String>,
    /// Coefficient of friction without vibration.
    pub mu: Interval,
    /// Peak tip velocity, m/s, per strength of the vibration; `None` if it was measured.
    pub tip: Option<Interval>,
    /// Tangential stiffness over angular frequency, N s/m, or over angular frequency and normal
    /// force, s/m, if that is unknown.
    pub stiffness_s: Interval,
    /// Knowledge of the stiffness.
    pub stiffness: Stiffness,
    /// Relative scatter of OFF and ON measurements; `None` if there are too few.
    pub scatter: Option<[f64; 2]>,
    /// Assumptions of the fit, one sentence each.
    pub assumptions: Vec<String>,
    /// Properties of the files, one sentence each.
    pub remarks: Vec<String>,
    /// Warnings, one sentence each.
    pub warnings: Vec<String>,
    /// `true` if the fit does not describe the measurements.
    pub is_doubtful: bool,
    fit: fit::Fit,
}

impl Conditions {
    /// Reads and fits files. `known` is the logarithm of a stiffness over angular frequency and its
    /// standard deviation.
    ///
    /// # Errors
    /// Returns [`ImportError`], with the file, the line or the column that shows the reason.
    pub(super) fn from_files(
        files: &[(PathBuf, Columns)],
        options: &Options,
        known: Option<(f64, f64)>,
    ) -> Result<Self, ImportError> {
        let mut all = Vec::new();
        let (mut remarks, mut notes, mut measurements) = (Vec::new(), Vec::new(), Vec::new());
        for (path, columns) in files {
            let mut found = measurement::read(path, columns, options).map_err(|error| error.of_file(path))?;
            found.measurements.iter_mut().for_each(|m| m.file = all.len());
            remarks.append(&mut found.remarks);
            notes.extend(found.notes.into_iter().filter(|note| !notes.contains(note)).collect::<Vec<_>>());
            measurements.append(&mut found.measurements);
            all.push((path, found.level_unit, found.frequency_hz));
        }
        let differ = |of: &dyn Fn(usize) -> Option<String>| -> Option<(usize, usize)> {
            let stated: Vec<usize> = (0..all.len()).filter(|at| of(*at).is_some()).collect();
            stated.iter().find(|at| of(**at) != of(stated[0])).map(|at| (stated[0], *at))
        };
        if let Some((first, other)) = differ(&|at| all[at].1.clone()) {
            let unit = |at: usize| match all[at].1.as_deref() {
                Some("") | None => "no unit".to_owned(),
                Some(unit) => format!("the unit {unit}"),
            };
            let why = format!(
                "the strength of the vibration has {} here, but {} in {}; give it in the same unit in all files",
                unit(other),
                unit(first),
                file_name(all[first].0)
            );
            return Err(ImportError::NoFit(why).of_file(all[other].0));
        }
        let stated: Vec<f64> = all.iter().filter_map(|(.., hz)| *hz).collect();
        let frequency_hz = match stated[..] {
            [] => options.frequency_hz,
            [first, ..] if stated.iter().all(|hz| (hz / first - 1.0).abs() < 0.02) => Some(first),
            _ => return Err(ImportError::NoFit("the files have different frequencies of the vibration; fit each alone".into())),
        };
        let level_unit = all.iter().find_map(|(_, unit, _)| unit.clone());
        let name = files.first().map_or_else(String::new, |(path, _)| file_name(path));
        let name = if files.len() == 1 { name } else { format!("{name} and {} more", files.len() - 1) };
        let mut found = Self::from_measurements(name, measurements, (level_unit, frequency_hz), known, remarks)?;
        found.warnings.append(&mut notes);
        Ok(found)
    }

    fn from_measurements(
        name: String,
        mut measurements: Vec<Measurement>,
        (level_unit, frequency_hz): (Option<String>, Option<f64>),
        known: Option<(f64, f64)>,
        mut remarks: Vec<String>,
    ) -> Result<Self, ImportError> {
        measurements.retain(|m| m.speed_m_per_s > 0.0 && m.mu.is_finite());
        // Friction takes energy out of the motion.
        if measurements.iter().filter(|m| !m.on).map(|m| m.mu).sum::<f64>() < 0.0 {
            measurements.iter_mut().for_each(|m| m.mu = -m.mu);
            remarks.push("The force is with the motion: its sign was turned".into());
        }
        let mut assumptions =
            vec!["the vibration is a sine along the sliding, and the friction ratio is quasi-static".to_owned()];
        // An amplitude and a frequency are a velocity.
        if let (Some("m"), Some(hz)) = (level_unit.as_deref(), frequency_hz) {
            assumptions.push("the amplitude is that of the sliding surface, from zero to the peak".into());
            measurements.iter_mut().for_each(|m| m.tip_m_per_s = m.tip_m_per_s.or(m.level.map(|level| TAU * hz * level)));
        }
        let (off, on) = (measurements.iter().filter(|m| !m.on).count(), measurements.iter().filter(|m| m.on).count());
        if off == 0 || on == 0 {
            let (has, lacks, name) = if off == 0 { ("ON", "OFF", "…_off") } else { ("OFF", "ON", "…_on") };
            return Err(ImportError::NoFit(format!(
                "all {} measurements are {has}; a ratio also needs one with the vibration {lacks}: add a file named `{name}`, or \
                 rows with {lacks} in a column `state`",
                off + on
            )));
        }
        let measured_tip = measurements.iter().filter(|m| m.on && m.tip_m_per_s.is_some()).count();
        let stated = measurements.iter().filter(|m| m.on && m.level.is_some()).count();
        for (what, count) in [("tip velocity", measured_tip), ("strength of the vibration", stated)] {
            if count != 0 && count != on {
                let why = format!("{count} of {on} measurements with vibration state the {what}; state it in all or in none");
                return Err(ImportError::NoFit(why));
            }
        }
        checks::check_tips(&measurements)?;
        if let Some(bad) = measurements.iter().find(|m| m.on && m.tip_m_per_s.or(m.level).is_some_and(|level| level <= 0.0)) {
            let why = format!("the measurement at {:?} m/s is ON, but the strength of its vibration is zero", bad.speed_m_per_s);
            return Err(ImportError::NoFit(why));
        }
        if measurements.iter().any(|m| m.normal_n.is_none()) {
            measurements.iter_mut().for_each(|m| m.normal_n = None);
            assumptions.push("the normal force, which is not stated, is the same in all measurements".into());
        } else {
            assumptions.push("the friction is proportional to the normal force".into());
        }
        // Only parts of a log have a noise within the measurement.
        if measurements.iter().any(|m| m.sd > 0.0) {
            assumptions.push("the rows are samples in time, and a steady part is one measurement".into());
        }
        let fits_tip = measured_tip == 0;
        if fits_tip {
            assumptions.push(match stated {
                0 => "the tip velocity is the same in all measurements with vibration".into(),
                _ => "the tip velocity is proportional to the strength of the vibration".to_owned(),
            });
        }
        let fit = fit::fit(&measurements, fits_tip, known)?;
        if fit.variances.iter().zip(&measurements).all(|(_, m)| m.sd == 0.0) && fit.freedom[1].is_infinite() {
            checks::check_reduction(&measurements)?;
            return Err(ImportError::NoFit(format!(
                "{} measurements do not determine {} parameters and a scatter; repeat each condition",
                off + on,
                fit.model.count() + 1
            )));
        }
        let slice = &fit.slices[fit.chosen];
        let of = fit.model.parameters(&slice.fitted, slice.ln_compliance);
        checks::check_off(&measurements, &fit.model, &of)?;
        let mu = interval::interval(&fit, |of| libm::exp(of.ln_mu));
        let tip = fits_tip.then(|| interval::interval(&fit, |of| libm::exp(of.ln_tip)));
        let stiffness_s = interval::interval(&fit, |of| libm::exp(of.ln_compliance));
        let scatter = fit.freedom[1].is_finite().then_some(fit.scatter);
        let conditions = table::conditions(&measurements, &fit);
        let mut warnings = table::warnings(&conditions, &fit);
        let mixed = checks::mixed(&measurements, &fit.model, &of);
        let is_doubtful = mixed.is_some() || table::is_misfit(&conditions, &fit);
        warnings.extend(mixed);
        if scatter.is_none() {
            warnings.push(
                "there are too few measurements for a scatter: the intervals contain the noise within a measurement only".into(),
            );
        }
        if fit.model.has_trend {
            assumptions
                .push("the coefficient of friction at the rms of the slip velocity is that of OFF sliding at this speed".into());
        }
        let stiffness = fit.stiffness;
        Ok(Conditions {
            name,
            measurements,
            conditions,
            frequency_hz,
            level_unit,
            mu,
            tip,
            stiffness_s,
            stiffness,
            scatter,
            assumptions,
            remarks,
            warnings,
            is_doubtful,
            fit,
        })
    }

    /// Returns the tangential stiffness, N/m; `None` if the frequency or the normal force is
    /// unknown.
    pub fn stiffness_n_per_m(&self) -> Option<Interval> {
        let w = TAU * self.frequency_hz.filter(|_| self.measurements.iter().all(|m| m.normal_n.is_some()))?;
        let Interval { value, low, high } = self.stiffness_s;
        Some(Interval { value: w * value, low: w * low, high: w * high })
    }
}

/// Parses the content of a file to its columns.
pub(super) fn open(
    path: &Path,
    content: Result<Vec<u8>, ImportError>,
    options: &Options,
) -> Result<(PathBuf, Columns), ImportError> {
    let columns = content.and_then(|bytes| Columns::parse(&bytes, options.columns.as_deref()));
    Ok((path.to_owned(), columns.map_err(|error| error.of_file(path))?))
}
