//! Measurements of a file: mean friction at one condition, with or without vibration.
//!
//! A measurement is a row of a table of means, or a steady part of a log.

use std::collections::BTreeSet;
use std::path::Path;

use super::super::log::Options;
use super::super::quantity::{Columns, Quantity, file_name};
use super::super::smoothed::Smoothed;
use super::checks;
use super::named::Named;
use super::steady::{MIN_SAMPLES, Part, grouped, parts};
use crate::error::ImportError;
use crate::friction::certainty::sd_of_mean;
use columns::Unit;

/// Mean friction at one condition.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurement {
    /// `true` with vibration.
    pub on: bool,
    /// Sliding speed, m/s.
    pub speed_m_per_s: f64,
    /// Normal force, N; `None` if it is unknown.
    pub normal_n: Option<f64>,
    /// Strength of the vibration in the unit of its column; `None` if it is not stated.
    pub level: Option<f64>,
    /// Peak velocity of the vibration, m/s, if it was measured.
    pub tip_m_per_s: Option<f64>,
    /// Mean friction over mean normal force.
    pub mu: f64,
    /// Standard deviation of the mean from the noise within the measurement; 0 if it is unknown.
    pub sd: f64,
    /// Words of the text columns.
    pub label: String,
    /// Index of the file.
    pub file: usize,
}

/// Measurements of a file.
pub(super) struct Measured {
    pub(super) measurements: Vec<Measurement>,
    /// Unit of the strength of the vibration; empty if it has none.
    pub(super) level_unit: Option<String>,
    /// Frequency of the vibration, Hz.
    pub(super) frequency_hz: Option<f64>,
    /// Properties of the file, one sentence each.
    pub(super) remarks: Vec<String>,
    /// Notes about the file for the user, one sentence each.
    pub(super) notes: Vec<String>,
}

/// Rows of a file in SI units.
struct Rows {
    speed: Vec<f64>,
    normal: Option<Vec<f64>>,
    level: Option<Vec<f64>>,
    tip: Option<Vec<f64>>,
    labels: Vec<String>,
}

/// Largest difference of two frequencies of one measurement, relative.
const MAX_FREQUENCY_CHANGE_REL: f64 = 0.02;

