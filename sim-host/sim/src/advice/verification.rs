//! The prediction put to the test: the whole controller, from its self-test on, on the plant of the scenes, many times. What may be told
//! wrong is drawn anew each time, as for the prediction, and C0 within 5 % before its calibration.

use std::sync::atomic::AtomicBool;

use serde::Serialize;

use super::case::{Case, TOLD};
use super::prediction::BOUNDS_HZ;
use crate::metrics::Metrics;
use crate::study::{self, StudyError};
use scene::Vary;
use scene::load::{LoadError, load_text};
use scene::resolved::resolved_toml;

/// C0 as told is off by this part at most.
const TOLD_C0: f64 = 0.05;
/// Self-test, calibration and lock take less, s; and so many time constants of the resonance follow.
const DURATION: (f64, f64) = (0.3, 4.0);
/// Lock times, as metrics.
const LOCK_TIMES: [(&str, &str); 3] = [
    ("lock_time_100hz_ms", "lock_time_100hz_ms_p95"),
    ("lock_time_20hz_ms", "lock_time_20hz_ms_p95"),
    ("lock_time_4hz_ms", "lock_time_4hz_ms_p95"),
];

/// What came of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verified {
    /// Runs, and how many of them locked.
    pub runs: u32,
    /// That came to a lock.
    pub locked: f64,
    /// That ended in a fault.
    pub faulted: f64,
    /// That called themselves locked and were not.
    pub false_locks: f64,
    /// Times to lock.
    pub lock: Vec<Measured>,
    /// Standard deviation of the frequency played, Hz: median.
    pub jitter_hz: Option<f64>,
    /// Lock point, Hz: the 95th percentile of its size.
    pub bias_p95_hz: Option<f64>,
}

/// A lock time, measured.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Measured {
    /// To within so much, Hz.
    pub within_hz: f64,
    /// Median, ms.
    pub median_ms: Option<f64>,
    /// 95th percentile, ms.
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

/// Runs the advised settings so many times; `progress` is told how many have come to their end.
pub fn verify(case: &Case, runs: u32, progress: &mut (dyn FnMut(f64) + Send)) -> Result<Verified, VerifyError> {
    let mut scene = case.scene().clone();
    let time_constant_s = case.parts().map_or(0.0, |parts| parts.circuit.time_constant_s());
    (scene.runs, scene.duration_s) = (runs, DURATION.0 + DURATION.1 * time_constant_s);
    let vary =
        |key: &str, spread: Option<f64>, factor: Option<f64>| Vary { key: key.into(), spread, factor, from: None, to: None };
    scene.vary = vec![
        vary("stack.bvd.series_resonance_hz", Some(TOLD.resonance), None),
        vary("controller.tracking.nominal_q", None, Some(TOLD.q)),
        vary("controller.tracking.nominal_lm_h", Some(TOLD.lm), None),
        vary("controller.tracking.nominal_c0_f", Some(TOLD_C0), None),
    ];
    let loaded = load_text("the advised scene", &resolved_toml(&scene), &[])?;
    let study = study::conduct(&loaded, None, &AtomicBool::new(false), Some(progress))?;
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
