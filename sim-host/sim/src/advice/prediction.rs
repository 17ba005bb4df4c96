//! Prediction of the observer's behaviour by rehearsal, with the Cramer-Rao bound.
//!
//! | quantity | definition |
//! |---|---|
//! | lock time to B | from the first sample of the lock stage to the last moment at which the drive frequency is off by more than B: median and 95th percentile of noisy cold starts over the possible errors of the nominal values ([`NOMINAL_ERROR`]) |
//! | jitter | steady standard deviation of the drive frequency |
//! | bandwidth | -3 dB, from a modulation of the true resonance to the drive frequency; without noise |
//! | lag | true resonance minus drive frequency on a ramp; without noise |
//! | bias | shift of the lock point if the clamped capacitance is 1 % above its calibration, or if the current is sampled 1 ns later |
//! | loss | from the end of the vibration until the lock is reported lost |
//!
//! The bound of the jitter is the Cramer-Rao bound of a sliding window. The middle of the window
//! lies in the past, by the lag that the observer without its second integrator has on a ramp. Lm
//! and C0 are known, because their errors are bias. The bound on a ramp is the best compromise of
//! lag and jitter for a resonance assumed constant within a window, or the jitter of an estimate
//! that also fits the slope.

use firmware::seam::block::LATENCY_BLOCKS;
use firmware::track::tracker::State;
use rand_core::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use serde::Serialize;

use super::case::{Case, NOMINAL_ERROR};
use super::rehearsal::{Rehearsal, RehearsalBench};
use super::response::bandwidth_hz;
use super::rig::RehearsalRig;
use crate::cramer_rao::{DEVIATIONS_95, Knowledge, PriorKnowledge, Setting, ramp, ramp_with_slope, steady, time_to};
use plant::circuit::Circuit;
use report::statistics::{ascending, percentile};

/// Number of cold starts of a prediction.
pub const DRAWS: u64 = 400;
/// Bounds within which a lock is counted, Hz.
pub const BOUNDS_HZ: [f64; 3] = [100.0, 20.0, 4.0];
/// Rates of a ramp, Hz/s.
const RAMPS_HZ_PER_S: [f64; 2] = [1e3, 10e3];
/// Duration of a cold start, s.
const WATCHED_S: f64 = 8e-3;
/// Time after which the state is steady, and duration of a ramp, s.
pub(super) const SETTLED_S: f64 = 30e-3;
/// Duration of a jitter measurement, s.
const JITTER_S: f64 = 60e-3;
/// Number of rehearsals of a jitter measurement.
const JITTER_REHEARSALS: u64 = 4;
/// Maximum time until a loss is reported, s.
const LOSS_S: f64 = 1.0;
/// Standard deviations that contain half of a Gaussian distribution.
const DEVIATIONS_50: f64 = 0.6745;
/// Relative error of C0 for the bias.
const ONE_PERCENT: f64 = 0.01;
/// Skew for the bias, s.
const ONE_NS: f64 = 1e-9;

/// Predicted behaviour of the observer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Prediction {
    /// Number of rehearsed cold starts.
    pub draws: u64,
    /// Lock times to within several bounds.
    pub lock: Vec<LockTime>,
    /// Standard deviation of the drive frequency, Hz.
    pub jitter_hz: f64,
    /// Standard deviation stated by the observer, Hz.
    pub jitter_stated_hz: f64,
    /// Bound of the standard deviation, Hz.
    pub jitter_bound_hz: f64,
    /// Bandwidth from true resonance to drive, Hz.
    pub bandwidth_hz: Option<f64>,
    /// Lags on several ramps of the resonance.
    pub ramps: Vec<Ramp>,
    /// Shift of the lock point per percent of C0, Hz.
    pub bias_hz_per_percent_c0: f64,
    /// Shift of the lock point per ns by which the current is sampled later than the voltage, Hz.
    pub bias_hz_per_ns_skew: f64,
    /// Time until the end of the vibration is detected, ms.
    pub loss_noticed_ms: Option<f64>,
}

