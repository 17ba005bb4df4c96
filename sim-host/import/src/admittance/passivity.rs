//! Checks that a sweep and its circuit belong to a passive, capacitive transducer, with the probable
//! cause if they do not.

use num_complex::Complex64;

use super::measured::Measured;
use super::memory::ROUGHNESS_WEIGHT;
use super::result::Circuit;
use super::start::Points;
use crate::error::ImportError;
use report::statistics::{ascending, quantile};

/// Causes of an inductive baseline, with remedies.
pub(super) const INDUCTIVE: &str = "The reactance is that of an inductor over most of the sweep. Disconnect a coil next to the \
                                    transducer; check that `--open` and `--short` are not exchanged, and that S21 is not read as \
                                    S11 (`--topology`)";

/// Checks the direction in which the admittance runs around the circle of the strongest resonance.
/// A passive one has a positive real part and a falling imaginary part. `gain` returns the reduction
/// of the sum of squares by one resonance.
pub(super) fn check_sense(measured: &Measured, readings: &[Complex64], gain: impl Fn(&Points) -> f64) -> Result<(), ImportError> {
    /// Gain over that of a passive resonance from which another sense explains the data.
    const MIN_GAIN_RATIO: f64 = 4.0;
    /// Smallest significant gain, variances of the noise.
    const MIN_GAIN_SIGMA2: f64 = 200.0;
    let weight: Vec<Complex64> =
        measured.admittance.iter().enumerate().map(|(at, y)| measured.reading(at, *y).1.norm_sqr().sqrt().into()).collect();
    let of = |sense: fn(Complex64) -> Complex64| {
        let admittance: Vec<Complex64> = measured.admittance.iter().map(|y| sense(*y)).collect();
        gain(&Points { hz: &measured.hz, admittance: &admittance, weight: &weight })
    };
    let difference = |a: usize, b: usize| measured.coordinate.difference(readings[a], readings[b]);
    let third = |at: usize| difference(at, at + 3) - 3.0 * difference(at + 1, at + 2);
    let ends = readings.len().saturating_sub(3);
    let noise = (0..ends).map(|at| third(at).norm_sqr()).sum::<f64>() / ROUGHNESS_WEIGHT / ends.max(1) as f64;
    let least = (MIN_GAIN_RATIO * of(|y| y)).max(MIN_GAIN_SIGMA2 * noise);
    let senses: [(fn(Complex64) -> Complex64, &str); 3] = [
        (
            |y| y.conj(),
            "the sign of the imaginary part is mirrored: only with the other sign does the sweep have a resonance. Negate the \
             column of the reactance, susceptance or angle",
        ),
        (
            |y| -y,
            "the real part is negative at the resonance, and all angles are off by 180 degrees. Turn the current probe, or add \
             180 degrees to the angle",
        ),
        (
            |y| -y.conj(),
            "the real part is negative at the resonance. `--series-ohm` may be too large, the fixture wrong, or the sign of the \
             real part mirrored",
        ),
    ];
    let gains = senses.map(|(sense, what)| (of(sense), what));
    match gains.into_iter().max_by(|(a, _), (b, _)| a.total_cmp(b)) {
        Some((gain, what)) if gain > least => Err(ImportError::NotATransducer(what.to_owned())),
        _ => Ok(()),
    }
}

/// Returns `true` if the susceptance is negative at most frequencies.
pub(super) fn is_inductive(measured: &Measured) -> bool {
    quantile(&ascending(measured.admittance.iter().map(|y| y.im)), 0.5).is_some_and(|middle| middle < 0.0)
}

/// Checks that a circuit has values of an ultrasonic transducer.
pub(super) fn check_circuit(circuit: &Circuit) -> Result<(), ImportError> {
    const RM_OHM: std::ops::RangeInclusive<f64> = 1e-4..=1e6;
    const C0_F: std::ops::RangeInclusive<f64> = 1e-12..=1e-4;
    /// Smallest loss tangent that an error of the angle explains.
    const MIN_LOSS_TANGENT: f64 = -0.1;
    let (rm, c0, loss) = (circuit.rm_ohm.value, circuit.c0_f.value, circuit.loss_tangent);
    let what = if !RM_OHM.contains(&rm) || !C0_F.contains(&c0) {
        format!("Rm is {rm:.2e} ohm and C0 {c0:.2e} F; is the unit of a column wrong, as milli instead of mega?")
    } else if loss.value < MIN_LOSS_TANGENT - 3.0 * loss.sd {
        format!("the real part is negative off resonance (loss tangent {:.2}); calibrate, or correct the fixture", loss.value)
    } else {
        return Ok(());
    };
    Err(ImportError::NotATransducer(what))
}
