//! A rigid rotor on a travelling wave, with Coulomb friction and the pressure of a bed of springs.
//!
//! At the phase theta from a crest the face moves with `V cos theta`, and presses with
//! `p(theta) = K a cos theta + d` if that is positive. Parts of the face that are faster than the
//! rotor drive it, the others brake it:
//!
//! ```text
//! F / (mu W) = 2 P(theta_v)/P(theta_c) - 1,   cos theta_v = v/V,   P(theta) = int_0^theta p
//! ```
//!
//! This model is ours, as the thesis has no model of the contact.

use std::f64::consts::PI;

/// Contact of the rotor with the wave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Offset of the pressure, d/(K a); above one, the troughs also touch.
    offset: f64,
}

impl Contact {
    /// Creates the contact for a mean pressure W, given over K a.
    pub fn loaded(load: f64) -> Contact {
        if load >= 1.0 {
            return Contact { offset: load };
        }
        // W/(K a) = (sin c - c cos c)/pi rises with the half angle c.
        let (mut low, mut high) = (0.0, PI);
        for _ in 0..100 {
            let c: f64 = 0.5 * (low + high);
            if (c.sin() - c * c.cos()) / PI < load { low = c } else { high = c }
        }
        Contact { offset: -low.cos() }
    }

    /// Creates the contact for a half angle, rad.
    #[cfg(test)]
    fn half_angle(angle: f64) -> Contact {
        Contact { offset: -angle.cos() }
    }

    /// Returns the half angle of contact, rad.
    pub fn angle(&self) -> f64 {
        (-self.offset).clamp(-1.0, 1.0).acos()
    }

    /// Returns the integral of the pressure over K a, from the crest to `theta`.
    fn pressed(&self, theta: f64) -> f64 {
        theta.sin() + self.offset * theta
    }

    /// Returns the tangential force over mu W at a speed over the crest's speed.
    pub fn force(&self, speed: f64) -> f64 {
        let theta = speed.clamp(-1.0, 1.0).acos().min(self.angle());
        2.0 * self.pressed(theta) / self.pressed(self.angle()) - 1.0
    }

    /// Returns the speed over the crest's speed at a tangential force over mu W; `None` if the
    /// rotor slips back even at rest.
    pub fn speed(&self, force: f64) -> Option<f64> {
        if self.force(0.0) < force {
            return None;
        }
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if self.force(middle) > force { low = middle } else { high = middle }
        }
        Some(low)
    }
}

/// Returns the drag on a rotor that touches the tops, over `a w z k` of the forward wave, with a
/// backward wave. It is the mean over the sheet of the face's velocity along it, each place taken
/// at its highest moment.
pub fn drag(backward: f64) -> f64 {
    let places = 360;
    let mean = |of: &dyn Fn(f64) -> f64| (0..places).map(|i| of(2.0 * PI * f64::from(i) / f64::from(places))).sum::<f64>();
    let at = |kx: f64| {
        // w = sin(wt - kx) + B sin(wt + kx) = c cos wt + s sin wt is largest at wt = atan2(s, c).
        let (c, s) = ((backward - 1.0) * kx.sin(), (backward + 1.0) * kx.cos());
        let wt = s.atan2(c);
        -((wt - kx).sin() - backward * (wt + kx).sin())
    };
    let drag = -mean(&at) / f64::from(places);
    // A sum that cancels leaves round-off.
    if drag.abs() < 1e-12 { 0.0 } else { drag }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// No-load speeds of the feasibility study, which integrated the same pressure with other code.
    #[test]
    fn no_load_speeds_are_those_of_an_independent_study() {
        for (degrees, speed) in [(15.0_f64, 0.9959), (30.0, 0.9836), (45.0, 0.9637), (60.0, 0.9368)] {
            let found = Contact::half_angle(degrees.to_radians()).speed(0.0).expect("it moves");
            assert!((found - speed).abs() < 5e-5, "{degrees}: {found}");
        }
    }

    /// Compares with the sum of the friction around the wave.
    #[test]
    fn the_force_is_the_sum_of_friction() {
        for load in [0.05, 0.3, 0.9, 2.0, 10.0] {
            let contact = Contact::loaded(load);
            let (mut drive, mut pressed) = (0.0, 0.0);
            for i in 0..200_000 {
                let theta = PI * (f64::from(i) + 0.5) / 200_000.0;
                let pressure = (theta.cos() + contact.offset).max(0.0);
                pressed += pressure;
                drive += pressure * (theta.cos() - 0.4).signum();
            }
            assert!((contact.force(0.4) - drive / pressed).abs() < 2e-5, "{load}");
            assert!((pressed / 200_000.0 - load).abs() < 1e-8, "{load}");
        }
    }

    #[test]
    fn a_standing_wave_drags_nowhere() {
        assert!((drag(0.0) - 1.0).abs() < 1e-12 && drag(1.0) == 0.0);
        assert!((drag(0.5) + drag(2.0) / 2.0).abs() < 1e-12, "{} {}", drag(0.5), drag(2.0));
    }
}