/// Reads the measurements of a file.
pub(super) fn read(path: &Path, columns: &Columns, options: &Options) -> Result<Measured, ImportError> {
    let stem = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    let named = Named::parse(&stem)?;
    let count = columns.table.rows();
    let (units, mut remarks) = (&options.units, vec![format!("{}: a table with {}", file_name(path), columns.table.found)]);
    remarks.extend(named.in_words().map(|words| format!("{}: {words} from its name", file_name(path))));
    let column = |wanted: Quantity| columns.numbers(wanted, units);
    let of_name = |wanted: Quantity| Ok::<_, ImportError>(named.number(wanted, units)?.map(|value| vec![value; count]));
    let either = |wanted: Quantity| {
        Ok::<_, ImportError>(match column(wanted)? {
            None => of_name(wanted)?,
            values => values,
        })
    };
    let (time, displacement) = (column(Quantity::Time)?, column(Quantity::Displacement)?);
    let speed = match (column(Quantity::Velocity)?, &displacement, &time) {
        (None, Some(x), Some(time)) if time.windows(2).all(|pair| pair[0] < pair[1]) => {
            Some(Smoothed::new(time, x).velocity_m_per_s)
        }
        (None, ..) => of_name(Quantity::Velocity)?,
        (speed, ..) => speed,
    };
    let speed = speed.ok_or_else(|| columns.missing("no column and no file name has the sliding speed"))?;
    let states = match (columns.states()?, &time, named.on) {
        (Some(states), ..) => Some(states),
        (None, Some(time), None) if !options.on_s.is_empty() => {
            Some(time.iter().map(|t| options.on_s.iter().any(|(from, to)| (*from..*to).contains(t))).collect())
        }
        (None, _, on) => on.map(|on| vec![on; count]),
    };
    let (level, level_unit, tip_of_level) = level(columns, &named)?;
    // A measured strength is noisy.
    let is_sampled = time.is_some() || displacement.is_some();
    let quiet = |values: Option<Vec<f64>>| if is_sampled { values.map(|values| grouped(&values)) } else { values };
    let level = quiet(level);
    let normal = either(Quantity::Normal)?.or_else(|| options.normal_n.map(|normal| vec![normal; count]));
    let normal = normal.map(|values| values.iter().map(|normal| normal.abs()).collect::<Vec<_>>());
    if let Some(row) = normal.as_ref().and_then(|normal| normal.iter().position(|normal| *normal == 0.0)) {
        return Err(ImportError::bad_row(&columns.table, row, "the normal force is zero; delete the line".into()));
    }
    let frequency_hz = match either(Quantity::Frequency)? {
        Some(all) => {
            let of_on = all.iter().filter(|hz| **hz > 0.0);
            let (least, most) = of_on.fold((f64::INFINITY, 0.0_f64), |(least, most), hz| (least.min(*hz), most.max(*hz)));
            if most > least * (1.0 + MAX_FREQUENCY_CHANGE_REL) {
                return Err(ImportError::NoFit(format!(
                    "the frequency of the vibration goes from {least} to {most} Hz; fit each alone"
                )));
            }
            (most > 0.0).then_some(0.5 * (least + most))
        }
        None => None,
    };
    let tip = either(Quantity::Tip)?
        .or(tip_of_level)
        .map(|values| grouped(&values))
        .or_else(|| options.tip_m_per_s.map(|tip| vec![tip; count]));
    let rows = Rows { speed, normal, level, tip, labels: labels(columns, &mut remarks) };
    // A table with both states in each row.
    let both = [false, true].map(|on| friction(columns, Some(on), &rows, options));
    let [off, on] = both;
    let mut measurements = Vec::new();
    if let (Some(off), Some(on)) = (off?, on?) {
        for row in 0..count {
            measurements.extend([(false, off[row]), (true, on[row])].map(|(on, mu)| rows.single(row, on, mu)));
        }
    } else {
        let mu = friction(columns, None, &rows, options)?
            .ok_or_else(|| columns.missing("no column is the friction, as a force or as a coefficient `mu`"))?;
        let by_level =
            || rows.level.as_ref().or(rows.tip.as_ref()).map(|levels| levels.iter().map(|level| *level > 0.0).collect());
        let states: Vec<bool> = states.or_else(by_level).ok_or_else(|| {
            columns.missing("no column and no file name says ON or OFF; add a column `state`, name the file `…_on` or `…_off`, or give `--on`")
        })?;
        let found = parts(&rows.speed, rows.normal.as_deref(), |row| {
            let bits = |values: &Option<Vec<f64>>| values.as_ref().map_or(0, |values| values[row].to_bits());
            (states[row], bits(&rows.level), bits(&rows.tip), rows.labels[row].as_str())
        });
        let is_log = is_sampled || columns.place(Quantity::Velocity).is_none();
        match is_log {
            true if !found.iter().any(Part::is_long) => {
                let longest = found.iter().map(|part| part.rows.len()).max().unwrap_or(0);
                return Err(ImportError::NoFit(format!(
                    "the longest part with constant speed, load and vibration has {longest} samples, but a mean needs \
                     {MIN_SAMPLES}; give longer parts, or one row for each mean without a column of times"
                )));
            }
            true => {
                let used: usize = found.iter().filter(|part| part.is_long()).map(|part| part.rows.len()).sum();
                let steady: Vec<&Part> = found.iter().filter(|part| part.is_long()).collect();
                remarks.push(format!("{}: {} steady parts with {used} of {count} samples", file_name(path), steady.len()));
                let offset = offset(&rows, &mu, &states, steady.iter().flat_map(|part| part.rows.clone()));
                measurements.extend(steady.iter().map(|part| rows.mean(part, states[part.rows.start], &mu, offset)));
            }
            false => {
                // A friction coefficient may have no sign.
                let back = (0..count).filter(|row| rows.speed[*row] < 0.0 && !states[*row]).map(|row| mu[row]).sum::<f64>();
                let ahead = (0..count).filter(|row| rows.speed[*row] > 0.0 && !states[*row]).map(|row| mu[row]).sum::<f64>();
                let is_signed = back * ahead < 0.0;
                let offset = if is_signed { offset(&rows, &mu, &states, 0..count) } else { 0.0 };
                let sign = |row: usize| if is_signed { rows.speed[row].signum() } else { 1.0 };
                measurements.extend((0..count).map(|row| rows.single(row, states[row], sign(row) * (mu[row] - offset))));
            }
        }
    }
    let notes = checks::unknown_columns(columns)?;
    Ok(Measured { measurements, level_unit, frequency_hz, remarks, notes })
}

/// Returns the friction of each row over the normal force; `on` selects a column for one state.
fn friction(columns: &Columns, on: Option<bool>, rows: &Rows, options: &Options) -> Result<Option<Vec<f64>>, ImportError> {
    if let Some(mu) = columns.numbers(Quantity::Mu(on), &options.units)? {
        return Ok(Some(mu));
    }
    let Some(force) = columns.numbers(Quantity::Force(on), &options.units)? else { return Ok(None) };
    let Some(normal) = &rows.normal else {
        let help = "give it with `--normal-n`, or as a column `N [N]`".to_owned();
        return Err(ImportError::UnitMissing { column: "the normal force".into(), help });
    };
    Ok(Some(force.iter().zip(normal).map(|(force, normal)| force / normal).collect()))
}

/// Strength of the vibration in each row, its unit, and the strength as a velocity.
type Levels = (Option<Vec<f64>>, Option<String>, Option<Vec<f64>>);

