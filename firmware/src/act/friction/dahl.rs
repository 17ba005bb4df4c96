//! Mean friction of a vibrating contact, by Dahl's law, a piece at a time.
//!
//! For `V = Vt + Vv cos(w t)` the steady mean of the friction, over the friction without vibration, depends on two numbers only
//! (thesis 4.15; Dahl 1968, exponent one):
//!
//! ```text
//! xi    = Vt / Vv           velocity ratio; from one on nothing reverses, and r = 1
//! kappa = Kt Vv / (w Fc)    vibration amplitude in Dahl lengths Fc / Kt; infinite for Coulomb friction
//!
//! r = (2/pi) asin xi + [ (1 - e^-2A) I_b - (1 - e^-2B) I_a ] / (pi (1 - e^-2(A+B)))
//! ```
//!
//! The contact slips forward over the phase `2 a` and backward over `2 b`, with `b = acos xi` and `a = pi - b`. Each way is the same function
//! of its half angle `h`, with `c = cos h`, -xi forward and xi backward:
//!
//! ```text
//! slip(u) = sin h (1 - cos u) - c (u - sin u),   A, B = kappa slip(h)
//! I = integral of e + exp(-2A) / e over u = 0 to h,   e = exp(-kappa slip(u))
//! ```
//!
//! The integral takes six nodes of half a Gauss-Legendre rule of twelve (it is even about h), up to where `kappa slip` is 16. Valid for any
//! kappa from zero to infinity. Nothing cancels: `(1 - cos u) / u^2` and `(u - sin u) / u^3` are power series, and differences of exponentials
//! are `expm1`. Its error against the closed form in f64 is what the tests state.
//!
//! An evaluation takes `STEPS` calls, about 400 instructions each, so that it can be spread over as many blocks.

use crate::seam::compare::within;

/// Calls of [`Evaluation::step`] that an evaluation takes.
pub(crate) const STEPS: u32 = 6;

const FRAC_2_PI: f32 = core::f32::consts::FRAC_2_PI;
const PI: f32 = core::f32::consts::PI;

/// Below this kappa the ratio is its limit to single precision.
const NO_MEMORY_LOST: f32 = 1e-6;
/// From this kappa on it is Coulomb's, even next to the velocity threshold, where the way back is short.
const NO_MEMORY: f32 = 1e12;
/// Where the integral is cut, in kappa times slip: e^-16 is 1e-7.
const CUT: f32 = 16.0;
/// Steps of Newton's method to where it is cut.
const CUT_STEPS: usize = 4;
/// Nodes of a way that one step adds.
const NODES_A_STEP: usize = 3;

/// Places and weights of the half from 0 to 1 of a Gauss-Legendre rule over 0 to 2 (Abramowitz and Stegun table 25.4, n = 12).
const NODES: [(f32, f32); 6] = [
    (0.018_439_366, 0.047_175_337),
    (0.095_882_74, 0.106_939_33),
    (0.230_097_33, 0.160_078_33),
    (0.412_682_05, 0.203_167_43),
    (0.632_168_5, 0.233_492_54),
    (0.874_766_6, 0.249_147_05),
];

/// `(1 - cos u) / u^2` and `(u - sin u) / u^3` in powers of u^2: `(-1)^k / (2k + 2)!` and `(-1)^k / (2k + 3)!`. At u = pi the next is 2e-8.
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

/// `(1 - cos u) / u^2` and `(u - sin u) / u^3`.
fn versines(square: f32) -> (f32, f32) {
    SERIES.iter().rev().fold((0.0, 0.0), |(cosine, sine), term| (cosine * square + term.0, sine * square + term.1))
}

/// One way of the slip, from standstill to standstill.
#[derive(Clone, Copy, Debug, Default)]
struct Way {
    /// Half its phase, rad.
    half: f32,
    sine: f32,
    cosine: f32,
    kappa: f32,
    /// Half of kappa times the whole slip.
    exponent: f32,
    /// How far the integral goes: the middle, or the cut.
    reach: f32,
    /// `1 - exp(-2A)`: how much of a difference in friction the way takes off; and what is left of it.
    forgotten: f32,
    retained: f32,
    integral: f32,
}

impl Way {
    fn new(half: f32, sine: f32, cosine: f32, kappa: f32) -> Self {
        let mut way = Way { half, sine, cosine, kappa, ..Way::default() };
        way.exponent = kappa * way.slip(half).0;
        way.forgotten = -libm::expm1f(-2.0 * way.exponent);
        way.retained = 1.0 - way.forgotten;
        way.reach = way.reach();
        way
    }

    /// Slip since the beginning, up to the middle, and its slope.
    fn slip(&self, u: f32) -> (f32, f32) {
        let square = u * u;
        let (cosine, sine) = versines(square);
        let slip = square * (self.sine * cosine - self.cosine * u * sine);
        let slope = u * (self.sine * (1.0 - square * sine) - self.cosine * u * cosine);
        (slip, slope)
    }

