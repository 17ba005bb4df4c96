//! Coulomb friction under a vibration at an angle: means over a period, in closed form.
//!
//! Notation: velocity ratio z = Vt / Vv, vibration u in units of its peak, c = cos a, s = sin a. In
//! these units the slip is `|w| = sqrt(u^2 + 2 z c u + z^2)`; A is its value at u = 1, B at u = -1.
//! The means over a period are
//!
//! ```text
//! r      = mean (z + c u) / |w|          friction ratio
//! z phi  = mean |w|                      power ratio
//! y^2    = mean (s u / |w|)^2            square of the friction across, over Fc
//! ```
//!
//! For the sine, `du / sqrt(1 - u^2)` makes r an elliptic integral whose quartic has two real and
//! two complex zeros. The substitution `u = -(al + cn) / (1 + al cn)`, `al = (A - B) / (A + B)`,
//! (Byrd and Friedman 1971, 259.00) turns it and the power into complete integrals of
//! `kc^2 = ((A + B)^2 - 4) / (4 A B)` and `p = (A + B)^2 / (4 A B)`. With Bulirsch's function cel:
//!
//! ```text
//! r     = (2 / (pi sqrt(A B))) cel(kc, p, z, p (z - c al))
//! z phi = (2 sqrt(A B) / pi) [E + al^2 p cel(kc, p, 1, 0)]
//! y^2   = -s Im[e^(ia) d],  d = q / (R (1 + R)),  R = sqrt(1 - q),  q = e^(-2ia) / z^2
//! ```
//!
//! Across, a = 90 degrees, this is `r = (2/pi) z / sqrt(1 + z^2) K(m = 1 / (1 + z^2))` and
//! `phi = (2/pi) sqrt(1 + 1/z^2) E(m)`; along, `r = (2/pi) asin z`. Differences are computed from
//! `A B - (1 - z^2) = 4 z^2 s^2 / (A B + 1 - z^2)`, so that no terms cancel at any z and a.

use std::f64::consts::{FRAC_2_PI, TAU};

use super::super::closed::{coulomb_friction_ratio, coulomb_power_ratio, gauss};
use super::super::hertz::elliptic;
use super::super::problem::Problem;
use super::super::waveform::Shape;
use super::{Direction, Moment};

/// Velocity ratio above which the transverse mean square is computed by quadrature, because its
/// closed form would cancel.
const QUADRATURE_VELOCITY_RATIO: f64 = 2.0;

/// Means over a period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoulombMeans {
    /// Mean friction along the sliding over Coulomb force.
    pub friction: f64,
    /// Power into friction over Fc Vt; `None` without sliding.
    pub power: Option<f64>,
    /// Mean square of the friction across the sliding, over that of the Coulomb force.
    pub transverse_square: f64,
}

/// Returns the means for a shape of vibration at a velocity ratio, which is infinite without
/// vibration; `None` for a shape that is not periodic.
pub fn means(shape: Shape, velocity_ratio: f64, direction: Direction) -> Option<CoulombMeans> {
    let size = velocity_ratio.abs();
    let found = match shape {
        Shape::Random { .. } | Shape::Chirp { .. } | Shape::Measured => return None,
        _ if velocity_ratio.is_nan() => CoulombMeans { friction: 0.0, power: None, transverse_square: 0.0 },
        Shape::Still => CoulombMeans { friction: 1.0, power: Some(1.0), transverse_square: 0.0 },
        _ if size == f64::INFINITY => CoulombMeans { friction: 1.0, power: Some(1.0), transverse_square: 0.0 },
        Shape::Sine => sine(size, direction),
        Shape::Square => square(size, direction),
        Shape::Sawtooth | Shape::Triangle => even(size, direction),
    };
    Some(CoulombMeans { friction: found.friction.copysign(velocity_ratio), power: found.power.filter(|_| size != 0.0), ..found })
}

/// Returns the friction ratio under a sine, at a velocity ratio and an angle, degrees.
pub fn friction_ratio(velocity_ratio: f64, angle_deg: f64) -> f64 {
    means(Shape::Sine, velocity_ratio, Direction::from_degrees(angle_deg)).map_or(f64::NAN, |means| means.friction)
}

