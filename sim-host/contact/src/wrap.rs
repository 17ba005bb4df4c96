//! Friction along the angle of wrap for webbing that slides over a ring, while the whole ring
//! vibrates in one direction.
//!
//! ```text
//!            n    outward normal at the middle of the wrap
//!            |  / d
//!   shoulder | /  direction of the vibration: `a` in the plane of the wrap, from n towards the
//!         .--+--.  shoulder; `g` out of it, towards the ring's axis
//!        /   |   \      position p: angle from the middle, -wrap/2 at the retractor, +wrap/2 at
//!       |         |     the shoulder
//! ```
//!
//! At the position p the vibration of peak velocity V has three parts,
//!
//! ```text
//! normal       V cos g cos(p - a)
//! tangential   V cos g sin(p - a)       along the sliding
//! transverse   V sin g                  across it, along the ring's axis
//! ```
//!
//! and the tension follows `dT/dp = mu r(p, T, v) T`, the capstan equation of Euler and Eytelwein
//! with a friction ratio `r` that depends on the position. Its in-surface part, `r_s`, is the mean
//! of Coulomb friction under a sine at an angle, in closed form ([`sine_friction`]), at the
//! velocity ratio `v / (V sqrt(tangential^2 + transverse^2))`. It does not depend on the tension:
//! `T1 / T2 = exp(mu int r_s dp)`. Two limits are exact: without vibration `exp(mu wrap)`, and
//! along the ring's axis `exp(r mu wrap)` with the transverse law.
//!
//! The [normal part](normal) either multiplies it, `r = r_s r_n`, or has no effect. **Both are
//! bounds, not a model of the behaviour in between.** No effect is exact for a contact that is
//! stiff along the surface and never lost. The normal force is then `W (1 + A cos wt)`, and the
//! slip is symmetric in time about the moments at which it is fastest, when `cos wt` changes sign:
//! `mean (N f) = W mean f` (test `a_stiff_contact_knows_no_normal_part`). The product means that
//! both parts act in full.
//!
//! | part of the law | cost | error |
//! |---|---|---|
//! | [`exponent`] | quadrature with 16 nodes in panels between the kinks, about 100 evaluations of the law | estimated, 1e-12 requested |
//! | [`table`] of it over the velocity ratio, inverted | a polynomial of degree 11 per call; several with a normal part, whose law depends on the speed; built in a millisecond, or in tens of milliseconds if the vibration is barely out of the plane | 1e-10 of the ratio |
//! | [`ode`], for a normal part that depends on the tension in any way | several hundred evaluations of the law | estimated |
//!
//! **Validity.** Webbing without bending stiffness, mass or stretch; one sliding speed along the
//! wrap. A round, rigid ring that moves as a whole. Webbing that does not follow the motion of the
//! ring, neither along nor across. Coulomb friction, dry and isotropic.

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

/// Ring with webbing around it, and the direction in which it vibrates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ring {
    /// Angle of wrap, rad.
    pub wrap_rad: f64,
    /// Coefficient of friction without vibration.
    pub mu: f64,
    /// Smallest friction ratio to which the in-surface part can lower friction at a position, 0 to
    /// 1.
    pub floor: f64,
    /// Direction of the vibration in the plane of the wrap, from the outward normal at its middle
    /// towards the shoulder, rad.
    pub angle_rad: f64,
    /// Components of the vibration in the plane of the wrap and along the ring's axis.
    pub plane: Direction,
}

/// Parts of the vibration at a position, over its peak velocity; none is negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parts {
    /// Part across the surface.
    pub normal: f64,
    /// Part along the sliding.
    pub tangential: f64,
    /// Part across the sliding, in the surface.
    pub transverse: f64,
}

/// End of the wrap that pulls.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pull {
    /// Webbing slides towards the shoulder, where the tension is higher.
    Shoulder,
    /// Webbing slides towards the retractor, where the tension is higher.
    Retractor,
}

impl Ring {
    /// Creates a ring; angles in degrees, `axis_deg` from 0 in the plane of the wrap to 90 along
    /// the ring's axis.
    ///
    /// # Errors
    /// Fails if an angle or a coefficient is out of its range.
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

    /// Returns the parts of the vibration at a position, rad from the middle of the wrap.
    pub fn parts(&self, place_rad: f64) -> Parts {
        let (sine, cosine) = (place_rad - self.angle_rad).sin_cos();
        let Direction { along, across } = self.plane;
        Parts { normal: along * cosine.abs(), tangential: along * sine.abs(), transverse: across }
    }

    /// Returns the friction ratio of the in-surface part at a position, at a sliding speed over the
    /// peak velocity of the vibration.
    pub fn in_surface(&self, place_rad: f64, velocity_ratio: f64) -> f64 {
        self.of_tangential(self.parts(place_rad).tangential, velocity_ratio)
    }

    /// Returns the friction ratio for a tangential part of the vibration.
    fn of_tangential(&self, tangential: f64, velocity_ratio: f64) -> f64 {
        let size = tangential.hypot(self.plane.across);
        if size == 0.0 || velocity_ratio == f64::INFINITY {
            return 1.0;
        }
        let direction = Direction { along: tangential / size, across: self.plane.across / size };
        sine_friction(velocity_ratio / size, direction).clamp(self.floor, 1.0)
    }

    /// Returns the positions within the wrap at which the law is not smooth, in order, with both
    /// ends of the wrap. `more` lists the normal parts of the vibration at which the effect of the
    /// normal part is not smooth.
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

    /// Returns the tangential part at which the in-surface ratio reaches the floor; `None` if it
    /// does so nowhere, or everywhere.
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
