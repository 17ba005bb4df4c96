//! Warnings: what will not go as one might expect, in plain words, and what to do.

use super::case::{Case, Parts};
use super::prediction::Prediction;
use super::settings::{LEAST_PERIODS, Settings};
use super::transducer::{Full, ZERO_PHASE_M};

/// A ring-up longer than this is long, ms.
const LONG_MS: f64 = 5.0;
/// Time constants after which residual vibration has fallen to a hundredth.
const GONE: f64 = 4.6;
/// So many deviations of jitter hold for thousands of blocks.
const DEVIATIONS: f64 = 4.0;
/// The tightest lock that is asked for, Hz.
const TIGHTEST_HZ: f64 = 4.0;
/// The guard wants this part of the drive at the stack, else it takes its sensor for broken (fault 20).
const LEFT: f64 = 0.5;
/// A block that uses less of the sensor's range than this is little, parts.
const LITTLE: f64 = 0.05;

/// All warnings that apply to a case.
pub fn of(case: &Case, parts: &Parts<'_>, full: &Full, settings: &Settings, prediction: &Prediction) -> Vec<String> {
    let mut said = Vec::new();
    let drive = &settings.drive;
    if full.figure_of_merit <= ZERO_PHASE_M {
        said.push(format!(
            "M = {:.2} is not above 2: the phase between voltage and current has no zero at any frequency, so a plain V-I loop \
             (mode = \"zero_phase\") has nothing to lock to. Keep the observer, which takes the current of C0 away first.",
            full.figure_of_merit
        ));
    }
    if drive.advised_v < drive.asked_v {
        said.push(format!(
            "{} V would draw {:.2} A at the resonance, which is too much: {} allows {} V, and that is what everything below is for.",
            drive.asked_v, drive.asked_current_a, drive.bounded_by, drive.largest_v
        ));
    }
    if drive.left_at_stack < LEFT {
        said.push(format!(
            "At the resonance the amplifier's {} ohm leave {:.0} % of the drive at a stack of {:.3} ohm. Below half of it the guard takes the voltage \
             sensor for broken (fault 20), whatever the voltage: this stack needs an amplifier of less source resistance.",
            parts.amplifier.source_ohm,
            100.0 * drive.left_at_stack,
            full.rm_ohm
        ));
    }
    if full.time_constant_ms > LONG_MS {
        said.push(format!(
            "The stack rings with a time constant of {:.1} ms: after the drive is OFF, vibration takes {:.0} ms to fall to a hundredth. Set \
             controller.burst.brake = true if OFF has to be quick.",
            full.time_constant_ms,
            GONE * full.time_constant_ms
        ));
    }
    let top_hz = parts.controller.drive.frequency_hz * (1.0 + settings.span);
    if top_hz >= full.parallel_resonance_hz {
        said.push(format!(
            "The window reaches up to {top_hz:.0} Hz, beyond the antiresonance at {:.0} Hz, where the total current all but vanishes. The \
             observer does not mind, a V-I loop and a scan may. If the resonance is known better than 2 %, make span smaller.",
            full.parallel_resonance_hz
        ));
    }
    let unlocked = prediction.lock.iter().any(|time| time.within_hz == TIGHTEST_HZ && time.p95_ms.is_none());
    if DEVIATIONS * prediction.jitter_hz > TIGHTEST_HZ || unlocked {
        said.push(format!(
            "Too much noise for a lock within {TIGHTEST_HZ} Hz: the frequency jitters by {:.1} Hz rms. Drive with more voltage (up to {} V), or use a \
             sensor of less range.",
            prediction.jitter_hz, drive.largest_v
        ));
    } else if drive.current_lsb < LITTLE * drive.full_scale_lsb {
        said.push(format!(
            "The current uses {:.0} of {:.0} LSB: most of the sensor is wasted. More voltage (up to {} V) or a sensor of less range would lock sooner.",
            drive.current_lsb, drive.full_scale_lsb, drive.largest_v
        ));
    }
    let periods = f64::from(settings.block_samples) * full.series_resonance_hz / parts.sensors.sample_hz;
    if periods < LEAST_PERIODS {
        let least = (LEAST_PERIODS * parts.sensors.sample_hz / full.series_resonance_hz).ceil();
        said.push(format!(
            "A block of {} samples holds {periods:.2} periods, too little to tell sine from cosine: use {least:.0} or more, or a lower sample rate.",
            settings.block_samples
        ));
    }
    if case.modes > 0 {
        said.push(format!(
            "The scene has {} further mode{}, which this advice leaves out: a mode nearby pulls the lock point, and one in the window may be taken for \
             the working mode. Run the scene itself.",
            case.modes,
            if case.modes == 1 { "" } else { "s" }
        ));
    } else {
        said.push(
            "Whether there is a second mode nearby is not known. A scan lists what there is (metric modes_found); the prediction is of one \
             mode alone."
                .into(),
        );
    }
    said
}
