//! Coulomb friction on an undamped oscillator under a cosine, in closed form between its reversals.
//! This is the limit of a Dahl contact of growing stiffness, independent of the stepping methods.
//!
//! ```text
//! m x'' + Ks x = F0 cos(w t) - s Fc,   s = sgn V,   V = Vt + x'
//! x = -s Fc / Ks + xa cos(w t) + A cos(wn t) + B sin(wn t),   xa = F0 / (Ks - m w^2)
//! ```
//!
//! Between reversals A and B are constant. At a reversal velocity and displacement are continuous,
//! so A and B change. The mass cannot stick, as Fc is far below its inertia force.
//!
//! Near the limit a stiff Dahl contact lags after each reversal: with `V = a t` there, friction is
//! `s (1 - 2 exp(-Kt a t^2 / 2 Fc))`, so each reversal takes `sqrt(2 pi Fc / (Kt a))` from the time
//! of its sign. The remaining difference is of the order of one over kappa.

use contact::{Law, Motion, Problem};

/// Number of places a period at which the slip is evaluated.
const SAMPLES_PER_PERIOD: u32 = 256;

/// Mean friction ratios of a problem from rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// Mean of sgn V over the window.
    pub coulomb: f64,
    /// Mean friction ratio of a stiff Dahl contact, with the lag after each reversal.
    pub lagging: f64,
}

/// Computes the limit of a problem; `None` without an oscillator under Dahl friction.
pub fn coulomb_limit(problem: &Problem) -> Option<Limit> {
    let Law::Dahl { stiffness_n_per_m: contact_n_per_m } = problem.law else { return None };
    let Motion::Sdof { mass_kg, stiffness_n_per_m, .. } = problem.motion else { return None };
    let omega = std::f64::consts::TAU * problem.waveform.frequency_hz();
    let natural = (stiffness_n_per_m / mass_kg).sqrt();
    let forced_m = problem.waveform.amplitude() / (stiffness_n_per_m - mass_kg * omega * omega);
    let offset_m = problem.coulomb_n / stiffness_n_per_m;
    let mut sign = 1.0;
    let [mut a, mut b] = [offset_m - forced_m, 0.0];
    let rate = |t: f64, a: f64, b: f64| {
        -forced_m * omega * (omega * t).sin() + natural * (b * (natural * t).cos() - a * (natural * t).sin())
    };
    let slip = |t: f64, a: f64, b: f64| problem.sliding_m_per_s + rate(t, a, b);
    // |dV/dt| of the motion; the effect of friction's own jump is far smaller.
    let steepness = |t: f64, a: f64, b: f64| {
        let free = natural * natural * (b * (natural * t).sin() + a * (natural * t).cos());
        (forced_m * omega * omega * (omega * t).cos() + free).abs()
    };
    let look_s = 1.0 / (problem.waveform.frequency_hz() * f64::from(SAMPLES_PER_PERIOD));
    let looks = (problem.duration_s / look_s).round() as u64;
    let (mut forward_s, mut late_s, mut since) = (0.0, 0.0, 0.0f64);
    let (from, to) = problem.window_s;
    let within = |start: f64, end: f64| (end.min(to) - start.max(from)).max(0.0);
    for look in 1..=looks {
        let end = look as f64 * look_s;
        if slip(end, a, b) * sign < 0.0 {
            let (mut low, mut high) = (end - look_s, end);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if slip(middle, a, b) * sign > 0.0 { low = middle } else { high = middle }
            }
            forward_s += sign * within(since, low);
            since = low;
            // x is continuous: the free part takes over the change of the offset.
            let jump = 2.0 * sign * offset_m;
            a -= jump * (natural * low).cos();
            b -= jump * (natural * low).sin();
            sign = -sign;
            if low > from && low < to {
                late_s += sign * (std::f64::consts::TAU * problem.coulomb_n / (contact_n_per_m * steepness(low, a, b))).sqrt();
            }
        }
    }
    forward_s += sign * within(since, problem.duration_s);
    Some(Limit { coulomb: forward_s / (to - from), lagging: (forward_s - late_s) / (to - from) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use contact::table_4_1::table_4_1;

    #[test]
    fn a_steady_motion_has_the_arcsine_law() {
        // Negligible friction, and a natural motion so slow that its velocity is small:
        // (2 / pi) asin xi.
        let mut problem = table_4_1(0.5, 2000.0);
        problem.coulomb_n *= 1e-9;
        problem.motion = Motion::Sdof { mass_kg: 0.02, stiffness_n_per_m: 1.0, damping_n_s_per_m: 0.0 };
        problem.sliding_m_per_s = 0.5 * problem.vibration_m_per_s();
        let mean = coulomb_limit(&problem).unwrap().coulomb;
        let exact = 2.0 / std::f64::consts::PI * 0.5f64.asin();
        assert!((mean - exact).abs() < 1e-4, "{mean} {exact}");
    }
}
