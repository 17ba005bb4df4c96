//! Advice, comparisons, spectra and suites, as the commands of the same names.

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

use import::signal::spectrogram::{Asked, Method, Spectrogram};
use import::signal::{Choice, Signal};
use pyo3::exceptions::{PyKeyboardInterrupt, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use scene::load::LoadError;
use scene::suite;
use sim::advice::case::{Case, Wishes};
use sim::advice::{self, AdviceError};
use sim::compare::{Comparison, Side, Tolerances};
use sim::evidence::{SuiteError, run_suite};
use sim::study::StudyError;

use crate::errors::{MeasurementError, SceneError, run_error, scene_error, with_causes};
use crate::interruptible;
use crate::result::bytes_of;
use crate::scene::Scene;

fn advice_error(error: impl Into<AdviceError>) -> PyErr {
    SceneError::new_err(with_causes(&error.into()))
}

/// Returns settings for the transducer of a scene, as JSON: as `sim-host advise`.
#[pyfunction]
pub fn advise(scene: &Scene, volts: Option<f64>, noise_lsb: Option<f64>, block_samples: Option<u16>) -> PyResult<String> {
    let wishes = Wishes { volts, noise_lsb, block_samples };
    let case = Case::of(scene.loaded(), None, &wishes).map_err(advice_error)?;
    let (advice, _) = advice::advise(&case).map_err(advice_error)?;
    serde_json::to_string(&advice).map_err(|error| run_error(&error))
}

/// Returns the demand on the amplifier for a tip velocity, m/s, as JSON: as `sim-host advise
/// --amplifier`.
#[pyfunction]
pub fn advise_amplifier(scene: &Scene, volts: Option<f64>, tip_m_per_s: Option<f64>, tip_m: Option<f64>) -> PyResult<String> {
    let loaded = scene.loaded();
    let wishes = Wishes { volts, noise_lsb: None, block_samples: None };
    let case = Case::of(loaded, None, &wishes).map_err(advice_error)?;
    let is_assumed = loaded.assumed.iter().any(|assumed| assumed.key == "stack.bvd.force_factor_n_per_v");
    let omega = case.parts().map_or(f64::NAN, |parts| parts.circuit.omega());
    let tip_m_per_s = tip_m_per_s.or(tip_m.map(|tip_m| omega * tip_m));
    let advice = advice::advise_amplifier(&case, tip_m_per_s, is_assumed).map_err(advice_error)?;
    serde_json::to_string(&advice).map_err(|error| run_error(&error))
}

/// Compares two folders of results, or a folder with measured metrics, as JSON: as `sim-host
/// compare`. Also returns `true` if every value is within its tolerance.
#[pyfunction]
pub fn compare(a: PathBuf, b: PathBuf, tolerances: Vec<String>, metrics: Vec<String>) -> PyResult<(String, bool)> {
    let compared = Tolerances::parse(&tolerances)
        .and_then(|tolerances| Comparison::new(Side::read(&a)?, Side::read(&b)?, &tolerances, &metrics))
        .map_err(|error| run_error(&error))?;
    Ok((compared.json().to_string(), compared.holds()))
}

/// Returns the spectrogram of a column of a file: its description as JSON, the power, the times, s,
/// and the frequencies, Hz, as bytes of 64-bit floating-point numbers: as `sim-host spectrum`.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "keyword arguments of the Python part")]
pub fn spectrum<'py>(
    py: Python<'py>,
    path: PathBuf,
    method: &str,
    signal: (Option<String>, Option<String>, Option<f64>),
    part_s: (Option<f64>, Option<f64>),
    band_hz: Option<(f64, f64)>,
    window_s: Option<f64>,
    cycles: Option<f64>,
    smooth_s: Option<f64>,
) -> PyResult<(String, [Bound<'py, PyBytes>; 3])> {
    let method = match method {
        "stft" => Method::Stft,
        "wavelet" => Method::Wavelet,
        "wigner-ville" => Method::WignerVille,
        other => return Err(PyValueError::new_err(format!("there is no method `{other}`: stft, wavelet, wigner-ville"))),
    };
    let ((column, time, sample_hz), (from_s, to_s)) = (signal, part_s);
    let choice = Choice { column, time, sample_hz, from_s, to_s };
    let asked = Asked { method, window_s, cycles, smooth_s, band_hz };
    let source = path.display().to_string();
    let found = interruptible::run_detached(py, move || Spectrogram::new(Signal::read(&path, &choice)?, &asked))?;
    let found = found.map_err(|error| MeasurementError::new_err(with_causes(&error)))?;
    let power: Vec<f64> = found.power.iter().flatten().copied().collect();
    let text = found.json(&source).to_string();
    Ok((text, [bytes_of(py, &power)?, bytes_of(py, &found.times_s)?, bytes_of(py, &found.hz)?]))
}

/// Runs a suite of cases with targets, and returns its evidence as JSON with the missed targets: as
/// `sim-host validate`.
#[pyfunction]
pub fn validate(py: Python<'_>, path: &str, quick: bool) -> PyResult<(String, Vec<String>)> {
    let loaded = suite::load(path, quick).map_err(|error: LoadError| scene_error(&error))?;
    let stop = AtomicBool::new(false);
    interruptible::run(py, &stop, || {
        let evidence = run_suite(&loaded, Some(&stop), &mut |_: &str| (), |_, _| Ok::<(), SuiteError>(()));
        let evidence = evidence.map_err(|error| match error {
            SuiteError::Study(StudyError::Interrupted) => PyKeyboardInterrupt::new_err("the suite was stopped"),
            error => run_error(&error),
        })?;
        Ok((evidence.json().to_string(), evidence.missed))
    })?
}