/// Time to lock to within a bound.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LockTime {
    /// Bound of the frequency error, Hz.
    pub within_hz: f64,
    /// Median, ms; `None` if it exceeds the simulated time.
    pub median_ms: Option<f64>,
    /// 95th percentile, ms; `None` if it exceeds the simulated time.
    pub p95_ms: Option<f64>,
    /// Bound of the median, ms.
    pub bound_median_ms: Option<f64>,
    /// Bound of the 95th percentile, ms.
    pub bound_p95_ms: Option<f64>,
}

/// Behaviour on a drifting resonance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Ramp {
    /// Rate of the drift, Hz/s.
    pub hz_per_s: f64,
    /// Lag of the firmware's observer, Hz.
    pub lag_hz: f64,
    /// Lag without its second integrator, Hz.
    pub lag_without_rate_hz: f64,
    /// Minimum error of an estimate for a constant resonance, lag and jitter combined, Hz rms.
    pub bound_constant_hz: Option<f64>,
    /// Jitter of an estimate that fits the slope, with the observer's memory, Hz rms.
    pub bound_slope_hz: f64,
}

/// Predicts the observer's behaviour for a case; `None` if the firmware refuses its settings.
pub fn predict(case: &Case) -> Option<Prediction> {
    let rig = RehearsalRig::from_case(case)?;
    let setting = Setting {
        prior: PriorKnowledge::cold(rig.bench.nominal_hz, NOMINAL_ERROR.resonance),
        ..Setting::from_scene(&case.driven()?)?
    };
    let latency = LATENCY_BLOCKS as f64;
    let times = lock_times(&rig, DRAWS);
    let bound_ms = |hz: f64| time_to(&setting, hz, latency).map(|s| 1e3 * s);
    let lock = BOUNDS_HZ.iter().zip(&times).map(|(&within_hz, times)| LockTime {
        within_hz,
        median_ms: percentile_ms(times, 0.5),
        p95_ms: percentile_ms(times, 0.95),
        bound_median_ms: bound_ms(within_hz * DEVIATIONS_95 / DEVIATIONS_50),
        bound_p95_ms: bound_ms(within_hz),
    });
    let lock = lock.collect();
    let (jitter_hz, jitter_stated_hz) = jitter(&rig);
    let locked = settle(&rig, rig.bench);
    let bandwidth_hz = bandwidth_hz(&locked.0, &rig);
    let mut without_rate = rig.start_without_rate();
    (0..rig.blocks(SETTLED_S)).for_each(|_| {
        without_rate.step(&rig.circuit);
    });
    let prior = PriorKnowledge { voltage: Knowledge::Unknown, state: Knowledge::Unknown, ..PriorKnowledge::LM_AND_C0 };
    let tracking = Setting { prior, ..setting };
    let behind_s = lag_hz(&rig, without_rate.clone(), RAMPS_HZ_PER_S[0]) / RAMPS_HZ_PER_S[0];
    let memory_s = 2.0 * (behind_s - latency * rig.block_s).max(rig.block_s);
    let ramps = RAMPS_HZ_PER_S.map(|hz_per_s| Ramp {
        hz_per_s,
        lag_hz: lag_hz(&rig, locked.0.clone(), hz_per_s),
        lag_without_rate_hz: lag_hz(&rig, without_rate.clone(), hz_per_s),
        bound_constant_hz: ramp(&tracking, hz_per_s, latency).map(|best| best.error_hz()),
        bound_slope_hz: ramp_with_slope(&tracking, memory_s, latency),
    });
    let bias = |bench: RehearsalBench| settle(&rig, bench).1 - locked.1;
    Some(Prediction {
        draws: DRAWS,
        lock,
        jitter_hz,
        jitter_stated_hz,
        jitter_bound_hz: steady(&tracking, memory_s),
        bandwidth_hz,
        ramps: ramps.to_vec(),
        bias_hz_per_percent_c0: bias(RehearsalBench { c0_error: ONE_PERCENT, ..rig.bench }),
        bias_hz_per_ns_skew: bias(RehearsalBench { skew_s: ONE_NS, ..rig.bench }),
        loss_noticed_ms: loss_s(&rig, locked.0).map(|s| 1e3 * s),
    })
}

