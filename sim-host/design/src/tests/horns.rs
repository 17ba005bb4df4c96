//! Closed forms of rods and horns of half a wavelength.

use super::{cylinder, design, solved};
use crate::keys::{Design, Element, Kind};
use std::f64::consts::{PI, TAU};

/// Returns the speed of sound in the light metal, m/s.
fn sound() -> f64 {
    (71e9_f64 / 2800.0).sqrt()
}

/// Returns the root of a function in a range.
fn root(of: impl Fn(f64) -> f64, (mut low, mut high): (f64, f64)) -> f64 {
    let sign = of(high) > 0.0;
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if (of(middle) > 0.0) == sign { high = middle } else { low = middle }
    }
    0.5 * (low + high)
}

/// Returns frequency and gain of the first mode of a horn.
fn first(kind: Kind, length_m: f64, diameters: [f64; 2]) -> (f64, f64) {
    let horn = Element { kind, end_diameter_m: Some(diameters[1]), ..cylinder("light", length_m, diameters[0]) };
    let found = solved(&Design { q: Some(1e6), ..design(vec![horn]) });
    (found.working().series_resonance_hz, found.operating.tip_m / found.operating.back_m)
}

#[test]
fn free_rod_has_multiples_of_half_a_wavelength() {
    let found = solved(&design(vec![cylinder("light", 0.06, 0.02), cylinder("light", 0.04, 0.02)]));
    assert_eq!(found.modes.len(), 5);
    for (index, mode) in found.modes.iter().enumerate() {
        let exact = (index + 1) as f64 * sound() / 0.2;
        assert!((mode.series_resonance_hz / exact - 1.0).abs() < 1e-9, "{index}: {}", mode.series_resonance_hz);
        assert!((mode.q / 5000.0 - 1.0).abs() < 1e-6, "{index}: {}", mode.q);
    }
    let nodes = &found.operating.nodes_m;
    assert!(nodes.len() == 1 && (nodes[0] - 0.05).abs() < 1e-9, "{nodes:?}");
}

/// Two quarter wavelengths: the gain is the ratio of the areas.
#[test]
fn stepped_horn_has_the_ratio_of_its_areas() {
    let quarter = sound() / 20e3 / 4.0;
    let steps = vec![cylinder("light", quarter, 0.04), cylinder("light", quarter, 0.016)];
    let found = solved(&Design { q: Some(1e6), ..design(steps) });
    assert!((found.working().series_resonance_hz / 20e3 - 1.0).abs() < 1e-9);
    let gain = found.operating.tip_m / found.operating.back_m;
    assert!((gain / 6.25 - 1.0).abs() < 1e-9, "{gain}");
}

/// `f = c / 2 L sqrt(1 + (ln(D1/D2) / pi)^2)`, gain `D1 / D2`.
#[test]
fn exponential_horn_has_its_closed_form() {
    for diameters in [[0.04, 0.01], [0.02, 0.03]] {
        let (hz, gain) = first(Kind::Exponential, 0.12, diameters);
        let ratio: f64 = diameters[0] / diameters[1];
        let exact = sound() / 0.24 * (1.0 + (ratio.ln() / PI).powi(2)).sqrt();
        assert!((hz / exact - 1.0).abs() < 1e-9 && (gain / ratio - 1.0).abs() < 1e-9, "{hz} {exact} {gain}");
    }
}

/// `tan kL = kL (D2 - D1)^2 / (D1 D2 (kL)^2 + (D2 - D1)^2)`.
#[test]
fn conical_horn_has_its_closed_form() {
    for [d1, d2] in [[0.04, 0.01], [0.02, 0.03]] {
        let (hz, gain) = first(Kind::Cone, 0.12, [d1, d2]);
        let square = (d2 - d1) * (d2 - d1);
        let kl = root(|kl: f64| kl.tan() - kl * square / (d1 * d2 * kl * kl + square), (0.6 * PI, 1.45 * PI));
        let exact_gain = d1 / d2 * (kl.cos() + (d2 - d1) / (d1 * kl) * kl.sin());
        assert!((TAU * hz * 0.12 / sound() / kl - 1.0).abs() < 1e-9, "{hz}");
        assert!((gain / exact_gain.abs() - 1.0).abs() < 1e-9, "{gain} {exact_gain}");
    }
}

/// `K L tan K L = -g L tanh g L` with `cosh g L = D1 / D2`; gain `D1 / (D2 cos K L)`.
#[test]
fn catenoidal_horn_has_its_closed_form() {
    let rate = 4.0_f64.acosh();
    let kl = root(|kl: f64| kl * kl.tan() + rate * rate.tanh(), (0.501 * PI, PI));
    let exact = sound() / (TAU * 0.12) * (kl * kl + rate * rate).sqrt();
    let exact_gain = (4.0 / kl.cos()).abs();
    let (hz, gain) = first(Kind::Catenoidal, 0.12, [0.04, 0.01]);
    assert!((hz / exact - 1.0).abs() < 1e-9 && (gain / exact_gain - 1.0).abs() < 1e-9, "{hz} {exact} {gain} {exact_gain}");
    let (hz, gain) = first(Kind::Catenoidal, 0.12, [0.01, 0.04]);
    assert!((hz / exact - 1.0).abs() < 1e-9 && (gain * exact_gain - 1.0).abs() < 1e-9, "{hz} {gain}");
}
