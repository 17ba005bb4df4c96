//! Verification of the prediction: many runs of the whole controller, from its self-test on, on the
//! plant of the scenes. Each run draws the errors of the nominal values as the prediction does, and
//! C0 within 5 % before its calibration.

use serde::Serialize;

use super::case::{Case, NOMINAL_ERROR};
use super::prediction::BOUNDS_HZ;
use crate::metrics::Metrics;
use crate::study::{self, Options, StudyError};
use scene::Vary;
use scene::load::{LoadError, load_text};
use scene::resolved::resolved_toml;

/// Largest error of the nominal C0, relative.
const NOMINAL_C0_ERROR: f64 = 0.05;
/// Duration of self-test, calibration and lock, s.
const BASE_DURATION_S: f64 = 0.3;
/// Number of time constants of the resonance that follow.
const TIME_CONSTANTS: f64 = 4.0;
/// Metrics of the lock times: median and 95th percentile.
const LOCK_TIMES: [(&str, &str); 3] = [
    ("lock_time_100hz_ms", "lock_time_100hz_ms_p95"),
    ("lock_time_20hz_ms", "lock_time_20hz_ms_p95"),
    ("lock_time_4hz_ms", "lock_time_4hz_ms_p95"),
];

/// Results of the verification.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verified {
    /// Number of runs of the verification.
    pub runs: u32,
    /// Number of runs that locked.
    pub locked: f64,
    /// Number of runs that ended in a fault.
    pub faulted: f64,
    /// Number of runs that reported a lock away from the resonance.
    pub false_locks: f64,
    /// Lock times to within several bounds.
    pub lock: Vec<MeasuredLockTime>,
    /// Median of the standard deviation of the drive frequency, Hz.
    pub jitter_hz: Option<f64>,
    /// 95th percentile of the absolute error of the lock point, Hz.
    pub bias_p95_hz: Option<f64>,
}

/// Measured lock time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MeasuredLockTime {
    /// Bound of the frequency error, Hz.
    pub within_hz: f64,
    /// Median of the lock times, ms.
    pub median_ms: Option<f64>,
    /// 95th percentile of the lock times, ms.
    pub p95_ms: Option<f64>,
}

/// Reason that there is no verification.
#[derive(Debug, thiserror::Error)]
pub enum VerifyError {
    /// The advised scene is not valid.
    #[error(transparent)]
    Scene(#[from] LoadError),
    /// The runs have no result.
    #[error(transparent)]
    Study(#[from] StudyError),
}

/// Runs the advised settings `runs` times; `progress` receives the number of completed runs.
pub fn verify(case: &Case, runs: u32, progress: &mut (dyn FnMut(f64) + Send)) -> Result<Verified, VerifyError> {
    let mut scene = case.scene().clone();
    let time_constant_s = case.parts().map_or(0.0, |parts| parts.circuit.time_constant_s());
    (scene.runs, scene.duration_s) = (runs, BASE_DURATION_S + TIME_CONSTANTS * time_constant_s);
    let vary = |key: &str, spread: Option<f64>, factor: Option<f64>| Vary { key: key.into(), spread, factor, ..Vary::default() };
    scene.vary = vec![
        vary("stack.bvd.series_resonance_hz", Some(NOMINAL_ERROR.resonance), None),
        vary("controller.tracking.nominal_q", None, Some(NOMINAL_ERROR.q)),
        vary("controller.tracking.nominal_lm_h", Some(NOMINAL_ERROR.lm), None),
        vary("controller.tracking.nominal_c0_f", Some(NOMINAL_C0_ERROR), None),
    ];
    let loaded = load_text("the advised scene", &resolved_toml(&scene), &[])?;
    let study = study::run(&loaded, Options { progress: Some(progress), ..Options::default() })?;
    Ok(Verified::from_metrics(runs, &study.metrics))
}

impl Verified {
    fn from_metrics(runs: u32, metrics: &Metrics) -> Self {
        let count = |name: &str| metrics.get(name).unwrap_or(0.0);
        let lock = BOUNDS_HZ.into_iter().zip(LOCK_TIMES);
        let lock = lock.map(|(within_hz, (median, p95))| MeasuredLockTime {
            within_hz,
            median_ms: metrics.get(median),
            p95_ms: metrics.get(p95),
        });
        Verified {
            runs,
            locked: count("runs_locked"),
            faulted: count("runs_faulted"),
            false_locks: count("false_locks"),
            lock: lock.collect(),
            jitter_hz: metrics.get("frequency_jitter_hz"),
            bias_p95_hz: metrics.get("frequency_bias_hz_p95"),
        }
    }
}
