//! Tests of the verdicts, and of some numbers against values from elsewhere.

use std::collections::HashSet;
use std::sync::LazyLock;

use super::claim::{Claim, Verdict};
use super::{Findings, compute};

pub(crate) static FINDINGS: LazyLock<Findings> = LazyLock::new(|| compute(&mut |_| ()).expect("all studies have a result"));

fn claim(id: &str) -> &'static Claim {
    FINDINGS.claims.iter().find(|claim| claim.id == id).expect(id)
}

fn value(id: &str, check: usize, name: &str) -> f64 {
    let numbers = &claim(id).checks[check].numbers;
    numbers.iter().find(|number| number.0 == name).unwrap_or_else(|| panic!("{name} is not in {numbers:?}")).1
}

#[test]
fn verdicts() {
    use Verdict::{Conditional, Refuted, Reproduced};
    let expected = VERDICTS.map(|(id, letter)| {
        let verdict = match letter {
            'r' => Reproduced,
            'c' => Conditional,
            _ => Refuted,
        };
        (id, verdict)
    });
    let found: Vec<(&str, Verdict)> = FINDINGS.claims.iter().map(|claim| (claim.id, claim.verdict())).collect();
    assert_eq!(found, expected);
    let ids: HashSet<&str> = found.iter().map(|(id, _)| *id).collect();
    assert_eq!(ids.len(), found.len(), "duplicate id");
}

/// Expected verdicts; r: reproduced, c: conditional, x: refuted.
const VERDICTS: [(&str, char); 94] = [
    ("rod-frequencies", 'r'),
    ("stepped-horn-gain", 'r'),
    ("prestress-raises-the-limit", 'c'),
    ("node-in-the-ceramics", 'r'),
    ("stack-at-40-khz", 'c'),
    ("load-raises-friction", 'r'),
    ("vibration-lowers-friction", 'r'),
    ("low-speed-reduces-more", 'r'),
    ("up-to-68-percent", 'c'),
    ("load-lowers-reduction", 'c'),
    ("load-cell-shows-the-mean", 'c'),
    ("normal-vibration-lowers-friction", 'r'),
    ("up-to-58-percent", 'c'),
    ("on-time-bottoms-out", 'c'),
    ("friction-falls-gradually", 'r'),
    ("load-raises-pull", 'r'),
    ("load-lowers-normal-reduction", 'r'),
    ("amplitude-raises-reduction", 'r'),
    ("amplitude-idle-at-450-n", 'c'),
    ("amplitude-makes-up-for-load", 'c'),
    ("power-at-670-n", 'r'),
    ("speed-lowers-normal-reduction", 'r'),
    ("coulomb-knows-one-ratio", 'c'),
    ("lugre-becomes-dahl", 'c'),
    ("coulomb-reduces-more", 'r'),
    ("dahl-depends-on-m-mu-kt", 'r'),
    ("less-reduction-at-higher-ratio", 'r'),
    ("coulomb-pulses", 'r'),
    ("decays-to-steady-state", 'c'),
    ("averages-stay", 'r'),
    ("natural-part-lowers-friction", 'r'),
    ("fast-excitation-suppresses", 'r'),
    ("two-frequencies", 'c'),
    ("friction-combination-frequencies", 'r'),
    ("power-ratio-equation", 'x'),
    ("power-ratio-depends", 'r'),
    ("force-lowers-friction", 'r'),
    ("force-raises-power", 'c'),
    ("low-ratio-needs-power", 'c'),
    ("mu-raises-friction-ratio", 'c'),
    ("mu-lowers-power-ratio", 'c'),
    ("mu-lowers-input-and-stored", 'r'),
    ("load-raises-friction-ratio", 'c'),
    ("load-flattens", 'r'),
    ("load-lowers-power-ratio", 'c'),
    ("low-ratio-low-power", 'c'),
    ("spring-energy-small", 'x'),
    ("load-raises-stored", 'x'),
    ("stiff-contact-reduces-unexcited", 'c'),
    ("hard-contact-helps", 'c'),
    ("stiff-contact-more-friction", 'r'),
    ("unexcited-power-below-unity", 'c'),
    ("unexcited-power-falls-with-kt", 'c'),
    ("stiff-contact-stores-more", 'c'),
    ("self-excited-oscillation", 'c'),
    ("free-oscillation-is-small", 'r'),
    ("friction-sets-free-amplitude", 'r'),
    ("resonance-lowers-friction", 'r'),
    ("resonance-raises-power", 'r'),
    ("low-stiffness-power-unaffected", 'c'),
    ("resonance-has-a-finite-velocity", 'c'),
    ("operate-at-resonance", 'c'),
    ("system-model-conforms", 'c'),
    ("zero-friction-unattainable", 'x'),
    ("square-resembles-coulomb", 'c'),
    ("sawtooth-higher-friction", 'c'),
    ("chirp-force-follows", 'r'),
    ("fourier-fails-for-chirp", 'c'),
    ("power-has-many-frequencies", 'r'),
    ("square-best-kinematic", 'c'),
    ("square-highest-power-kinematic", 'c'),
    ("random-displaces-little", 'c'),
    ("chirp-largest-displacement", 'c'),
    ("chirp-largest-velocity", 'c'),
    ("chirp-friction-bottoms-lower", 'c'),
    ("chirp-power-peaks-higher", 'c'),
    ("chirp-best-oscillator", 'c'),
    ("chirp-highest-power", 'c'),
    ("bending-wave-number", 'r'),
    ("particle-ellipse", 'r'),
    ("rotor-towards-source", 'r'),
    ("tens-and-hundreds", 'c'),
    ("twenty-nanometres", 'r'),
    ("teeth-amplify", 'c'),
    ("tabs-fill-sheet", 'r'),
    ("four-signals-travel", 'c'),
    ("all-pass-quadrature", 'c'),
    ("charge-makes-erratic", 'x'),
    ("amplifier-makes-erratic", 'x'),
    ("shapes-are-erratic", 'c'),
    ("voltage-raises-speed", 'c'),
    ("opposing-waves-turn", 'c'),
    ("friction-prevents-slip", 'c'),
    ("low-torque", 'c'),
];