    fn reach(&self) -> f32 {
        if self.exponent <= CUT {
            return self.half;
        }
        // The slip is convex up to its middle, which is beyond the cut: from there Newton's method comes down without a jump. A guess from the
        // quadratic, which forward is too far and backward too near, is as good a beginning where the way is long.
        let target = CUT / self.kappa;
        let mut u = libm::sqrtf(2.0 * target / self.sine).min(self.half);
        for _ in 0..CUT_STEPS {
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

/// A friction ratio that is being evaluated.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Evaluation {
    xi: f32,
    ways: [Way; 2],
    /// Calls so far.
    step: u32,
    /// Known without an integral.
    known: Option<f32>,
}

impl Evaluation {
    /// Begins to evaluate the ratio at a velocity ratio and a kappa, neither below zero. What is not a number is no vibration.
    pub(crate) fn new(xi: f32, kappa: f32) -> Self {
        let xi = xi.abs();
        let known = if xi.is_nan() || xi >= 1.0 {
            Some(1.0)
        } else if kappa.is_nan() || kappa < NO_MEMORY_LOST {
            Some(limit(xi))
        } else if kappa >= NO_MEMORY {
            Some(coulomb(xi))
        } else {
            None
        };
        Evaluation { xi, ways: [Way { kappa, ..Way::default() }; 2], step: 0, known }
    }

    /// Goes on by one step; the ratio, once it is done.
    pub(crate) fn step(&mut self) -> Option<f32> {
        if self.known.is_some() {
            return self.known;
        }
        self.step += 1;
        match self.step {
            1 => {
                let (xi, kappa) = (self.xi, self.ways[0].kappa);
                let sine = libm::sqrtf((1.0 - xi) * (1.0 + xi));
                self.ways[1] = Way::new(libm::atan2f(sine, xi), sine, xi, kappa);
            }
            2 => {
                let Way { half, sine, cosine, kappa, .. } = self.ways[1];
                self.ways[0] = Way::new(PI - half, sine, -cosine, kappa);
            }
            part => {
                let place = ((part - 3) % 2) as usize;
                let [forward, backward] = &mut self.ways;
                let way = if part < 5 { forward } else { backward };
                way.add(&NODES[place * NODES_A_STEP..(place + 1) * NODES_A_STEP]);
            }
        }
        if self.step == STEPS {
            self.known = Some(self.ratio());
        }
        self.known
    }

    fn ratio(&self) -> f32 {
        let [forward, backward] = &self.ways;
        let (a, b) = (forward.forgotten, backward.forgotten);
        // 1 - exp(-2 (A + B)), without a difference.
        let both = a + b * forward.retained;
        let difference = a * backward.integral - b * forward.integral;
        let ratio = coulomb(self.xi) + difference / (PI * both);
        if ratio < 1.0 { ratio } else { 1.0 }
    }
}

/// The friction ratio, at once.
pub fn friction_ratio(xi: f32, kappa: f32) -> f32 {
    let mut evaluation = Evaluation::new(xi, kappa);
    for _ in 1..STEPS {
        if let Some(ratio) = evaluation.step() {
            return ratio;
        }
    }
    evaluation.step().unwrap_or(1.0)
}

/// The ratio of Coulomb friction, `(2/pi) asin xi` (thesis 4.3): the reference. Its inverse is `Vv / Vt = 1 / sin(pi r / 2)`.
pub fn coulomb(xi: f32) -> f32 {
    FRAC_2_PI * arc_sine(if xi < 1.0 { xi } else { 1.0 })
}

/// `asin x`, 0 to 1, by single precision only, which that of the library is not.
fn arc_sine(x: f32) -> f32 {
    libm::atan2f(x, libm::sqrtf((1.0 - x) * (1.0 + x)))
}

/// The ratio as kappa goes to zero, where the friction is constant: net slip over slip, `(pi/2) xi / (xi asin xi + sqrt(1 - xi^2))`.
fn limit(xi: f32) -> f32 {
    let ratio = 0.5 * PI * xi / (xi * arc_sine(xi) + libm::sqrtf((1.0 - xi) * (1.0 + xi)));
    if ratio < 1.0 { ratio } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Independent of this code: 40 digits, rounded. (xi, kappa, ratio)
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

    /// Measured: 2.4e-6, of the six nodes; the rest is single precision.
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
    fn takes_so_many_steps() {
        let mut evaluation = Evaluation::new(0.3, 2.0);
        for _ in 1..STEPS {
            assert_eq!(evaluation.step(), None);
        }
        let done = evaluation.step();
        assert!(done.is_some() && done == evaluation.step());
    }

    /// Nothing that can be asked is not a number, or outside zero to one.
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

    /// For every velocity ratio the friction falls with kappa, and for every kappa it rises with the velocity ratio.
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
