//! Friction with a static peak: the LuGre model, stepped in slip.
//!
//! ```text
//! dz/dt = V - |V| z / G(V),   Kt G(V) = Fc + (Fs - Fc) exp(-(V / Vs)^2),   F = Kt z + sigma1 dz/dt + sigma2 V
//! ```
//!
//! (Canudas de Wit, Olsson, Åström and Lischinsky 1995.) While `G` is constant, `Kt z` is Dahl's
//! force with the Coulomb force `Kt G`, which [`Dahl`] integrates exactly in slip. Here `G` is
//! constant during a step, at the step's mean velocity. The mean of `dz/dt` over a step is the
//! change of `z`, for any motion. Units: N, m, s.

use crate::dahl::Dahl;

/// Squared speed, in units of the Stribeck velocity, above which the peak is neglected: `exp(-40)`
/// is 4e-18.
const NEGLIGIBLE_SPEED_SQUARE: f64 = 40.0;

/// A contact whose static friction is more than its kinetic friction.
#[derive(Clone, Debug)]
pub struct Stribeck {
    bristles: Dahl,
    /// Bristle stiffness Kt, N/m.
    kt: f64,
    /// Kinetic friction, N.
    kinetic_n: f64,
    /// Static minus kinetic friction, N.
    peak_n: f64,
    /// One over the Stribeck velocity, s/m.
    per_speed: f64,
    sigma1: f64,
    sigma2: f64,
}

impl Stribeck {
    /// Creates the relaxed contact of a scene under a normal force, N.
    pub fn new(contact: &scene::Lugre, normal_n: f64) -> Self {
        Stribeck {
            bristles: Dahl::new(contact.stiffness_n_per_m, contact.static_mu * normal_n),
            kt: contact.stiffness_n_per_m,
            kinetic_n: contact.mu * normal_n,
            peak_n: (contact.static_mu - contact.mu) * normal_n,
            per_speed: 1.0 / contact.stribeck_m_per_s,
            sigma1: contact.sigma1,
            sigma2: contact.sigma2,
        }
    }

    /// Returns the present force of the bristles, N, in the direction of the slip that caused it.
    pub fn force(&self) -> f64 {
        self.bristles.force()
    }

    /// Slips by `slip` metres within `step_s` seconds, from velocity `v0` to `v1`. Returns the time
    /// mean of the friction, N.
    pub fn slip(&mut self, v0: f64, v1: f64, slip: f64, step_s: f64) -> f64 {
        let square = (slip / step_s * self.per_speed).powi(2);
        let peak_n = if square < NEGLIGIBLE_SPEED_SQUARE { self.peak_n * libm::exp(-square) } else { 0.0 };
        self.bristles.set_coulomb_force(self.kinetic_n + peak_n);
        let before = self.bristles.force();
        let mean = self.bristles.slip(v0, v1, slip, step_s);
        let bent_m = (self.bristles.force() - before) / self.kt;
        mean + (self.sigma1 * bent_m + self.sigma2 * slip) / step_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Under a steady slip the force follows the Stribeck curve, at any speed and in either
    /// direction.
    #[test]
    fn the_steady_force_is_the_stribeck_curve() {
        let contact = lugre();
        for speed in [1e-5, 3e-4, 1e-3, 0.1, -2e-4] {
            let mut friction = Stribeck::new(&contact, 200.0);
            let mut force = 0.0;
            for _ in 0..60_000 {
                force = friction.slip(speed, speed, speed * 1e-4, 1e-4);
            }
            let curve = 200.0 * (0.25 + 0.1 * (-(speed / 3e-4f64).powi(2)).exp()) * speed.signum() + 20.0 * speed;
            // The slowest has moved by twenty bristle lengths.
            assert!((force - curve).abs() < 5e-3, "{speed}: {force} for {curve}");
        }
    }

    /// A tip that vibrates over a slow carriage, against the differential equation itself, stepped
    /// by the midpoint rule a hundred times finer.
    #[test]
    fn a_vibrating_contact_matches_the_differential_equation() {
        const TAU: f64 = std::f64::consts::TAU;
        let (contact, normal, period) = (lugre(), 200.0, 25e-6);
        let velocity = |t: f64| 2e-3 + 0.05 * libm::cos(TAU * t / period);
        let place = |t: f64| 2e-3 * t + 0.05 * period / TAU * libm::sin(TAU * t / period);
        let periods = 40;
        let mean_of = |steps: usize| {
            let (mut friction, step) = (Stribeck::new(&contact, normal), period / steps as f64);
            let mut sum = 0.0;
            for n in 0..periods * steps {
                let (t0, t1) = (n as f64 * step, (n + 1) as f64 * step);
                let force = friction.slip(velocity(t0), velocity(t1), place(t1) - place(t0), step);
                sum += if n >= (periods - 10) * steps { force } else { 0.0 };
            }
            sum / (10 * steps) as f64
        };
        let rate = |z: f64, v: f64| {
            let level =
                normal * (contact.mu + (contact.static_mu - contact.mu) * libm::exp(-(v / contact.stribeck_m_per_s).powi(2)));
            v - v.abs() * z * contact.stiffness_n_per_m / level
        };
        let (steps, mut z, mut sum) = (20_000, 0.0, 0.0);
        let step = period / steps as f64;
        for n in 0..periods * steps {
            let t = n as f64 * step;
            let half = z + 0.5 * step * rate(z, velocity(t));
            let middle = velocity(t + 0.5 * step);
            let slope = rate(half, middle);
            let force = contact.stiffness_n_per_m * half + contact.sigma1 * slope + contact.sigma2 * middle;
            sum += if n >= (periods - 10) * steps { force } else { 0.0 };
            z += step * slope;
        }
        let reference = sum / (10 * steps) as f64;
        let errors = [25, 100].map(|steps| (mean_of(steps) / reference - 1.0).abs());
        println!("mean friction {reference} N, errors at 25 and 100 steps {errors:?}");
        assert!(errors[0] < 1e-5 && errors[1] < 3e-5, "{errors:?} of {reference}");
    }

    fn lugre() -> scene::Lugre {
        scene::Lugre {
            mu: 0.25,
            static_mu: 0.35,
            normal_n: None,
            stiffness_n_per_m: 25e6,
            stribeck_m_per_s: 3e-4,
            sigma1: 0.0,
            sigma2: 20.0,
            sign: None,
        }
    }
}
