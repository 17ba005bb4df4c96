//! Vibration across the contact: a normal oscillation lowers friction through Hertz's law.
//!
//! Quasi-static model: the distance d of the bodies follows the vibration, and the mean normal
//! force is the load W,
//!
//! ```text
//! N = K d^(3/2) for d > 0, else 0        (Hertz 1881)
//! d = D + a w(t),  mean N = W            D follows from the load
//! F ~ real area ~ d                      (adhesion theory; Hess and Soom 1991)
//! r = mean d+ / d0,  d0 = (W / K)^(2/3)
//! ```
//!
//! Since N is convex in d, the mean of d is below d0: friction falls although the mean load does
//! not change. For the sine, contact is lost above `a / d0 = (3 pi / (8 sqrt 2))^(2/3) = 0.885`, at
//! a reduction of 11.5 %.
//!
//! The solution depends only on a / d0 and the shape. For the sine the mean force is a complete
//! elliptic integral, with m = 2 a / (D + a):
//!
//! ```text
//! pi mean (D + a cos p)^(3/2) = (2/3) sqrt(D + a) [4 D E(m) - (D - a) K(m)]                       D >= a
//!                             = 2 (2 a)^(3/2) k^4 integral of cos^4 / sqrt(1 - k^2 sin^2) over 0 to pi/2,  k^2 = (D + a) / (2 a) < 1
//! ```
//!
//! The square is at one of two places, triangle and sawtooth are spread evenly; both are
//! elementary. [`vibration`] contains the motion of a mass on the spring of the contact (Hess and
//! Soom 1991; Grudzinski and Kostek 2005). The quasi-static model holds if the resonance of the
//! contact lies far above the drive.

pub(crate) mod elliptic;
mod mean;
pub mod vibration;

use super::SolveError;
use super::waveform::{Shape, Waveform};
use mean::Spread;

const METHOD: &str = "hertz";

/// Number of steps into which a displayed period is divided.
const PERIOD_STEPS: u32 = 256;

/// Loaded contact whose bodies vibrate across it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HertzProblem {
    /// Static load W of the contact, N.
    pub normal_n: f64,
    /// Contact stiffness K, N/m^1.5.
    pub stiffness_n_per_m15: f64,
    /// Amplitude of the vibration a, m.
    pub amplitude_m: f64,
    /// Shape of the vibration: sine, square, sawtooth, triangle or still.
    pub shape: Shape,
}

/// Effect of the vibration on a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HertzSolution {
    /// Mean friction over friction without vibration.
    pub friction_ratio: f64,
    /// Fraction of the period in contact.
    pub contact_share: f64,
    /// Mean distance D, m: a deflection if positive, a mean gap if negative.
    pub mean_deflection_m: f64,
    /// Deflection without vibration d0, m.
    pub static_deflection_m: f64,
}

/// Moment of the period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HertzPoint {
    /// Phase of the vibration, turns.
    pub phase_turns: f64,
    /// Deflection d, m; negative for a gap.
    pub deflection_m: f64,
    /// Normal force at that phase, N.
    pub normal_n: f64,
}

/// Solves the quasi-static problem.
pub fn solve(problem: &HertzProblem) -> Result<HertzSolution, SolveError> {
    let HertzProblem { normal_n, stiffness_n_per_m15, amplitude_m, shape } = *problem;
    let unsuited = |reason: &str| Err(SolveError::Unsuited { method: METHOD, reason: reason.to_owned() });
    let Some(spread) = Spread::from_shape(shape) else { return unsuited("the vibration is not periodic") };
    if !(normal_n > 0.0 && stiffness_n_per_m15 > 0.0 && amplitude_m >= 0.0 && amplitude_m.is_finite()) {
        return unsuited("load and stiffness must be positive, and the amplitude must not be negative");
    }
    let static_m = (normal_n / stiffness_n_per_m15).powf(2.0 / 3.0);
    let amplitude = amplitude_m / static_m;
    let lift = spread.lift(amplitude);
    Ok(HertzSolution {
        friction_ratio: spread.mean_deflection(lift, amplitude),
        contact_share: spread.contact_share(lift, amplitude),
        mean_deflection_m: (lift - amplitude) * static_m,
        static_deflection_m: static_m,
    })
}

/// Returns one period, both ends included.
pub fn period(problem: &HertzProblem, solution: &HertzSolution) -> Vec<HertzPoint> {
    let waveform = Waveform::new(problem.shape, problem.amplitude_m, 1.0, 1.0);
    let point = |step: u32| {
        let phase_turns = f64::from(step) / f64::from(PERIOD_STEPS);
        let deflection_m = solution.mean_deflection_m + waveform.value(phase_turns);
        HertzPoint { phase_turns, deflection_m, normal_n: problem.stiffness_n_per_m15 * deflection_m.max(0.0).powf(1.5) }
    };
    (0..=PERIOD_STEPS).map(point).collect()
}

/// Returns the largest a / d0 at which contact is never lost; infinite without vibration, `None`
/// for a shape that is not periodic.
pub fn contact_loss_threshold(shape: Shape) -> Option<f64> {
    Spread::from_shape(shape).map(Spread::threshold)
}

#[cfg(test)]
mod tests;
