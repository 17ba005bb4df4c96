//! The closed form for many points at once: friction and power ratio of steady Dahl friction, several points abreast in SIMD lanes.
//!
//! The same equations as in [`closed`], word for word but for the functions (`functions`): every lane
//! carries its own velocity ratio and kappa, and all go through the rule of the lane that needs most nodes. Points out of the ordinary
//! (|xi| of zero, one or more, kappa of nothing or infinity) are left to the scalar form. What comes out is equal to the scalar result
//! to 1e-13; how much faster it is, the bench says: `cargo bench -p sonoglide-contact`.

mod functions;

use super::closed::gauss;
use super::closed::swing::{CUT, SERIES, TERMS};
use super::closed::{self, NO_MEMORY_LOST};
use functions::{Lanes, arc_cosine, exponential, less_one};

/// Number of points that are computed side by side.
pub const LANES: usize = 4;

/// Friction ratios of the points (xi, kappa), see [`closed::friction_ratio`].
pub fn friction_ratios(points: &[(f64, f64)]) -> Vec<f64> {
    points.chunks(LANES).flat_map(|chunk| lanes_of(chunk, friction, closed::friction_ratio)).collect()
}

/// Power ratios of the points (xi, kappa), see [`closed::power_ratio`]; NaN where there is none.
pub fn power_ratios(points: &[(f64, f64)]) -> Vec<f64> {
    let scalar = |xi, kappa| closed::power_ratio(xi, kappa).unwrap_or(f64::NAN);
    points.chunks(LANES).flat_map(|chunk| lanes_of(chunk, power, scalar)).collect()
}

/// One chunk, in lanes if they are full and ordinary.
#[inline]
fn lanes_of(
    chunk: &[(f64, f64)],
    abreast: impl Fn(Lanes, Lanes) -> Lanes,
    scalar: impl Fn(f64, f64) -> f64,
) -> impl Iterator<Item = f64> {
    let ordinary = |&(xi, kappa): &(f64, f64)| xi != 0.0 && xi.abs() < 1.0 && (NO_MEMORY_LOST..f64::INFINITY).contains(&kappa);
    let mut out = [0.0; LANES];
    if chunk.len() == LANES && chunk.iter().all(ordinary) {
        let lane = |of: fn(&(f64, f64)) -> f64| Lanes::new(std::array::from_fn(|i| of(&chunk[i])));
        out = abreast(lane(|point| point.0), lane(|point| point.1)).to_array();
    } else {
        out.iter_mut().zip(chunk).for_each(|(out, &(xi, kappa))| *out = scalar(xi, kappa));
    }
    out.into_iter().take(chunk.len())
}

fn friction(xi: Lanes, kappa: Lanes) -> Lanes {
    let size = xi.abs();
    let [forward, backward] = Way::both(size, kappa);
    let (forgotten_a, forgotten_b) = (forward.forgotten(), backward.forgotten());
    let difference = forgotten_a * backward.integral() - forgotten_b * forward.integral();
    let both = forgotten_a + forgotten_b * (1.0 - forgotten_a);
    // asin xi = pi / 2 - acos xi, which for xi -> 0 loses what is lost anyway: an absolute 1e-16.
    let coulomb = Lanes::splat(1.0) - backward.half * std::f64::consts::FRAC_2_PI;
    let ratio = coulomb + difference / (both * std::f64::consts::PI);
    (xi.simd_lt(Lanes::ZERO)).select(-ratio, ratio)
}

fn power(xi: Lanes, kappa: Lanes) -> Lanes {
    let size = xi.abs();
    let [forward, backward] = Way::both(size, kappa);
    let apart = size * kappa * std::f64::consts::PI;
    let (forgotten_a, forgotten_b) = (forward.forgotten(), backward.forgotten());
    let (tanh_a, tanh_b) = (forgotten_a / (2.0 - forgotten_a), forgotten_b / (2.0 - forgotten_b));
    // tanh A - tanh B = tanh(A - B) (1 - tanh A tanh B), the last by what either way leaves
    let (left_a, left_b) = (1.0 - forgotten_a, 1.0 - forgotten_b);
    let beside = (left_a + left_b) * 2.0 / ((left_a + 1.0) * (left_b + 1.0));
    let less = less_one(-2.0 * apart);
    let difference = -less / (less + 2.0) * beside;
    let over = forward.over_tanh(tanh_a, left_a) + backward.over_tanh(tanh_b, left_b);
    (over + difference * difference / (tanh_a + tanh_b)) / apart
}

/// One way of the slip, as `closed::swing` has it.
#[derive(Clone, Copy)]
struct Way {
    half: Lanes,
    sine: Lanes,
    cosine: Lanes,
    kappa: Lanes,
    exponent: Lanes,
}

impl Way {
    #[inline]
    fn both(xi: Lanes, kappa: Lanes) -> [Way; 2] {
        let sine = ((1.0 - xi) * (1.0 + xi)).sqrt();
        let backward = arc_cosine(xi);
        [Way::new(std::f64::consts::PI - backward, sine, -xi, kappa), Way::new(backward, sine, xi, kappa)]
    }