/// Returns the lock times of `draws` cold starts to each of [`BOUNDS_HZ`], s, in ascending order;
/// infinite if not reached.
pub fn lock_times(rig: &RehearsalRig, draws: u64) -> [Vec<f64>; 3] {
    let blocks = rig.blocks(WATCHED_S);
    let one = |number: u64| {
        let (mut rehearsal, circuit) = rig.draw(number);
        let errors: Vec<f64> = (0..blocks).map(|_| rehearsal.step(&circuit).error_hz().abs()).collect();
        BOUNDS_HZ.map(|bound| {
            let inside = errors.iter().rposition(|&error| error > bound).map_or(0, |last| last + 1);
            if inside < blocks { inside as f64 * rig.block_s } else { f64::INFINITY }
        })
    };
    let all: Vec<[f64; 3]> = (1..=draws).into_par_iter().map(one).collect();
    [0, 1, 2].map(|n| ascending(all.iter().map(|times| times[n])))
}

/// Returns the smallest value that at least the fraction `part` does not exceed, ms; `None` if it
/// is infinite.
pub fn percentile_ms(rising: &[f64], part: f64) -> Option<f64> {
    Some(1e3 * percentile(rising, part)).filter(|ms| ms.is_finite())
}

/// Returns the standard deviation of the drive frequency, and that stated by the observer, Hz.
fn jitter(rig: &RehearsalRig) -> (f64, f64) {
    let one = |number: u64| {
        let mut rehearsal = rig.start(rig.bench, Some(Xoshiro256PlusPlus::seed_from_u64(number)));
        (0..rig.blocks(SETTLED_S)).for_each(|_| {
            rehearsal.step(&rig.circuit);
        });
        let blocks: Vec<_> = (0..rig.blocks(JITTER_S)).map(|_| rehearsal.step(&rig.circuit)).collect();
        let mean = |of: &dyn Fn(f64) -> f64| blocks.iter().map(|block| of(block.played_hz)).sum::<f64>() / blocks.len() as f64;
        let centre = mean(&|hz| hz);
        (mean(&|hz| (hz - centre).powi(2)), blocks.last().map_or(f64::NAN, |block| block.stated_hz))
    };
    let all: Vec<(f64, f64)> = (1..=JITTER_REHEARSALS).into_par_iter().map(one).collect();
    let mean = |of: fn(&(f64, f64)) -> f64| all.iter().map(of).sum::<f64>() / all.len() as f64;
    (mean(|one| one.0).sqrt(), mean(|one| one.1))
}

/// Returns a settled rehearsal without noise, and its offset from the true resonance, Hz.
fn settle(rig: &RehearsalRig, bench: RehearsalBench) -> (Rehearsal, f64) {
    let mut rehearsal = rig.start(bench, None);
    let blocks = rig.blocks(SETTLED_S);
    let errors: Vec<f64> = (0..blocks).map(|_| rehearsal.step(&rig.circuit).error_hz()).collect();
    let last = &errors[blocks - blocks / 3..];
    (rehearsal, last.iter().sum::<f64>() / last.len() as f64)
}

/// Returns the steady lag of a rehearsal on a ramp, Hz.
fn lag_hz(rig: &RehearsalRig, mut settled: Rehearsal, hz_per_s: f64) -> f64 {
    let (from_s, own_hz) = (settled.time_s(), rig.circuit.series_resonance_hz());
    let blocks = rig.blocks(SETTLED_S);
    let mut lags = Vec::with_capacity(blocks);
    for _ in 0..blocks {
        let hz = own_hz + hz_per_s * (settled.time_s() - from_s);
        lags.push(-settled.step(&rig.circuit.with_series_resonance(hz)).error_hz());
    }
    let last = &lags[blocks - blocks / 3..];
    last.iter().sum::<f64>() / last.len() as f64
}

/// Returns the time until the end of the vibration is detected, s.
fn loss_s(rig: &RehearsalRig, mut settled: Rehearsal) -> Option<f64> {
    /// Factor of the inductance that removes the motional branch.
    const BROKEN: f64 = 1e6;
    let own = rig.circuit;
    let broken = Circuit { lm_h: own.lm_h * BROKEN, cm_f: own.cm_f / BROKEN, rm_ohm: own.rm_ohm * BROKEN, ..own };
    let lost = |state: Option<State>| matches!(state, Some(State::Lost | State::Disagree));
    let noticed = (1..=rig.blocks(LOSS_S)).find(|_| lost(settled.step(&broken).state))?;
    Some(noticed as f64 * rig.block_s)
}