/// Returns the strength of the vibration in each row.
fn level(columns: &Columns, named: &Named) -> Result<Levels, ImportError> {
    let (values, unit, text) = match (columns.place(Quantity::Level), named.level()?) {
        (Some(at), _) => {
            let values = crate::units::numbers(&columns.table, at)?;
            (values, columns.heading(at).unit.unwrap_or("").to_owned(), columns.names[at].clone())
        }
        (None, Some((value, unit))) => (vec![value; columns.table.rows()], unit.to_owned(), "name of the file".to_owned()),
        (None, None) => return Ok((None, None, None)),
    };
    if unit.is_empty() {
        return Ok((Some(values), Some(String::new()), None));
    }
    let parsed = Unit::parse(&unit).filter(|unit| !unit.is_ambiguous());
    let si = ["m", "m/s", "V", "A"].into_iter().find_map(|base| Some((base, parsed.as_ref()?.factor_to(&Unit::parse(base)?)?)));
    let si = si.or_else(|| (unit == "%").then_some(("%", 1.0)));
    let Some((base, factor)) = si else {
        let help = "m, m/s, V, A or % is needed, also with a prefix".to_owned();
        return Err(ImportError::UnitUnknown { column: text, unit, help });
    };
    let values: Vec<f64> = values.iter().map(|value| factor * value).collect();
    Ok(if base == "m/s" { (None, None, Some(values)) } else { (Some(values), Some(base.to_owned()), None) })
}

/// Returns the words of the text columns of each row.
fn labels(columns: &Columns, remarks: &mut Vec<String>) -> Vec<String> {
    let rows = columns.table.rows();
    let mut labels = vec![String::new(); rows];
    for (at, column) in columns.table.columns.iter().enumerate() {
        let is_label = Quantity::parse(columns.heading(at).name).is_none()
            && 2 * column.words.len() > rows
            && !column.words.iter().all(|(_, word)| super::super::quantity::state(word).is_some());
        let distinct = column.words.iter().map(|(_, word)| word).collect::<BTreeSet<_>>().len();
        if !is_label || distinct < 2 {
            continue;
        }
        if 2 * distinct > rows {
            remarks.push(format!("The column `{}` is different in most rows and is not a condition", columns.names[at]));
            continue;
        }
        for (row, word) in &column.words {
            let label = &mut labels[*row];
            if !label.is_empty() {
                label.push_str(", ");
            }
            label.push_str(word);
        }
    }
    labels
}

/// Returns the middle between the mean frictions of both directions without vibration; zero if it
/// slides in one direction.
fn offset(rows: &Rows, mu: &[f64], states: &[bool], part: impl Iterator<Item = usize>) -> f64 {
    let part: Vec<usize> = part.filter(|row| !states[*row]).collect();
    let mean = |forward: bool| {
        let values: Vec<f64> = part.iter().filter(|row| (rows.speed[**row] > 0.0) == forward).map(|row| mu[*row]).collect();
        (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
    };
    mean(true).zip(mean(false)).map_or(0.0, |(forward, back)| 0.5 * (forward + back))
}

impl Rows {
    /// Returns the measurement of one row of a table of means.
    fn single(&self, row: usize, on: bool, mu: f64) -> Measurement {
        let at = |values: &Option<Vec<f64>>| values.as_ref().map(|values| values[row]);
        Measurement {
            on,
            speed_m_per_s: self.speed[row].abs(),
            normal_n: at(&self.normal),
            level: at(&self.level).filter(|_| on),
            tip_m_per_s: at(&self.tip).filter(|_| on),
            mu,
            sd: 0.0,
            label: self.labels[row].clone(),
            file: 0,
        }
    }

    /// Returns the measurement of a steady part of a log.
    fn mean(&self, part: &Part, on: bool, mu: &[f64], offset: f64) -> Measurement {
        let rows = part.settled();
        let mean = |values: &[f64]| values[rows.clone()].iter().sum::<f64>() / rows.len() as f64;
        let speed = mean(&self.speed);
        // Mean force over mean normal force.
        let normal = |row: usize| self.normal.as_ref().map_or(1.0, |normal| normal[row]);
        let mean_normal = self.normal.as_ref().map_or(1.0, |normal| mean(normal));
        let forces: Vec<f64> = rows.clone().map(|row| (mu[row] - offset) * normal(row) / mean_normal * speed.signum()).collect();
        let value = forces.iter().sum::<f64>() / forces.len() as f64;
        let places: Vec<usize> = (0..forces.len()).collect();
        let sd = sd_of_mean(forces.iter().map(|force| value - force).collect(), &places).unwrap_or(0.0);
        let mut one = self.single(rows.start, on, value);
        (one.speed_m_per_s, one.mu, one.sd) = (speed.abs(), value, sd);
        one.normal_n = self.normal.as_ref().map(|_| mean_normal);
        one
    }
}
