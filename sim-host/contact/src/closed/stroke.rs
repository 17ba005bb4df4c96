//! One stroke of the slip, from standstill to standstill: the velocity `cos p - cos h` over phases
//! from -h to h.
//!
//! Forward motion has h = pi - acos xi, backward motion h = acos xi. Slip is counted from the
//! beginning, as a function of the phase u since then:
//!
//! ```text
//! slip(u) = sin h (1 - cos u) - cos h (u - sin u),    slip(h + u) = S - slip(h - u),    S = 2 (sin h - h cos h)
//! ```
//!
//! Written with `(1 - cos u) / u^2` and `(u - sin u) / u^3` as power series, its relative error is
//! round-off down to u = 0, which a kappa of 1e12 requires. With `A = kappa S / 2` and
//! `e = exp(-kappa slip)`, the symmetry folds the integral over the stroke in two,
//!
//! ```text
//! integral of exp(-kappa slip) over 0 to 2 h  =  integral of (e + exp(-2 A) / e) over 0 to h,
//! ```
//!
//! and the folded integrand is even about h. Beyond kappa slip = 37 the contribution is below
//! round-off (e^-37 = 9e-17). A longer stroke is cut there, so that the exponent spans at most this
//! range and 20 nodes suffice for any kappa.

use super::gauss;

/// Value of kappa times slip at which the integral is cut.
pub(crate) const CUT_EXPONENT: f64 = 37.0;

/// Number of terms of both series. At u = pi, the next term is 4e-19 of the sum.
pub(crate) const TERMS: usize = 15;

/// Coefficients of `(1 - cos u) / u^2` and `(u - sin u) / u^3` in powers of u^2:
/// `(-1)^k / (2k + 2)!` and `(-1)^k / (2k + 3)!`.
pub(crate) const SERIES: [(f64, f64); TERMS] = series();

const fn series() -> [(f64, f64); TERMS] {
    let mut out = [(0.5, 1.0 / 6.0); TERMS];
    let mut k = 1;
    while k < TERMS {
        let n = (2 * k) as f64;
        let (cosine, sine) = out[k - 1];
        out[k] = (-cosine / ((n + 1.0) * (n + 2.0)), -sine / ((n + 2.0) * (n + 3.0)));
        k += 1;
    }
    out
}

/// Stroke of the slip in one direction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stroke {
    half_rad: f64,
    sine: f64,
    cosine: f64,
    kappa: f64,
    /// kappa S / 2.
    exponent: f64,
}

impl Stroke {
    /// Returns the forward and the backward stroke of `V = xi + cos p`, for 0 <= xi < 1.
    pub(super) fn both(xi: f64, kappa: f64) -> [Stroke; 2] {
        let sine = ((1.0 - xi) * (1.0 + xi)).sqrt();
        let backward = sine.atan2(xi);
        [Stroke::new(std::f64::consts::PI - backward, sine, -xi, kappa), Stroke::new(backward, sine, xi, kappa)]
    }

    fn new(half_rad: f64, sine: f64, cosine: f64, kappa: f64) -> Self {
        let mut stroke = Stroke { half_rad, sine, cosine, kappa, exponent: 0.0 };
        stroke.exponent = kappa * stroke.slip(half_rad);
        stroke
    }

    /// Returns the phase of the whole stroke, rad.
    pub(super) fn length_rad(&self) -> f64 {
        2.0 * self.half_rad
    }

    /// Returns A: half of kappa times the slip of the whole stroke.
    pub(super) fn exponent(&self) -> f64 {
        self.exponent
    }

    /// Returns `1 - exp(-2 A)`: the fraction of a difference in friction that the stroke removes.
    pub(super) fn forgotten(&self) -> f64 {
        -(-2.0 * self.exponent).exp_m1()
    }

    /// Returns `exp(-kappa slip)` at a phase since the beginning, rad.
    pub(super) fn decay(&self, u: f64) -> f64 {
        let slip =
            if u <= self.half_rad { self.slip(u) } else { 2.0 * self.slip(self.half_rad) - self.slip(self.length_rad() - u) };
        (-self.kappa * slip).exp()
    }

    /// Returns the integral of `exp(-kappa slip)` over the phase of the stroke.
    pub(super) fn integral(&self) -> f64 {
        self.integral_by(self.exponent)
    }