    #[inline]
    fn new(half: Lanes, sine: Lanes, cosine: Lanes, kappa: Lanes) -> Self {
        let mut way = Way { half, sine, cosine, kappa, exponent: Lanes::ZERO };
        way.exponent = kappa * way.slip(half);
        way
    }

    #[inline]
    fn forgotten(&self) -> Lanes {
        -less_one(-2.0 * self.exponent)
    }

    #[inline]
    fn left(&self) -> Lanes {
        exponential(-2.0 * self.exponent)
    }

    /// `A - tanh A`, given the last and `exp(-2 A)`.
    fn over_tanh(&self, tanh: Lanes, left: Lanes) -> Lanes {
        let x = self.exponent;
        let large = x.simd_gt(Lanes::splat(1.0));
        if large.all() {
            return x - tanh;
        }
        // x cosh x - sinh x, as in the scalar form; 1 / cosh x = 2 exp(-x) / (1 + exp(-2 x))
        let square = x * x;
        let (mut term, mut sum) = (x, Lanes::ZERO);
        for k in 1..10 {
            let k = f64::from(k);
            term *= square * (1.0 / (2.0 * k * (2.0 * k + 1.0)));
            sum += term * (2.0 * k);
        }
        large.select(x - tanh, sum * left.sqrt() * 2.0 / (left + 1.0))
    }

    #[inline]
    fn integral(&self) -> Lanes {
        let (reach, whole) = (self.reach(), self.left());
        let most = self.exponent.to_array().into_iter().fold(0.0, f64::max);
        let mut sum = Lanes::ZERO;
        for node in gauss::half(most) {
            let decay = exponential(-self.kappa * self.slip(reach * node.at));
            sum += (decay + whole / decay) * node.weight;
        }
        reach * sum
    }

    #[inline]
    fn slip(&self, u: Lanes) -> Lanes {
        let square = u * u;
        let (one, other) = series(square);
        square * (self.sine * one - self.cosine * u * other)
    }

    fn reach(&self) -> Lanes {
        let far = self.exponent.simd_gt(Lanes::splat(CUT));
        if !far.any() {
            return self.half;
        }
        let cut_slip = CUT / self.kappa;
        let quadratic = (cut_slip * 2.0 / self.sine).sqrt();
        let towards = self.cosine.simd_lt(Lanes::ZERO);
        let cubic = towards.select((cut_slip * 6.0 / -self.cosine).cbrt(), Lanes::splat(f64::INFINITY));
        let mut u = quadratic.min(cubic).min(self.half);
        for _ in 0..4 {
            let square = u * u;
            let (one, other) = series(square);
            let slip = square * (self.sine * one - self.cosine * u * other);
            let speed = self.sine * u * (1.0 - square * other) - self.cosine * square * one;
            u = (u + (cut_slip - slip) / speed).min(self.half);
        }
        far.select(u, self.half)
    }
}

#[inline]
fn series(square: Lanes) -> (Lanes, Lanes) {
    let fourth = square * square;
    let splat = |k: usize| (Lanes::splat(SERIES[k].0), Lanes::splat(SERIES[k].1));
    let (mut even, mut odd) = (splat(TERMS - 1), (Lanes::ZERO, Lanes::ZERO));
    for k in (0..TERMS / 2).rev() {
        let (low, high) = (splat(2 * k), splat(2 * k + 1));
        even = (even.0 * fourth + low.0, even.1 * fourth + low.1);
        odd = (odd.0 * fourth + high.0, odd.1 * fourth + high.1);
    }
    (even.0 + square * odd.0, even.1 + square * odd.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points() -> Vec<(f64, f64)> {
        let mut points = Vec::new();
        for i in 0..=102 {
            for j in 0..90 {
                let xi = f64::from(i - 1) / 100.0;
                points.push((if i % 7 == 3 { -xi } else { xi }, 10f64.powf(f64::from(j) / 3.0 - 16.0)));
            }
        }
        points.extend([(1.0 - 1e-9, 3.0), (1.0 - 1e-14, 1e12), (1e-9, 0.4), (0.3, 0.0), (0.3, f64::INFINITY), (0.5, f64::NAN)]);
        points
    }

    #[test]
    fn lanes_are_equal_to_the_scalar_form() {
        let points = points();
        let (mut worst, mut worst_power) = (0.0f64, 0.0f64);
        let ratios = friction_ratios(&points).into_iter().zip(power_ratios(&points));
        for (&(xi, kappa), (friction, power)) in points.iter().zip(ratios) {
            let scalar = closed::friction_ratio(xi, kappa);
            let off = (friction - scalar).abs();
            assert!(off < 1e-13 || friction.is_nan() && scalar.is_nan(), "{xi} {kappa:e}: {friction} {scalar}");
            worst = worst.max(off);
            match closed::power_ratio(xi, kappa) {
                Some(scalar) => {
                    let off = (power / scalar - 1.0).abs();
                    assert!(off < 1e-13, "{xi} {kappa:e}: {power} {scalar}");
                    worst_power = worst_power.max(off);
                }
                None => assert!(power.is_nan()),
            }
        }
        println!("friction {worst:e}, power {worst_power:e} (relative)");
    }
}