/// Returns the friction ratio under a sine, at a velocity ratio of zero or more. An infinite ratio
/// means no vibration and gives one.
pub fn sine_friction(velocity_ratio: f64, direction: Direction) -> f64 {
    match velocity_ratio {
        z if z == f64::INFINITY => 1.0,
        0.0 => 0.0,
        z if direction.across == 0.0 => coulomb_friction_ratio(z),
        z => Ends::new(z, direction.across).friction(z),
    }
}

/// Slip at both ends of the vibration, with combinations that do not cancel.
struct Ends {
    /// Sum A + B.
    sum: f64,
    /// Product A B.
    product: f64,
    /// Difference (A + B)^2 - 4.
    beyond: f64,
    /// Difference (A + B)^2 - 4 c^2.
    open: f64,
}

impl Ends {
    /// Computes the ends at a velocity ratio, from the sine of the angle.
    fn new(z: f64, s: f64) -> Self {
        let inner = (1.0 - z) * (1.0 + z);
        let product = inner.hypot(2.0 * z * s);
        // A B - (1 - z^2)
        let excess = if inner > 0.0 { 4.0 * z * z * s * s / (product + inner) } else { product - inner };
        let sum = (2.0 * (1.0 + z * z + product)).sqrt();
        Ends { sum, product, beyond: 2.0 * excess, open: 2.0 * excess + 4.0 * s * s }
    }

    /// Returns the friction ratio under a sine with these ends.
    fn friction(&self, z: f64) -> f64 {
        let four = 4.0 * self.product;
        // z - c al = z ((A + B)^2 - 4 c^2) / (A + B)^2
        let integral = elliptic::general((self.beyond / four).sqrt(), self.sum * self.sum / four, z, z * self.open / four);
        FRAC_2_PI * (integral / self.product.sqrt())
    }
}

fn sine(z: f64, direction: Direction) -> CoulombMeans {
    let Direction { along: c, across: s } = direction;
    if s == 0.0 {
        let power = coulomb_power_ratio(z);
        return CoulombMeans { friction: coulomb_friction_ratio(z), power, transverse_square: 0.0 };
    }
    if z == 0.0 {
        return CoulombMeans { friction: 0.0, power: None, transverse_square: s * s };
    }
    let ends = Ends::new(z, direction.across);
    let four = 4.0 * ends.product;
    let (p, complement) = (ends.sum * ends.sum / four, ends.beyond / four);
    let kc = complement.sqrt();
    let alpha = 4.0 * z * c / (ends.sum * ends.sum);
    let friction = ends.friction(z);
    let (_, e) = elliptic::complete(complement);
    let slip = ends.product.sqrt() * (e + alpha * alpha * p * elliptic::general(kc, p, 1.0, 0.0));
    CoulombMeans { friction, power: Some(FRAC_2_PI * slip / z), transverse_square: sine_square(z, direction) }
}

/// Returns `-s Im[e^(ia) d]`.
fn sine_square(z: f64, Direction { along: c, across: s }: Direction) -> f64 {
    // 1 - q = (z^2 - e^(-2ia)) / z^2; in units of 1 / z^2: real (z - 1)(z + 1) + 2 s^2, imaginary 2
    // s c
    let (real, imaginary) = ((z - 1.0) * (z + 1.0) + 2.0 * s * s, 2.0 * s * c);
    // z R, on the branch that approaches z for large z
    let size = real.hypot(imaginary);
    let root = if real > 0.0 {
        let re = (0.5 * (size + real)).sqrt();
        (re, 0.5 * imaginary / re)
    } else {
        let im = (0.5 * (size - real)).sqrt();
        (0.5 * imaginary / im, im)
    };
    // d = e^(-2ia) / (z R (z + z R)); e^(ia) d = e^(-ia) / (z R (z + z R))
    let sum = (z + root.0, root.1);
    let below = (root.0 * sum.0 - root.1 * sum.1, root.0 * sum.1 + root.1 * sum.0);
    let square = below.0 * below.0 + below.1 * below.1;
    s * (s * below.0 + c * below.1) / square
}

