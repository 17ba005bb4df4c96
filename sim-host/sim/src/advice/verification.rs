//! The prediction put to the test: the whole controller, from its self-test on, on the plant of the scenes, many times. The errors
//! of the nominal values are drawn again each time, as for the prediction, and C0 within 5 % before its calibration.

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
/// Self-test, calibration and lock take less, s; and so many time constants of the resonance follow.
const DURATION: (f64, f64) = (0.3, 4.0);
/// Lock times, as metrics.
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
    pub lock: Vec<Measured>,
    /// Standard deviation of the frequency played, Hz: median.
    pub jitter_hz: Option<f64>,
    /// Lock point, Hz: the 95th percentile of its size.
    pub bias_p95_hz: Option<f64>,
}

/// A lock time, measured.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Measured {
    /// Bound to which the time is counted, Hz.
    pub within_hz: f64,
    /// Median of the lock times, ms.
    pub median_ms: Option<f64>,
    /// 95th percentile of the lock times, ms.
    pub p95_ms: Option<f64>,
}

/// Why there is no verification.
#[derive(Debug, thiserror::Error)]
pub enum VerifyError {
    /// The scene is none.
    #[error(transparent)]
    Scene(#[from] LoadError),
    /// The runs have no result.
    #[error(transparent)]
    Study(#[from] StudyError),
}

/// Runs the advised settings so many times; `progress` receives the number of runs that have ended.
pub fn verify(case: &Case, runs: u32, progress: &mut (dyn FnMut(f64) + Send)) -> Result<Verified, VerifyError> {
    let mut scene = case.scene().clone();
    let time_constant_s = case.parts().map_or(0.0, |parts| parts.circuit.time_constant_s());
    (scene.runs, scene.duration_s) = (runs, DURATION.0 + DURATION.1 * time_constant_s);
    let vary =
        |key: &str, spread: Option<f64>, factor: Option<f64>| Vary { key: key.into(), spread, factor, from: None, to: None };
    scene.vary = vec![
        vary("stack.bvd.series_resonance_hz", Some(NOMINAL_ERROR.resonance), None),
        vary("controller.tracking.nominal_q", None, Some(NOMINAL_ERROR.q)),
        vary("controller.tracking.nominal_lm_h", Some(NOMINAL_ERROR.lm), None),
        vary("controller.tracking.nominal_c0_f", Some(NOMINAL_C0_ERROR), None),
    ];
    let loaded = load_text("the advised scene", &resolved_toml(&scene), &[])?;
    let study = study::run(&loaded, Options { progress: Some(progress), ..Options::default() })?;
    Ok(Verified::of(runs, &study.metrics))
}

impl Verified {
    fn of(runs: u32, metrics: &Metrics) -> Self {
        let count = |name: &str| metrics.get(name).unwrap_or(0.0);
        let lock = BOUNDS_HZ.into_iter().zip(LOCK_TIMES);
        let lock = lock.map(|(within_hz, (median, p95))| Measured {
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
