//! Checks that a sweep and its circuit belong to a passive, capacitive transducer. Errors name the
//! probable cause.

use num_complex::Complex64;

use super::measured::Measured;
use super::memory::ROUGHNESS_WEIGHT;
use super::result::Circuit;
use super::start::Points;
use crate::error::ImportError;
use report::statistics::{ascending, quantile};

/// Change of the sign of an admittance, its smallest ratio of gains, and the cause to report.
type Sense = (Turned, f64, &'static str);
/// Change of the sign of an admittance.
type Turned = fn(Complex64) -> Complex64;

/// Causes of an inductive baseline, with remedies.
pub(super) const INDUCTIVE: &str = "The reactance is that of an inductor over most of the sweep. Disconnect a coil next to \
                                    the transducer; check that `--open` and `--short` are not exchanged, that impedance \
                                    and admittance, or R and X, are not exchanged, and that S21 is not read as S11 \
                                    (`--topology`)";

/// Checks the direction in which the admittance runs around the circle of the strongest resonance.
/// A passive one has a positive real part and a falling imaginary part. `gain` returns the
/// reduction of the sum of squares by one resonance.
pub(super) fn check_sense(measured: &Measured, gain: impl Fn(&Points) -> f64) -> Result<(), ImportError> {
    /// Gain over that of a passive resonance from which a mirrored one explains the data.
    const MIN_MIRRORED_RATIO: f64 = 1.5;
    /// Number of standard deviations from which the sum of the real parts is negative.
    const NEGATIVE_SIGMA: f64 = 4.0;
    /// Smallest significant gain, variances of the noise.
    const MIN_GAIN_SIGMA2: f64 = 200.0;
    // With relative weights, no single point dominates.
    let weight: Vec<Complex64> = measured.admittance.iter().map(|y| y.norm_sqr().sqrt().recip().into()).collect();
    let of = |sense: fn(Complex64) -> Complex64| {
        let admittance: Vec<Complex64> = measured.admittance.iter().map(|y| sense(*y)).collect();
        gain(&Points { hz: &measured.hz, admittance: &admittance, weight: &weight })
    };
    let weighted: Vec<Complex64> = measured.admittance.iter().zip(&weight).map(|(y, weight)| y * weight).collect();
    let third = ascending(weighted.windows(4).map(|y| (y[0] - 3.0 * (y[1] - y[2]) - y[3]).norm_sqr()));
    // The median, so that a narrow resonance does not count as noise.
    let noise = quantile(&third, 0.5).unwrap_or(0.0) / (std::f64::consts::LN_2 * ROUGHNESS_WEIGHT);
    let real: Vec<f64> = weighted.iter().map(|y| y.re * y.re.abs()).collect();
    let is_negative = real.iter().sum::<f64>() < -NEGATIVE_SIGMA * real.iter().map(|x| x * x).sum::<f64>().sqrt();
    let negative_ratio = if is_negative { 1.0 } else { f64::INFINITY };
    let senses: [Sense; 3] = [
        (
            |y| y.conj(),
            MIN_MIRRORED_RATIO,
            "the sign of the imaginary part is mirrored: only with the other sign does the sweep have a resonance. Negate the \
             column of the reactance, susceptance or angle; if the result is an inductor, impedance and admittance are \
             exchanged, or the topology is wrong",
        ),
        (
            |y| -y,
            negative_ratio,
            "the real part is negative at the resonance, and all angles are off by 180 degrees. Turn the current probe, or add \
             180 degrees to the angle",
        ),
        (
            |y| -y.conj(),
            negative_ratio,
            "the real part is negative at the resonance. `--series-ohm` may be too large, the fixture wrong, or the sign of \
             the real part mirrored",
        ),
    ];
    let passive = of(|y| y);
    let gains = senses.map(|(sense, ratio, what)| (of(sense), ratio, what));
    match gains.into_iter().max_by(|(a, ..), (b, ..)| a.total_cmp(b)) {
        Some((gain, ratio, what)) if gain > (ratio * passive).max(MIN_GAIN_SIGMA2 * noise) => {
            Err(ImportError::NotATransducer(what.to_owned()))
        }
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

#[cfg(test)]
mod tests {
    use super::super::circuit::{Branch, Equivalent};
    use super::super::coordinate::{Coordinate, Topology};
    use super::super::options::ModeChoice;
    use super::super::result::{Admittance, Mode};
    use super::super::{fit, fit::Fitter};
    use super::*;
    use crate::synthetic::random::Random;

    /// Branches of a narrow resonance, and of a wide one with a larger motional capacitance.
    const TWO: [(f64, f64, f64); 2] = [(40_123.4, 480.0, 23.7), (45e3, 5.0, 1500.0)];
    const SIX: [(f64, f64, f64); 6] = [
        (38_350.0, 150.0, 1360.0),
        (39_768.0, 165.0, 27.0),
        (40_430.0, 150.0, 190.0),
        (41_100.0, 200.0, 2000.0),
        (42_260.0, 120.0, 420.0),
        (43_300.0, 150.0, 3000.0),
    ];

    /// Returns a sweep of branches with frequency, Q and Rm, after a change of the admittance at
    /// each angular frequency.
    fn sweep(coordinate: Coordinate, branches: &[(f64, f64, f64)], change: impl Fn(f64, Complex64) -> Complex64) -> Measured {
        let branches = branches.iter().map(|&(hz, q, rm)| Branch { hz, q, siemens: rm.recip() }).collect();
        let circuit = Equivalent { c0_f: 3.6e-9, loss_tangent: 0.004, branches };
        let mut random = Random::new(7);
        let hz: Vec<f64> = (0..1201).map(|n| 38e3 + 6.0 * f64::from(n)).collect();
        let mut seen = |hz: &f64| {
            let noise = 1e-3 * Complex64::new(random.normal(), random.normal());
            let y = change(std::f64::consts::TAU * hz, circuit.admittance(*hz));
            if coordinate == Coordinate::Immittance {
                y * (1.0 + noise)
            } else {
                coordinate.admittance(coordinate.of(y) + 0.1 * noise)
            }
        };
        let seen: Vec<Complex64> = hz.iter().map(&mut seen).collect();
        Measured { hz, admittance: seen.clone(), seen, fixture: Vec::new(), coordinate, remarks: Vec::new() }
    }

    fn choose(measured: Measured, choice: Option<ModeChoice>) -> Result<Admittance, ImportError> {
        let fit = Fitter::new(&measured).fit(None)?;
        Admittance::from_fit("x".into(), measured, fit, choice)
    }

    #[test]
    fn each_wrong_sense_is_named_in_each_coordinate() {
        let ports = [Topology::OnePort, Topology::SeriesThrough].map(|topology| Coordinate::Scattering(topology, 50.0));
        let senses: [(Turned, &str); 3] =
            [(|y| y.conj(), "imaginary part is mirrored"), (|y| -y, "off by 180 degrees"), (|y| -y.conj(), "`--series-ohm`")];
        for coordinate in ports.into_iter().chain([Coordinate::Immittance]) {
            for branches in [&TWO[..1], &SIX] {
                for (sense, named) in senses {
                    let error = fit("x", sweep(coordinate, branches, |_, y| sense(y)), None).unwrap_err().to_string();
                    assert!(error.starts_with("not a transducer") && error.contains(named), "{coordinate:?}: {error}");
                }
            }
        }
    }

    #[test]
    fn the_cause_of_impossible_values_is_named() {
        let change = |named: &str, change: &dyn Fn(f64, Complex64) -> Complex64| {
            let error = fit("x", sweep(Coordinate::Immittance, &TWO[..1], change), None).unwrap_err().to_string();
            assert!(error.contains(named), "{error}");
        };
        change("milli instead of mega?", &|_, y| 1e-9 * y);
        change("milli instead of mega?", &|_, y| 1e6 * y);
        change("Disconnect a coil", &|omega, y| y + (Complex64::I * omega * 2e-3).inv());
        change("loss tangent -0.30", &|omega, y| y - 0.304 * omega * 3.6e-9);
    }

    #[test]
    fn the_working_mode_is_the_strongest_or_the_chosen_one() {
        let working = |choice: Option<&str>| {
            let choice = choice.map(|text| text.parse().unwrap());
            let found = choose(sweep(Coordinate::Immittance, &TWO, |_, y| y), choice).map_err(|error| error.to_string())?;
            Ok(found.circuit.series_resonance_hz.value.round())
        };
        for (choice, hz) in
            [(None, 40_123.0), (Some("1"), 40_123.0), (Some("2"), 45e3), (Some("40.2k"), 40_123.0), (Some("44900"), 45e3)]
        {
            let found: Result<f64, String> = working(choice);
            assert!(found.as_ref().is_ok_and(|found| (found - hz).abs() < 20.0), "{choice:?} {found:?}");
        }
        for choice in ["3", "30k"] {
            let error = working(Some(choice)).unwrap_err();
            assert!(error.starts_with("no such mode; the resonances are 1 at 40123"), "{error}");
        }
        assert!(["0", "9", "x", "-40k"].iter().all(|text| text.parse::<ModeChoice>().is_err()));
    }

    #[test]
    fn deviations_of_six_modes_cover_the_truth() {
        let found = choose(sweep(Coordinate::Immittance, &SIX, |_, y| y), None).unwrap();
        assert_eq!(found.modes.len(), 6);
        let far = |mode: &Mode, (hz, q, rm): (f64, f64, f64)| {
            let pairs = [(mode.series_resonance_hz, hz), (mode.q, q), (mode.rm_ohm, rm)];
            pairs.iter().any(|(value, truth)| (value.value - truth).abs() > 4.0 * value.sd || value.sd > 0.01 * truth)
        };
        assert!(!found.modes.iter().zip(SIX).any(|(mode, truth)| far(mode, truth)), "{:?}", found.modes);
        assert!(
            !found.is_doubtful() && found.warnings.iter().any(|warning| warning.contains("40430 Hz (Rm 190")),
            "{:?}",
            found.warnings
        );
        let scene = found.scene("x").unwrap();
        assert_eq!(
            (scene.matches("[[stack.mode]]").count(), scene.matches("series_resonance_hz = 404").count()),
            (3, 1),
            "{scene}"
        );
    }

    #[test]
    fn a_circuit_that_lacks_modes_is_doubtful() {
        let lacking = fit("x", sweep(Coordinate::Immittance, &SIX, |_, y| y), Some(2)).unwrap();
        assert!(lacking.is_doubtful() && lacking.warnings[0].contains("No scene is written"), "{:?}", lacking.warnings);
        let (rm, truth) = (lacking.circuit.rm_ohm, SIX[1].2);
        assert!((rm.value - truth).abs() < 2.0 * rm.sd && (rm.value - truth).abs() > 0.01 * truth, "{rm:?}");
    }
}
