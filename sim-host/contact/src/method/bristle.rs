//! Bristles over a step whose slip velocity is a parabola: exact in the slip while the Stribeck
//! level is constant.
//!
//! With `f = Kt z / Fc` and the slip counted in `dL = (Kt/Fc) |V| dt / g(V)`, LuGre's bristle
//! equation (4.7, 4.9) is linear,
//!
//! ```text
//! df/dL = T - f,   T = g(V) sgn V
//! ```
//!
//! and is solved exactly for a T that is a parabola in L, through its values at the beginning,
//! middle and end of the step. If that solution would overshoot, T is taken as linear in each half;
//! the result is then a mean of f and T with positive weights. So `|f|` never exceeds the larger of
//! Fs / Fc and its initial value, at any stiffness. The step is split at zero crossings of the
//! slip.

use super::rates::level;
use crate::problem::Law;

/// Slip length L above which the initial force fades within the step, so that rules for smooth
/// functions of time do not hold.
const FADING_LENGTH: f64 = 2.0;

/// Bristles of a friction law at one Coulomb force.
#[derive(Clone, Copy, Debug)]
pub struct Bristle {
    /// Kt / Fc, 1/m.
    pub per_m: f64,
    static_ratio: f64,
    stribeck_m_per_s: f64,
}

/// Effect of a step on the bristles.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Part {
    /// Force f at the end of the step.
    pub end: f64,
    /// Integral of f over time, s.
    pub impulse: f64,
    /// Integral of f V over time, m.
    pub work: f64,
    /// Slip in units of L.
    pub length: f64,
    /// `e^-L`: remaining fraction of the initial f.
    pub left: f64,
    /// Sign of the first slip; zero without slip.
    pub first: f64,
    /// Sign of the last slip.
    pub sign: f64,
    /// Number of reversals within the step.
    pub reversals: u32,
}

impl Bristle {
    /// Creates the bristles of a law; `None` for Coulomb's law.
    pub fn new(law: Law, coulomb_n: f64) -> Option<Self> {
        match law {
            Law::Coulomb => None,
            Law::Dahl { stiffness_n_per_m } => {
                Some(Bristle { per_m: stiffness_n_per_m / coulomb_n, static_ratio: 1.0, stribeck_m_per_s: 1.0 })
            }
            Law::Lugre { stiffness_n_per_m, static_ratio, stribeck_m_per_s, .. } => {
                Some(Bristle { per_m: stiffness_n_per_m / coulomb_n, static_ratio, stribeck_m_per_s })
            }
        }
    }

    /// Returns `g` at a slip velocity.
    #[inline]
    pub fn level(&self, slip: f64) -> f64 {
        if self.static_ratio == 1.0 { 1.0 } else { level(self.static_ratio, self.stribeck_m_per_s, slip) }
    }

    /// Limits a force that began at f to the larger of Fs / Fc and |f|.
    #[inline]
    pub fn within(&self, f: f64, end: f64) -> f64 {
        let bound = self.static_ratio.max(1.0).max(f.abs());
        end.clamp(-bound, bound)
    }

    /// Advances f by `h` seconds, with the slip velocities at the beginning, middle and end of the
    /// step.
    #[inline]
    pub fn advance(&self, f: f64, h: f64, slip: [f64; 3]) -> Part {
        let [v0, vm, v1] = slip;
        if (v0 > 0.0) == (v1 > 0.0) && (vm > 0.0) == (v0 > 0.0) && 4.0 * vm.abs() > (v0 - v1).abs() {
            return self.between_reversals(f, h, slip);
        }
        self.with_reversals(f, h, slip)
    }

    /// Advances over a step in which the parabola of the slip velocity may cross zero.
    fn with_reversals(&self, f: f64, h: f64, [v0, vm, v1]: [f64; 3]) -> Part {
        // v0 + b u + c u^2 over u from 0 to 1
        let (b, c) = (4.0 * vm - 3.0 * v0 - v1, 2.0 * (v0 - 2.0 * vm + v1));
        let at = |u: f64| v0 + u * (b + u * c);
        let discriminant = b * b - 4.0 * v0 * c;
        let q = -0.5 * (b + discriminant.max(0.0).sqrt().copysign(b));
        let (one, other) = (q / c, v0 / q);
        let mut cuts = if one < other { [one, other, 1.0] } else { [other, one, 1.0] };
        for cut in &mut cuts[..2] {
            // A missing crossing, or one at an end, makes no cut.
            if discriminant <= 0.0 || !(1e-12..1.0 - 1e-12).contains(cut) {
                *cut = 0.0;
            }
        }
        let mut sum = Part { end: f, left: 1.0, ..Part::default() };
        let mut from = 0.0;
        for to in cuts {
            if to <= from {
                continue;
            }
            let part = self.between_reversals(sum.end, (to - from) * h, [at(from), at(0.5 * (from + to)), at(to)]);
            sum.reversals += u32::from(part.sign * sum.sign < 0.0);
            (sum.end, sum.sign) = (part.end, if part.sign == 0.0 { sum.sign } else { part.sign });
            sum.first = if sum.first == 0.0 { part.first } else { sum.first };
            sum.impulse += part.impulse;
            sum.work += part.work;
            sum.length += part.length;
            sum.left *= part.left;
            from = to;
        }
        sum
    }

