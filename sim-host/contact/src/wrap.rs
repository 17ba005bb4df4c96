//! Webbing that slides over a ring which vibrates as a whole in one direction: friction along the angle of wrap.
//!
//! ```text
//!            n    outward normal at the middle of the wrap
//!            |  / d
//!   shoulder | /  direction of the vibration: `a` in the plane of the wrap, from n towards the shoulder; `g` out of it, towards the ring's axis
//!         .--+--.
//!        /   |   \      place p: angle from the middle, -wrap/2 at the retractor, +wrap/2 at the shoulder
//!       |         |
//! ```
//!
//! At the place p the vibration of peak velocity V has three parts,
//!
//! ```text
//! normal       V cos g cos(p - a)
//! tangential   V cos g sin(p - a)       along the sliding
//! transverse   V sin g                  across it, along the ring's axis
//! ```
//!
//! and the tension follows `dT/dp = mu r(p, T, v) T`, the capstan of Euler and Eytelwein with a friction ratio `r` that depends on the place. The in-surface
//! part of it, `r_s`, is the mean of Coulomb friction of a sine at an angle, in closed form ([`sine_friction`]), at the velocity ratio
//! `v / (V sqrt(tangential^2 + transverse^2))`. It does not depend on the tension: `T1 / T2 = exp(mu int r_s dp)`. Two limits are exact: without vibration
//! `exp(mu wrap)`, and along the ring's axis `exp(r mu wrap)` with the transverse law.
//!
//! The [normal part](normal) multiplies it, `r = r_s r_n`, or is granted nothing. **Both are bounds, not a model of what happens between.** That it changes nothing is
//! exact for a contact that is stiff along the surface and never lost: the normal force is then `W (1 + A cos wt)`, even in time about the moments at which the
//! in-surface part of the same vibration turns round, and the slip is the same function of time on both sides of the moment at which it is fastest, where
//! `cos wt` changes sign: `mean (N f) = W mean f` (test `a_stiff_contact_knows_no_normal_part`). That it multiplies means that both act in full.
//!
//! | part of the law | cost | error |
//! |---|---|---|
//! | [`exponent`] | quadrature with 16 nodes in panels between the kinks, about 100 laws | estimated, 1e-12 asked |
//! | [`table`] of it over the velocity ratio, inverted | a polynomial of degree 11 a call; with a normal part, whose law has the speed in it, some of them; made in a millisecond, or in tens where the vibration is barely out of the plane | 1e-10 of the ratio |
//! | [`ode`], for a normal part that depends on the tension in any way | some hundred laws | estimated |
//!
//! **Where it holds.** Webbing without bending stiffness and mass; a ring that is round and rigid and moves as a whole; webbing that does not follow the ring's
//! motion, neither along nor across; Coulomb friction, dry and isotropic; one sliding speed along the wrap (webbing that does not stretch).

mod chebyshev;
mod corners;
pub mod exponent;
mod gauss;
mod integrals;
pub mod normal;
pub mod ode;
pub mod table;

#[cfg(test)]
mod tests;

use std::f64::consts::PI;

use super::SolveError;
use super::plane::Direction;
use super::plane::coulomb::sine_friction;

/// A ring with webbing around it, and the direction in which it vibrates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ring {
    /// Angle of wrap, rad.
    pub wrap_rad: f64,
    /// Coefficient of friction without vibration.
    pub mu: f64,
    /// The smallest friction ratio to which the in-surface part brings any place, 0 to 1.
    pub floor: f64,
    /// Direction of the vibration in the plane of the wrap, from the outward normal at its middle towards the shoulder, rad.
    pub angle_rad: f64,
    /// The part of the vibration in the plane of the wrap, and the part along the ring's axis.
    pub plane: Direction,
}

/// Parts of the vibration at a place, over its peak velocity; none is negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parts {
    /// Part across the surface.
    pub normal: f64,
    /// Part along the sliding.
    pub tangential: f64,
    /// Part across the sliding, in the surface.
    pub transverse: f64,
}

/// Which end of the wrap pulls.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pull {
    /// Webbing slides towards the shoulder, where the tension is higher.
    Shoulder,
    /// Webbing slides towards the retractor, where the tension is higher.
    Retractor,
}

