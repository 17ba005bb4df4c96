//! Coulomb friction in the contact zone around each crest, in closed form.
//!
//! At any moment the surface is one sine wave: `w = R cos p`, with `p` the angle from the crest and
//! `R^2 = q_s^2 + q_c^2`. The rigid rotor is at height `h` over a compliant layer. The pressure is
//! `R cos p - h` times the layer's stiffness where that is positive: `|p| < pc`,
//! `cos pc = h / R`. By `u = -z dw/dx` (thesis B.13) the surface moves along the ring at
//!
//! ```text
//! u' = U cos p + W sin p = D cos(p - delta),   U = -z k R phi',   W = z k R'
//! ```
//!
//! with `phi` the crest's phase; in a pure travelling wave `W` is zero. Friction is `mu` times the
//! pressure, in the direction of the faster side. Its sign therefore changes at
//! `D cos(p - delta) = v`, the rotor's surface speed: at `p = delta +- acos(v / D)`. Between these
//! places and the ends of the zone every integral is elementary, with
//!
//! ```text
//! P0 = R sin p - h p                            (integral of the pressure)
//! P1 = R (p / 2 + sin 2p / 4) - h sin p         (times cos p)
//! P2 = R sin^2 p / 2 + h cos p                  (times sin p)
//! ```
//!
//! No quadrature and no small step is needed to locate the sticking places.

use std::f64::consts::TAU;

/// Returns the length of a vector. The values here are far from the ends of the number range, for
/// which `hypot` takes five times as long.
#[inline]
pub(super) fn length(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}

/// Returns the sine of an angle from 0 to pi from its cosine.
#[inline]
fn sine(cos: f64) -> f64 {
    ((1.0 - cos) * (1.0 + cos)).sqrt()
}

/// An angle with its cosine and sine.
#[derive(Clone, Copy, Debug)]
struct Angle {
    /// The angle, rad; for a difference of two primitives only up to a constant.
    p: f64,
    cos: f64,
    sin: f64,
}

/// Friction properties of the contact layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer {
    /// Coefficient of friction between rotor and stator.
    pub mu: f64,
    /// Stiffness of the whole layer, N/m: force over approach at contact everywhere.
    pub stiffness_n_per_m: f64,
}

/// The wave under the rotor at one moment, in the frame of its crest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Crest {
    /// Height of the crests, m.
    pub height_m: f64,
    /// Height of the rotor over the neutral line, m. Below minus the crest's height the contact is
    /// everywhere.
    pub rotor_m: f64,
    /// Surface speed at the crest, m/s.
    pub along_m_per_s: f64,
    /// Part of the surface speed in quadrature with the crest, from a growing crest, m/s.
    pub across_m_per_s: f64,
}

/// Sum of the friction over all crests.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CrestFriction {
    /// Force on the rotor along the ring, N.
    pub force_n: f64,
    /// Force along the ring weighted with `cos p`, N.
    pub cos_n: f64,
    /// Force along the ring weighted with `sin p`, N.
    pub sin_n: f64,
    /// Normal force on the rotor, N.
    pub normal_n: f64,
}

impl Crest {
    /// Returns half the angle over which a crest touches, rad; pi if the wave touches everywhere.
    pub fn zone(&self) -> f64 {
        libm::acos(self.cos_zone())
    }

    /// Returns the cosine of [`zone`](Self::zone).
    fn cos_zone(&self) -> f64 {
        match (self.rotor_m, self.height_m) {
            (rotor_m, height_m) if rotor_m <= -height_m => -1.0,
            (rotor_m, height_m) if rotor_m >= height_m => 1.0,
            (rotor_m, height_m) => rotor_m / height_m,
        }
    }

    /// Returns `P0`, `P1` and `P2` at an angle.
    fn primitive(&self, Angle { p, cos, sin }: Angle) -> [f64; 3] {
        let (r, h) = (self.height_m, self.rotor_m);
        [r * sin - h * p, 0.5 * r * (p + sin * cos) - h * sin, 0.5 * r * sin * sin + h * cos]
    }

    /// Returns the friction on a rotor whose surface moves at `speed` m/s. It is zero if nothing
    /// slips at all (no wave, rotor at rest): the holding force is not a function of the speed.
    pub fn friction(&self, layer: &Layer, speed: f64) -> CrestFriction {
        let zone = self.zone();
        if zone == 0.0 {
            return CrestFriction::default();
        }
        let cos = self.cos_zone();
        let end = self.primitive(Angle { p: zone, cos, sin: sine(cos) });
        // P0 and P1 are odd, P2 is even.
        let all = [2.0 * end[0], 2.0 * end[1], 0.0];
        let faster = self.faster_side(zone, end, speed).unwrap_or(all);
        let scale = layer.stiffness_n_per_m / TAU;
        let [force_n, cos_n, sin_n] = std::array::from_fn(|n| layer.mu * scale * (2.0 * faster[n] - all[n]));
        let pull = CrestFriction { force_n, cos_n, sin_n, normal_n: scale * all[0] };
        let still = self.along_m_per_s == 0.0 && self.across_m_per_s == 0.0 && speed == 0.0;
        if still { CrestFriction { normal_n: pull.normal_n, ..CrestFriction::default() } } else { pull }
    }

