//! Checks of measurements before and after their fit.

use std::collections::BTreeMap;

use super::super::quantity::{Columns, Quantity};
use super::measurement::Measurement;
use super::model::{Model, Parameters};
use crate::error::ImportError;
use columns::{Heading, beginning};
use report::significant;
use report::statistics::mean;

/// Difference of two coefficients of friction that counts, standard deviations.
const SIGMAS: f64 = 4.0;
/// Smallest relative difference of two coefficients of friction that counts.
const MIN_DIFFERENCE_REL: f64 = 0.03;
/// Smallest ratio of friction ON to OFF without a reduction.
const NO_REDUCTION: f64 = 0.97;

/// Refuses a tip velocity that is the same at different strengths of the vibration.
pub(super) fn check_tips(measurements: &[Measurement]) -> Result<(), ImportError> {
    let on = || measurements.iter().filter(|m| m.on);
    let range = |of: fn(&Measurement) -> Option<f64>| {
        on().filter_map(of).fold((f64::INFINITY, 0.0_f64), |(low, high), value| (low.min(value), high.max(value)))
    };
    let (tips, levels) = (range(|m| m.tip_m_per_s), range(|m| m.level));
    if tips.0 == tips.1 && levels.1 > 1.05 * levels.0 {
        return Err(ImportError::NoFit(format!(
            "one tip velocity of {} m/s is given for strengths of the vibration from {} to {}; leave it out, or give a column \
             `tip velocity [m/s]`",
            significant(tips.0),
            significant(levels.0),
            significant(levels.1)
        )));
    }
    Ok(())
}

/// Refuses a column that may be the strength of the vibration, but has an unknown name. Returns a
/// note for each other unknown column that varies.
pub(super) fn unknown_columns(columns: &Columns) -> Result<Vec<String>, ImportError> {
    const BEGINS: [&str; 7] = ["ampl", "peak", "vibr", "volt", "curr", "power", "drive"];
    const WORDS: [&str; 4] = ["pp", "p2p", "pkpk", "rms"];
    let mut notes = Vec::new();
    for (name, column) in columns.names.iter().zip(&columns.table.columns) {
        let heading = Heading::new(name, |name| Quantity::parse(name).is_some());
        let varies = column.values.iter().any(|value| !value.is_nan() && *value != column.values[0]);
        if !varies || Quantity::parse(heading.name).is_some() {
            continue;
        }
        let lower = name.to_lowercase().replace("p-p", "pp");
        let mut words = lower.split(|c: char| !c.is_alphanumeric());
        if words.any(|word| WORDS.contains(&word) || BEGINS.iter().any(|begin| word.starts_with(begin))) {
            return Err(columns.missing(&format!(
                "`{name}` may be the strength of the vibration, but is not known. Amplitudes are peak values; convert \
                 peak-to-peak or rms, and name the column `amplitude`, `voltage`, `current` or `level`, or `-` to leave it out"
            )));
        }
        if heading.name != "-" {
            notes.push(format!("the column `{}` is not known and is left out", beginning(name)));
        }
    }
    Ok(notes)
}

/// Returns the logarithms of the coefficient of friction OFF at the middle speed, by the trend over
/// the speed.
fn off_logs<'a>(measurements: impl Iterator<Item = &'a Measurement>, model: &Model, of: &Parameters) -> Vec<f64> {
    let middle = (model.off_speeds.0 * model.off_speeds.1).sqrt();
    let log = |m: &Measurement| libm::log(m.mu) - of.trend * libm::log(m.speed_m_per_s / middle);
    measurements.filter(|m| !m.on && m.mu > 0.0).map(log).collect()
}

/// Returns the mean, and the standard deviation of a single value.
fn spread(values: &[f64]) -> (f64, f64) {
    let mean = mean(values.iter().copied()).unwrap_or(f64::NAN);
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (mean, (squares / (values.len() as f64 - 1.0).max(1.0)).sqrt())
}

/// Refuses a vibration that does not lower the friction.
pub(super) fn check_reduction(measurements: &[Measurement]) -> Result<(), ImportError> {
    let of = |on: bool| mean(measurements.iter().filter(|m| m.on == on).map(|m| m.mu)).unwrap_or(f64::NAN);
    let ratio = of(true) / of(false);
    if ratio >= NO_REDUCTION {
        let why = format!("the vibration does not lower the friction: the mean ratio of ON to OFF is {}", significant(ratio));
        return Err(ImportError::NoFit(why));
    }
    Ok(())
}

/// Refuses a fit whose coefficient of friction is not that of the measurements OFF: the ones ON
/// contradict them.
pub(super) fn check_off(measurements: &[Measurement], model: &Model, of: &Parameters) -> Result<(), ImportError> {
    let off = off_logs(measurements.iter(), model, of);
    let (alone, sd) = spread(&off);
    let allowed = MIN_DIFFERENCE_REL + SIGMAS * sd / (off.len() as f64).sqrt();
    if off.len() < 3 || (of.ln_mu - alone).abs() <= allowed {
        return Ok(());
    }
    Err(ImportError::NoFit(format!(
        "the measurements ON and OFF contradict each other: mu is {} for all, but {} OFF alone; check the units of amplitude and \
         frequency, the states, and that the vibration is along the sliding",
        significant(libm::exp(of.ln_mu)),
        significant(libm::exp(alone))
    )))
}

/// Returns a warning if the friction OFF differs between files or labels.
pub(super) fn mixed(measurements: &[Measurement], model: &Model, of: &Parameters) -> Option<String> {
    let mut groups: BTreeMap<(&str, usize), Vec<&Measurement>> = BTreeMap::new();
    measurements.iter().for_each(|m| groups.entry((m.label.as_str(), m.file)).or_default().push(m));
    let means: Vec<_> = groups
        .iter()
        .map(|(key, group)| (key, off_logs(group.iter().copied(), model, of)))
        .filter(|(_, logs)| logs.len() >= 2)
        .map(|(key, logs)| (key, spread(&logs), logs.len() as f64))
        .collect();
    let low = means.iter().min_by(|a, b| a.1.0.total_cmp(&b.1.0))?;
    let high = means.iter().max_by(|a, b| a.1.0.total_cmp(&b.1.0))?;
    let sd = (low.1.1.powi(2) / low.2 + high.1.1.powi(2) / high.2).sqrt();
    let name = |(label, file): &(&str, usize)| if label.is_empty() { format!("file {}", file + 1) } else { format!("`{label}`") };
    (high.1.0 - low.1.0 > MIN_DIFFERENCE_REL + SIGMAS * sd).then(|| {
        format!(
            "the friction OFF differs between {} and {}: mu is {} and {}; fit each alone",
            name(low.0),
            name(high.0),
            significant(libm::exp(low.1.0)),
            significant(libm::exp(high.1.0))
        )
    })
}
