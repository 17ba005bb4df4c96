//! Effects of temperature and amplitude on the elements of a stack.
//!
//! ```text
//! fs  = fs0 + a T + d |Im|^2                        C0  = C00 (1 + c T)
//! Rm  = Rm0 (1 + g(b |Im|^2)) (1 + r T)             phi = phi0 (1 + p T)
//! g(x) = x, or x / (1 + x / (m - 1)) if the amplitude raises Rm at most m-fold
//! ```
//!
//! `T` is the rise over ambient, `|Im|` the amplitude of the motional current. The motional
//! inductance is constant, so `Cm = 1 / (omega_s^2 Lm)`, and the quality factor is constant too,
//! apart from Rm's own law. To first order in the shift this is the cubic spring of Duffing (1918).
//! `d` in Hz/A^2 is three eighths of the cubic over the linear stiffness, times `fs`, times the
//! square of the displacement of one ampere. Piezoceramics soften: `d < 0`.
//!
//! Takahashi, Hirose and Uchino found that the loss of lead zirconate titanate grows with the
//! square of the vibration velocity (J. Am. Ceram. Soc. 77, 2429, 1994, abstract). In soft ceramic
//! Q falls to a fixed level (Xue et al., Sensors 25, 349, 2025, abstract), which is the second form
//! of `g`. The force factor changes mainly with the temperature (Umeda, Nakamura and Ueha,
//! abstract). It couples the same mass, spring and damper to the terminals: `Lm`, `1/Cm` and `Rm`
//! scale with `1/phi^2`, and it affects neither resonance nor Q.
//!
//! The amplitude is that at the beginning of the block, at any frequency; within a block it changes
//! by the block's fraction of the ring-up time. The shift of the resonance is limited to
//! [`MAX_SHIFT_REL`], and the factors of Rm, C0 and phi to [`LAW_FACTORS`]: the laws are first
//! terms of series.

use crate::circuit::Circuit;
use scene::LAW_FACTORS;

/// Largest shift of the resonance by temperature and amplitude together, relative.
pub const MAX_SHIFT_REL: f64 = 0.2;

/// Coefficients by which temperature and amplitude change the elements.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shift {
    /// Series resonance over temperature, Hz/K.
    temperature_hz_per_k: f64,
    /// Clamped capacitance over temperature, relative, 1/K.
    temperature_c0_per_k: f64,
    /// Series resonance over the squared amplitude of the motional current, Hz/A^2.
    duffing_hz_per_a2: f64,
    /// Motional resistance over temperature, relative, 1/K.
    temperature_rm_per_k: f64,
    /// Force factor over temperature, relative, 1/K.
    temperature_force_factor_per_k: f64,
    /// Motional resistance over the squared amplitude of the motional current, relative, 1/A^2.
    amplitude_rm_per_a2: f64,
    /// Largest factor by which the amplitude raises the motional resistance.
    amplitude_rm_most: Option<f64>,
}

/// Limits a factor to the range of the laws.
fn limited(factor: f64) -> f64 {
    factor.clamp(LAW_FACTORS.0, LAW_FACTORS.1)
}

impl Shift {
    /// Returns the coefficients of a scene; `None` if neither temperature nor amplitude has an
    /// effect.
    pub fn from_bvd(bvd: &scene::Bvd) -> Option<Self> {
        let shift = Shift {
            temperature_hz_per_k: bvd.temperature_hz_per_k,
            temperature_c0_per_k: bvd.temperature_c0_per_k,
            duffing_hz_per_a2: bvd.duffing_hz_per_a2,
            temperature_rm_per_k: bvd.temperature_rm_per_k,
            temperature_force_factor_per_k: bvd.temperature_force_factor_per_k,
            amplitude_rm_per_a2: bvd.amplitude_rm_per_a2,
            amplitude_rm_most: bvd.amplitude_rm_most,
        };
        (shift != Shift { amplitude_rm_most: shift.amplitude_rm_most, ..Shift::default() }).then_some(shift)
    }

    /// Returns the circuit at a temperature over ambient, K, and an amplitude of the motional
    /// current, A.
    pub fn apply(&self, rest: &Circuit, temperature_k: f64, amplitude_a: f64) -> Circuit {
        let hz = rest.series_resonance_hz();
        let by = self.temperature_hz_per_k * temperature_k + self.duffing_hz_per_a2 * amplitude_a * amplitude_a;
        let c0_f =
            rest.c0_f * (1.0 + (self.temperature_c0_per_k * temperature_k).clamp(LAW_FACTORS.0 - 1.0, LAW_FACTORS.1 - 1.0));
        let moved = Circuit { c0_f, ..rest.with_series_resonance(hz + by.clamp(-MAX_SHIFT_REL * hz, MAX_SHIFT_REL * hz)) };
        let rm = self.by_amplitude(amplitude_a) * limited(1.0 + self.temperature_rm_per_k * temperature_k);
        let coupling = limited(1.0 + self.temperature_force_factor_per_k * temperature_k);
        let square = coupling * coupling;
        Circuit {
            cm_f: moved.cm_f * square,
            lm_h: moved.lm_h / square,
            rm_ohm: moved.rm_ohm * rm / square,
            force_factor_n_per_v: moved.force_factor_n_per_v * coupling,
            ..moved
        }
    }

