//! The front end of a transducer of the set, and the scene in which it is run.
//!
//! The ranges are those of a user who has measured the transducer, or the advice of
//! `sim-host advise` for its voltage:
//!
//! * **Drive**: 3 V, or less, in two digits, so that the largest current stays within nine tenths
//!   of the limit of 3 A.
//! * **Current limit**: nine tenths of the current range, 3 A at most.
//! * **Current range**: the smallest of 0.5 mA, 1, 2, 5 mA, ... 5 A for which the largest current
//!   is at most nine tenths of the current limit.
//! * **Voltage range**: the smallest of 2, 5, 10 and 20 V for which the drive is at most nine
//!   tenths of the range.
//! * **Block**: 32 samples, or 50 if 32 contain less than 0.6 periods at the lower end of the
//!   window.
//!
//! The largest current is that of the whole admittance from the lower end of the window to the
//! highest tone of the power-on calibration, in series with the amplifier's source resistance.
//! Amplifier, noise and
//! bits are the defaults of scenes: 200 kHz, 0.3 ohm, 20 V, 1 LSB, 12 bits.

use std::f64::consts::TAU;

use realfft::num_complex::Complex64;

use super::draw::{FurtherMode, Transducer};

/// Scene that is changed into that of a transducer: a cold start without a nominal Lm.
pub const SCENE: &str = "transducer-smbltd45f28h";
/// Largest voltage of the amplifier, V: the default of scenes, which [`SCENE`] changes.
const AMPLIFIER_V: f64 = 20.0;
/// Bandwidth of the phase loop, Hz: the default of scenes, which [`SCENE`] changes.
const BANDWIDTH_HZ: f64 = 200.0;
/// Source resistance of the amplifier, ohm.
const SOURCE_OHM: f64 = 0.3;
/// Peak drive voltage if the current does not limit it, V.
const DRIVE_V: f64 = 3.0;
/// Current limit of scenes that set none, A.
const LIMIT_A: f64 = 3.0;
/// Used share of a range and of a limit, as in the advice.
const USED_SHARE: f64 = 0.9;
/// Largest current range of a front end, A.
const LARGEST_RANGE_A: f64 = 5.0;
/// Ranges of the voltage sensor, V.
const RANGES_V: [f64; 4] = [2.0, 5.0, 10.0, 20.0];
/// Distance of the calibration's highest tone above the end of the window, relative to the nominal
/// frequency.
const HIGHEST_TONE_REL: f64 = 0.0213 + 0.1711;
/// Smallest number of periods in a block.
const MIN_BLOCK_PERIODS: f64 = 0.6;
/// Periods of the calibration's tones.
const CALIBRATION_PERIODS: f64 = 1600.0;
/// Time for the self-test before the tones, for the fit after them, and for the lock of a
/// transducer without ringing, s.
const BASE_S: f64 = 0.05;
/// Additional time for the lock in ring-down times, each `Q / (pi fs)`.
const RING_DOWNS: f64 = 20.0;
/// Factor on the time of all transducers. A scan waits for the transducer and is followed by
/// another lock: the phase loop begins with one, the observer needs one if its calibration or lock
/// is ambiguous.
const SCAN_TIME_FACTOR: f64 = 3.0;

/// Front-end settings of a transducer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrontEnd {
    /// Peak drive voltage, V.
    pub drive_v: f64,
    /// Largest peak current that this voltage drives, A.
    pub current_a: f64,
    /// Full scale of the current sensor, A.
    pub current_range_a: f64,
    /// Full scale of the voltage sensor, V.
    pub voltage_range_v: f64,
    /// Samples in a block.
    pub block_samples: u16,
}

impl FrontEnd {
    /// Chooses the settings by the rules of this module.
    pub fn of(transducer: &Transducer) -> Self {
        let siemens = largest_siemens(transducer);
        let drive_v = DRIVE_V.min(two_digits(USED_SHARE * LIMIT_A / siemens));
        let current_a = drive_v * siemens;
        let lowest_hz = transducer.nominal.hz * (1.0 - transducer.nominal.span);
        FrontEnd {
            drive_v,
            current_a,
            current_range_a: range_a(current_a),
            voltage_range_v: RANGES_V.into_iter().find(|range| USED_SHARE * range >= drive_v).unwrap_or(RANGES_V[3]),
            block_samples: if 32e-6 * lowest_hz < MIN_BLOCK_PERIODS { 50 } else { 32 },
        }
    }
}

/// Returns the largest admittance that the amplifier drives, S.
fn largest_siemens(of: &Transducer) -> f64 {
    let highest_hz = of.nominal.hz * (1.0 + of.nominal.span + HIGHEST_TONE_REL);
    let lowest_hz = of.nominal.hz * (1.0 - of.nominal.span);
    let at = |hz: f64| 1.0 / (admittance(of, hz).inv() + SOURCE_OHM).norm();
    // Around each resonance in steps of a hundredth of its bandwidth: due to its neighbours and C0,
    // the current may be largest off resonance.
    let near = |(hz, q): (f64, f64)| (-500..=500).map(move |step| hz * (1.0 + 0.01 * f64::from(step) / q));
    let resonances = of.modes.iter().map(|mode| (mode.hz, mode.q)).chain([(of.hz, of.q)]);
    let tones = resonances.flat_map(near).filter(|hz| (lowest_hz..highest_hz).contains(hz));
    tones.chain([highest_hz]).map(at).fold(0.0, f64::max)
}

