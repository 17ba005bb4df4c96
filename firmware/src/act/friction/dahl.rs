//! Mean friction of a vibrating contact by Dahl's law, computed in steps.
//!
//! For `V = Vt + Vv cos(w t)` the steady mean of the friction, relative to the friction without
//! vibration, depends on two numbers only (thesis 4.15; Dahl 1968, exponent one):
//!
//! ```text
//! xi    = Vt / Vv           velocity ratio; from one on nothing reverses, and r = 1
//! kappa = Kt Vv / (w Fc)    vibration amplitude in Dahl lengths Fc / Kt; infinite for Coulomb friction
//!
//! r = (2/pi) asin xi + [ (1 - e^-2A) I_b - (1 - e^-2B) I_a ] / (pi (1 - e^-2(A+B)))
//! ```
//!
//! The contact slips forward over the phase `2 a` and backward over `2 b`, with `b = acos xi` and
//! `a = pi - b`. Each direction is the same function of its half angle `h`, with `c = cos h`: -xi
//! forward and xi backward.
//!
//! ```text
//! slip(u) = sin h (1 - cos u) - c (u - sin u),   A, B = kappa slip(h)
//! I = integral of e + exp(-2A) / e over u = 0 to h,   e = exp(-kappa slip(u))
//! ```
//!
//! The integral uses the six nodes of half a Gauss-Legendre rule of twelve, because it is even
//! about h, up to the point where `kappa slip` is 16. Valid for any kappa from zero to infinity.
//! There is no cancellation: `(1 - cos u) / u^2` and `(u - sin u) / u^3` are power series, and
//! differences of exponentials are `expm1`. The tests state the error relative to the closed form
//! in f64.
//!
//! An evaluation takes `STEPS` calls of about 400 instructions each, so that it can be spread over
//! several blocks.

use crate::seam::compare::within;

/// Number of calls of [`Evaluation::step`] per evaluation.
pub(crate) const STEPS: u32 = 6;

const FRAC_2_PI: f32 = core::f32::consts::FRAC_2_PI;
const PI: f32 = core::f32::consts::PI;

/// Kappa below which the ratio equals its limit to single precision.
const MIN_KAPPA: f32 = 1e-6;
/// Kappa from which the ratio is that of Coulomb friction, even near the velocity threshold, where
/// the backward slip is short.
const COULOMB_KAPPA: f32 = 1e12;
/// Upper limit of the integral, in kappa times slip: e^-16 is 1e-7.
const CUT_EXPONENT: f32 = 16.0;
/// Newton steps towards this limit.
const NEWTON_STEPS: usize = 4;
/// Nodes added per step.
const NODES_PER_STEP: usize = 3;

/// Nodes and weights of the half from 0 to 1 of a Gauss-Legendre rule over 0 to 2 (Abramowitz and
/// Stegun table 25.4, n = 12).
const NODES: [(f32, f32); 6] = [
    (0.018_439_366, 0.047_175_337),
    (0.095_882_74, 0.106_939_33),
    (0.230_097_33, 0.160_078_33),
    (0.412_682_05, 0.203_167_43),
    (0.632_168_5, 0.233_492_54),
    (0.874_766_6, 0.249_147_05),
];

/// Coefficients of `(1 - cos u) / u^2` and `(u - sin u) / u^3` in powers of u^2:
/// `(-1)^k / (2k + 2)!` and `(-1)^k / (2k + 3)!`. At u = pi the next term is 2e-8.
const SERIES: [(f32, f32); 8] = series();

const fn series() -> [(f32, f32); 8] {
    let mut out = [(0.5, 1.0 / 6.0); 8];
    let (mut cosine, mut sine) = (0.5, 1.0 / 6.0);
    let mut k = 1;
    while k < out.len() {
        let n = (2 * k) as f64;
        cosine = -cosine / ((n + 1.0) * (n + 2.0));
        sine = -sine / ((n + 2.0) * (n + 3.0));
        out[k] = (cosine as f32, sine as f32);
        k += 1;
    }
    out
}

/// Computes `(1 - cos u) / u^2` and `(u - sin u) / u^3` from `u^2`.
fn versines(square: f32) -> (f32, f32) {
    SERIES.iter().rev().fold((0.0, 0.0), |(cosine, sine), term| (cosine * square + term.0, sine * square + term.1))
}