    /// Returns the same integral by the rule for another exponent.
    #[inline]
    pub(super) fn integral_by(&self, rule: f64) -> f64 {
        let (reach, whole) = (self.reach(), (-2.0 * self.exponent).exp());
        let sum: f64 = gauss::half(rule)
            .iter()
            .map(|node| {
                let decay = (-self.kappa * self.slip(reach * node.at)).exp();
                node.weight * (decay + whole / decay)
            })
            .sum();
        reach * sum
    }

    /// Returns the integral of `cos p exp(-kappa slip)` over the phase of the stroke.
    pub(super) fn cosine_integral(&self) -> f64 {
        let (reach, whole) = (self.reach(), (-2.0 * self.exponent).exp());
        let sum: f64 = gauss::half(self.exponent)
            .iter()
            .map(|node| {
                let u = reach * node.at;
                let decay = (-self.kappa * self.slip(u)).exp();
                node.weight * (self.half_rad - u).cos() * (decay + whole / decay)
            })
            .sum();
        reach * sum
    }

    /// Returns the slip at a phase u since the beginning, up to the middle of the stroke.
    #[inline]
    pub(super) fn slip(&self, u: f64) -> f64 {
        let (one, other) = self.series(u * u);
        u * u * (self.sine * one - self.cosine * u * other)
    }

    /// Returns `(1 - cos u) / u^2` and `(u - sin u) / u^3` from u^2. Even and odd powers are
    /// separate, which halves the latency of a single Horner chain.
    #[inline]
    fn series(&self, square: f64) -> (f64, f64) {
        let fourth = square * square;
        let (mut even, mut odd) = (SERIES[TERMS - 1], (0.0, 0.0));
        for k in (0..TERMS / 2).rev() {
            let (low, high) = (SERIES[2 * k], SERIES[2 * k + 1]);
            even = (even.0 * fourth + low.0, even.1 * fourth + low.1);
            odd = (odd.0 * fourth + high.0, odd.1 * fourth + high.1);
        }
        (even.0 + square * odd.0, even.1 + square * odd.1)
    }

    /// Returns the upper limit of the integral: the middle, or the phase at which kappa times slip
    /// is [`CUT_EXPONENT`].
    fn reach(&self) -> f64 {
        if self.exponent <= CUT_EXPONENT {
            return self.half_rad;
        }
        // Start from the slip at small phases, sin h u^2 / 2 - cos h u^3 / 6; then Newton: slip is
        // convex up to the middle.
        let cut_slip = CUT_EXPONENT / self.kappa;
        let quadratic = (2.0 * cut_slip / self.sine).sqrt();
        let cubic = if self.cosine < 0.0 { (6.0 * cut_slip / -self.cosine).cbrt() } else { f64::INFINITY };
        let mut u = quadratic.min(cubic).min(self.half_rad);
        for _ in 0..4 {
            let (one, other) = self.series(u * u);
            let slip = u * u * (self.sine * one - self.cosine * u * other);
            let speed = self.sine * u * (1.0 - u * u * other) - self.cosine * u * u * one;
            u = (u + (cut_slip - slip) / speed).min(self.half_rad);
        }
        u
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slip_is_that_of_the_motion() {
        // Independent reference: the antiderivative xi p + sin p, at phases where it does not
        // cancel.
        for xi in [0.0, 0.1, 0.5, 0.9] {
            let [forward, backward] = Stroke::both(xi, 1.0);
            for part in [0.3, 0.7, 1.0] {
                let u = part * forward.half_rad;
                let p = u - forward.half_rad;
                let direct = xi * u + p.sin() + forward.half_rad.sin();
                assert!((forward.slip(u) - direct).abs() < 1e-15, "{xi} {part}");
                let u = part * backward.half_rad;
                let p = u - backward.half_rad;
                let direct = -xi * u + p.sin() + backward.half_rad.sin();
                assert!((backward.slip(u) - direct).abs() < 1e-15, "{xi} {part}");
            }
        }
    }

    #[test]
    fn the_cut_is_at_its_exponent() {
        for xi in [0.0, 1e-6, 0.3, 0.9, 0.999, 1.0 - 1e-12] {
            for kappa in [20.0, 30.0, 100.0, 1e3, 1e6, 1e12] {
                for stroke in Stroke::both(xi, kappa) {
                    let at_reach = kappa * stroke.slip(stroke.reach());
                    assert!((at_reach - stroke.exponent.min(CUT_EXPONENT)).abs() < 1e-3, "{xi} {kappa}: {at_reach}");
                }
            }
        }
    }
}
