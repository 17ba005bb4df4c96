//! Steady friction and power under a sine, system dynamics apart: what the ratios tend to once start-up is over.
//!
//! Dahl's depend on the velocity ratio and kappa alone, Coulomb's on the velocity ratio alone.

use crate::contact::Trouble;

/// Steady ratios.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Steady {
    /// Friction ratio.
    pub friction: f64,
    /// Power dissipation ratio.
    pub power: f64,
}

impl Steady {
    /// Power that the vibration takes in, over that of friction without it: what is dissipated beyond what sliding brings.
    pub fn input(&self) -> f64 {
        self.power - self.friction
    }
}

/// Dahl's.
pub fn dahl(velocity_ratio: f64, kappa: f64) -> Result<Steady, Trouble> {
    // TEMPORARY until contact::closed is there.
    use std::f64::consts::{PI, TAU};
    if velocity_ratio >= 1.0 {
        return Ok(Steady { friction: 1.0, power: 1.0 });
    }
    let xi = velocity_ratio;
    let ta = PI - xi.acos();
    let forward = 2.0 * (xi * ta + ta.sin());
    let backward = forward - TAU * xi;
    let (a, b) = ((-kappa * forward).exp(), (-kappa * backward).exp());
    let (f0, f1) = (-2.0 * (1.0 - b) / (1.0 - a * b), 2.0 * (1.0 - a) / (1.0 - a * b));
    let power = (forward + f0 * (1.0 - a) / kappa + backward - f1 * (1.0 - b) / kappa) / (TAU * xi);
    let simpson = |from: f64, to: f64, f: &dyn Fn(f64) -> f64| {
        let n = 400;
        let h = (to - from) / f64::from(n);
        (0..=n)
            .map(|i| {
                f(from + f64::from(i) * h)
                    * if i == 0 || i == n {
                        1.0
                    } else if i % 2 == 1 {
                        4.0
                    } else {
                        2.0
                    }
            })
            .sum::<f64>()
            * h
            / 3.0
    };
    let i1 = simpson(-ta, ta, &|t| (-kappa * (xi * (t + ta) + t.sin() + ta.sin())).exp());
    let i2 = simpson(ta, TAU - ta, &|t| (kappa * (xi * (t - ta) + t.sin() - ta.sin())).exp());
    Ok(Steady { friction: (2.0 * ta + f0 * i1 - (TAU - 2.0 * ta) + f1 * i2) / TAU, power })
}

/// Coulomb's (4.3): `(2/pi) asin xi`, and `(2/pi) (asin xi + sqrt(1 - xi^2) / xi)`; one from a ratio of one on.
pub fn coulomb(velocity_ratio: f64) -> Steady {
    if velocity_ratio >= 1.0 {
        return Steady { friction: 1.0, power: 1.0 };
    }
    let friction = std::f64::consts::FRAC_2_PI * velocity_ratio.asin();
    let swing = (1.0 - velocity_ratio * velocity_ratio).sqrt() / velocity_ratio;
    Steady { friction, power: friction + std::f64::consts::FRAC_2_PI * swing }
}

/// Dahl's friction ratio for kappa -> 0, where the contact is so compliant that the force hardly changes within a period:
/// mean V over mean |V|, `(pi/2) xi / (xi asin xi + sqrt(1 - xi^2))`.
pub fn compliant(velocity_ratio: f64) -> f64 {
    if velocity_ratio >= 1.0 {
        return 1.0;
    }
    let slip = velocity_ratio * velocity_ratio.asin() + (1.0 - velocity_ratio * velocity_ratio).sqrt();
    std::f64::consts::FRAC_PI_2 * velocity_ratio / slip
}