    /// Advances over a step within which the slip keeps its sign, in two halves.
    #[inline]
    fn between_reversals(&self, f: f64, h: f64, slip: [f64; 3]) -> Part {
        let mean = slip[0] + 4.0 * slip[1] + slip[2];
        let sign = if mean > 0.0 {
            1.0
        } else if mean < 0.0 {
            -1.0
        } else {
            return Part { end: f, impulse: f * h, left: 1.0, ..Part::default() };
        };
        let [g0, gm, g1] = slip.map(|v| self.level(v));
        // Round-off of a crossing at an end has the other sign.
        let [v0, vm, v1] = slip.map(|v| (sign * v).max(0.0));
        let (r0, rm, r1) = (self.per_m * h * v0 / g0, self.per_m * h * vm / gm, self.per_m * h * v1 / g1);
        // Integrals of the parabola through the three points: over the step (Simpson's rule) and
        // over its first half.
        let length = (r0 + 4.0 * rm + r1) / 6.0;
        let first = ((5.0 * r0 + 8.0 * rm - r1) / 24.0).clamp(0.0, length);
        let second = length - first;
        let (middle, end, left) = relax(f, [sign * g0, sign * gm, sign * g1], first, second);
        let simpson = |a: f64, b: f64, c: f64| h / 6.0 * (a + 4.0 * b + c);
        let (impulse, work) = if length < FADING_LENGTH {
            (simpson(f, middle, end), sign * simpson(f * v0, middle * vm, end * v1))
        } else {
            // f = T + d with d' = -rate d, apart from T': the initial deviation d fades within the
            // step.
            let faded = |f0: f64, f1: f64, g0: f64, g1: f64, length: f64| {
                if length < 0.5 * FADING_LENGTH { 0.5 * (f0 + f1 - sign * (g0 + g1)) } else { (f0 - f1) / length }
            };
            let faded = faded(f, middle, g0, gm, first) + faded(middle, end, gm, g1, second);
            let bent = 0.5 * ((g0 + gm) * (middle - f) + (gm + g1) * (end - middle));
            (sign * simpson(g0, gm, g1) + 0.5 * h * faded, simpson(g0 * v0, gm * vm, g1 * v1) - sign * bent / self.per_m)
        };
        Part { end, impulse, work, length, left, first: sign, sign, reversals: 0 }
    }
}

/// Solves `df/dL = T - f` over two halves with T given at their ends. Returns f in the middle and
/// at the end, and the remaining fraction of the initial f.
#[inline]
fn relax(f: f64, [t0, tm, t1]: [f64; 3], first: f64, second: f64) -> (f64, f64, f64) {
    let length = first + second;
    let (to_middle, to_end) = ((-first).exp(), (-second).exp());
    let left = to_middle * to_end;
    if t0 == t1 && tm == t0 {
        return (t0 + (f - t0) * to_middle, t0 + (f - t0) * left, left);
    }
    let part = first / length;
    if part > 0.05 && part < 0.95 {
        // T = t0 + a u + b u^2 with u = L / length
        let b = ((tm - t0) / part - (t1 - t0)) / (part - 1.0);
        let a = t1 - t0 - b;
        let at = |u: f64, length: f64, left: f64| {
            let (mean, mean2) = means_left(length, left);
            t0 + (f - t0) * left + u * (a * (1.0 - mean) + b * u * (1.0 - 2.0 * mean2))
        };
        let (middle, end) = (at(part, first, to_middle), at(1.0, length, left));
        let (low, high) = (f.min(t0).min(tm).min(t1), f.max(t0).max(tm).max(t1));
        if middle >= low && middle <= high && end >= low && end <= high {
            return (middle, end, left);
        }
    }
    let half = |f: f64, from: f64, to: f64, length: f64, left: f64| {
        let (mean, _) = means_left(length, left);
        left * f + (mean - left) * from + (1.0 - mean) * to
    };
    let middle = half(f, t0, tm, first, to_middle);
    (middle, half(middle, tm, t1, second, to_end), left)
}

