//! The equations in units that make every quantity of order one: phase w t, displacement Vv/w,
//! velocity Vv, force Fc.
//!
//! ```text
//! x' = v        v' = g cos(p) - a x - e F        V = xi + v        q' = F / (2 pi N)
//! f' = kappa V (1 - f sgn V / G(V))        F = f + d f' + u V        G(V) = 1 + s exp(-(V/Vs)^2)
//! ```
//!
//! with a = (wn/w)^2, g = F0/(m w Vv), e = Fc/(m w Vv): LuGre's friction (thesis 4.7, 4.9, 4.10),
//! in which f is the force of the bristles. With s = d = u = 0 it is Dahl's (4.15). The phase p has
//! the rate 1, or a linear one in a chirp ([`Clock`]). q is the quadrature state: over N periods it
//! grows to the mean of F, so that it never limits a peer's step.

use std::f64::consts::TAU;

/// Coefficients of the scaled equations.
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub struct Scaled {
    /// Sliding velocity xi.
    pub sliding: f64,
    /// Vibration amplitude in Dahl lengths, kappa.
    pub kappa: f64,
    /// Coefficient a of the spring.
    pub spring: f64,
    /// Coefficient g of the forcing.
    pub forcing: f64,
    /// Coefficient e of the friction.
    pub friction: f64,
    /// Growth of the quadrature state per unit of phase and force, 1 / (2 pi N).
    pub share: f64,
    /// Ratio of static to kinetic friction, less one: s.
    pub excess: f64,
    /// Stribeck velocity Vs.
    pub stribeck: f64,
    /// Damping d of the bristles.
    pub damping: f64,
    /// Viscous friction u.
    pub viscous: f64,
    /// Frequency at the beginning, over the drive frequency.
    pub start: f64,
    /// Rate of the frequency per unit of time.
    pub rate: f64,
}

impl Scaled {
    /// Returns the slip velocity V of a state.
    pub fn slip(&self, y: &[f64]) -> f64 {
        self.sliding + y[1]
    }

    /// Returns the Stribeck level G and its slope.
    #[inline]
    fn level(&self, slip: f64) -> (f64, f64) {
        if self.excess == 0.0 {
            return (1.0, 0.0);
        }
        let part = slip / self.stribeck;
        let peak = self.excess * (-part * part).exp();
        (1.0 + peak, -2.0 * part / self.stribeck * peak)
    }

    /// Returns the friction F of a state for a held sign of the slip.
    pub fn force(&self, sign: f64, y: &[f64]) -> f64 {
        let mut rates = [0.0; 4];
        self.held(sign, 0.0, y, &mut rates);
        y[2] + self.damping * rates[2] + self.viscous * self.slip(y)
    }

    /// Computes the rates of x, v, f, q for a held sign of the slip, at a value of the cosine.
    #[inline]
    pub fn held(&self, sign: f64, cosine: f64, y: &[f64], rates: &mut [f64]) {
        let slip = self.slip(y);
        let bristle = self.kappa * slip * (1.0 - sign * y[2] / self.level(slip).0);
        let force = y[2] + self.damping * bristle + self.viscous * slip;
        rates[0] = y[1];
        rates[1] = self.forcing * cosine - self.spring * y[0] - self.friction * force;
        rates[2] = bristle;
        rates[3] = self.share * force;
    }

    /// Computes the rates with the sign taken from the slip velocity, as in the equation.
    #[inline]
    pub fn free(&self, cosine: f64, y: &[f64], rates: &mut [f64]) {
        self.held(self.slip(y).signum(), cosine, y, rates);
    }

    /// Computes the product of the Jacobian with a vector, for a held sign.
    #[inline]
    pub fn jacobian(&self, sign: f64, y: &[f64], by: &[f64], out: &mut [f64]) {
        let slip = self.slip(y);
        let (level, slope) = self.level(slip);
        let by_slip = self.kappa * (1.0 - sign * y[2] / level * (1.0 - slip * slope / level));
        let bristle = by_slip * by[1] - self.kappa * sign * slip / level * by[2];
        let force = by[2] + self.damping * bristle + self.viscous * by[1];
        out[0] = by[1];
        out[1] = -self.spring * by[0] - self.friction * force;
        out[2] = bristle;
        out[3] = self.share * force;
    }
}