    /// Returns the integrals over the part of the zone in which the surface is faster than the
    /// rotor; `None` for all of it. `end` is the primitive at the end of the zone.
    fn faster_side(&self, zone: f64, end: [f64; 3], speed: f64) -> Option<[f64; 3]> {
        let amplitude = length(self.along_m_per_s, self.across_m_per_s);
        if speed >= amplitude {
            return Some([0.0; 3]);
        }
        if speed <= -amplitude {
            return None;
        }
        let (cos_delta, sin_delta) = (self.along_m_per_s / amplitude, self.across_m_per_s / amplitude);
        let cos = speed / amplitude;
        let (half, sin) = (libm::acos(cos), sine(cos));
        // Cosine and sine of both crossings by the addition theorem.
        let crossing = |sin: f64| (cos_delta * cos - sin_delta * sin, sin_delta * cos + cos_delta * sin);
        let [first, last] = [crossing(-sin), crossing(sin)];
        let at = |p: f64, (cos, sin): (f64, f64)| self.primitive(Angle { p, cos, sin });
        let cos_zone = self.cos_zone();
        if self.along_m_per_s > 0.0 && speed > 0.0 && first.0 > cos_zone && last.0 > cos_zone {
            // The arc is within the zone and shorter than half a turn. The angles only enter by
            // their difference, so that its centre is not needed.
            let (a, b) = (at(-half, first), at(half, last));
            return Some(std::array::from_fn(|n| b[n] - a[n]));
        }
        let mirrored = [-end[0], -end[1], end[2]];
        let delta = libm::atan2(self.across_m_per_s, self.along_m_per_s);
        let mut sum = [0.0; 3];
        // The arc may extend past either end of the turn.
        for centre in [delta - TAU, delta, delta + TAU] {
            let (from, to) = (centre - half, centre + half);
            if from.max(-zone) < to.min(zone) {
                let a = if from <= -zone { mirrored } else { at(from, first) };
                let b = if to >= zone { end } else { at(to, last) };
                sum = std::array::from_fn(|n| sum[n] + (b[n] - a[n]));
            }
        }
        Some(sum)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    const LAYER: Layer = Layer { mu: 0.3, stiffness_n_per_m: 5e7 };

    /// Integrates by the midpoint rule over the turn, independently of the closed form.
    fn by_quadrature(crest: &Crest, speed: f64) -> CrestFriction {
        let slices = 400_000;
        // A little more than the zone.
        let span = if crest.rotor_m < -crest.height_m { PI } else { (1.01 * (crest.rotor_m / crest.height_m).acos()).min(PI) };
        let mut sum = CrestFriction::default();
        for n in 0..slices {
            let p = span * (2.0 * (f64::from(n) + 0.5) / f64::from(slices) - 1.0);
            let share = span / PI / f64::from(slices);
            let pressure = (crest.height_m * p.cos() - crest.rotor_m).max(0.0) * LAYER.stiffness_n_per_m * share;
            let slip = crest.along_m_per_s * p.cos() + crest.across_m_per_s * p.sin() - speed;
            let friction = LAYER.mu * pressure * slip.signum();
            sum.force_n += friction;
            sum.cos_n += friction * p.cos();
            sum.sin_n += friction * p.sin();
            sum.normal_n += pressure;
        }
        sum
    }

    /// Zones from a few degrees to the whole turn, pure and growing waves, every kind of crossing.
    #[test]
    fn the_closed_form_is_the_integral() {
        let mut worst = 0.0f64;
        for rotor_m in [-3e-6, -1.2e-6, -0.4e-6, 0.0, 0.5e-6, 0.99e-6] {
            for (along_m_per_s, across_m_per_s) in
                [(0.1, 0.0), (-0.1, 0.0), (0.07, 0.05), (-0.02, 0.09), (0.01, -0.1), (0.0, 0.1)]
            {
                for speed in [-0.2, -0.05, 0.0, 0.03, 0.0999, 0.2] {
                    let crest = Crest { height_m: 1e-6, rotor_m, along_m_per_s, across_m_per_s };
                    let (closed, summed) = (crest.friction(&LAYER, speed), by_quadrature(&crest, speed));
                    let scale = summed.normal_n.max(1e-3);
                    for (a, b) in [
                        (closed.force_n, summed.force_n),
                        (closed.cos_n, summed.cos_n),
                        (closed.sin_n, summed.sin_n),
                        (closed.normal_n, summed.normal_n),
                    ] {
                        worst = worst.max((a - b).abs() / scale);
                    }
                }
            }
        }
        // The midpoint rule misplaces each of two crossings by up to half a slice, where the
        // pressure is up to twice its mean: 0.3 x 2 x 2 / 400 000 = 3e-6 of the normal force.
        assert!(worst < 3e-6, "{worst:e}");
    }

    #[test]
    fn friction_never_drives_the_slip() {
        for n in 0..2000 {
            let at = |k: f64| (f64::from(n) * k).sin();
            let crest = Crest {
                height_m: 1e-6,
                rotor_m: 1.5e-6 * at(0.37) - 0.6e-6,
                along_m_per_s: 0.1 * at(1.7),
                across_m_per_s: 0.1 * at(2.3),
            };
            let speed = 0.12 * at(0.91);
            let pull = crest.friction(&LAYER, speed);
            let heat = pull.cos_n * crest.along_m_per_s + pull.sin_n * crest.across_m_per_s - pull.force_n * speed;
            assert!(heat >= -1e-12, "{n}: {heat:e}");
            assert!(pull.force_n.abs() <= LAYER.mu * pull.normal_n * (1.0 + 1e-12));
        }
    }

    #[test]
    fn no_motion_gives_no_friction() {
        let crest = Crest { height_m: 0.0, rotor_m: -1e-7, ..Crest::default() };
        let pull = crest.friction(&LAYER, 0.0);
        assert_eq!(pull.force_n, 0.0);
        assert!((pull.normal_n - 5.0).abs() < 1e-12);
    }
}
