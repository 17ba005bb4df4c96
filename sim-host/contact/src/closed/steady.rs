//! Friction within a period of the steady state: `V = xi + cos p`, Dahl or Coulomb.
//!
//! Forward `f = 1 - d_f exp(-kappa slip)`, backward `f = -1 + d_b exp(-kappa slip)`, with the slip
//! since the reversal. The distances to the bounds, `d_f = 2 (1 - e^-2B) / (1 - e^-2(A+B))` and
//! `d_b = 2 (1 - e^-2A) / (1 - e^-2(A+B))`, repeat after one period.

use std::f64::consts::{PI, TAU};

use super::stroke::Stroke;
use super::{CONSTANT_FRICTION_KAPPA, both_forgotten, coulomb_friction_ratio, limit_ratio};

/// One period of steady friction.
#[derive(Clone, Copy, Debug)]
pub struct Steady {
    /// `true` for negative sliding, which is positive sliding half a period later, mirrored.
    mirrored: bool,
    profile: Profile,
}

#[derive(Clone, Copy, Debug)]
enum Profile {
    /// Constant friction: the slip does not reverse, or friction does not relax.
    Constant(f64),
    /// Sign of the slip: forward within this angle around the maximum, rad.
    Sign(f64),
    Dahl {
        strokes: [Stroke; 2],
        /// d_f and d_b.
        distances: [f64; 2],
    },
}

impl Steady {
    /// Computes the steady friction for a velocity ratio and a kappa >= 0 (infinite: Coulomb).
    pub fn new(xi: f64, kappa: f64) -> Self {
        let size = xi.abs();
        let profile = if size >= 1.0 {
            Profile::Constant(1.0)
        } else if kappa < CONSTANT_FRICTION_KAPPA {
            Profile::Constant(limit_ratio(size))
        } else if kappa == f64::INFINITY {
            Profile::Sign(0.5 * PI * (1.0 + coulomb_friction_ratio(size)))
        } else {
            let strokes = Stroke::both(size, kappa);
            let both = both_forgotten(&strokes[0], &strokes[1]);
            Profile::Dahl { strokes, distances: [2.0 * strokes[1].forgotten() / both, 2.0 * strokes[0].forgotten() / both] }
        };
        Steady { mirrored: xi < 0.0, profile }
    }

    /// Returns F / Fc at a phase, in turns since the maximum of the vibration velocity.
    pub fn force(&self, phase_turns: f64) -> f64 {
        if self.mirrored { -self.forward_sliding(phase_turns + 0.5) } else { self.forward_sliding(phase_turns) }
    }

    fn forward_sliding(&self, phase_turns: f64) -> f64 {
        // Reduced to half a turn on either side of the maximum.
        let p = TAU * (phase_turns - phase_turns.round());
        match &self.profile {
            Profile::Constant(force) => *force,
            Profile::Sign(half_rad) => (half_rad - p.abs()).signum(),
            Profile::Dahl { strokes: [forward, backward], distances } => {
                let half_rad = 0.5 * forward.length_rad();
                if p.abs() <= half_rad {
                    return 1.0 - distances[0] * forward.decay(p + half_rad);
                }
                let since = if p > 0.0 { p - half_rad } else { p + TAU - half_rad };
                distances[1] * backward.decay(since.min(backward.length_rad())) - 1.0
            }
        }
    }
}