#[test]
fn every_number_is_finite() {
    let checks = FINDINGS.claims.iter().flat_map(|claim| &claim.checks).chain(FINDINGS.errata.iter().map(|e| &e.evidence));
    for check in checks {
        assert!(!check.numbers.is_empty() && check.numbers.iter().all(|(_, value)| value.is_finite()), "{check:?}");
    }
    for choice in &FINDINGS.choices {
        assert!(choice.numbers.iter().all(|(_, value)| value.is_finite()), "{choice:?}");
    }
}

#[test]
fn every_contradiction_is_shown() {
    for erratum in &FINDINGS.errata {
        assert!(erratum.evidence.holds, "{erratum:?}");
    }
}

#[test]
fn every_thesis_figure_exists_with_curves() {
    let ids: Vec<&str> = FINDINGS.figures.iter().map(|figure| figure.id.as_str()).collect();
    for number in ["05", "07", "08", "10", "11", "12", "13"] {
        assert!(ids.contains(&format!("fig-2-{number}").as_str()), "figure 2.{number} is not in {ids:?}");
    }
    for number in ["04a", "04b", "05a", "05b", "07", "08", "09", "10", "11", "12"] {
        assert!(ids.contains(&format!("fig-3-{number}").as_str()), "figure 3.{number} is not in {ids:?}");
    }
    for number in 6..=26 {
        let stem = format!("fig-4-{number:02}");
        assert!(ids.iter().any(|id| id.starts_with(&stem)), "{stem} is not in {ids:?}");
    }
    for id in ["fig-b-06", "app-b-wave-number", "app-b-pattern", "app-b-pattern-groups", "app-b-backward", "app-b-causes"] {
        assert!(ids.contains(&id), "{id} is not in {ids:?}");
    }
    for figure in &FINDINGS.figures {
        let finite = |y: &[f64]| y.iter().all(|value| value.is_finite());
        assert!(!figure.series.is_empty() && figure.series.iter().all(|s| s.x.len() > 10 && finite(&s.y)), "{}", figure.id);
        assert!(figure.caption.len() > 40, "{}", figure.id);
    }
}

