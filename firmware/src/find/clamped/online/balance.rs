//! Evaluation of a round, from the motional admittance above (`+`) and below (`-`) the resonance.
//!
//! With the assumed motional admittance `r + j m = (Y - Y0(f)) / axis`, the motional resistance is
//! `r / (r^2 + m^2)`. It does not depend on frequency. The error of C0 is the susceptance `b` that
//! makes the resistance equal on both sides:
//!
//! ```text
//! F(b) = r+ (r-^2 + (m- - b u-)^2) - r- (r+^2 + (m+ - b u+)^2) = 0,    u = f / f_nominal
//! ```
//!
//! The phase of the remainder changes with the quality factor of the resonance, independently of
//! the strength found at power-on:
//!
//! ```text
//! Q = (m- / r- - m+ / r+) (u+ + u-) / (4 (u+ - u-))
//! ```
//!
//! With steps of `x` half bandwidths and a noise `s` of `Y` in each average, the standard deviation
//! of `b` is `s (1 + x^2) / (2 sqrt(2) x)`, and the relative one of Q is
//! `s (1 + x^2) Rm / (sqrt(2) x)`.

use crate::find::clamped::reading::Measured;
use crate::seam::phasor::Phasor;

/// Sums over the blocks of one side.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Side {
    motional: Phasor,
    /// Sum of the relative offsets from the nominal frequency; rounds less than the frequency
    /// itself.
    offset: f32,
    blocks: f32,
    last: Option<Phasor>,
    scatter: f32,
    pairs: f32,
}

impl Side {
    /// Adds the motional admittance of a block at `relative` times the nominal frequency.
    pub(super) fn add(&mut self, y: Phasor, relative: f32) {
        if let Some(last) = self.last.replace(y) {
            // Variance per component: a difference has twice the variance, in two components.
            self.scatter += 0.25 * (y - last).norm_sqr();
            self.pairs += 1.0;
        }
        self.motional += y;
        self.offset += relative - 1.0;
        self.blocks += 1.0;
    }

    /// Marks the next block as not adjacent to the previous one.
    pub(super) fn pause(&mut self) {
        self.last = None;
    }

    fn mean(&self) -> (Phasor, f32) {
        (self.motional / self.blocks, self.offset / self.blocks)
    }

    /// Returns the variance of one component of the mean.
    fn variance(&self) -> f32 {
        self.scatter / (self.pairs * self.blocks)
    }
}

/// Result of both sides.
#[derive(Clone, Copy, Debug)]
pub(super) struct Balance {
    /// Error of the assumed clamped susceptance, S; positive if the true one is larger.
    pub(super) susceptance: f32,
    /// Variance of that error, S^2.
    pub(super) variance: f32,
    /// Motional conductance, S.
    pub(super) conductance: f32,
    /// Quality factor of the resonance.
    pub(super) q: Measured,
}

impl Balance {
    /// Evaluates both sides; `None` if they contain too few blocks or no finite result.
    pub(super) fn from_sides(below: &Side, above: &Side) -> Option<Self> {
        if below.pairs == 0.0 || above.pairs == 0.0 {
            return None;
        }
        let ((yb, xb), (ya, xa)) = (below.mean(), above.mean());
        let (ub, ua) = (1.0 + xb, 1.0 + xa);
        let (mut b, mut slope) = (0.0, 0.0);
        for _ in 0..3 {
            let (mb, ma) = (yb.im - b * ub, ya.im - b * ua);
            let f = ya.re * (yb.re * yb.re + mb * mb) - yb.re * (ya.re * ya.re + ma * ma);
            slope = 2.0 * (yb.re * ma * ua - ya.re * mb * ub);
            b -= f / slope;
        }
        let (mb, ma) = (yb.im - b * ub, ya.im - b * ua);
        let by_below = Phasor::new(2.0 * ya.re * yb.re - ya.re * ya.re - ma * ma, 2.0 * ya.re * mb);
        let by_above = Phasor::new(yb.re * yb.re + mb * mb - 2.0 * ya.re * yb.re, -2.0 * yb.re * ma);
        let variances = (below.variance(), above.variance());
        let variance = (by_below.norm_sqr() * variances.0 + by_above.norm_sqr() * variances.1) / (slope * slope);
        let (tb, ta) = (mb / yb.re, ma / ya.re);
        let turned = tb - ta;
        let q = 0.25 * turned * (ub + ua) / (xa - xb);
        // Variance of a tangent, from both components of the admittance.
        let of_tangent = |t: f32, re: f32, variance: f32| (1.0 + t * t) * variance / (re * re);
        let relative = (of_tangent(tb, yb.re, variances.0) + of_tangent(ta, ya.re, variances.1)) / (turned * turned);
        let is_valid = b.is_finite() && variance.is_finite() && variance > 0.0 && q.is_finite();
        is_valid.then(|| Balance {
            susceptance: b,
            variance,
            conductance: 0.5 * (yb.re + ya.re),
            q: Measured { value: q, deviation: q * fpu::sqrtf(relative) },
        })
    }
}