/// Returns the admittance of a transducer at a frequency, S.
fn admittance(of: &Transducer, hz: f64) -> Complex64 {
    let branch = |resonance_hz: f64, q: f64, cm_f: f64| {
        let x = hz / resonance_hz;
        Complex64::new(0.0, TAU * hz * cm_f) / Complex64::new(1.0 - x * x, x / q)
    };
    let working = Complex64::new(0.0, TAU * hz * of.c0_f) + branch(of.hz, of.q, of.cm_f());
    of.modes.iter().fold(working, |sum, mode| sum + branch(mode.hz, mode.q, mode.share * of.cm_f()))
}

/// Returns the smallest range of the series 0.5, 1, 2 mA etc. for a current, A.
fn range_a(current_a: f64) -> f64 {
    let mut ranges = (-3..1).flat_map(|decade| [0.5, 1.0, 2.0].map(|step| step * 10f64.powi(decade)));
    ranges.find(|range| USED_SHARE * USED_SHARE * range >= current_a).unwrap_or(LARGEST_RANGE_A)
}

/// Rounds down to two digits.
fn two_digits(value: f64) -> f64 {
    let step = 10f64.powf(value.log10().floor() - 1.0);
    (value / step + 1e-9).floor() * step
}

/// Rounds to five digits, which keeps the commands that repeat a run short.
fn rounded(value: f64) -> f64 {
    format!("{value:.4e}").parse().unwrap_or(value)
}

/// Returns the changes of [`SCENE`] for a transducer and a tracking mode, as `key=value`.
pub fn sets(of: &Transducer, mode: &str) -> Vec<String> {
    let (front_end, nominal) = (FrontEnd::of(of), &of.nominal);
    let ring_down_s = of.q / (std::f64::consts::PI * of.hz);
    let allowed_s = BASE_S + CALIBRATION_PERIODS / nominal.hz + RING_DOWNS * ring_down_s;
    let duration_s = SCAN_TIME_FACTOR * allowed_s;
    let further = |(place, mode): (usize, &FurtherMode)| {
        let lm_h = 1.0 / ((TAU * mode.hz).powi(2) * mode.share * of.cm_f());
        [("series_resonance_hz", mode.hz), ("q", mode.q), ("lm_h", lm_h)]
            .map(|(key, value)| (format!("stack.mode.{place}.{key}"), value))
    };
    let own = [
        ("duration_s", duration_s),
        ("stack.bvd.series_resonance_hz", of.hz),
        ("stack.bvd.q", of.q),
        ("stack.bvd.coupling", of.coupling),
        ("stack.bvd.c0_f", of.c0_f),
        ("amplifier.full_scale_v", AMPLIFIER_V),
        ("sensors.i_full_scale_a", front_end.current_range_a),
        ("sensors.v_full_scale_v", front_end.voltage_range_v),
        ("controller.limits.current_a", LIMIT_A.min(USED_SHARE * front_end.current_range_a)),
        ("controller.drive.frequency_hz", nominal.hz),
        ("controller.drive.amplitude_v", front_end.drive_v),
        ("controller.tracking.span", nominal.span),
        ("controller.tracking.bandwidth_hz", BANDWIDTH_HZ),
        ("controller.tracking.nominal_q", nominal.q),
    ];
    let own = own.map(|(key, value)| (key.to_owned(), value)).into_iter();
    let lm = nominal.lm_h.map(|lm_h| ("controller.tracking.nominal_lm_h".to_owned(), lm_h));
    let numbers = own.chain(lm).chain(of.modes.iter().enumerate().flat_map(further));
    let fixed = [
        format!("seed={}", of.number + 1),
        format!("controller.tracking.mode={mode}"),
        format!("controller.tracking.nominal_c0_f={}", nominal.c0_f.map_or("none".into(), |c0_f| format!("{:?}", rounded(c0_f)))),
        format!("controller.block_samples={}", front_end.block_samples),
    ];
    fixed.into_iter().chain(numbers.map(|(key, value)| format!("{key}={:?}", rounded(value)))).collect()
}

#[cfg(test)]
mod tests {
    use super::super::draw::KINDS;
    use super::*;

    #[test]
    fn ranges_are_the_smallest_that_fit() {
        for (current_a, range) in [(0.1e-3, 0.5e-3), (0.40e-3, 0.5e-3), (0.41e-3, 1e-3), (2.69, 5.0), (1.63, 5.0), (0.8, 1.0)] {
            assert!((range_a(current_a) / range - 1.0).abs() < 1e-12, "{current_a}: {}", range_a(current_a));
        }
        assert!((two_digits(2.789) - 2.7).abs() < 1e-12 && (two_digits(0.1234) - 0.12).abs() < 1e-12);
    }

    /// At resonance the admittance is that of Rm and C0 in parallel.
    #[test]
    fn the_admittance_is_that_of_the_circuit() {
        let transducer = Transducer::draw(0);
        let (at, c0) = (admittance(&transducer, transducer.hz), TAU * transducer.hz * transducer.c0_f);
        assert!((at.re * transducer.rm_ohm() - 1.0).abs() < 1e-9 && (at.im / c0 - 1.0).abs() < 1e-9, "{at}");
    }

    #[test]
    fn every_transducer_fits_its_front_end() {
        for transducer in (0..600).map(Transducer::draw) {
            let front_end = FrontEnd::of(&transducer);
            assert!(front_end.current_a <= USED_SHARE * (USED_SHARE * front_end.current_range_a).min(LIMIT_A), "{front_end:?}");
            assert!(front_end.current_a > 0.1 * front_end.current_range_a, "{front_end:?} of {transducer:?}");
        }
        assert!(KINDS.iter().all(|kind| kind.modes <= 3));
    }
}