/// Time in legs from reversal to reversal. The clock of each leg begins at zero: the resolution of
/// a located root depends on the length of the leg, not on that of the run.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    /// Frequency of the forcing at the beginning of the leg.
    pub frequency: f64,
    start: f64,
    rate: f64,
    /// Phase of the forcing at the beginning of the leg, within a turn.
    turned: Sum,
    /// Time before the leg.
    passed: Sum,
}

/// A sum with its rounding error, because many equal steps would all be rounded the same way.
#[derive(Clone, Copy, Debug, Default)]
struct Sum(f64, f64);

impl Sum {
    fn add(&mut self, term: f64) {
        let Sum(before, rest) = *self;
        let sum = before + term;
        let added = sum - before;
        *self = Sum(sum, rest + (before - (sum - added)) + (term - added));
    }
}

impl Clock {
    /// Starts the clock at the beginning of a run.
    pub fn new(scaled: &Scaled) -> Self {
        let (start, rate) = (scaled.start, scaled.rate);
        Clock { frequency: start, start, rate, turned: Sum::default(), passed: Sum::default() }
    }

    /// Returns the phase of the forcing at the beginning of the leg.
    pub fn phase(&self) -> f64 {
        self.turned.0 + self.turned.1
    }

    /// Returns the phase of the forcing at a time of the leg.
    #[inline]
    pub fn phase_at(&self, time: f64) -> f64 {
        self.phase() + time * (self.frequency + 0.5 * self.rate * time)
    }

    /// Begins the next leg, `time` after the beginning of this one.
    pub fn advance(&mut self, time: f64) {
        self.turned.add(time * (self.frequency + 0.5 * self.rate * time));
        self.turned.0 %= TAU;
        self.passed.add(time);
        self.frequency = self.start + self.rate * (self.passed.0 + self.passed.1);
    }

    /// Returns the time from the beginning of the leg to a moment of the run.
    pub fn until(&self, moment: f64) -> f64 {
        (moment - self.passed.0) - self.passed.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::{Case, Kind};

    #[test]
    fn jacobian_is_the_derivative_of_the_rates() {
        for kind in Kind::ALL {
            let scaled = Case::new(kind, 10).scaled;
            let by = [0.2, -0.5, 0.7, 0.3];
            // Far from the Stribeck peak, and on it.
            for slip in [-0.3, -0.01] {
                let y = [0.3, slip - scaled.sliding, 0.6, 0.1];
                let at = |size: f64| {
                    let mut rates = [0.0; 4];
                    let moved: Vec<f64> = y.iter().zip(by).map(|(y, by)| y + size * by).collect();
                    scaled.held(-1.0, 0.4, &moved, &mut rates);
                    rates
                };
                let mut product = [0.0; 4];
                scaled.jacobian(-1.0, &y, &by, &mut product);
                let (ahead, behind) = (at(1e-5), at(-1e-5));
                for i in 0..4 {
                    let difference = (ahead[i] - behind[i]) / 2e-5;
                    assert!((product[i] - difference).abs() < 2e-5, "{kind:?} {i}: {} {difference}", product[i]);
                }
            }
        }
    }

    #[test]
    fn a_clock_of_legs_keeps_the_time() {
        let scaled = Scaled { rate: 1e-4, ..Case::new(Kind::Ordinary, 10).scaled };
        let mut clock = Clock::new(&scaled);
        for _ in 0..10_000 {
            clock.advance(0.1);
        }
        // A tenth is not a binary number: 10 000 of them are 1000 within the rounding error of a
        // tenth.
        assert!(clock.until(1000.0).abs() < 1e-13, "{:e}", clock.until(1000.0));
        let phase: f64 = 1000.0 * (scaled.start + 0.5 * scaled.rate * 1000.0);
        assert!((clock.phase().cos() - phase.cos()).abs() < 1e-11);
    }
}
