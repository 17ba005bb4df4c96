//! Means over a period, in units of the static deflection d0 and the load W: amplitude a, lift L =
//! D + a, which is the largest deflection.
//!
//! | shape | mean d+ | mean N |
//! |---|---|---|
//! | square | mean of the two places | mean of the two places |
//! | triangle, sawtooth | `(L^2 - l^2) / (4 a)` | `(L^(5/2) - l^(5/2)) / (5 a)`, l = max(L - 2 a, 0) |
//! | sine | `D`, or `a (sin c - c cos c) / pi` over the contact angle -c to c | elliptic |

use std::f64::consts::PI;

use super::super::closed::gauss;
use super::super::waveform::Shape;
use super::elliptic;

/// Distribution of a shape's time over its positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Spread {
    Still,
    Cosine,
    TwoPlaces,
    Even,
}

impl Spread {
    pub(super) fn from_shape(shape: Shape) -> Option<Self> {
        match shape {
            Shape::Sine => Some(Spread::Cosine),
            Shape::Square => Some(Spread::TwoPlaces),
            Shape::Sawtooth | Shape::Triangle => Some(Spread::Even),
            Shape::Still => Some(Spread::Still),
            Shape::Random { .. } | Shape::Chirp { .. } | Shape::Measured => None,
        }
    }

    /// Returns the amplitude above which contact is lost: D = a, with mean N = 1.
    pub(super) fn threshold(self) -> f64 {
        self.mean_force(2.0, 1.0).powf(-2.0 / 3.0)
    }

    /// Returns the lift at which the mean force is the load.
    pub(super) fn lift(self, amplitude: f64) -> f64 {
        if amplitude == 0.0 || self == Spread::Still {
            return 1.0 + amplitude;
        }
        // The mean force rises with the lift. Bounds: D <= d0 because the force is convex, and L >=
        // d0 because the largest force is at least the mean.
        let (mut low, mut high) = (1.0, 1.0 + amplitude);
        let mut lift = high;
        for _ in 0..200 {
            let off = self.mean_force(lift, amplitude) - 1.0;
            if off > 0.0 {
                high = lift;
            } else {
                low = lift;
            }
            // d mean N / d L = 1.5 mean sqrt(d+), from a small difference
            let small = 1e-6 * lift;
            let slope = (self.mean_force(lift + small, amplitude) - self.mean_force(lift - small, amplitude)) / (2.0 * small);
            let newton = lift - off / slope;
            let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            if (next - lift).abs() <= f64::EPSILON * lift {
                return next;
            }
            lift = next;
        }
        lift
    }

    /// Returns the mean of d+.
    pub(super) fn mean_deflection(self, lift: f64, amplitude: f64) -> f64 {
        let low = (lift - 2.0 * amplitude).max(0.0);
        match self {
            Spread::Still => 1.0,
            _ if low > 0.0 || amplitude == 0.0 => lift - amplitude,
            Spread::TwoPlaces => 0.5 * lift,
            Spread::Even => lift * lift / (4.0 * amplitude),
            Spread::Cosine => {
                let c = contact_angle(lift, amplitude);
                amplitude / PI * sine_less_angle(c)
            }
        }
    }

    /// Returns the fraction of the time in contact.
    pub(super) fn contact_share(self, lift: f64, amplitude: f64) -> f64 {
        match self {
            _ if lift >= 2.0 * amplitude => 1.0,
            Spread::Still => 1.0,
            Spread::TwoPlaces => 0.5,
            Spread::Even => lift / (2.0 * amplitude),
            Spread::Cosine => contact_angle(lift, amplitude) / PI,
        }
    }

    /// Returns the mean of d+^(3/2).
    pub(super) fn mean_force(self, lift: f64, amplitude: f64) -> f64 {
        let low = (lift - 2.0 * amplitude).max(0.0);
        match self {
            Spread::Still => 1.0,
            Spread::TwoPlaces => 0.5 * (lift.powf(1.5) + low.powf(1.5)),
            // For small amplitudes the difference of the powers cancels; quadrature gives the mean.
            Spread::Even if low > 0.5 * lift => {
                gauss::whole().iter().map(|node| node.weight * (low + 2.0 * amplitude * node.at).powf(1.5)).sum()
            }
            Spread::Even => (lift.powf(2.5) - low.powf(2.5)) / (5.0 * amplitude),
            Spread::Cosine => cosine_force(lift, amplitude),
        }
    }
}

fn cosine_force(lift: f64, amplitude: f64) -> f64 {
    if lift >= 2.0 * amplitude {
        // m = 2 a / L
        let (k, e) = elliptic::complete((lift - 2.0 * amplitude) / lift);
        let far = lift - 2.0 * amplitude;
        // At the threshold K is infinite and its factor zero.
        let last = if far == 0.0 { 0.0 } else { far * k };
        return 2.0 / (3.0 * PI) * lift.sqrt() * (4.0 * (lift - amplitude) * e - last);
    }
    let modulus = lift / (2.0 * amplitude);
    if modulus > 0.5 {
        // Reciprocal modulus: E(m > 1) = [E(k^2) - (1 - k^2) K(k^2)] / k, K(m > 1) = k K(k^2)
        let (complement, root) = (1.0 - modulus, modulus.sqrt());
        let (k, e) = elliptic::complete(complement);
        let bracket = 4.0 * (lift - amplitude) * (e - complement * k) / root + (2.0 * amplitude - lift) * root * k;
        return 2.0 / (3.0 * PI) * lift.sqrt() * bracket;
    }
    // The integrand is periodic and smooth: the trapezium rule with 16 steps over a quarter is
    // accurate to round-off.
    let places = 16;
    let mean = (0..=places)
        .map(|i| {
            let (sine, cosine) = (0.5 * PI * f64::from(i) / f64::from(places)).sin_cos();
            let end = if i == 0 || i == places { 0.5 } else { 1.0 };
            end * cosine.powi(4) / (1.0 - modulus * sine * sine).sqrt()
        })
        .sum::<f64>()
        / f64::from(places);
    (2.0 * amplitude).powf(1.5) * modulus * modulus * mean
}

/// Returns half of the phase in contact, from `1 - cos c = L / a`.
fn contact_angle(lift: f64, amplitude: f64) -> f64 {
    2.0 * (lift / (2.0 * amplitude)).min(1.0).sqrt().asin()
}

/// Returns `sin c - c cos c`, without cancellation.
fn sine_less_angle(c: f64) -> f64 {
    if c > 1.0 {
        return c.sin() - c * c.cos();
    }
    // sum of (-1)^(k+1) 2 k c^(2k+1) / (2k+1)!
    let mut term = c;
    let mut sum = 0.0;
    for k in 1..10 {
        let k = f64::from(k);
        term *= -c * c / (2.0 * k * (2.0 * k + 1.0));
        sum -= 2.0 * k * term;
    }
    sum
}
