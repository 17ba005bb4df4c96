//! A torso in its shoulder belt, over a D-ring, in a crash.
//!
//! ```text
//! torso m, x --- shoulder span ks, slack --- D-ring (capstan, p) --- retractor span kr --- spool with load limiter, s
//! ```
//!
//! In the frame of the vehicle, which the pulse `a(t)` decelerates:
//!
//! ```text
//! m x'' = m a(t) - Ts                       torso, once that is positive: then it leaves the back
//!                                           of its seat permanently.
//!                                           Nothing else holds it: no airbag, no lap belt
//! Ts = T0 + ks [(x - p) beyond slack]       shoulder span
//! Tr = T0 + kr (p - s)                      retractor span
//! out:   Ts = Tr exp(mu theta),  p' > 0     capstan, Euler 1769, Eytelwein 1808
//! stick: Tr exp(-mu theta) <= Ts <= Tr exp(mu theta),  p' = 0
//! back:  Tr = Ts exp(mu theta),  p' < 0
//! spool: s' = 0 below the limiter's force, Tr = limiter and s' = p' > 0 at it; it winds loose webbing up at Tr = T0
//! ```
//!
//! States: `x`, `v`, `s`, and `p`. `p` is integrated only if the friction depends on the sliding
//! speed; otherwise it follows from the others or is constant. `mu` is the friction coefficient as
//! reduced by the [actuator] at that speed.
//!
//! Validity: massless webbing, the torso as a single mass, a rigid pulse, friction that does not
//! rise at rest. Between events the motion is smooth and is integrated by the classical
//! fourth-order Runge-Kutta method; each [event](motion) is located to 1e-12 s.

pub mod actuator;
pub mod capstan;
pub mod crash;
pub mod mode;
pub mod motion;
pub mod pulse;
pub mod span;
pub mod state;

#[cfg(test)]
mod tests;

use self::actuator::Actuator;
use self::capstan::Capstan;
use self::pulse::{Course, Pulse};
use self::span::Span;

/// Constants of a crash.
#[derive(Clone, Debug, PartialEq)]
pub struct Bench {
    /// Mass of the torso, kg.
    pub torso_kg: f64,
    /// Deceleration of the vehicle.
    pub pulse: Pulse,
    /// Webbing between torso and D-ring.
    pub shoulder: Span,
    /// Webbing between D-ring and spool.
    pub retractor: Span,
    /// D-ring that the webbing slides over.
    pub capstan: Capstan,
    /// Force at which the load limiter lets the spool turn, N.
    pub limiter_n: f64,
    /// Actuator that lowers the friction.
    pub actuator: Actuator,
}

impl Bench {
    /// Creates the bench of a scene; the pulse begins at the scene's time.
    pub fn of(scene: &scene::Dring) -> Self {
        Bench {
            torso_kg: scene.torso_mass_kg(),
            pulse: Pulse {
                at_s: scene.at_s,
                length_s: scene.pulse_s(),
                course: match &scene.pulse {
                    Some(profile) => Course::Measured(profile.clone()),
                    None => Course::HalfSine(scene.pulse_g.unwrap_or(0.0) * G_M_PER_S2),
                },
            },
            shoulder: Span {
                stiffness_n_per_m: scene.belt_stiffness_n_per_m,
                slack_m: scene.slack_m,
                pretension_n: scene.pretension_n,
            },
            retractor: Span {
                stiffness_n_per_m: scene.retractor_stiffness_n_per_m,
                slack_m: 0.0,
                pretension_n: scene.pretension_n,
            },
            capstan: Capstan {
                wrap_rad: scene.wrap_deg.to_radians(),
                mu_high: scene.mu_high,
                mu_low: scene.mu_low.min(scene.mu_high),
            },
            limiter_n: scene.limiter_n,
            actuator: Actuator::from_dring(scene),
        }
    }

    /// Returns the bench with a passive belt, whose friction is never lowered.
    pub fn passive(&self) -> Self {
        Bench { actuator: Actuator::None, ..self.clone() }
    }
}

/// Standard gravity as rounded in belt design, m/s^2.
pub const G_M_PER_S2: f64 = 9.81;
