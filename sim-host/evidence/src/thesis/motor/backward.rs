//! The backward wave that arises if the two standing waves of a travelling wave differ in amplitude
//! or are not a quarter period apart.
//!
//! `cos kx cos wt + (1 + g) sin kx sin(wt + eps)` is a forward wave of amplitude
//! `|1 + (1 + g) e^(i eps)|/2` and a backward wave of amplitude `|1 - (1 + g) e^(i eps)|/2`.

use std::f64::consts::TAU;

use realfft::num_complex::Complex64;

use crate::thesis::claim::number;
use crate::thesis::picture::{figure as draw, line, ranged};
use crate::thesis::sweep;
use report::{Figure, Marker, Series, Style};

/// Errors of the second of two standing waves that should form a travelling wave.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StandingWaveErrors {
    /// Phase error of the second signal, rad.
    pub phase_rad: f64,
    /// Excess amplitude of the second wave, relative to the first.
    pub gain: f64,
}

/// Range of the phase error that the amplifier adds, degrees (B.6).
pub const AMPLIFIER_DEG: [f64; 2] = [5.0, 10.0];

impl StandingWaveErrors {
    /// Creates a phase error alone, degrees.
    pub fn degrees(degrees: f64) -> StandingWaveErrors {
        StandingWaveErrors { phase_rad: degrees.to_radians(), gain: 0.0 }
    }

    /// Returns backward wave over forward wave: tan(eps/2) for phase alone, g/(2 + g) for gain
    /// alone.
    pub fn backward(&self) -> f64 {
        let second = Complex64::from_polar(1.0 + self.gain, self.phase_rad);
        (1.0 - second).norm() / (1.0 + second).norm()
    }

    /// Returns the displacement at k x and w t.
    fn field(&self, kx: f64, wt: f64) -> f64 {
        kx.cos() * wt.cos() + (1.0 + self.gain) * kx.sin() * (wt + self.phase_rad).sin()
    }

    /// Returns backward wave over forward wave, by projecting samples of the displacement, as of a
    /// scanning vibrometer, on both waves.
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

    /// Returns backward wave over forward wave, from the largest and the smallest amplitude along
    /// the wave: (S - 1)/(S + 1) with the standing wave ratio S.
    pub fn backward_by_envelope(&self) -> f64 {
        let along =
            (0..4000).map(|i| TAU * f64::from(i) / 4000.0).map(|kx| self.field(kx, 0.0).hypot(self.field(kx, 0.25 * TAU)));
        let (low, high) = along.fold((f64::INFINITY, 0.0_f64), |(low, high), a| (low.min(a), high.max(a)));
        (high - low) / (high + low)
    }

    /// Returns the three results with their names.
    pub fn numbers(&self, name: &str) -> Vec<(String, f64)> {
        vec![
            number(format!("backward over forward, {name}"), self.backward()),
            number("by projection of samples", self.backward_by_projection()),
            number("by largest and smallest amplitude", self.backward_by_envelope()),
        ]
    }
}

/// Returns the standing wave ratio for a backward wave.
pub fn standing_wave_ratio(backward: f64) -> f64 {
    (1.0 + backward) / (1.0 - backward)
}

/// Draws backward wave over phase error.
pub fn figure() -> Figure {
    let fine = sweep::spaced(0.0, 45.0, 181);
    let coarse = sweep::spaced(0.0, 45.0, 19);
    let curve = |gain: f64, degrees: &[f64], of: &dyn Fn(&StandingWaveErrors) -> f64| {
        degrees
            .iter()
            .map(|&degrees| 100.0 * of(&StandingWaveErrors { gain, ..StandingWaveErrors::degrees(degrees) }))
            .collect::<Vec<_>>()
    };
    let points = |name: &str, csv: &str, y: Vec<f64>| Series { style: Style::Points, ..line(name, csv, &coarse, y) };
    let series = vec![
        line("equal amplitudes: tan(eps/2)", "backward_percent", &fine, curve(0.0, &fine, &StandingWaveErrors::backward)),
        line("one 10 % too large", "backward_gain_10_percent", &fine, curve(0.1, &fine, &StandingWaveErrors::backward)),
        points("by projection", "projected_percent", curve(0.0, &coarse, &StandingWaveErrors::backward_by_projection)),
        points("by the envelope", "envelope_percent", curve(0.1, &coarse, &StandingWaveErrors::backward_by_envelope)),
    ];
    let caption = "Backward wave over forward wave if sine and cosine are not a quarter period apart. Lines: closed form. \
                   Dots: both standing waves sampled in place and time and separated again. The amplifier's 5 to 10 degrees \
                   (B.6) cause 4.4 to 8.7 %."
        .into();
    let axes = [ranged("phase error [deg]", 0.0, 45.0), ranged("backward wave [%]", 0.0, 45.0)];
    let mut drawn = draw("app-b-backward", "Appendix B.6: backward wave over phase error", caption, axes, series);
    drawn.markers = AMPLIFIER_DEG
        .map(|degrees| {
            let percent = 100.0 * StandingWaveErrors::degrees(degrees).backward();
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
            let errors = StandingWaveErrors { gain, ..StandingWaveErrors::degrees(degrees) };
            let (closed, projected, envelope) =
                (errors.backward(), errors.backward_by_projection(), errors.backward_by_envelope());
            assert!((closed - projected).abs() < 1e-12, "{errors:?}: {closed} {projected}");
            // Samples are d = 2 pi/4000 apart, so the smallest amplitude is missed by at most d/2.
            // It is too large by (d/2)^2 (S^2 - 1)/2 of itself, and the ratio too small by less
            // than (d/2)^2 S.
            let within = (TAU / 8000.0).powi(2) * standing_wave_ratio(closed);
            assert!((closed - envelope).abs() < within, "{errors:?}: {closed} {envelope}");
        }
    }

    #[test]
    fn closed_forms() {
        assert!((StandingWaveErrors::degrees(10.0).backward() - 5f64.to_radians().tan()).abs() < 1e-15);
        assert!((StandingWaveErrors { phase_rad: 0.0, gain: 0.1 }.backward() - 0.1 / 2.1).abs() < 1e-15);
        assert!((standing_wave_ratio(StandingWaveErrors::degrees(10.0).backward()) - 1.19).abs() < 5e-3);
    }
}
