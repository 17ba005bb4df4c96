//! The effect of a time interval on the bristles. Their equation is linear in their force, with
//! coefficients that follow from the given slip.
//!
//! ```text
//! f = B / Fc        f' = p - q f,   p = Kt w / Fc,   q = Kt |w| / G(|w|)
//! F / Fc = (1 - t q) f + b w,       t = sigma1 / Kt,   b = (sigma1 + sigma2) / Fc
//! f(t) = f(0) (1 - lost(t)) + gained(t)       lost' = q (1 - lost),   gained' = p - q gained,   both zero at the start
//! ```
//!
//! So force, mean, power and mean square after any time are polynomials in the initial force: a
//! [`Passage`], which grows panel by panel. For stiff bristles, `lost` reaches one, and `gained`
//! turns smoothly with the slip except at the beginning. `lost` is stored instead of the remaining
//! fraction, so that for soft bristles no small value is rounded against one.

use super::super::forcing::Forcing;
use super::super::problem::Law;
use super::Direction;
use crate::radau::{STAGES, rule, solve};

/// Bristles under a given slip.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bristles {
    pub(super) law: Law,
    pub(super) coulomb_n: f64,
    pub(super) sliding_m_per_s: f64,
    /// Direction of the vibration, with its sign in the slip.
    pub(super) direction: Direction,
}

/// Coefficients at one moment.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rates {
    /// Slip velocity, m/s.
    pub(super) slip: [f64; 2],
    /// Coefficient q, 1/s.
    loss: f64,
    /// Ratio p / w = Kt / Fc, 1/m.
    gain: f64,
    /// Share of the bristles' force in the friction, 1 - t q.
    elastic: f64,
    /// Coefficient b, s/m.
    viscous: f64,
}

impl Bristles {
    /// Returns the slip velocity at a vibration velocity, m/s.
    pub(super) fn slip(&self, u: f64) -> [f64; 2] {
        [self.sliding_m_per_s + self.direction.along * u, self.direction.across * u]
    }

    pub(super) fn rates(&self, u: f64) -> Rates {
        let slip = self.slip(u);
        let speed = slip[0].hypot(slip[1]);
        match self.law {
            Law::Coulomb => Rates { slip, loss: 0.0, gain: 0.0, elastic: 1.0, viscous: 0.0 },
            Law::Dahl { stiffness_n_per_m } => {
                let gain = stiffness_n_per_m / self.coulomb_n;
                Rates { slip, loss: gain * speed, gain, elastic: 1.0, viscous: 0.0 }
            }
            Law::Lugre { stiffness_n_per_m, static_ratio, stribeck_m_per_s, sigma1, sigma2 } => {
                let gain = stiffness_n_per_m / self.coulomb_n;
                let limit = 1.0 + (static_ratio - 1.0) * (-(speed / stribeck_m_per_s).powi(2)).exp();
                let loss = gain * speed / limit;
                let (elastic, viscous) = (1.0 - sigma1 / stiffness_n_per_m * loss, (sigma1 + sigma2) / self.coulomb_n);
                Rates { slip, loss, gain, elastic, viscous }
            }
        }
    }

    /// Returns friction over the Coulomb force, for a given bristle force over the Coulomb force.
    pub(super) fn friction(&self, rates: &Rates, force: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| rates.elastic * force[axis] + rates.viscous * rates.slip[axis])
    }
}

/// Effect of a time interval on the bristle force f, and its integrals of the friction F over Fc.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Passage {
    /// Length of the interval, s.
    time_s: f64,
    /// Integral of the vibration velocity, m.
    pub(super) travel_m: f64,
    /// Integral of q: a difference in force fades as its negative exponential.
    pub(super) fading: f64,
    lost: f64,
    gained: [f64; 2],
    /// Integral of f, s: `mean.0 f(0) + mean.1`.
    mean: (f64, [f64; 2]),
    /// Integral of F w / Fc, m: `power.0 . f(0) + power.1`, with a scalar product.
    power: ([f64; 2], f64),
    /// Integral of (F_y / Fc)^2, s: coefficients of f_y(0)^2, f_y(0) and one.
    square: [f64; 3],
}

/// Integrals over a passage.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Sums {
    /// Length of the interval, s.
    pub(super) time_s: f64,
    /// Integral of F / Fc along the sliding, s.
    pub(super) friction: f64,
    /// Integral of F w / Fc, m.
    pub(super) power: f64,
    /// Integral of (F_y / Fc)^2, s.
    pub(super) square: f64,
}