    /// Returns the factor of the motional resistance at an amplitude of the motional current, A.
    fn by_amplitude(&self, amplitude_a: f64) -> f64 {
        let raised = self.amplitude_rm_per_a2 * amplitude_a * amplitude_a;
        limited(1.0 + self.amplitude_rm_most.map_or(raised, |most| raised / (1.0 + raised / (most - 1.0))))
    }

    /// Returns the relative increase of the motional resistance per kelvin at the same motional
    /// current, 1/K. `circuit` is the one at this temperature, K.
    pub fn rm_per_k(&self, circuit: &Circuit, temperature_k: f64) -> f64 {
        // d ln Rm / dT of the three laws; zero for a law at its limit.
        let law = |per_k: f64| {
            let factor = 1.0 + per_k * temperature_k;
            if factor == limited(factor) { per_k / factor } else { 0.0 }
        };
        let by_resonance = self.temperature_hz_per_k / circuit.series_resonance_hz();
        law(self.temperature_rm_per_k) + by_resonance - 2.0 * law(self.temperature_force_factor_per_k)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const A3: Circuit = Circuit { c0_f: 300e-9, cm_f: 20e-9, lm_h: 0.7916e-3, rm_ohm: 3.08, force_factor_n_per_v: 5.566 };

    fn near(got: f64, expected: f64) {
        assert!((got / expected - 1.0).abs() < 1e-12, "{got} {expected}");
    }

    #[test]
    fn loss_grows_with_current_squared_and_temperature() {
        let shift = Shift { amplitude_rm_per_a2: 0.5, temperature_rm_per_k: 4e-3, ..Shift::default() };
        near(shift.apply(&A3, 25.0, 2.0).rm_ohm, 3.08 * 3.0 * 1.1);
        near(shift.apply(&A3, 25.0, 2.0).q(), A3.q() / 3.3);
        assert_eq!(shift.apply(&A3, 0.0, 0.0).rm_ohm, A3.with_series_resonance(A3.series_resonance_hz()).rm_ohm);
        let saturating = Shift { amplitude_rm_most: Some(4.0), ..shift };
        near(saturating.apply(&A3, 0.0, 0.02).rm_ohm, 3.08 * (1.0 + 2e-4 / (1.0 + 2e-4 / 3.0)));
        // Half of the possible increase, and all but a thousandth of it.
        near(saturating.apply(&A3, 0.0, 6f64.sqrt()).rm_ohm, 3.08 * 2.5);
        assert!((saturating.apply(&A3, 0.0, 100.0).rm_ohm / 3.08 - 4.0).abs() < 3e-3);
    }

    /// The mechanics is unchanged: mass `phi^2 Lm`, compliance `Cm / phi^2`, damping `phi^2 Rm`.
    #[test]
    fn a_force_factor_couples_the_same_mechanics() {
        let shift = Shift { temperature_force_factor_per_k: -2e-3, ..Shift::default() };
        let warm = shift.apply(&A3, 50.0, 0.0);
        near(warm.force_factor_n_per_v, 0.9 * 5.566);
        let mechanics = |c: &Circuit| {
            let square = c.force_factor_n_per_v.powi(2);
            [square * c.lm_h, c.cm_f / square, square * c.rm_ohm]
        };
        mechanics(&warm).into_iter().zip(mechanics(&A3)).for_each(|(got, expected)| near(got, expected));
        near(warm.series_resonance_hz(), A3.series_resonance_hz());
        near(warm.q(), A3.q());
    }

    #[test]
    fn factors_are_limited_to_the_range_of_the_laws() {
        let shift = Shift { temperature_rm_per_k: -0.05, amplitude_rm_per_a2: -1.0, ..Shift::default() };
        near(shift.apply(&A3, 100.0, 0.0).rm_ohm, 0.308);
        near(shift.apply(&A3, 0.0, 3.0).rm_ohm, 0.308);
        assert_eq!(shift.rm_per_k(&A3, 100.0), 0.0);
    }

    /// The slope equals the difference of two circuits.
    #[test]
    fn loss_slope_equals_the_difference_of_circuits() {
        let shift = Shift {
            temperature_hz_per_k: -10.0,
            temperature_rm_per_k: 5e-3,
            temperature_force_factor_per_k: -1e-3,
            amplitude_rm_per_a2: 0.3,
            ..Shift::default()
        };
        let at = |temperature_k: f64| shift.apply(&A3, temperature_k, 1.0);
        let slope = (at(40.01).rm_ohm / at(39.99).rm_ohm).ln() / 0.02;
        assert!((shift.rm_per_k(&at(40.0), 40.0) / slope - 1.0).abs() < 1e-8, "{slope}");
    }

    #[test]
    fn no_coefficients_give_no_shift() {
        let loaded = scene::load::load("lock", &[]).unwrap_or_else(|error| panic!("{error}"));
        let mut bvd = loaded.scene.stack.unwrap().bvd;
        bvd.amplitude_rm_most = Some(3.0);
        assert_eq!(Shift::from_bvd(&bvd), None);
        bvd.amplitude_rm_per_a2 = 0.1;
        assert!(Shift::from_bvd(&bvd).is_some());
    }
}