/// Returns `phi1 = (1 - e^-L) / L` and `phi2 = (1 - phi1) / L`, given L and `e^-L`.
#[inline]
pub fn means_left(length: f64, left: f64) -> (f64, f64) {
    if length < 1e-2 {
        let mean2 = 0.5 - length * (1.0 / 6.0 - length * (1.0 / 24.0 - length / 120.0));
        (1.0 - length * mean2, mean2)
    } else {
        let mean = (1.0 - left) / length;
        (mean, (1.0 - mean) / length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LUGRE: Law =
        Law::Lugre { stiffness_n_per_m: 56e3, static_ratio: 1.5, stribeck_m_per_s: 0.01, sigma1: 0.0, sigma2: 0.0 };

    /// Integrates f, its integral and that of f V in `n` small steps of the midpoint rule in time.
    fn small_steps(bristle: &Bristle, f: f64, h: f64, [v0, vm, v1]: [f64; 3], n: u32) -> [f64; 3] {
        let (b, c) = (4.0 * vm - 3.0 * v0 - v1, 2.0 * (v0 - 2.0 * vm + v1));
        let dt = h / f64::from(n);
        (0..n).fold([f, 0.0, 0.0], |[f, impulse, work], i| {
            let u = (f64::from(i) + 0.5) / f64::from(n);
            let v = v0 + u * (b + u * c);
            let (rate, target) = (bristle.per_m * v.abs() / bristle.level(v), bristle.level(v) * v.signum());
            let middle = (f + 0.5 * dt * rate * target) / (1.0 + 0.5 * dt * rate);
            [2.0 * middle - f, impulse + dt * middle, work + dt * middle * v]
        })
    }

    #[test]
    fn a_dahl_contact_is_exact_in_the_slip() {
        let bristle = Bristle::new(Law::Dahl { stiffness_n_per_m: 1.0 }, 1.0).unwrap();
        // Over 1 s, V = 2 - 8 u + 5 u^2 with the integral -1/3.
        let part = bristle.advance(0.3, 1.0, [2.0, 2.0 - 4.0 + 1.25, -1.0]);
        let root = (8.0 - 24f64.sqrt()) / 10.0;
        let forward = 2.0 * root - 4.0 * root * root + 5.0 / 3.0 * root.powi(3);
        let turned = 1.0 + (0.3 - 1.0) * (-forward).exp();
        let expected = -1.0 + (turned + 1.0) * (-(forward + 1.0 / 3.0)).exp();
        assert!((part.end - expected).abs() < 1e-15 && part.reversals == 1 && part.sign == -1.0, "{part:?} {expected}");
    }

    #[test]
    fn two_reversals_in_a_step_and_a_touch() {
        let bristle = Bristle::new(LUGRE, 0.02).unwrap();
        let inside = bristle.advance(0.9, 1e-8, [0.002, -0.002, 0.002]);
        assert_eq!((inside.reversals, inside.first, inside.sign), (2, 1.0, 1.0));
        let touch = bristle.advance(0.9, 1e-8, [0.002, 0.0, 0.002]);
        assert_eq!((touch.reversals, touch.sign), (0, 1.0));
        let still = bristle.advance(0.9, 1e-8, [0.0; 3]);
        assert_eq!((still.end, still.work, still.sign), (0.9, 0.0, 0.0));
        assert!((still.impulse - 0.9e-8).abs() < 1e-22);
    }

    #[test]
    fn a_step_converges_to_many_small_steps() {
        let bristle = Bristle::new(LUGRE, 0.02).unwrap();
        let worst = |h: f64| {
            // Section of one parabola, over a shorter time.
            let v = |t: f64| 0.004 + 0.01 * t / 1e-7 - 0.02 * (t / 1e-7).powi(2);
            let slip = [v(0.0), v(0.5 * h), v(h)];
            let part = bristle.advance(-0.2, h, slip);
            let [end, impulse, work] = small_steps(&bristle, -0.2, h, slip, 20_000);
            (part.end - end).abs().max((part.impulse - impulse).abs() / h).max((part.work - work).abs() / (h * 0.01))
        };
        let (coarse, fine) = (worst(1e-7 / 2.0), worst(1e-7 / 4.0));
        println!("{coarse:e} {fine:e}");
        assert!(coarse < 1e-5 && fine < coarse / 10.0);
    }

    #[test]
    fn force_is_bounded_at_any_stiffness() {
        for (factor, v1) in [(1e0, 0.01), (1e2, -0.03), (1e4, 0.002), (1e8, 1.0), (1e12, -1e-3)] {
            let law = Law::Lugre {
                stiffness_n_per_m: factor * 56e3,
                static_ratio: 1.5,
                stribeck_m_per_s: 0.01,
                sigma1: 0.0,
                sigma2: 0.0,
            };
            let bristle = Bristle::new(law, 0.02).unwrap();
            for v0 in [-0.05, -0.004, 0.0, 0.003, 0.2] {
                let part = bristle.advance(1.5, 1e-7, [v0, 0.3 * v0 + 0.5 * v1, v1]);
                assert!(part.end.abs() <= 1.5 && part.impulse.abs() <= 1.6e-7, "{factor} {v0} {part:?}");
            }
        }
    }
}
