//! Choice among several resonances, by these rules only:
//!
//! 1. The resonance is inside the window. If none is, there is no resonance (fault 30).
//! 2. If a motional inductance is configured (`tracking.nominal_lm_h`), the inductance of the
//!    resonance is within [`LM_FACTOR`] of it, or within three standard deviations of that. If no
//!    resonance fits, the mode is wrong (fault 34), unless the fine pass of a scan finds one.
//! 3. Among the remaining resonances, the one with the largest motional capacitance is chosen, as
//!    damping does not change it. The choice is ambiguous (fault 34) if the inductance is not
//!    configured and another resonance has more than `AMBIGUOUS_RATIO` of that capacitance.

use crate::seam::compare::smaller;
use crate::seam::fault::Fault;
use crate::seam::transducer::Resonance;

/// Maximum ratio between the measured motional inductance and its nominal value: a factor of two,
/// and a tenth for the error of the measurement, in which other resonances take part.
pub(crate) const LM_FACTOR: f32 = 2.2;
/// Margin of that comparison, standard deviations of the measured inductance.
const MARGIN_SIGMAS: f32 = 3.0;
/// Largest margin, relative.
const MAX_MARGIN_REL: f32 = 0.5;
/// Ratio of two motional capacitances above which the choice is ambiguous.
const AMBIGUOUS_RATIO: f32 = 0.8;

/// Nominal values for the choice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Choice {
    /// Centre and half-width of the window, Hz.
    pub(crate) window_hz: (f32, f32),
    /// Nominal motional inductance, H; `None` if it is not configured.
    pub(crate) nominal_lm_h: Option<f32>,
}

impl Choice {
    /// Returns the index of the chosen resonance in the list, or the fault. `lm_deviations_h`:
    /// standard deviations of the inductances; zero if absent.
    pub(crate) fn choose(&self, found: &[Resonance], lm_deviations_h: &[f32]) -> Result<usize, Fault> {
        if !found.iter().any(|resonance| self.is_inside(resonance)) {
            return Err(Fault::NoResonance);
        }
        let (mut best, mut second) = ((None, 0.0), 0.0);
        let deviation_h = |n| lm_deviations_h.get(n).copied().unwrap_or_default();
        for (n, resonance) in found.iter().enumerate().filter(|(n, resonance)| self.fits(resonance, deviation_h(*n))) {
            let strength = 1.0 / (resonance.lm_h * resonance.hz * resonance.hz);
            if strength > best.1 {
                (best, second) = ((Some(n), strength), best.1);
            } else if strength > second {
                second = strength;
            }
        }
        let ambiguous = self.nominal_lm_h.is_none() && second > AMBIGUOUS_RATIO * best.1;
        best.0.filter(|_| !ambiguous).ok_or(Fault::WrongMode)
    }

    fn is_inside(&self, resonance: &Resonance) -> bool {
        let (centre_hz, half_hz) = self.window_hz;
        (resonance.hz - centre_hz).abs() <= half_hz
    }

    /// Returns `true` if the resonance is inside the window and if its inductance, which has this
    /// standard deviation, H, fits the nominal one.
    pub(crate) fn fits(&self, resonance: &Resonance, deviation_h: f32) -> bool {
        let lm_h = resonance.lm_h;
        let factor = LM_FACTOR * (1.0 + smaller(MARGIN_SIGMAS * deviation_h / lm_h, MAX_MARGIN_REL));
        let has_inductance = self.nominal_lm_h.is_none_or(|nominal| lm_h < nominal * factor && lm_h * factor > nominal);
        has_inductance && self.is_inside(resonance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn resonance(hz: f32, lm_h: f32) -> Resonance {
        Resonance { hz, lm_h, q: 50.0, conductance_s: 0.1 }
    }

    fn choice(nominal_lm_h: Option<f32>) -> Choice {
        Choice { window_hz: (40e3, 1e3), nominal_lm_h }
    }

    #[test]
    fn the_strongest_in_the_window_is_chosen() {
        let found = [resonance(38_000.0, 1e-4), resonance(39_500.0, 4e-3), resonance(40_400.0, 8e-4)];
        assert_eq!(choice(None).choose(&found, &[]), Ok(2));
        assert_eq!(choice(None).choose(&found[..1], &[]), Err(Fault::NoResonance));
        assert_eq!(choice(None).choose(&[], &[]), Err(Fault::NoResonance));
    }

    #[test]
    fn the_nominal_inductance_decides() {
        let found = [resonance(39_500.0, 4e-3), resonance(40_400.0, 8e-4)];
        assert_eq!(choice(Some(3e-3)).choose(&found, &[]), Ok(0));
        assert_eq!(choice(Some(1e-3)).choose(&found, &[]), Ok(1));
        assert_eq!(choice(Some(0.1)).choose(&found, &[]), Err(Fault::WrongMode));
        assert_eq!(choice(Some(2.19 * 4e-3)).choose(&found, &[]), Ok(0));
        assert_eq!(choice(Some(2.21 * 4e-3)).choose(&found, &[]), Err(Fault::WrongMode));
        assert_eq!(choice(Some(2.21 * 4e-3)).choose(&found, &[1e-4, 0.0]), Ok(0));
        for deviation_h in [4e-3, f32::INFINITY, f32::NAN] {
            assert_eq!(choice(Some(3.31 * 4e-3)).choose(&found, &[deviation_h; 2]), Err(Fault::WrongMode));
        }
    }

    #[test]
    fn two_equal_resonances_are_ambiguous() {
        let found = [resonance(39_500.0, 8e-4), resonance(40_400.0, 8.5e-4)];
        assert_eq!(choice(None).choose(&found, &[]), Err(Fault::WrongMode));
        assert_eq!(choice(Some(8e-4)).choose(&found, &[]), Ok(0));
    }
}
