//! The front end of a transducer of the set, and the scene that it is run in.
//!
//! The ranges are those that a user would choose who has measured the transducer, or has asked `sim-host advise` for its voltage:
//!
//! * **Drive**: 3 V, or as much less as keeps the largest current within nine tenths of the limit of 3 A, in two digits.
//! * **Current range**: the least of 0.5 mA, 1, 2, 5 mA, ... 5 A whose limit leaves the largest current nine tenths; the limit is nine tenths of the range, and 3 A
//!   at most.
//! * **Voltage range**: the least of 2, 5, 10 and 20 V of which the drive is nine tenths at most.
//! * **Block**: 32 samples, or 50 where those hold less than 0.6 periods at the lower end of the window.
//!
//! The largest current is that at any of the resonances, or through C0 at the highest tone of the power-on calibration, behind the amplifier's source resistance.
//! Amplifier, noise and bits are the defaults of scenes: 200 kHz, 0.3 ohm, 20 V, 1 LSB, 12 bits.

use std::f64::consts::TAU;

use realfft::num_complex::Complex64;

use super::draw::{FurtherMode, Transducer};

/// The scene that becomes that of a transducer: a cold start without a nominal Lm.
pub const SCENE: &str = "transducer-smbltd45f28h";
/// Largest voltage of the amplifier, V, and bandwidth of the phase loop, Hz: the defaults of scenes, which that scene changes.
const AMPLIFIER_V: f64 = 20.0;
const BANDWIDTH_HZ: f64 = 200.0;
/// Source resistance of the amplifier, ohm.
const SOURCE_OHM: f64 = 0.3;
/// Peak drive voltage where nothing is too much, V.
const DRIVE_V: f64 = 3.0;
/// Current limit of scenes that name none, A.
const LIMIT_A: f64 = 3.0;
/// Part of a range and of a limit that is used, as the advice uses it.
const USED: f64 = 0.9;
/// Largest current range of a front end, A.
const LARGEST_RANGE_A: f64 = 5.0;
/// Ranges of the voltage sensor, V.
const RANGES_V: [f64; 4] = [2.0, 5.0, 10.0, 20.0];
/// Highest tone of the power-on calibration above the window's end, relative to the nominal frequency.
const HIGHEST_TONE: f64 = 0.0213 + 0.1711;
/// Periods that a block has at least.
const LEAST_PERIODS: f64 = 0.6;
/// Periods of the calibration's tones.
const CALIBRATION_PERIODS: f64 = 1600.0;
/// Time for the self-test before them, for the fit behind them, and for the lock of a transducer that does not ring, s.
const REST_S: f64 = 0.05;
/// Ring-down times that a transducer has beyond that to be locked, each `Q / (pi fs)`.
const RING_DOWNS: f64 = 20.0;
/// How much more time all have: a scan, by which the phase loop begins, and the observer where its calibration or its lock cannot tell, waits for the transducer; another lock
/// comes after it.
const SCAN: f64 = 3.0;

/// The front end's settings of a transducer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrontEnd {
    /// Peak drive voltage, V.
    pub drive_v: f64,
    /// Largest peak current that this voltage drives, A.
    pub current_a: f64,
    /// End of the current sensor's range, A.
    pub current_range_a: f64,
    /// End of the voltage sensor's range, V.
    pub voltage_range_v: f64,
    /// Samples in a block.
    pub block_samples: u16,
}

impl FrontEnd {
    /// Chooses the settings, by the rule above.
    pub fn of(transducer: &Transducer) -> Self {
        let siemens = largest_siemens(transducer);
        let drive_v = DRIVE_V.min(two_digits(USED * LIMIT_A / siemens));
        let current_a = drive_v * siemens;
        let lowest_hz = transducer.nominal.hz * (1.0 - transducer.nominal.span);
        FrontEnd {
            drive_v,
            current_a,
            current_range_a: range_a(current_a),
            voltage_range_v: RANGES_V.into_iter().find(|range| USED * range >= drive_v).unwrap_or(RANGES_V[3]),
            block_samples: if 32e-6 * lowest_hz < LEAST_PERIODS { 50 } else { 32 },
        }
    }
}

/// The largest admittance that the amplifier drives, S.
fn largest_siemens(of: &Transducer) -> f64 {
    let highest_hz = of.nominal.hz * (1.0 + of.nominal.span + HIGHEST_TONE);
    let at = |hz: f64| 1.0 / (admittance(of, hz).inv() + SOURCE_OHM).norm();
    of.modes.iter().map(|mode| mode.hz).chain([of.hz, highest_hz]).map(at).fold(0.0, f64::max)
}

/// Admittance of a transducer at a frequency, S.
fn admittance(of: &Transducer, hz: f64) -> Complex64 {
    let branch = |resonance_hz: f64, q: f64, cm_f: f64| {
        let x = hz / resonance_hz;
        Complex64::new(0.0, TAU * hz * cm_f) / Complex64::new(1.0 - x * x, x / q)
    };
    let working = Complex64::new(0.0, TAU * hz * of.c0_f) + branch(of.hz, of.q, of.cm_f());
    of.modes.iter().fold(working, |sum, mode| sum + branch(mode.hz, mode.q, mode.share * of.cm_f()))
}

/// The least range of the series 0.5, 1, 2 mA and so on that takes this current, A.
fn range_a(current_a: f64) -> f64 {
    let mut ranges = (-3..1).flat_map(|decade| [0.5, 1.0, 2.0].map(|step| step * 10f64.powi(decade)));
    ranges.find(|range| USED * USED * range >= current_a).unwrap_or(LARGEST_RANGE_A)
}

/// Two digits, downwards.
fn two_digits(value: f64) -> f64 {
    let step = 10f64.powf(value.log10().floor() - 1.0);
    (value / step + 1e-9).floor() * step
}

/// With five digits, so that a command that repeats a run is short.
fn rounded(value: f64) -> f64 {
    format!("{value:.4e}").parse().unwrap_or(value)
}

/// Changes of [`SCENE`] that make it that of a transducer, in a mode of tracking, as `key=value`.
pub fn sets(of: &Transducer, mode: &str) -> Vec<String> {
    let (front_end, nominal) = (FrontEnd::of(of), &of.nominal);
    let ring_down_s = of.q / (std::f64::consts::PI * of.hz);
    let allowed_s = REST_S + CALIBRATION_PERIODS / nominal.hz + RING_DOWNS * ring_down_s;
    let duration_s = SCAN * allowed_s;
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
        ("controller.limits.current_a", LIMIT_A.min(USED * front_end.current_range_a)),
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
    fn ranges_are_the_least_that_fit() {
        for (current_a, range) in [(0.1e-3, 0.5e-3), (0.40e-3, 0.5e-3), (0.41e-3, 1e-3), (2.69, 5.0), (1.63, 5.0), (0.8, 1.0)] {
            assert!((range_a(current_a) / range - 1.0).abs() < 1e-12, "{current_a}: {}", range_a(current_a));
        }
        assert!((two_digits(2.789) - 2.7).abs() < 1e-12 && (two_digits(0.1234) - 0.12).abs() < 1e-12);
    }

    /// Beside a resonance the admittance is that of C0; at it that of Rm beside C0.
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
            assert!(front_end.current_a <= USED * (USED * front_end.current_range_a).min(LIMIT_A), "{front_end:?}");
            assert!(front_end.current_a > 0.1 * front_end.current_range_a, "{front_end:?} of {transducer:?}");
        }
        assert!(KINDS.iter().all(|kind| kind.modes <= 3));
    }
}
