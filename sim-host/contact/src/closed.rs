//! Steady friction under a prescribed vibration, without time steps: `V = Vt + Vv cos(w t)`,
//! Coulomb or Dahl.
//!
//! In units of the vibration velocity Vv, the phase `p = w t` and the slip `Vv / w`, the steady
//! state depends only on two numbers,
//!
//! ```text
//! xi    = Vt / Vv               velocity ratio
//! kappa = Kt Vv / (w Fc)        vibration amplitude in Dahl lengths; infinite for Coulomb friction
//! ```
//!
//! For |xi| < 1 the slip goes forward over the angle 2 a and backward over 2 b, with b = acos xi
//! and a = pi - b. Each stroke is the same function of its half angle (`stroke`). Dahl's law
//! (thesis 4.15) is linear in slip. Let `A = kappa (sin a - a cos a)` be half of kappa times the
//! forward slip, `B` the same for the backward slip, and I the integral of `exp(-kappa slip)` over
//! a stroke:
//!
//! ```text
//! friction at the end of the forward stroke   f1 = (1 - 2 e^-2A + e^-2(A+B)) / (1 - e^-2(A+B))
//! friction ratio   r   = (2/pi) asin xi + [ (1 - e^-2A) I_b - (1 - e^-2B) I_a ] / (pi (1 - e^-2(A+B)))
//! power ratio      phi = [ (A - tanh A) + (B - tanh B) + (tanh A - tanh B)^2 / (tanh A + tanh B) ] / (pi xi kappa)
//! ```
//!
//! The power ratio is elementary and, in this form, a sum of positive terms. The friction ratio is
//! the time mean, whose integrals are not elementary (similar to incomplete Anger functions). They
//! take 6 to 20 Gauss-Legendre nodes (`gauss`) for round-off accuracy at any kappa. For |xi| >= 1
//! the slip does not reverse and both ratios are one.
//!
//! Limits: `kappa -> 0` r = phi = (pi/2) xi / (xi asin xi + sqrt(1 - xi^2)); Coulomb r = (2/pi)
//! asin xi (Kumar and Hutchings 2004) and phi = (2/pi) (asin xi + sqrt(1 - xi^2) / xi). At every
//! xi, as kappa grows, r falls from the first limit to the second, and phi rises.

pub(super) mod gauss;
mod lines;
mod solve;
mod steady;
pub(super) mod stroke;

use std::f64::consts::{FRAC_2_PI, FRAC_PI_2, PI};

pub use solve::ClosedForm;
pub use steady::Steady;
use stroke::Stroke;

/// Value of kappa below which both ratios equal their limit to round-off.
pub(super) const CONSTANT_FRICTION_KAPPA: f64 = 1e-17;

/// Returns mean friction over Coulomb force for steady Dahl friction: odd in xi; kappa >= 0,
/// infinite for Coulomb friction.
///
/// Absolute error below 1e-14 for any kappa.
pub fn friction_ratio(xi: f64, kappa: f64) -> f64 {
    let size = xi.abs();
    if !in_range(kappa) {
        return f64::NAN;
    }
    if size >= 1.0 || xi.is_nan() {
        return xi.signum();
    }
    if kappa < CONSTANT_FRICTION_KAPPA {
        return limit_ratio(xi);
    }
    if kappa == f64::INFINITY {
        return coulomb_friction_ratio(xi);
    }
    let [forward, backward] = Stroke::both(size, kappa);
    let difference = forward.forgotten() * backward.integral() - backward.forgotten() * forward.integral();
    (FRAC_2_PI * size.asin() + difference / (PI * both_forgotten(&forward, &backward))).copysign(xi)
}

/// Returns the power that steady Dahl friction dissipates, over that of Coulomb friction without
/// vibration: even in xi, `None` at xi = 0.
///
/// Relative error below 1e-14 for any kappa.
pub fn power_ratio(xi: f64, kappa: f64) -> Option<f64> {
    let size = xi.abs();
    if size == 0.0 || xi.is_nan() || !in_range(kappa) {
        return None;
    }
    if size >= 1.0 {
        return Some(1.0);
    }
    if kappa < CONSTANT_FRICTION_KAPPA {
        return Some(limit_ratio(size));
    }
    if kappa == f64::INFINITY {
        return coulomb_power_ratio(xi);
    }
    let [forward, backward] = Stroke::both(size, kappa);
    let (a, b) = (forward.exponent(), backward.exponent());
    let (tanh_a, tanh_b) = (a.tanh(), b.tanh());
    // tanh A - tanh B, where A - B = pi xi kappa
    let apart = (PI * size * kappa).tanh() * (1.0 - tanh_a * tanh_b);
    let sum = over_tanh(a, tanh_a) + over_tanh(b, tanh_b) + apart * apart / (tanh_a + tanh_b);
    Some(sum / (PI * size * kappa))
}