/// Slip in one direction, from standstill to standstill.
#[derive(Clone, Copy, Debug, Default)]
struct Stroke {
    /// Half of its phase, rad.
    half: f32,
    sine: f32,
    cosine: f32,
    kappa: f32,
    /// Half of kappa times the whole slip.
    exponent: f32,
    /// Upper limit of the integral, rad: the middle, or the cut.
    reach: f32,
    /// Part of a difference in friction that the slip removes: `1 - exp(-2A)`.
    forgotten: f32,
    /// Part that remains: `exp(-2A)`.
    retained: f32,
    integral: f32,
}

impl Stroke {
    fn new(half: f32, sine: f32, cosine: f32, kappa: f32) -> Self {
        let mut stroke = Stroke { half, sine, cosine, kappa, ..Stroke::default() };
        stroke.exponent = kappa * stroke.slip(half).0;
        stroke.forgotten = -libm::expm1f(-2.0 * stroke.exponent);
        stroke.retained = 1.0 - stroke.forgotten;
        stroke.reach = stroke.reach();
        stroke
    }

    /// Computes the slip from the start to the phase `u`, up to the middle, and its slope.
    fn slip(&self, u: f32) -> (f32, f32) {
        let square = u * u;
        let (cosine, sine) = versines(square);
        let slip = square * (self.sine * cosine - self.cosine * u * sine);
        let slope = u * (self.sine * (1.0 - square * sine) - self.cosine * u * cosine);
        (slip, slope)
    }

    fn reach(&self) -> f32 {
        if self.exponent <= CUT_EXPONENT {
            return self.half;
        }
        // Newton's method converges monotonically from beyond the cut, because the slip is convex
        // up to its middle. For long slips a quadratic guess is as good; it is too large forward
        // and too small backward.
        let target = CUT_EXPONENT / self.kappa;
        let mut u = fpu::sqrtf(2.0 * target / self.sine).min(self.half);
        for _ in 0..NEWTON_STEPS {
            let (slip, slope) = self.slip(u);
            u = within(u - (slip - target) / slope.max(f32::MIN_POSITIVE), 0.0, self.half);
        }
        u
    }

    fn add(&mut self, nodes: &[(f32, f32)]) {
        for &(at, weight) in nodes {
            let retained = libm::expf(-self.kappa * self.slip(self.reach * at).0);
            self.integral += self.reach * weight * (retained + self.retained / retained);
        }
    }
}

/// Evaluation of a friction ratio, in progress.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Evaluation {
    xi: f32,
    strokes: [Stroke; 2],
    /// Number of calls so far.
    step: u32,
    /// Result; set at the start if it needs no integral.
    known: Option<f32>,
}

impl Evaluation {
    /// Starts the evaluation at a velocity ratio and a kappa, both non-negative. NaN means no
    /// vibration.
    pub(crate) fn new(xi: f32, kappa: f32) -> Self {
        let xi = xi.abs();
        let known = if xi.is_nan() || xi >= 1.0 {
            Some(1.0)
        } else if kappa.is_nan() || kappa < MIN_KAPPA {
            Some(limit(xi))
        } else if kappa >= COULOMB_KAPPA {
            Some(coulomb(xi))
        } else {
            None
        };
        Evaluation { xi, strokes: [Stroke { kappa, ..Stroke::default() }; 2], step: 0, known }
    }

    /// Advances by one step. Returns the ratio once it is complete.
    pub(crate) fn step(&mut self) -> Option<f32> {
        if self.known.is_some() {
            return self.known;
        }
        self.step += 1;
        match self.step {
            1 => {
                let (xi, kappa) = (self.xi, self.strokes[0].kappa);
                let sine = fpu::sqrtf((1.0 - xi) * (1.0 + xi));
                self.strokes[1] = Stroke::new(libm::atan2f(sine, xi), sine, xi, kappa);
            }
            2 => {
                let Stroke { half, sine, cosine, kappa, .. } = self.strokes[1];
                self.strokes[0] = Stroke::new(PI - half, sine, -cosine, kappa);
            }
            part => {
                let place = ((part - 3) % 2) as usize;
                let [forward, backward] = &mut self.strokes;
                let stroke = if part < 5 { forward } else { backward };
                stroke.add(&NODES[place * NODES_PER_STEP..(place + 1) * NODES_PER_STEP]);
            }
        }
        if self.step == STEPS {
            self.known = Some(self.ratio());
        }
        self.known
    }

    fn ratio(&self) -> f32 {
        let [forward, backward] = &self.strokes;
        let (a, b) = (forward.forgotten, backward.forgotten);
        // 1 - exp(-2 (A + B)), without cancellation.
        let both = a + b * forward.retained;
        let difference = a * backward.integral - b * forward.integral;
        let ratio = coulomb(self.xi) + difference / (PI * both);
        if ratio < 1.0 { ratio } else { 1.0 }
    }
}

