//! Warnings about unexpected behaviour, in plain words, with remedies.

use super::case::{Case, Parts};
use super::prediction::Prediction;
use super::settings::{MIN_PERIODS, Settings};
use super::transducer::{Full, ZERO_PHASE_M};

/// Time constant above which a ring-up is called long, ms.
const LONG_RING_UP_MS: f64 = 5.0;
/// Number of time constants in which residual vibration falls to a hundredth.
const DECAY_TIME_CONSTANTS: f64 = 4.6;
/// Number of standard deviations that jitter does not exceed for thousands of blocks.
const JITTER_SIGMA: f64 = 4.0;
/// Tightest bound of a lock, Hz.
const TIGHTEST_HZ: f64 = 4.0;
/// Minimum fraction of the drive voltage at the stack; below it the guard reports a broken sensor
/// (fault 20).
const MIN_STACK_FRACTION: f64 = 0.5;
/// Fraction of the sensor's range below which the current is too small.
const MIN_CURRENT_FRACTION: f64 = 0.05;

/// Returns all warnings that apply to a case.
pub fn collect(case: &Case, parts: &Parts<'_>, full: &Full, settings: &Settings, prediction: &Prediction) -> Vec<String> {
    let mut warnings = Vec::new();
    let drive = &settings.drive;
    if full.figure_of_merit <= ZERO_PHASE_M {
        warnings.push(format!(
            "M = {:.2} is not above 2: the phase between voltage and current has no zero at any frequency, so a plain V-I loop \
             (mode = \"zero_phase\") cannot lock. Keep the observer: it first subtracts the current of C0.",
            full.figure_of_merit
        ));
    }
    if drive.advised_v < drive.asked_v {
        warnings.push(format!(
            "{} V would draw {:.2} A in calibration, scan or lock, which is too much: {} allows {} V. All results below are for that \
             voltage.",
            drive.asked_v, drive.asked_current_a, drive.bounded_by, drive.largest_v
        ));
    }
    if drive.left_at_stack < MIN_STACK_FRACTION {
        warnings.push(format!(
            "At the resonance, the amplifier's {} ohm leave {:.0} % of the drive voltage at a stack of {:.3} ohm. Below 50 % \
             the guard reports a broken voltage sensor (fault 20) at any voltage: this stack needs an amplifier with a lower \
             source resistance.",
            parts.amplifier.source_ohm,
            100.0 * drive.left_at_stack,
            full.rm_ohm
        ));
    }
    if full.time_constant_ms > LONG_RING_UP_MS {
        warnings.push(format!(
            "The stack has a time constant of {:.1} ms: after the drive is switched OFF, the vibration takes {:.0} ms to fall \
             to a hundredth. Set controller.burst.brake = true if OFF must be quick.",
            full.time_constant_ms,
            DECAY_TIME_CONSTANTS * full.time_constant_ms
        ));
    }
    let top_hz = parts.controller.drive.frequency_hz * (1.0 + settings.span);
    if top_hz >= full.parallel_resonance_hz {
        warnings.push(format!(
            "The window reaches up to {top_hz:.0} Hz, beyond the antiresonance at {:.0} Hz, where the total current nearly \
             vanishes. The observer tolerates this; a V-I loop or a scan may not. If the resonance is known to better than 2 %, \
             reduce span.",
            full.parallel_resonance_hz
        ));
    }
    let unlocked = prediction.lock.iter().any(|time| time.within_hz == TIGHTEST_HZ && time.p95_ms.is_none());
    if JITTER_SIGMA * prediction.jitter_hz > TIGHTEST_HZ || unlocked {
        warnings.push(format!(
            "Too much noise for a lock within {TIGHTEST_HZ} Hz: the frequency jitters by {:.1} Hz rms. Drive with a higher \
             voltage (up to {} V), or use a sensor with a smaller range.",
            prediction.jitter_hz, drive.largest_v
        ));
    } else if drive.current_lsb < MIN_CURRENT_FRACTION * drive.full_scale_lsb {
        warnings.push(format!(
            "The current uses only {:.0} of {:.0} LSB. A higher voltage (up to {} V) or a sensor with a smaller range would lock \
             sooner.",
            drive.current_lsb, drive.full_scale_lsb, drive.largest_v
        ));
    }
    let periods = f64::from(settings.block_samples) * full.series_resonance_hz / parts.sensors.sample_hz;
    if periods < MIN_PERIODS {
        let least = (MIN_PERIODS * parts.sensors.sample_hz / full.series_resonance_hz).ceil();
        warnings.push(format!(
            "A block of {} samples contains {periods:.2} periods, too few to distinguish sine from cosine: use {least:.0} \
             samples or more, or a lower sample rate.",
            settings.block_samples
        ));
    }
    if case.modes > 0 {
        warnings.push(format!(
            "The scene has {} further mode{}, which this advice ignores: a nearby mode pulls the lock point, and a mode in the \
             window may be mistaken for the working mode. Run the scene itself.",
            case.modes,
            if case.modes == 1 { "" } else { "s" }
        ));
    } else {
        warnings.push(
            "The prediction assumes a single mode. A scan shows if there is a second mode nearby (metric modes_found).".into(),
        );
    }
    warnings
}