/// Values of a feasibility study in 34 to 40 digits: steady Dahl by closed form, two runs from rest
/// by a Taylor series.
#[test]
fn numbers_agree_with_an_independent_study() {
    let near = |found: f64, expected: f64, within: f64| assert!((found - expected).abs() < within, "{found} {expected}");
    near(value("coulomb-reduces-more", 0, "r Dahl(0.5)"), 0.674_948_667, 1e-9);
    near(value("force-lowers-friction", 1, "r(384 N)"), 0.6571, 5e-5);
    near(value("force-lowers-friction", 1, "r(1920 N)"), 0.4973, 5e-5);
    near(value("decays-to-steady-state", 0, "time constant (negative: grows) [s]"), 0.154, 5e-4);
    near(value("system-model-conforms", 2, "r oscillator(0.1)"), 0.148_749_778, 1e-5);
    near(value("square-best-kinematic", 1, "r(square)"), 0.455_98, 1e-5);
    near(value("square-best-kinematic", 1, "r(sawtooth)"), 0.743_81, 1e-5);
    near(value("chirp-best-oscillator", 0, "r(chirp)"), 0.1538, 5e-5);
}

/// Values of appendix B, computed by hand or in an earlier study.
#[test]
fn numbers_of_appendix_b_agree_with_an_independent_study() {
    let near = |found: f64, expected: f64, within: f64| assert!((found - expected).abs() < within, "{found} {expected}");
    near(value("bending-wave-number", 0, "k at 20 kHz [rad/m]"), 384.0, 0.5);
    near(value("bending-wave-number", 0, "k at 40 kHz [rad/m]"), 543.0, 0.5);
    near(value("rotor-towards-source", 0, "40 kHz [mm/s]"), -1.39, 5e-3);
    // 390e-12 m/V times 60 V; 190e-12 m/V times 60 V times 2.85/0.040.
    near(value("tens-and-hundreds", 0, "d33 V [nm]"), 23.4, 1e-9);
    near(value("tens-and-hundreds", 0, "d31 V L/t [nm]"), -812.25, 1e-9);
    near(value("amplifier-makes-erratic", 1, "by projection of samples"), 0.0875, 5e-5);
    near(value("charge-makes-erratic", 0, "lag of the far end [deg]"), 0.41, 5e-3);
}

/// Values of chapter 3, computed in an earlier study: reductions in per cent.
#[test]
fn numbers_of_the_experiments_agree_with_an_independent_study() {
    let near = |found: f64, expected: f64, within: f64| assert!((found - expected).abs() < within, "{found} {expected}");
    near(value("low-speed-reduces-more", 0, "reduction at 0.038 m/s, no load [%]"), 67.4, 0.1);
    near(value("low-speed-reduces-more", 0, "at 0.068 m/s [%]"), 44.3, 0.1);
    near(value("up-to-68-percent", 1, "reduction, no load [%]"), 68.2, 0.1);
    assert!(value("load-lowers-reduction", 0, "fall to 10 N [points]") < 1.0);
    near(value("up-to-58-percent", 0, "reduction [%]"), 11.466, 5e-4);
    near(value("up-to-58-percent", 3, "a/d0"), 197.0, 1.0);
    near(value("up-to-58-percent", 4, "reduction [%]"), 58.0, 0.15);
    near(value("on-time-bottoms-out", 0, "reduction [%](0.5 s)"), 39.4, 0.5);
    near(value("on-time-bottoms-out", 0, "reduction [%](1 s)"), 52.3, 0.5);
    near(value("on-time-bottoms-out", 0, "reduction [%](2.5 s)"), 58.5, 0.15);
    near(value("power-at-670-n", 0, "power [W]"), 1200.0, 6.0);
}