/// Computes the friction ratio in one call.
pub fn friction_ratio(xi: f32, kappa: f32) -> f32 {
    let mut evaluation = Evaluation::new(xi, kappa);
    for _ in 1..STEPS {
        if let Some(ratio) = evaluation.step() {
            return ratio;
        }
    }
    evaluation.step().unwrap_or(1.0)
}

/// Computes the ratio of Coulomb friction, `(2/pi) asin xi` (thesis 4.3), as a reference. Its
/// inverse is `Vv / Vt = 1 / sin(pi r / 2)`.
pub fn coulomb(xi: f32) -> f32 {
    FRAC_2_PI * arc_sine(if xi < 1.0 { xi } else { 1.0 })
}

/// Computes `asin x` for 0 to 1 in single precision; the library function uses double precision.
fn arc_sine(x: f32) -> f32 {
    libm::atan2f(x, fpu::sqrtf((1.0 - x) * (1.0 + x)))
}

/// Computes the limit of the ratio for kappa to zero, where the friction is constant: net slip over
/// slip, `(pi/2) xi / (xi asin xi + sqrt(1 - xi^2))`.
fn limit(xi: f32) -> f32 {
    let ratio = 0.5 * PI * xi / (xi * arc_sine(xi) + fpu::sqrtf((1.0 - xi) * (1.0 + xi)));
    if ratio < 1.0 { ratio } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reference values (xi, kappa, ratio) from an independent computation with 40 digits, rounded.
    const DIGITS: [(f32, f32, f32); 8] = [
        (0.1, 0.404_517, 0.148_749_78),
        (0.5, 0.404_517, 0.674_948_7),
        (0.9, 0.404_517, 0.975_847_2),
        (0.5, 1e-6, 0.696_383_1),
        (0.5, 4.0, 0.398_152_24),
        (0.5, 100.0, 0.334_766_4),
        (0.9, 20.0, 0.801_565_45),
        (0.1, 1e4, 0.063_770_7),
    ];

    /// Measured error: 2.4e-6 from the six nodes; the rest is single precision.
    #[test]
    fn agrees_with_forty_digits() {
        for (xi, kappa, ratio) in DIGITS {
            let got = friction_ratio(xi, kappa);
            assert!((got - ratio).abs() < 3e-6, "{xi} {kappa}: {got} {ratio}");
        }
    }

    #[test]
    fn nodes_integrate_polynomials_of_their_degree() {
        for k in 0..12 {
            let sum: f32 = NODES.iter().map(|&(at, weight)| weight * (1.0 - at).powi(2 * k)).sum();
            assert!((sum - 1.0 / (2 * k + 1) as f32).abs() < 1e-6, "{k}: {sum}");
        }
    }

    #[test]
    fn takes_the_stated_number_of_steps() {
        let mut evaluation = Evaluation::new(0.3, 2.0);
        for _ in 1..STEPS {
            assert_eq!(evaluation.step(), None);
        }
        let done = evaluation.step();
        assert!(done.is_some() && done == evaluation.step());
    }

    /// The result is never NaN nor outside zero to one, for any input.
    #[test]
    fn holds_at_the_ends_of_single_precision() {
        let odd =
            [0.0, f32::MIN_POSITIVE, 1e-30, 1e-7, 1e-3, 0.5, 0.999, 1.0 - f32::EPSILON / 2.0, 1.0, 2.0, f32::INFINITY, f32::NAN];
        for xi in odd {
            for kappa in odd.into_iter().chain([10.0, 1e3, 9.9e5, 1e6, 1e20, 1e38]) {
                let ratio = friction_ratio(xi, kappa);
                assert!((0.0..=1.0).contains(&ratio), "{xi} {kappa}: {ratio}");
            }
        }
    }

    /// The friction falls with kappa at every velocity ratio, and rises with the velocity ratio at
    /// every kappa.
    #[test]
    fn is_monotone() {
        let kappas = || (-8..=28).map(|n| libm::powf(10.0, 0.25 * n as f32 - 1.0));
        for n in 1..100 {
            let xi = 0.01 * n as f32;
            let over_kappa: std::vec::Vec<f32> = kappas().map(|kappa| friction_ratio(xi, kappa)).collect();
            assert!(over_kappa.windows(2).all(|pair| pair[1] < pair[0] + 4e-6), "{xi}: {over_kappa:?}");
            for kappa in kappas() {
                assert!(friction_ratio(xi + 0.01, kappa) > friction_ratio(xi, kappa) - 4e-6, "{xi} {kappa}");
            }
        }
    }
}
