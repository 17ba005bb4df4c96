//! Coulomb friction in the contact zone around each crest, in closed form.
//!
//! At any moment the surface is one sine wave: `w = R cos p`, `p` the angle from the crest, `R^2 = q_s^2 + q_c^2`. A compliant
//! layer presses the rigid rotor, which stands at height `h`, with `R cos p - h` per unit of its stiffness wherever that is
//! positive: `|p| < pc`, `cos pc = h / R`. By `u = -z dw/dx` (thesis B.13) the surface moves along the ring at
//!
//! ```text
//! u' = U cos p + W sin p = D cos(p - delta),   U = -z k R phi',   W = z k R'
//! ```
//!
//! with `phi` the crest's phase; in a pure travelling wave `W` is zero. Friction is `mu` times pressure towards the faster side, so
//! it changes its sign where `D cos(p - delta) = v`, the rotor's surface speed: at `p = delta +- acos(v / D)`. Between these and the
//! zone's ends every integral is elementary, with
//!
//! ```text
//! P0 = R sin p - h p                            (integral of the pressure)
//! P1 = R (p / 2 + sin 2p / 4) - h sin p         (times cos p)
//! P2 = R sin^2 p / 2 + h cos p                  (times sin p)
//! ```
//!
//! so neither a quadrature nor a small step is needed to follow the places where the surface sticks.

use std::f64::consts::{PI, TAU};

/// Length of a vector. Nothing here is near the ends of the number range, for which `hypot` takes five times as long.
#[inline]
pub(super) fn length(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}

/// The contact layer as the friction sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer {
    /// Coefficient of friction between rotor and stator.
    pub mu: f64,
    /// Stiffness of the whole layer, N/m: force over approach if it touched everywhere.
    pub stiffness_n_per_m: f64,
}

/// The wave under the rotor at one moment, in the frame of its crest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Crest {
    /// Height of the crests, m.
    pub height_m: f64,
    /// Height at which the rotor stands over the neutral line, m; below minus the crest's height it touches everywhere.
    pub rotor_m: f64,
    /// Surface speed at the crest, m/s.
    pub along_m_per_s: f64,
    /// Part of the surface speed that is a quarter wave off: of a crest that grows, m/s.
    pub across_m_per_s: f64,
}

/// What the friction of all crests adds up to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pull {
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
    /// Half the angle over which a crest touches, rad; pi if the wave touches everywhere.
    pub fn zone(&self) -> f64 {
        if self.rotor_m <= -self.height_m {
            PI
        } else if self.rotor_m >= self.height_m {
            0.0
        } else {
            libm::acos(self.rotor_m / self.height_m)
        }
    }

    /// Integrals of the pressure, and of it times cosine and sine, from `a` to `b`.
    fn pressed(&self, a: f64, b: f64) -> [f64; 3] {
        let (r, h) = (self.height_m, self.rotor_m);
        let at = |p: f64| {
            let (sin, cos) = libm::sincos(p);
            [r * sin - h * p, 0.5 * r * (p + sin * cos) - h * sin, 0.5 * r * sin * sin + h * cos]
        };
        let (a, b) = (at(a), at(b));
        std::array::from_fn(|n| b[n] - a[n])
    }

    /// The friction on a rotor whose surface moves at `speed` m/s. Where nothing slips at all (no wave, rotor at rest) it is zero:
    /// what holds the rotor then is not a function of its speed.
    pub fn friction(&self, layer: &Layer, speed: f64) -> Pull {
        let zone = self.zone();
        if zone == 0.0 {
            return Pull::default();
        }
        let all = self.pressed(-zone, zone);
        let faster = self.faster_side(zone, speed);
        let scale = layer.stiffness_n_per_m / TAU;
        let [force_n, cos_n, sin_n] = std::array::from_fn(|n| layer.mu * scale * (2.0 * faster[n] - all[n]));
        let pull = Pull { force_n, cos_n, sin_n, normal_n: scale * all[0] };
        let still = self.along_m_per_s == 0.0 && self.across_m_per_s == 0.0 && speed == 0.0;
        if still { Pull { normal_n: pull.normal_n, ..Pull::default() } } else { pull }
    }

    /// The integrals over the part of the zone where the surface is faster than the rotor.
    fn faster_side(&self, zone: f64, speed: f64) -> [f64; 3] {
        let amplitude = length(self.along_m_per_s, self.across_m_per_s);
        if speed >= amplitude {
            return [0.0; 3];
        }
        if speed <= -amplitude {
            return self.pressed(-zone, zone);
        }
        let delta = libm::atan2(self.across_m_per_s, self.along_m_per_s);
        let half = libm::acos(speed / amplitude);
        let mut sum = [0.0; 3];
        // The arc may reach over either end of the turn.
        for centre in [delta - TAU, delta, delta + TAU] {
            let (from, to) = ((centre - half).max(-zone), (centre + half).min(zone));
            if from < to {
                let part = self.pressed(from, to);
                sum = std::array::from_fn(|n| sum[n] + part[n]);
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAYER: Layer = Layer { mu: 0.3, stiffness_n_per_m: 5e7 };

    /// Independent of the closed form: the midpoint rule over the turn.
    fn by_quadrature(crest: &Crest, speed: f64) -> Pull {
        let slices = 400_000;
        // A little more than the zone.
        let span = if crest.rotor_m < -crest.height_m { PI } else { (1.01 * (crest.rotor_m / crest.height_m).acos()).min(PI) };
        let mut sum = Pull::default();
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
        // The midpoint rule misplaces each of two crossings by up to half a slice, where the pressure is up to twice its mean:
        // 0.3 x 2 x 2 / 400 000 = 3e-6 of the normal force.
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
    fn nothing_slips_where_nothing_moves() {
        let crest = Crest { height_m: 0.0, rotor_m: -1e-7, ..Crest::default() };
        let pull = crest.friction(&LAYER, 0.0);
        assert_eq!(pull.force_n, 0.0);
        assert!((pull.normal_n - 5.0).abs() < 1e-12);
    }
}
