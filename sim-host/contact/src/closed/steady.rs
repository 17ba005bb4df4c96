//! Friction within a period of the steady state: `V = xi + cos p`, Dahl or Coulomb.
//!
//! Forward `f = 1 - d_f exp(-kappa slip)`, backward `f = -1 + d_b exp(-kappa slip)`, slip since the reversal, with the distances to the
//! bounds `d_f = 2 (1 - e^-2B) / (1 - e^-2(A+B))` and `d_b = 2 (1 - e^-2A) / (1 - e^-2(A+B))` that one period leaves as they are.

use std::f64::consts::{PI, TAU};

use super::swing::Swing;
use super::{NO_MEMORY_LOST, both_forgotten, coulomb_friction_ratio, limit_ratio};

/// One period of steady friction.
#[derive(Clone, Copy, Debug)]
pub struct Steady {
    /// Negative sliding is positive sliding half a period later, mirrored.
    mirrored: bool,
    course: Course,
}

#[derive(Clone, Copy, Debug)]
enum Course {
    /// Nothing reverses, or nothing is forgotten.
    Constant(f64),
    /// The sign of the slip, forward within this angle of the maximum, rad.
    Sign(f64),
    Dahl {
        ways: [Swing; 2],
        /// d_f and d_b.
        distances: [f64; 2],
    },
}

impl Steady {
    /// For a velocity ratio and a kappa >= 0 (infinite: Coulomb).
    pub fn new(xi: f64, kappa: f64) -> Self {
        let size = xi.abs();
        let course = if size >= 1.0 {
            Course::Constant(1.0)
        } else if kappa < NO_MEMORY_LOST {
            Course::Constant(limit_ratio(size))
        } else if kappa == f64::INFINITY {
            Course::Sign(0.5 * PI * (1.0 + coulomb_friction_ratio(size)))
        } else {
            let ways = Swing::both(size, kappa);
            let both = both_forgotten(&ways[0], &ways[1]);
            Course::Dahl { ways, distances: [2.0 * ways[1].forgotten() / both, 2.0 * ways[0].forgotten() / both] }
        };
        Steady { mirrored: xi < 0.0, course }
    }

    /// F / Fc at a phase, in turns since the vibration velocity was at its maximum.
    pub fn force(&self, phase_turns: f64) -> f64 {
        if self.mirrored { -self.forward_sliding(phase_turns + 0.5) } else { self.forward_sliding(phase_turns) }
    }

    fn forward_sliding(&self, phase_turns: f64) -> f64 {
        // Within half a turn of the maximum
        let p = TAU * (phase_turns - phase_turns.round());
        match &self.course {
            Course::Constant(force) => *force,
            Course::Sign(half_rad) => (half_rad - p.abs()).signum(),
            Course::Dahl { ways: [forward, backward], distances } => {
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
