//! Measured data: an admittance as a circuit, a friction log as a contact.

use std::path::{Path, PathBuf};

use ::import::admittance::coordinate::Topology;
use ::import::admittance::options::Options;
use ::import::admittance::{self, MOST_MODES};
use ::import::error::ImportError;
use ::import::friction::conditions::Request;
use ::import::friction::{self, Found};
use ::import::units::Units;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::errors::import_error;
use crate::interruptible;

/// A result: JSON, its scene as TOML, and arrays by name, as 64-bit floating-point numbers in bytes
/// in the machine's order.
type Parts<'py> = (String, Option<String>, Vec<(&'static str, Bound<'py, PyBytes>)>);

fn bytes<'py>(py: Python<'py>, numbers: impl Iterator<Item = f64>) -> Bound<'py, PyBytes> {
    PyBytes::new(py, &numbers.flat_map(f64::to_ne_bytes).collect::<Vec<u8>>())
}

/// Returns the name of a file, as it is given as the source in results.
fn source(path: &Path) -> String {
    path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

fn topology(name: Option<&str>) -> PyResult<Option<Topology>> {
    Ok(Some(match name {
        None => return Ok(None),
        Some("one-port") => Topology::OnePort,
        Some("series-through") => Topology::SeriesThrough,
        Some("shunt-through") => Topology::ShuntThrough,
        Some(other) => {
            let message = format!("topology: `{other}` is unknown; known are one-port, series-through, shunt-through");
            return Err(PyValueError::new_err(message));
        }
    }))
}

/// Fits the circuit of a measured admittance.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "same as on the command line")]
pub fn import_admittance<'py>(
    py: Python<'py>,
    path: PathBuf,
    columns: Option<String>,
    units: Vec<String>,
    z0_ohm: f64,
    topology: Option<&str>,
    open: Option<PathBuf>,
    short: Option<PathBuf>,
    series_ohm: f64,
    modes: Option<usize>,
    mode: Option<f64>,
    force: bool,
) -> PyResult<Parts<'py>> {
    let units =
        Units::parse(units.iter().map(String::as_str)).map_err(|error| PyValueError::new_err(format!("unit: {error}")))?;
    if modes.is_some_and(|modes| !(1..=MOST_MODES).contains(&modes)) {
        return Err(PyValueError::new_err(format!("modes: from 1 to {MOST_MODES}")));
    }
    let sound = |ohm: f64, least: f64| (least..=1e6).contains(&ohm);
    if !sound(z0_ohm, 1e-3) || !sound(series_ohm, 0.0) {
        return Err(PyValueError::new_err("z0_ohm: from 0.001 to 1e6 ohm; series_ohm: from 0 to 1e6 ohm"));
    }
    let topology = self::topology(topology)?;
    let mode = mode.map(|mode| mode.to_string().parse()).transpose();
    let mode = mode.map_err(|why: String| PyValueError::new_err(format!("mode: {why}")))?;
    let options = Options { z0_ohm: Some(z0_ohm), topology, units, columns, open, short, series_ohm, modes, mode };
    let file = path.clone();
    let found = interruptible::run_detached(py, move || admittance::import(&file, &options))?;
    let found = found.map_err(|error| import_error(&path, &error))?;
    let measured = &found.measured;
    let fitted = || measured.hz.iter().map(|hz| found.equivalent.admittance(*hz));
    let arrays = vec![
        ("frequency_hz", bytes(py, measured.hz.iter().copied())),
        ("measured_re_s", bytes(py, measured.admittance.iter().map(|y| y.re))),
        ("measured_im_s", bytes(py, measured.admittance.iter().map(|y| y.im))),
        ("fitted_re_s", bytes(py, fitted().map(|y| y.re))),
        ("fitted_im_s", bytes(py, fitted().map(|y| y.im))),
        ("residual_re", bytes(py, found.residuals.iter().map(|residual| residual.re))),
        ("residual_im", bytes(py, found.residuals.iter().map(|residual| residual.im))),
    ];
    let scene = found.scene(&source(&path)).filter(|_| force || !found.is_doubtful());
    Ok((found.json(None).to_string(), scene, arrays))
}

