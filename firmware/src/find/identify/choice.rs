//! The choice among several resonances, by this rule and nothing else:
//!
//! 1. It is in the window. If none is, there is no resonance (fault 30).
//! 2. If a motional inductance is configured (`tracking.nominal_lm_h`): that of the chosen resonance is within a factor of two of that. If none is, what is there is another
//!    one (fault 34).
//! 3. Of those that are left, the one of the largest motional capacitance, which does not depend on how much it is damped. If the
//!    inductance is not configured, and another has more than `ALIKE` of that, the choice is ambiguous (fault 34).

use crate::seam::fault::Fault;
use crate::seam::transducer::Resonance;

/// How far the motional inductance may be from its nominal value.
const LM_FACTOR: f32 = 2.0;
/// Capacitances that are alike.
const ALIKE: f32 = 0.8;

/// The rule, with the nominal values that it uses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Choice {
    /// Middle of the window, and how far it goes to each side, Hz.
    pub(crate) window_hz: (f32, f32),
    /// Motional inductance, H.
    pub(crate) nominal_lm_h: Option<f32>,
}

impl Choice {
    /// The place of the chosen resonance in the list, or the fault.
    pub(crate) fn of(&self, found: &[Resonance]) -> Result<usize, Fault> {
        let (centre_hz, half_hz) = self.window_hz;
        let inside = |resonance: &Resonance| (resonance.hz - centre_hz).abs() <= half_hz;
        let fits = |resonance: &Resonance| {
            self.nominal_lm_h.is_none_or(|nominal| resonance.lm_h < nominal * LM_FACTOR && resonance.lm_h * LM_FACTOR > nominal)
        };
        if !found.iter().any(inside) {
            return Err(Fault::NoResonance);
        }
        let (mut best, mut second) = ((None, 0.0), 0.0);
        for (n, resonance) in found.iter().enumerate().filter(|(_, resonance)| inside(resonance) && fits(resonance)) {
            let strength = 1.0 / (resonance.lm_h * resonance.hz * resonance.hz);
            if strength > best.1 {
                (best, second) = ((Some(n), strength), best.1);
            } else if strength > second {
                second = strength;
            }
        }
        let alike = self.nominal_lm_h.is_none() && second > ALIKE * best.1;
        best.0.filter(|_| !alike).ok_or(Fault::WrongMode)
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
        assert_eq!(choice(None).of(&found), Ok(2));
        assert_eq!(choice(None).of(&found[..1]), Err(Fault::NoResonance));
        assert_eq!(choice(None).of(&[]), Err(Fault::NoResonance));
    }

    #[test]
    fn the_nominal_inductance_decides() {
        let found = [resonance(39_500.0, 4e-3), resonance(40_400.0, 8e-4)];
        assert_eq!(choice(Some(3e-3)).of(&found), Ok(0));
        assert_eq!(choice(Some(1e-3)).of(&found), Ok(1));
        assert_eq!(choice(Some(0.1)).of(&found), Err(Fault::WrongMode));
    }

    #[test]
    fn two_alike_are_not_guessed_between() {
        let found = [resonance(39_500.0, 8e-4), resonance(40_400.0, 8.5e-4)];
        assert_eq!(choice(None).of(&found), Err(Fault::WrongMode));
        assert_eq!(choice(Some(8e-4)).of(&found), Ok(0));
    }
}
