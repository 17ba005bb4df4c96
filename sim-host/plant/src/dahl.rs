//! Dahl's friction, integrated exactly in slip.
//!
//! `dF/dz = Kt (1 - (F / Fc) sgn V)`, exponent one (Dahl 1968; thesis 4.9). Between reversals of
//! `V` this is linear in the slip `z`, for any motion in time:
//!
//! ```text
//! F(z) = s Fc + (F0 - s Fc) exp(-Kt |z| / Fc),   s = sgn V
//! ```
//!
//! Therefore a step needs only its slip, never a small time step, and `|F| <= Fc` holds for any
//! stiffness. A reversal inside a step is located on the quadratic through both velocities and the
//! slip (fourth-order error), and the step is split there. The time mean over the step is the
//! trapezium rule with end corrections (fourth order).

/// Contact with Dahl friction.
#[derive(Clone, Debug)]
pub struct Dahl {
    /// Tangential stiffness, N/m.
    kt: f64,
    /// Coulomb force mu N, N.
    fc: f64,
    /// Kt / Fc, 1/m: one over the Dahl length.
    per_metre: f64,
    force: f64,
}

impl Dahl {
    /// Creates a relaxed contact of stiffness `kt`, N/m, and Coulomb force `fc`, N.
    pub fn new(kt: f64, fc: f64) -> Self {
        Dahl { kt, fc, per_metre: kt / fc, force: 0.0 }
    }

    /// Changes the Coulomb force. The bristles keep their force, and the next slip moves it towards
    /// the new bound.
    pub fn set_coulomb_force(&mut self, fc: f64) {
        self.fc = fc;
        self.per_metre = self.kt / fc;
    }

    /// Returns the present friction, N, in the direction of the slip that caused it.
    pub fn force(&self) -> f64 {
        self.force
    }

    /// Slips by `slip` metres within `step` seconds, from velocity `v0` to `v1`. Returns the time
    /// mean of the friction, N.
    #[inline(always)]
    pub fn slip(&mut self, v0: f64, v1: f64, slip: f64, step: f64) -> f64 {
        if self.fc == 0.0 {
            self.force = 0.0;
            return 0.0;
        }
        if v0 * v1 >= 0.0 {
            return self.one_way(v0, v1, slip, step);
        }
        let (part, first_slip) = reversal(v0, v1, slip, step);
        let first = self.one_way(v0, 0.0, first_slip, part * step);
        let second = self.one_way(0.0, v1, slip - first_slip, (1.0 - part) * step);
        part * first + (1.0 - part) * second
    }

    #[inline(always)]
    fn one_way(&mut self, v0: f64, v1: f64, slip: f64, step: f64) -> f64 {
        let limit = self.fc.copysign(v0 + v1);
        let before = self.force - limit;
        let after = before * decay(self.per_metre * slip.abs());
        self.force = limit + after;
        // dF/dt = Kt (1 - F / (s Fc)) V = -(Kt / Fc) (F - s Fc) |V|
        let ends = self.per_metre * (after * v1.abs() - before * v0.abs());
        limit + 0.5 * (before + after) + step * (1.0 / 12.0) * ends
    }
}

/// Returns the fraction of the step, 0 to 1, at which the velocity passes zero, and the slip until
/// then.
#[inline(always)]
fn reversal(v0: f64, v1: f64, slip: f64, step: f64) -> (f64, f64) {
    let curve = 3.0 * (v0 + v1) - 6.0 * slip / step;
    let slope = v1 - v0 - curve;
    // v0 + slope s + curve s^2 = 0; this form of the root does not cancel. The other sign lies
    // outside the step.
    let root = (slope * slope - 4.0 * curve * v0).max(0.0).sqrt();
    let part = (-2.0 * v0 / (slope + root.copysign(slope))).clamp(0.0, 1.0);
    (part, step * part * (v0 + part * (slope / 2.0 + part * curve / 3.0)))
}

/// Computes `exp(-x)` for `x >= 0`. Steps are small, so the short series is the usual path.
#[inline(always)]
fn decay(x: f64) -> f64 {
    if x > 0.125 {
        return libm::exp(-x);
    }
    // Taylor to the eighth power; the ninth is below 2e-14. Powers in pairs (Estrin 1960) shorten
    // the chain of dependencies.
    let (x2, x4) = (x * x, x * x * (x * x));
    let low = (1.0 - x) + x2 * (1.0 / 2.0 - x * (1.0 / 6.0));
    let high = (1.0 / 24.0 - x * (1.0 / 120.0)) + x2 * ((1.0 / 720.0 - x * (1.0 / 5040.0)) + x2 * (1.0 / 40320.0));
    low + x4 * high
}

#[cfg(test)]
mod closed_form;

#[cfg(test)]
mod tests {
    use super::*;

    const TAU: f64 = std::f64::consts::TAU;

    /// Returns the time mean of F / Fc in the steady state of `V = xi + cos t` (in units of the
    /// vibration velocity), with `steps` steps a period.
    fn steady_ratio(xi: f64, kappa: f64, steps: usize) -> f64 {
        let mut contact = Dahl::new(kappa, 1.0);
        let step = TAU / steps as f64;
        let mut mean = 0.0;
        let periods = 40;
        for n in 0..periods * steps {
            let (t0, t1) = (n as f64 * step, (n + 1) as f64 * step);
            let slip = xi * step + t1.sin() - t0.sin();
            let force = contact.slip(xi + t0.cos(), xi + t1.cos(), slip, step);
            if n >= (periods - 1) * steps {
                mean += force / steps as f64;
            }
        }
        mean
    }

    /// Independent of this code: 40-digit closed form of steady kinematic Dahl friction, kappa =
    /// 0.404517.
    #[test]
    fn agrees_with_the_closed_form() {
        let kappa = 0.056e6 * 0.053_429_6 / (TAU * 60e3 * 0.019_62);
        for (xi, ratio) in [(0.1, 0.148_749_778), (0.5, 0.674_948_667), (0.9, 0.975_847_159)] {
            let got = steady_ratio(xi, kappa, 50);
            assert!((got - ratio).abs() < 3e-6, "{xi}: {got} {ratio}");
        }
    }

    #[test]
    fn a_stiff_contact_tends_to_coulomb() {
        let got = steady_ratio(0.5, 1e4, 400);
        assert!((got - 1.0 / 3.0).abs() < 2e-3, "{got}");
    }

    #[test]
    fn force_never_exceeds_coulomb_at_any_stiffness() {
        for kt in [1.0, 1e3, 1e9, 1e15] {
            let mut contact = Dahl::new(kt, 0.7);
            for n in 0..1000 {
                let (v0, v1) = ((f64::from(n) * 0.37).sin(), (f64::from(n + 1) * 0.37).sin());
                contact.slip(v0, v1, 0.5 * (v0 + v1), 1.0);
                assert!(contact.force().abs() <= 0.7 * (1.0 + 1e-12));
            }
        }
    }

    #[test]
    fn zero_coulomb_force_gives_zero_friction() {
        assert_eq!(Dahl::new(1e6, 0.0).slip(1.0, -1.0, 0.1, 1.0), 0.0);
    }
}
