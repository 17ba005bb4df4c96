//! A carriage: a mass that slides past the tip under the forces that act on it.
//!
//! ```text
//! m v' = P + k (y - x) + c (y' - v) - F,    x' = v,    y' = pull from `pull_at_s` on, before that 0
//! ```
//!
//! `F` is the friction at the tip, positive against a positive `v`. A rotating body is a carriage
//! too: with the contact at radius `r`, `m = J / r^2` and `P = M / r`. The friction changes with
//! the vibration, so the carriage is stepped with the contact, twenty or more times a period. Each
//! step first updates the position with the present speed, then the speed with the mean friction of
//! that step and the spring force at the new position (symplectic Euler, whose energy does not
//! drift). Its error is of the order of the step times `sqrt(k / m)`. Units: kg, m, s, N.

use crate::stribeck::Stribeck;

/// A carriage with its contact.
#[derive(Clone, Debug)]
pub struct Carriage {
    scene: scene::Carriage,
    contact: Stribeck,
    time_s: f64,
    position_m: f64,
    speed_m_per_s: f64,
    /// Position of the spring's end, m.
    end_m: f64,
    /// Speed of the spring's end in the last step, m/s.
    end_m_per_s: f64,
}

/// Forces on a carriage at the end of a block.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CarriageTruth {
    /// Sum of the constant force, spring and damper, N.
    pub pull_n: f64,
    /// Position of the spring's end, m.
    pub end_m: f64,
}

impl Carriage {
    /// Creates the carriage of a scene, at rest on a relaxed contact.
    pub fn new(contact: &scene::Lugre, carriage: &scene::Carriage) -> Self {
        Carriage {
            scene: carriage.clone(),
            contact: Stribeck::new(contact, carriage.normal_n),
            time_s: 0.0,
            position_m: 0.0,
            speed_m_per_s: 0.0,
            end_m: 0.0,
            end_m_per_s: 0.0,
        }
    }

    /// Returns the present force of the contact's bristles, N.
    pub fn force(&self) -> f64 {
        self.contact.force()
    }

    /// Returns the position, m.
    pub fn position_m(&self) -> f64 {
        self.position_m
    }

    /// Returns the speed, m/s.
    pub fn speed_m_per_s(&self) -> f64 {
        self.speed_m_per_s
    }

    /// Returns the present forces on the carriage.
    pub fn truth(&self) -> CarriageTruth {
        CarriageTruth { pull_n: self.pull_n(), end_m: self.end_m }
    }

    fn pull_n(&self) -> f64 {
        let spring_n = self.scene.stiffness_n_per_m * (self.end_m - self.position_m);
        self.scene.force_n + spring_n + self.scene.damping_n_s_per_m * (self.end_m_per_s - self.speed_m_per_s)
    }

    /// Slides for `step_s` seconds, while the tip moves by `moved` metres and its velocity goes
    /// from `v0` to `v1`. Returns the mean friction, N.
    #[inline(never)]
    pub fn slide(&mut self, v0: f64, v1: f64, moved: f64, step_s: f64) -> f64 {
        let speed = self.speed_m_per_s;
        let friction_n = self.contact.slip(speed + v0, speed + v1, speed * step_s + moved, step_s);
        self.position_m += speed * step_s;
        self.end_m_per_s = if self.time_s >= self.scene.pull_at_s { self.scene.pull_m_per_s } else { 0.0 };
        self.end_m += self.end_m_per_s * step_s;
        self.time_s += step_s;
        self.speed_m_per_s += (self.pull_n() - friction_n) / self.scene.mass_kg * step_s;
        friction_n
    }
}

#[cfg(test)]
mod tests;