/// Checks options of a friction measurement.
fn friction_options(
    columns: Option<String>,
    normal_n: Option<f64>,
    on_s: Vec<(f64, f64)>,
    frequency_hz: Option<f64>,
    tip_m_per_s: Option<f64>,
) -> PyResult<friction::Options> {
    if normal_n.is_some_and(|normal_n| !(1e-9..=1e6).contains(&normal_n)) {
        return Err(PyValueError::new_err("normal_n: from 1e-9 to 1e6 N"));
    }
    if on_s.iter().any(|(from, to)| from.partial_cmp(to).is_none_or(|order| order.is_ge())) {
        return Err(PyValueError::new_err("on_s: pairs of ascending times in s"));
    }
    Ok(friction::Options { columns, normal_n, on_s, frequency_hz, tip_m_per_s, ..friction::Options::default() })
}

/// Fits friction with and without vibration at the conditions of one or several files, and predicts
/// it at others.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "same as on the command line")]
pub fn import_conditions<'py>(
    py: Python<'py>,
    paths: Vec<PathBuf>,
    columns: Option<String>,
    units: Vec<String>,
    normal_n: Option<f64>,
    on_s: Vec<(f64, f64)>,
    frequency_hz: Option<f64>,
    tip_m_per_s: Option<f64>,
    predict: Vec<String>,
) -> PyResult<Parts<'py>> {
    let refuse = |option: &str, why: String| PyValueError::new_err(format!("{option}: {why}"));
    let units = Units::parse_friction(units.iter().map(String::as_str)).map_err(|why| refuse("unit", why))?;
    let requests = predict.iter().map(|request| request.parse::<Request>());
    let requests = requests.collect::<Result<Vec<_>, _>>().map_err(|why| refuse("predict", why.to_string()))?;
    let options = friction_options(columns, normal_n, on_s, frequency_hz, tip_m_per_s)?;
    let options = friction::Options { units, ..options };
    let first = paths.first().cloned().ok_or_else(|| refuse("paths", "at least one file is needed".to_owned()))?;
    let source = if paths.len() == 1 { source(&first) } else { format!("{} files", paths.len()) };
    let fit = move || match friction::import_files(&paths, &options)? {
        Found::Conditions(conditions, _) => {
            let predictions = requests.iter().map(|request| conditions.predict(request)).collect::<Result<Vec<_>, _>>()?;
            Ok((conditions, predictions))
        }
        Found::Log(_) => Err(ImportError::NoFit("no measurement has the vibration ON; import_friction fits such a log".into())),
    };
    let found = interruptible::run_detached(py, fit)?;
    let (conditions, predictions) = found.map_err(|error| import_error(&first, &error))?;
    let scene = conditions.scene(&source, &predictions).ok().filter(|_| !conditions.is_doubtful);
    Ok((conditions.json(&predictions).to_string(), scene, Vec::new()))
}

/// Fits the contact of a friction log, and its conditions if it has parts with vibration.
#[pyfunction]
pub fn import_friction<'py>(
    py: Python<'py>,
    path: PathBuf,
    columns: Option<String>,
    normal_n: Option<f64>,
    on_s: Vec<(f64, f64)>,
    frequency_hz: Option<f64>,
    tip_m_per_s: Option<f64>,
) -> PyResult<Parts<'py>> {
    let options = friction_options(columns, normal_n, on_s, frequency_hz, tip_m_per_s)?;
    let (file, given) = (path.clone(), options.clone());
    let found = interruptible::run_detached(py, move || friction::import_files(&[file], &given))?;
    let (found, conditions) = match found.map_err(|error| import_error(&path, &error))? {
        Found::Log(contact) => (contact, None),
        Found::Conditions(conditions, Some(contact)) => (contact, Some(conditions)),
        Found::Conditions(_, None) => {
            let why = "not a log with samples OFF; `sim-host import friction` fits tables of means".to_owned();
            return Err(import_error(&path, &ImportError::NoFit(why)));
        }
    };
    let mut json = found.json(None);
    let mut scene = found.scene(&source(&path), &options).ok();
    if let Some(conditions) = &conditions {
        json["on"] = conditions.json(&[]);
        scene = conditions.scene(&source(&path), &[]).ok().filter(|_| !conditions.is_doubtful);
    }
    let (log, fitted) = (&found.log, &found.chosen().force_n);
    let arrays = vec![
        ("time_s", bytes(py, log.time_s.iter().copied())),
        ("velocity_m_per_s", bytes(py, log.velocity_m_per_s.iter().copied())),
        ("measured_n", bytes(py, log.force_n.iter().copied())),
        ("fitted_n", bytes(py, fitted.iter().copied())),
        ("on", bytes(py, log.on.iter().map(|on| f64::from(u8::from(*on))))),
    ];
    Ok((json.to_string(), scene, arrays))
}