/// Returns the power that sustains the vibration against steady Dahl friction,
/// `mean(F x') / (Fc Vt)`. `None` at xi = 0.
///
/// Uses its own quadrature, so the residual of `phi = r + phi_iu` is the error of the integrals.
pub fn input_ratio(xi: f64, kappa: f64) -> Option<f64> {
    let size = xi.abs();
    if size == 0.0 || xi.is_nan() || !in_range(kappa) {
        return None;
    }
    if size >= 1.0 || kappa < CONSTANT_FRICTION_KAPPA {
        return Some(0.0);
    }
    let sine = ((1.0 - size) * (1.0 + size)).sqrt();
    if kappa == f64::INFINITY {
        return Some(FRAC_2_PI * sine / size);
    }
    let [forward, backward] = Stroke::both(size, kappa);
    let lost = backward.forgotten() * forward.cosine_integral() + forward.forgotten() * backward.cosine_integral();
    Some((2.0 * sine - lost / both_forgotten(&forward, &backward)) / (PI * size))
}

/// Returns the mean of `sgn V`: the friction ratio of Coulomb friction (thesis 4.3).
pub fn coulomb_friction_ratio(xi: f64) -> f64 {
    FRAC_2_PI * xi.clamp(-1.0, 1.0).asin()
}

/// Returns the mean of `|V| / Vt`: the power ratio of Coulomb friction. `None` at xi = 0.
pub fn coulomb_power_ratio(xi: f64) -> Option<f64> {
    let size = xi.abs();
    match size {
        _ if size == 0.0 || xi.is_nan() => None,
        _ if size >= 1.0 => Some(1.0),
        _ => Some(FRAC_2_PI * (size.asin() + ((1.0 - size) * (1.0 + size)).sqrt() / size)),
    }
}

/// Returns the limit of both ratios as kappa goes to zero, in which friction is constant: net slip
/// over slip, `(pi/2) xi / (xi asin xi + sqrt(1 - xi^2))`.
pub fn limit_ratio(xi: f64) -> f64 {
    if xi.abs() >= 1.0 {
        return xi.signum();
    }
    FRAC_PI_2 * xi / (xi * xi.asin() + ((1.0 - xi) * (1.0 + xi)).sqrt())
}

/// Returns the fraction of a difference in friction that remains after one period:
/// `exp(-kappa slip)`, with the slip of both strokes.
///
/// After N periods the influence of the start is `forget^N`, so a window that begins then is steady
/// to that fraction of Fc.
pub fn forget(xi: f64, kappa: f64) -> f64 {
    let size = xi.abs();
    let slip = if size >= 1.0 { 2.0 * PI * size } else { 4.0 * (size * size.asin() + ((1.0 - size) * (1.0 + size)).sqrt()) };
    (-kappa * slip).exp()
}

fn in_range(kappa: f64) -> bool {
    kappa >= 0.0
}

/// Returns `1 - exp(-2 (A + B))`.
fn both_forgotten(forward: &Stroke, backward: &Stroke) -> f64 {
    -(-2.0 * (forward.exponent() + backward.exponent())).exp_m1()
}

/// Returns `x - tanh x` for x >= 0.
fn over_tanh(x: f64, tanh: f64) -> f64 {
    if x > 1.0 {
        return x - tanh;
    }
    // x cosh x - sinh x = sum of 2 k x^(2k+1) / (2k+1)!, all positive; the tenth is below 1e-17 of
    // the first
    let square = x * x;
    let mut term = x;
    let mut sum = 0.0;
    for k in 1..10 {
        let k = f64::from(k);
        term *= square / (2.0 * k * (2.0 * k + 1.0));
        sum += 2.0 * k * term;
    }
    sum / x.cosh()
}

#[cfg(test)]
mod laws;
#[cfg(test)]
mod tests;
