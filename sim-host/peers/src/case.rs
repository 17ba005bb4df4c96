//! The case that all peers solve: the thesis's Table 4.1 on one mass and one spring with Dahl friction, from rest.
//!
//! In units that make every quantity of order one (phase w t, displacement Vv/w, velocity Vv, force Fc) it is
//!
//! ```text
//! x' = v        v' = g cos(t) - a x - e f        f' = kappa V (1 - f sgn V)        V = xi + v        q' = f / (2 pi N)
//! ```
//!
//! with a = (wn/w)^2, g = F0/(m w Vv), e = Fc/(m w Vv). q is the quadrature state: over N periods it grows to the mean of f, so that it
//! never limits a peer's step. Peers of this project get the same case in SI units, as a [`Problem`].

use std::f64::consts::{FRAC_PI_2, TAU};

use contact::Problem;
use contact::table_4_1::{COULOMB_N, DRIVE_HZ, FORCE_N, MASS_KG, STIFFNESS_N_PER_M, VELOCITY_RATIO, table_4_1};

/// The case over a number of periods.
#[derive(Clone, Debug)]
pub struct Case {
    /// Length of the run in periods; an even number, so that the window begins with a period.
    pub periods: u32,
    /// The problem in SI units.
    pub problem: Problem,
    /// In units of order one.
    pub scaled: Scaled,
}

/// The coefficients in units of order one.
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub struct Scaled {
    /// Sliding velocity xi, scaled.
    pub sliding: f64,
    /// Vibration amplitude in Dahl lengths, kappa.
    pub kappa: f64,
    /// Coefficient a of the spring.
    pub spring: f64,
    /// Coefficient g of the forcing.
    pub forcing: f64,
    /// Coefficient e of the friction.
    pub friction: f64,
    /// What the quadrature state gains a unit of phase and force, 1 / (2 pi N).
    pub share: f64,
}

impl Case {
    /// The case over so many periods, means over the second half.
    pub fn new(periods: u32) -> Self {
        let periods = periods.max(2).next_multiple_of(2);
        let problem = table_4_1(VELOCITY_RATIO, f64::from(periods));
        let omega = TAU * DRIVE_HZ;
        let vibration = problem.vibration_m_per_s();
        let momentum_rate_n = MASS_KG * omega * vibration;
        let scaled = Scaled {
            sliding: VELOCITY_RATIO,
            kappa: problem.kappa(),
            spring: STIFFNESS_N_PER_M / (MASS_KG * omega * omega),
            forcing: FORCE_N / momentum_rate_n,
            friction: COULOMB_N / momentum_rate_n,
            share: 1.0 / (TAU * f64::from(periods)),
        };
        Case { periods, problem, scaled }
    }

    /// Number of the last quarter period; the first is number zero.
    pub fn last_quarter(&self) -> u32 {
        4 * self.periods
    }
}

/// Longest step that a peer is allowed from reversal to reversal, as a phase: two reversals in one step would go unnoticed.
pub const LONGEST_STEP: f64 = TAU / 6.0;

/// Longest first step after a reversal, as a phase: from zero slip to zero slip nothing shows that there was a reversal.
pub const LONGEST_FIRST_STEP: f64 = TAU / 8.0;

/// Phase of a quarter period.
pub fn quarter(number: u32) -> f64 {
    f64::from(number) * FRAC_PI_2
}

impl Scaled {
    /// Slip velocity V of a state.
    pub fn slip(&self, y: &[f64]) -> f64 {
        self.sliding + y[1]
    }

    /// Rates of x, v, f, q for a sign of the slip that is held, at a value of the cosine.
    #[inline]
    pub fn held(&self, sign: f64, cosine: f64, y: &[f64], rates: &mut [f64]) {
        let slip = self.slip(y);
        rates[0] = y[1];
        rates[1] = self.forcing * cosine - self.spring * y[0] - self.friction * y[2];
        rates[2] = self.kappa * slip * (1.0 - sign * y[2]);
        rates[3] = self.share * y[2];
    }

    /// Rates with the sign taken from the slip velocity, as the equation is written.
    #[inline]
    pub fn free(&self, cosine: f64, y: &[f64], rates: &mut [f64]) {
        self.held(self.slip(y).signum(), cosine, y, rates);
    }

    /// Product of the Jacobian with a vector, for a held sign.
    #[inline]
    pub fn jacobian(&self, sign: f64, y: &[f64], by: &[f64], out: &mut [f64]) {
        out[0] = by[1];
        out[1] = -self.spring * by[0] - self.friction * by[2];
        out[2] = self.kappa * (by[1] * (1.0 - sign * y[2]) - self.slip(y) * sign * by[2]);
        out[3] = self.share * by[2];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jacobian_is_the_derivative_of_the_rates() {
        let scaled = Case::new(10).scaled;
        let (y, by) = ([0.3, -0.8, 0.6, 0.1], [0.2, -0.5, 0.7, 0.3]);
        let at = |size: f64| {
            let mut rates = [0.0; 4];
            let moved: Vec<f64> = y.iter().zip(by).map(|(y, by)| y + size * by).collect();
            scaled.held(-1.0, 0.4, &moved, &mut rates);
            rates
        };
        let mut product = [0.0; 4];
        scaled.jacobian(-1.0, &y, &by, &mut product);
        // Rates are quadratic, so a central difference is exact but for round-off.
        let (ahead, behind) = (at(1e-3), at(-1e-3));
        for i in 0..4 {
            assert!((product[i] - (ahead[i] - behind[i]) / 2e-3).abs() < 1e-12, "{i}");
        }
    }

    #[test]
    fn scales_of_table_4_1() {
        // Friction is 5.1e-5 of the forcing; kappa 0.40452.
        let scaled = Case::new(10).scaled;
        assert!((scaled.friction / scaled.forcing - COULOMB_N / FORCE_N).abs() < 1e-15);
        assert!((scaled.kappa - 0.404_52).abs() < 1e-5);
        assert!((scaled.forcing - (1.0 - scaled.spring)).abs() < 1e-12);
    }
}
