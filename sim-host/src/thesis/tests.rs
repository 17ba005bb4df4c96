//! The verdicts, and some numbers against values that do not come from here.

use std::collections::HashSet;
use std::path::Path;
use std::sync::LazyLock;

use super::claim::{Claim, Verdict};
use super::{Findings, conduct, table};

static FINDINGS: LazyLock<Findings> = LazyLock::new(|| conduct(&mut |_, _, _| ()).expect("all studies have an answer"));

fn claim(id: &str) -> &'static Claim {
    FINDINGS.claims.iter().find(|claim| claim.id == id).expect(id)
}

fn value(id: &str, check: usize, name: &str) -> f64 {
    let numbers = &claim(id).checks[check].numbers;
    numbers.iter().find(|number| number.0 == name).unwrap_or_else(|| panic!("{name} is none of {numbers:?}")).1
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
    assert_eq!(ids.len(), found.len(), "an id stands twice");
}

/// r: reproduced, c: conditional, x: refuted.
const VERDICTS: [(&str, char); 72] = [
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
fn every_number_is_one() {
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
fn every_figure_of_the_thesis_is_there_and_has_curves() {
    let ids: Vec<&str> = FINDINGS.figures.iter().map(|figure| figure.id.as_str()).collect();
    for number in 6..=26 {
        let stem = format!("fig-4-{number:02}");
        assert!(ids.iter().any(|id| id.starts_with(&stem)), "{stem} is none of {ids:?}");
    }
    for id in ["fig-b-06", "app-b-wave-number", "app-b-pattern", "app-b-pattern-groups", "app-b-backward", "app-b-causes"] {
        assert!(ids.contains(&id), "{id} is none of {ids:?}");
    }
    for figure in &FINDINGS.figures {
        let finite = |y: &[f64]| y.iter().all(|value| value.is_finite());
        assert!(!figure.series.is_empty() && figure.series.iter().all(|s| s.x.len() > 10 && finite(&s.y)), "{}", figure.id);
        assert!(figure.caption.len() > 40, "{}", figure.id);
    }
}

/// A feasibility study in 34 to 40 digits gave these: steady Dahl by closed form, two runs from rest by a Taylor series.
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

/// Appendix B, computed by hand or by the study that went before.
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

/// `UPDATE_DOCS=1 cargo test -p sim-host thesis` writes the tables anew.
#[test]
fn the_documentation_has_these_numbers() {
    const MARK: &str = "<!-- tables: printed by `sim-host thesis` -->\n";
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/thesis-errata.md");
    let text = std::fs::read_to_string(&path).expect("the page is there");
    let (head, tables) = text.split_once(MARK).expect("the page has its mark");
    let expected = format!("\n{}", table::markdown(&FINDINGS));
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::write(&path, format!("{head}{MARK}{expected}")).expect("the page can be written");
    } else {
        assert!(tables == expected, "docs/thesis-errata.md has other numbers; run with UPDATE_DOCS=1");
    }
}
