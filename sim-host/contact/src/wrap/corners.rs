//! The velocity ratios at which a kink of the law enters at an end of the wrap, or meets a fixed
//! kink. At these the integrals have square-root singularities.

use std::f64::consts::PI;

use super::Ring;
use super::normal::Normal;

/// Velocity ratio below which the friction ratio is a straight line, if it is above its floor from
/// zero on.
const LINEAR_VELOCITY_RATIO: f64 = 1e-9;
/// Velocity ratio above which the asymptote is used, if the vibration has a transverse part.
const ASYMPTOTE_VELOCITY_RATIO: f64 = 1e3;

impl Ring {
    /// Returns the logarithms of the velocity ratios between which the law is smooth, in order. The
    /// first and the last are the ends of a table.
    pub(super) fn corners(&self, normal: Option<&Normal>) -> Vec<f64> {
        let half = 0.5 * self.wrap_rad;
        let sine = |place: f64| self.plane.along * (place - self.angle_rad).sin().abs();
        // `true` if the wrap contains a position at this angle from the direction of the vibration,
        // or from its opposite.
        let within = |angle: f64| {
            let from = (-half - self.angle_rad - angle) / PI;
            from.ceil() * PI <= half - self.angle_rad - angle
        };
        let mut sines = vec![sine(-half), sine(half)];
        sines.extend(within(0.0).then_some(0.0));
        sines.extend(within(0.5 * PI).then_some(self.plane.along));
        let saturated = normal.map(|normal| normal.saturated() / self.plane.along).filter(|cosine| *cosine < 1.0);
        let saturated = saturated.map(f64::acos).filter(|angle| within(*angle) || within(-angle));
        sines.extend(saturated.map(|angle| self.plane.along * angle.sin()));
        let mut ratios: Vec<f64> = sines.iter().filter_map(|&tangential| self.leaves_the_floor(tangential)).collect();
        // Along the sliding alone friction is restored at a velocity ratio of one. Otherwise there
        // is not a corner but a strong bend.
        let first = match ratios.iter().copied().fold(f64::INFINITY, f64::min) {
            above if above > 0.0 && above.is_finite() => above,
            _ => LINEAR_VELOCITY_RATIO,
        };
        ratios.extend(sines.iter().copied().filter(|sine| *sine > 0.0));
        let last = if self.plane.across == 0.0 { ratios.iter().copied().fold(0.0, f64::max) } else { ASYMPTOTE_VELOCITY_RATIO };
        ratios.retain(|ratio| *ratio > first && *ratio < last);
        ratios.extend([first, last]);
        let mut corners: Vec<f64> = ratios.into_iter().map(f64::ln).collect();
        corners.sort_by(f64::total_cmp);
        corners.dedup_by(|next, kept| *next - *kept < 1e-9);
        corners
    }

    /// Returns the velocity ratio at which the in-surface ratio leaves the floor, for a tangential
    /// part of the vibration; `None` if the floor is one.
    fn leaves_the_floor(&self, tangential: f64) -> Option<f64> {
        let size = tangential.hypot(self.plane.across);
        if self.floor >= 1.0 {
            return None;
        }
        if self.plane.across == 0.0 {
            return Some(tangential * (0.5 * PI * self.floor).sin());
        }
        if self.floor == 0.0 {
            return Some(0.0);
        }
        let bare = Ring { floor: 0.0, ..*self };
        let (mut low, mut high) = (1e-12 * size, 1e12 * size);
        while high / low > 1.0 + 1e-15 {
            let middle = (low * high).sqrt();
            if middle <= low || middle >= high {
                break;
            }
            if bare.of_tangential(tangential, middle) > self.floor { high = middle } else { low = middle }
        }
        Some(high)
    }
}