impl Ring {
    /// A ring; angles in degrees, `axis_deg` from 0 in the plane of the wrap to 90 along the ring's axis.
    ///
    /// # Errors
    /// If an angle or a coefficient is out of its range.
    pub fn new(wrap_deg: f64, mu: f64, floor: f64, (angle_deg, axis_deg): (f64, f64)) -> Result<Self, SolveError> {
        let ranges = [
            ("angle of wrap", wrap_deg, 0.0, 720.0, "degrees"),
            ("coefficient of friction", mu, 0.0, 10.0, ""),
            ("smallest friction ratio", floor, 0.0, 1.0, ""),
            ("direction of the vibration", angle_deg, -360.0, 360.0, "degrees"),
            ("angle out of the plane of the wrap", axis_deg, 0.0, 90.0, "degrees"),
        ];
        for (what, value, least, most, unit) in ranges {
            if !(least..=most).contains(&value) {
                let reason = format!("the {what} is {value} {unit}, and must be from {least} to {most} {unit}");
                return Err(SolveError::Unsuited { method: "wrap", reason });
            }
        }
        let (wrap_rad, angle_rad) = (wrap_deg.to_radians(), angle_deg.to_radians());
        Ok(Ring { wrap_rad, mu, floor, angle_rad, plane: Direction::from_degrees(axis_deg) })
    }

    /// Parts of the vibration at a place, rad from the middle of the wrap.
    pub fn parts(&self, place_rad: f64) -> Parts {
        let (sine, cosine) = (place_rad - self.angle_rad).sin_cos();
        let Direction { along, across } = self.plane;
        Parts { normal: along * cosine.abs(), tangential: along * sine.abs(), transverse: across }
    }

    /// Friction ratio of the in-surface part at a place, at a sliding speed over the peak velocity of the vibration.
    pub fn in_surface(&self, place_rad: f64, velocity_ratio: f64) -> f64 {
        self.of_tangential(self.parts(place_rad).tangential, velocity_ratio)
    }

    /// Friction ratio where the vibration has this part along the sliding.
    fn of_tangential(&self, tangential: f64, velocity_ratio: f64) -> f64 {
        let size = tangential.hypot(self.plane.across);
        if size == 0.0 || velocity_ratio == f64::INFINITY {
            return 1.0;
        }
        let direction = Direction { along: tangential / size, across: self.plane.across / size };
        sine_friction(velocity_ratio / size, direction).clamp(self.floor, 1.0)
    }

    /// Places within the wrap at which the law over the place is not smooth, in order, with both ends of the wrap. `more` are parts of the vibration
    /// across the surface at which the normal part is not.
    fn kinks(&self, velocity_ratio: f64, more: &[f64]) -> Vec<f64> {
        let half = 0.5 * self.wrap_rad;
        let mut from_angle = vec![0.0, 0.5 * PI];
        let in_plane = self.plane.along;
        let sines = [velocity_ratio / in_plane, self.tangential_at_floor(velocity_ratio).unwrap_or(2.0) / in_plane];
        from_angle.extend(sines.into_iter().filter(|sine| *sine < 1.0).map(f64::asin));
        from_angle.extend(more.iter().map(|normal| normal / in_plane).filter(|cosine| *cosine < 1.0).map(f64::acos));
        let turns = (self.wrap_rad / PI).ceil() as i32 + 3;
        let mut kinks = vec![-half, half];
        for angle in from_angle {
            for turn in -turns..=turns {
                let middle = self.angle_rad + f64::from(turn) * PI;
                kinks.extend([middle - angle, middle + angle].into_iter().filter(|kink| kink.abs() < half));
            }
        }
        kinks.sort_by(f64::total_cmp);
        kinks.dedup_by(|next, kept| *next - *kept < 1e-13);
        kinks
    }

    /// The part along the sliding at which the in-surface part comes to the floor; none if it does so nowhere, or everywhere.
    fn tangential_at_floor(&self, velocity_ratio: f64) -> Option<f64> {
        let bare = Ring { floor: 0.0, ..*self };
        let above = |tangential: f64| bare.of_tangential(tangential, velocity_ratio) - self.floor;
        let (mut low, mut high) = (0.0, self.plane.along);
        if !(above(low) > 0.0 && above(high) < 0.0) {
            return None;
        }
        if self.plane.across == 0.0 {
            return Some(velocity_ratio / (0.5 * PI * self.floor).sin()).filter(|tangential| *tangential < high);
        }
        while high - low > 1e-15 * high {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            if above(middle) > 0.0 { low = middle } else { high = middle }
        }
        Some(high)
    }
}
