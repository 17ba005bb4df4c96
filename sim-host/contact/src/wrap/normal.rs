//! The effect of the normal part of a ring's vibration on friction at a position, if it is assumed
//! to have any.
//!
//! | normal part | law | validity |
//! |---|---|---|
//! | none | one | exact for a contact that is stiff along the surface, as long as contact is not lost |
//! | fitted | `1 - R0 g(v) (W / W0)^-p min(1, a / a50)` | fitted to a belt at 20 to 87 mm/s and 270 to 670 N ([`empirical`](crate::empirical)); **extrapolated** beyond |
//! | compliant | mean of Popov's contact under the load W ([`crate::compliant`]) | needs two stiffnesses; those that fit the belt are implausible, and plausible ones contradict it |
//!
//! `W = T L / R` is the load on a piece of webbing as long as the horn's face in the belt
//! experiment. Its length is ASSUMED to be L = 10 mm (470 mm^2, 47 mm wide). `a` is the amplitude
//! of the normal part, `a50` the smallest amplitude that was tested, 50 % of 85 um. It is ASSUMED
//! that the effect does not rise above `a50`, and falls in proportion below. The fitted constants
//! `q` and `s` of the empirical law, which were chosen, are not used.

use super::super::compliant;
use super::super::empirical::EmpiricalLaw;

/// Length of the horn's face along the webbing, m: ASSUMED.
pub const FACE_M: f64 = 0.010;
/// Full amplitude of the horn, m (thesis, Table 3.2).
pub const FULL_M: f64 = 85e-6;

/// Effect of the normal part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NormalPart {
    /// No effect.
    None,
    /// Reduction of friction by the law that is fitted to the belt.
    Fitted(Normal),
    /// Reduction of friction as in a compliant contact of these stiffnesses.
    Compliant(Normal, Stiffnesses),
}

/// Normal part of a vibration on a ring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Normal {
    /// Amplitude of the whole vibration, m.
    pub amplitude_m: f64,
    /// Radius of the ring that the webbing bends around, m.
    pub radius_m: f64,
}

/// Stiffnesses of the webbing under the face of the horn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stiffnesses {
    /// Normal stiffness, N/m.
    pub normal_n_per_m: f64,
    /// Tangential stiffness, N/m.
    pub tangential_n_per_m: f64,
}

impl Normal {
    /// Returns the load on a face of the horn at a tension, N.
    pub fn load_n(&self, tension_n: f64) -> f64 {
        tension_n * FACE_M / self.radius_m
    }

    /// Returns the share of the fitted effect, 0 to 1, for a normal part of the vibration.
    pub(super) fn share(&self, normal: f64) -> f64 {
        (normal / self.saturated()).min(1.0)
    }

    /// Returns the normal part above which the fitted effect does not rise.
    pub(super) fn saturated(&self) -> f64 {
        EmpiricalLaw::FITTED.lowest_amplitude_fraction * FULL_M / self.amplitude_m
    }
}

/// Returns the fitted effect at a speed, m/s, and a load of W0 on one face.
pub(super) fn fitted_effect(speed_m_per_s: f64) -> f64 {
    let law = EmpiricalLaw::FITTED;
    let creeping = |speed: f64| 1.0 + speed / law.speed_scale_m_per_s;
    law.reduction * creeping(law.speed_m_per_s) / creeping(speed_m_per_s)
}

/// Returns the derivative of the fitted effect with respect to the speed, over the effect, per m/s.
pub(super) fn fitted_effect_fall(speed_m_per_s: f64) -> f64 {
    -1.0 / (EmpiricalLaw::FITTED.speed_scale_m_per_s + speed_m_per_s)
}

impl NormalPart {
    /// Returns the friction ratio of the normal part alone, at a tension and a sliding speed; `mu`
    /// applies without vibration.
    pub fn ratio(&self, normal: f64, tension_n: f64, speed_m_per_s: f64, mu: f64, hz: f64) -> f64 {
        match self {
            NormalPart::None => 1.0,
            NormalPart::Fitted(part) => {
                let law = EmpiricalLaw::FITTED;
                let load = (part.load_n(tension_n) / law.load_n).powf(-law.load_exponent);
                1.0 - fitted_effect(speed_m_per_s) * load * part.share(normal)
            }
            NormalPart::Compliant(part, stiff) => {
                let amplitude_m = part.amplitude_m * normal;
                let deepest = amplitude_m * stiff.normal_n_per_m;
                if deepest == 0.0 {
                    return 1.0;
                }
                let critical = mu * deepest * std::f64::consts::TAU * hz / stiff.tangential_n_per_m;
                compliant::friction_ratio(deepest / part.load_n(tension_n), speed_m_per_s / critical, true)
            }
        }
    }

    /// Returns the normal parts at which the law has a kink.
    pub(super) fn kinks(&self) -> Vec<f64> {
        match self {
            NormalPart::Fitted(part) => vec![part.saturated()],
            _ => Vec::new(),
        }
    }
}