/// Returns the means for a square: half of the time at one end, half at the other.
fn square(z: f64, Direction { along: c, across: s }: Direction) -> CoulombMeans {
    let ends = [1.0, -1.0].map(|u: f64| {
        let (along, across) = (z + c * u, s * u);
        let size = along.hypot(across);
        if size == 0.0 { [0.0; 3] } else { [along / size, size, (across / size).powi(2)] }
    });
    let mean = |which: usize| 0.5 * (ends[0][which] + ends[1][which]);
    CoulombMeans { friction: mean(0), power: Some(mean(1) / z), transverse_square: mean(2) }
}

/// Returns the means for triangle and sawtooth, which spend equal times at all velocities.
///
/// With L the potential of a rod, `ln((A + B + 2) / (A + B - 2))`, r = 2 z c^2 / (A + B) + z s^2 L
/// / 2.
fn even(z: f64, direction: Direction) -> CoulombMeans {
    let Direction { along: c, across: s } = direction;
    if z == 0.0 {
        return CoulombMeans { friction: 0.0, power: None, transverse_square: s * s };
    }
    let ends = Ends::new(z, direction.across);
    let outside = ends.beyond / (ends.sum + 2.0);
    let rod = if s == 0.0 { 0.0 } else { (4.0 / outside).ln_1p() };
    let friction = 2.0 * z * c * c / ends.sum + 0.5 * z * s * s * rod;
    let slip = 0.25 * (ends.sum + 4.0 * z * z * c * c / ends.sum + z * z * s * s * rod);
    let of_square = |u: f64| {
        let (along, across) = (z + c * u, s * u);
        across * across / (along * along + across * across)
    };
    let transverse_square = if s == 0.0 {
        0.0
    } else if z > QUADRATURE_VELOCITY_RATIO {
        gauss::whole().iter().map(|node| node.weight * of_square(2.0 * node.at - 1.0)).sum()
    } else {
        let (one, other) = ((1.0 + z * c).hypot(z * s), (1.0 - z * c).hypot(z * s));
        let angle = (1.0 + z * c).atan2(z * s) + (1.0 - z * c).atan2(z * s);
        s * s - s * z * (s * c * (one / other).ln() + 0.5 * (s - c) * (s + c) * angle)
    };
    CoulombMeans { friction, power: Some(slip / z), transverse_square }
}

/// Returns moments of the last period, both ends included.
pub(super) fn period(problem: &Problem, direction: Direction, moments: u32) -> Vec<Moment> {
    let hz = problem.waveform.frequency_hz();
    let from_s = (problem.duration_s - 1.0 / hz).max(0.0);
    let mut displacement_m = 0.0;
    let mut before = None;
    let step_s = 1.0 / (hz * f64::from(moments));
    (0..=moments)
        .map(|index| {
            let time_s = from_s + step_s * f64::from(index);
            // At a jump the value is the one after it; at the end of the period, the one before it.
            let shown = problem.waveform.value(time_s - 1e-9 * step_s * f64::from(u8::from(index == moments)));
            let u = problem.sign.factor() * shown;
            displacement_m += 0.5 * step_s * before.map_or(0.0, |before: f64| before + u);
            before = Some(u);
            let slip = [problem.sliding_m_per_s + direction.along * u, direction.across * u];
            let size = slip[0].hypot(slip[1]);
            let friction_n = slip.map(|part| if size == 0.0 { 0.0 } else { problem.coulomb_n * part / size });
            Moment { time_s, displacement_m, vibration_m_per_s: u, slip_m_per_s: slip, friction_n }
        })
        .map(|moment| match problem.waveform.shape() {
            Shape::Sine => Moment { displacement_m: displacement_of_sine(problem, moment.time_s), ..moment },
            _ => moment,
        })
        .collect()
}

/// Returns the displacement of the sine, m.
fn displacement_of_sine(problem: &Problem, time_s: f64) -> f64 {
    let hz = problem.waveform.frequency_hz();
    problem.sign.factor() * problem.waveform.amplitude() / (TAU * hz) * (TAU * (hz * time_s).fract()).sin()
}
