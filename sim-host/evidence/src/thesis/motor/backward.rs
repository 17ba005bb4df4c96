//! The wave that goes back when the two standing waves of a travelling one are not equal, or not a quarter period apart.
//!
//! `cos kx cos wt + (1 + g) sin kx sin(wt + eps)` is a wave `|1 + (1 + g) e^(i eps)|/2` forward and `|1 - (1 + g) e^(i eps)|/2`
//! backward.

use std::f64::consts::TAU;

use realfft::num_complex::Complex64;

use crate::thesis::claim::number;
use crate::thesis::picture::{figure as draw, line, ranged};
use crate::thesis::sweep;
use report::{Figure, Marker, Series, Style};

/// Two standing waves that should make a travelling one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Errors {
    /// What the second signal is late or early, rad.
    pub phase_rad: f64,
    /// What the second wave is stronger, as a part of the first.
    pub gain: f64,
}

/// The phase error that the amplifier adds, degrees (B.6).
pub const AMPLIFIER_DEG: [f64; 2] = [5.0, 10.0];

impl Errors {
    /// A phase error by itself, degrees.
    pub fn degrees(degrees: f64) -> Errors {
        Errors { phase_rad: degrees.to_radians(), gain: 0.0 }
    }

    /// Backward wave over forward wave: tan(eps/2) for phase alone, g/(2 + g) for gain alone.
    pub fn backward(&self) -> f64 {
        let second = Complex64::from_polar(1.0 + self.gain, self.phase_rad);
        (1.0 - second).norm() / (1.0 + second).norm()
    }

    /// Displacement at k x and w t.
    fn field(&self, kx: f64, wt: f64) -> f64 {
        kx.cos() * wt.cos() + (1.0 + self.gain) * kx.sin() * (wt + self.phase_rad).sin()
    }

    /// The backward wave over the forward one, by projecting samples of the displacement, as of a scanning vibrometer, on both
    /// waves.
    pub fn backward_by_projection(&self) -> f64 {
        const N: u32 = 24;
        let angle = |i: u32| TAU * f64::from(i) / f64::from(N);
        let onto = |sense: f64| {
            let mut sum = Complex64::default();
            for x in 0..N {
                for t in 0..N {
                    sum += Complex64::from_polar(self.field(angle(x), angle(t)), -(angle(t) - sense * angle(x)));
                }
            }
            sum.norm()
        };
        onto(-1.0) / onto(1.0)
    }

    /// The backward wave over the forward one, by the largest and the smallest amplitude along the wave: (S - 1)/(S + 1) of the
    /// standing wave ratio S.
    pub fn backward_by_envelope(&self) -> f64 {
        let along =
            (0..4000).map(|i| TAU * f64::from(i) / 4000.0).map(|kx| self.field(kx, 0.0).hypot(self.field(kx, 0.25 * TAU)));
        let (low, high) = along.fold((f64::INFINITY, 0.0_f64), |(low, high), a| (low.min(a), high.max(a)));
        (high - low) / (high + low)
    }

    /// The three results, named.
    pub fn numbers(&self, name: &str) -> Vec<(String, f64)> {
        vec![
            number(format!("backward over forward, {name}"), self.backward()),
            number("by projection of samples", self.backward_by_projection()),
            number("by largest and smallest amplitude", self.backward_by_envelope()),
        ]
    }
}

/// Standing wave ratio of a backward part.
pub fn standing_wave_ratio(backward: f64) -> f64 {
    (1.0 + backward) / (1.0 - backward)
}

/// Backward wave over phase error.
pub fn figure() -> Figure {
    let fine = sweep::spaced(0.0, 45.0, 181);
    let coarse = sweep::spaced(0.0, 45.0, 19);
    let curve = |gain: f64, degrees: &[f64], of: &dyn Fn(&Errors) -> f64| {
        degrees.iter().map(|&degrees| 100.0 * of(&Errors { gain, ..Errors::degrees(degrees) })).collect::<Vec<_>>()
    };
    let points = |name: &str, csv: &str, y: Vec<f64>| Series { style: Style::Points, ..line(name, csv, &coarse, y) };
    let series = vec![
        line("equal amplitudes: tan(eps/2)", "backward_percent", &fine, curve(0.0, &fine, &Errors::backward)),
        line("one 10 % too large", "backward_gain_10_percent", &fine, curve(0.1, &fine, &Errors::backward)),
        points("by projection", "projected_percent", curve(0.0, &coarse, &Errors::backward_by_projection)),
        points("by the envelope", "envelope_percent", curve(0.1, &coarse, &Errors::backward_by_envelope)),
    ];
    let caption = "Backward wave over forward wave when sine and cosine are not a quarter period apart: closed form, and dots where the \
                   displacement of both standing waves was sampled in place and time and taken apart again. The amplifier's 5 to 10 \
                   degrees (B.6) send 4.4 to 8.7 % back."
        .into();
    let axes = [ranged("phase error [deg]", 0.0, 45.0), ranged("backward wave [%]", 0.0, 45.0)];
    let mut drawn = draw("app-b-backward", "Appendix B.6: backward wave over phase error", caption, axes, series);
    drawn.markers = AMPLIFIER_DEG
        .map(|degrees| {
            let percent = 100.0 * Errors::degrees(degrees).backward();
            Marker { x: degrees, y: percent, label: format!("{percent:.1} %") }
        })
        .to_vec();
    drawn
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_ways_agree() {
        for (degrees, gain) in [(0.0, 0.1), (5.0, 0.0), (10.0, 0.0), (10.0, 0.1), (-30.0, -0.2), (80.0, 0.5)] {
            let errors = Errors { gain, ..Errors::degrees(degrees) };
            let (closed, projected, envelope) =
                (errors.backward(), errors.backward_by_projection(), errors.backward_by_envelope());
            assert!((closed - projected).abs() < 1e-12, "{errors:?}: {closed} {projected}");
            // The smallest amplitude falls between samples that are d = 2 pi/4000 apart, at most d/2 off: it is too large by
            // (d/2)^2 (S^2 - 1)/2 of itself, and the ratio too small by less than (d/2)^2 S.
            let within = (TAU / 8000.0).powi(2) * standing_wave_ratio(closed);
            assert!((closed - envelope).abs() < within, "{errors:?}: {closed} {envelope}");
        }
    }

    #[test]
    fn closed_forms() {
        assert!((Errors::degrees(10.0).backward() - 5f64.to_radians().tan()).abs() < 1e-15);
        assert!((Errors { phase_rad: 0.0, gain: 0.1 }.backward() - 0.1 / 2.1).abs() < 1e-15);
        assert!((standing_wave_ratio(Errors::degrees(10.0).backward()) - 1.19).abs() < 5e-3);
    }
}