impl Passage {
    /// Returns this passage extended by one panel, s from the beginning of the forcing, by the
    /// polynomial of collocation; `None` if values overflow.
    pub(super) fn and_panel(&self, bristles: &Bristles, forcing: &Forcing, (from_s, to_s): (f64, f64)) -> Option<Self> {
        let (rule, length_s) = (rule(), to_s - from_s);
        let velocity = rule.at.map(|at| forcing.value(from_s + at * length_s));
        let rates = velocity.map(|u| bristles.rates(u));
        let left = 1.0 - self.lost;
        // Right-hand sides for the increments of the three quantities over the panel.
        let (mut matrix, mut sides) = (rule.slope, [[0.0; 3]; STAGES]);
        for (node, Rates { slip, loss, gain, .. }) in rates.iter().enumerate() {
            matrix[node][node] += length_s * loss;
            let gains = [0, 1].map(|axis| length_s * (gain * slip[axis] - loss * self.gained[axis]));
            sides[node] = [length_s * loss * left, gains[0], gains[1]];
        }
        let found = solve(matrix, sides)?;
        let mut passage = *self;
        passage.time_s += length_s;
        passage.lost += found[STAGES - 1][0];
        passage.gained = [0, 1].map(|axis| self.gained[axis] + found[STAGES - 1][1 + axis]);
        for (((rates, [lost, along, across]), weight), u) in rates.iter().zip(found).zip(rule.weight).zip(velocity) {
            let time_s = weight * length_s;
            let factor = rates.elastic * (left - lost);
            let rest = bristles.friction(rates, [self.gained[0] + along, self.gained[1] + across]);
            passage.travel_m += time_s * u;
            passage.fading += time_s * rates.loss;
            passage.mean.0 += time_s * (left - lost);
            passage.mean.1[0] += time_s * (self.gained[0] + along);
            passage.mean.1[1] += time_s * (self.gained[1] + across);
            for axis in [0, 1] {
                passage.power.0[axis] += time_s * factor * rates.slip[axis];
                passage.power.1 += time_s * rest[axis] * rates.slip[axis];
            }
            passage.square[0] += time_s * factor * factor;
            passage.square[1] += time_s * 2.0 * factor * rest[1];
            passage.square[2] += time_s * rest[1] * rest[1];
        }
        Some(passage)
    }

    /// Returns the force at the end, from that at the start.
    pub(super) fn end(&self, start: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| start[axis] + (self.gained[axis] - self.lost * start[axis]))
    }

    /// Returns the integrals for an initial force.
    pub(super) fn sums(&self, bristles: &Bristles, start: [f64; 2]) -> Sums {
        // The integral of dB/dt is the change of the force.
        let (damping_s, viscous) = match bristles.law {
            Law::Lugre { stiffness_n_per_m, sigma1, sigma2, .. } => (sigma1 / stiffness_n_per_m, sigma2 / bristles.coulomb_n),
            Law::Coulomb | Law::Dahl { .. } => (0.0, 0.0),
        };
        let slip_m = bristles.sliding_m_per_s * self.time_s + bristles.direction.along * self.travel_m;
        let turned = self.end(start)[0] - start[0];
        Sums {
            time_s: self.time_s,
            friction: self.mean.0 * start[0] + self.mean.1[0] + damping_s * turned + viscous * slip_m,
            power: self.power.0[0] * start[0] + self.power.0[1] * start[1] + self.power.1,
            square: (self.square[0] * start[1] + self.square[1]) * start[1] + self.square[2],
        }
    }

    /// Returns the difference of two passages over the same interval, for forces up to one: in the
    /// force at the end, and in the mean over a unit of time.
    pub(super) fn distance(&self, other: &Passage, unit_s: f64) -> (f64, f64) {
        let end = |axis: usize| (self.gained[axis] - other.gained[axis]).abs();
        let mean = |axis: usize| (self.mean.1[axis] - other.mean.1[axis]).abs();
        let of_end = (self.lost - other.lost).abs().max(end(0)).max(end(1));
        let of_mean = (self.mean.0 - other.mean.0).abs().max(mean(0)).max(mean(1)) / unit_s;
        (of_end, of_mean)
    }
}
