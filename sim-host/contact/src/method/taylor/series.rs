//! The Taylor series of a contact about a moment: each coefficient follows from the preceding ones.
//!
//! Dahl, with `f = F / Fc`: `f' = (Kt / Fc) (V - s V f)`. This takes one Cauchy product, which is
//! also the friction power.
//!
//! LuGre, with `b = Kt z / Fc` (rates of [`rates`](crate::method::rates)), takes three more:
//!
//! ```text
//! E  = exp(-(V / Vs)^2)       k E[k] = -sum of j q[j] E[k-j],  q = (V / Vs)^2
//! y  = b / (1 + (Fs/Fc - 1) E)
//! z' = V - s V y              b' = (Kt / Fc) z',   F = Fc b + sigma1 z' + sigma2 V
//! ```

use crate::forcing::INVERSE;
use crate::problem::{Law, Motion, Problem};

/// Order of a series, and the largest permitted last coefficient of friction over Fc and of the
/// slip over its size. The step is shortened accordingly. The final error is a few times this
/// value.
const LARGEST_LAST_TERM: [(usize, f64); 7] =
    [(8, 1e-5), (12, 1e-7), (16, 1e-10), (20, 1e-13), (24, 1e-15), (28, 1e-15), (32, 1e-15)];
/// Largest change of the slip in a step, as a fraction of the slip. A series about a moment far
/// from a narrow Stribeck peak does not represent the peak.
const LARGEST_CHANGE_OF_SLIP: f64 = 0.5;
/// Addition to that change, in Stribeck velocities.
const LARGEST_CHANGE_STRIBECK: f64 = 0.5;
/// Distance from the edge of the Stribeck peak, in Stribeck velocities, above which a step ends at
/// that edge. At the edge the peak equals the permitted last term.
const EDGE_DISTANCE_STRIBECK: f64 = 1.0;
/// Slip, in Stribeck velocities, above which the peak is below round-off: exp(-42). A series that
/// neglects the peak ends there.
const PEAK_GONE_STRIBECK: f64 = 6.5;
/// Initial slip, in Stribeck velocities, above which a series with rising slip neglects the peak.
const BEYOND_RISING_STRIBECK: f64 = 7.0;
/// Initial slip, in Stribeck velocities, above which a series with falling slip neglects the peak.
const BEYOND_FALLING_STRIBECK: f64 = 13.0;

/// Coefficients over one step, in units of the step length.
pub struct Series<const N: usize> {
    pub unit_s: f64,
    /// `true` beyond the Stribeck peak, which the series then neglects.
    beyond: bool,
    /// Bristle damping over Fc, s/m.
    damping: f64,
    pub u: [f64; N],
    pub x: [f64; N],
    pub v: [f64; N],
    pub slip: [f64; N],
    /// Force in the bristles over Fc; for Dahl friction the whole friction.
    pub bristle: [f64; N],
    /// Friction over Fc, of LuGre's law.
    pub f: [f64; N],
}

/// Initial state of a series.
#[derive(Clone, Copy, Debug)]
pub struct Begin {
    /// Displacement, m.
    pub x: f64,
    /// Velocity, m/s.
    pub v: f64,
    /// Force in the bristles over Fc.
    pub bristle: f64,
    /// Sign of the slip velocity.
    pub sense: f64,
    pub coulomb_n: f64,
}

impl<const N: usize> Series<N> {
    /// Creates a series of zeros.
    pub fn new() -> Self {
        let zero = [0.0; N];
        Series { unit_s: 0.0, beyond: false, damping: 0.0, u: zero, x: zero, v: zero, slip: zero, bristle: zero, f: zero }
    }

    /// Computes the series from the initial state under the forcing `u`, whose coefficients are in
    /// units of `unit_s`.
    pub fn expand(&mut self, problem: &Problem, begin: &Begin, u: [f64; N], unit_s: f64) {
        (self.unit_s, self.u) = (unit_s, u);
        (self.x[0], self.v[0], self.bristle[0]) = (begin.x, begin.v, begin.bristle);
        match problem.law {
            Law::Coulomb => {}
            Law::Dahl { stiffness_n_per_m } => self.dahl(problem, begin, stiffness_n_per_m),
            Law::Lugre { .. } => self.lugre(problem, begin),
        }
    }

    /// Expands Dahl friction. The product V f is split so that as little as possible depends on the
    /// newest coefficient of friction:
    ///
    /// ```text
    /// (k+1) f[k+1] = (Kt / Fc) ((1 - s f[0]) V[k] - s (V f)[k]' - s V[0] f[k])      (V f)[k]': coefficients from 1 to k - 1
    /// ```
    fn dahl(&mut self, problem: &Problem, begin: &Begin, kt: f64) {
        let per_force = self.unit_s * kt / begin.coulomb_n;
        let motion = Recurrence::new(problem, begin.coulomb_n, self.unit_s);
        let mut known = [0.0; N];
        self.slip_from(&motion, 0);
        let (s, free) = (begin.sense, 1.0 - begin.sense * self.bristle[0]);
        let by_slip = s * self.slip[0];
        if N > 1 {
            self.bristle[1] = per_force * self.slip[0] * free;
            self.motion_from(&motion, begin.bristle, 0);
        }
        for k in 1..N {
            self.slip_from(&motion, k);
            if k + 1 < N {
                let per = per_force * INVERSE[k];
                let f = self.bristle[k];
                self.bristle[k + 1] = per * (free * self.slip[k] - s * known[k]) - per * by_slip * f;
                self.motion_from(&motion, f, k);
                add_known(&mut known, &self.slip, &self.bristle, k);
            }
        }
    }

    fn lugre(&mut self, problem: &Problem, begin: &Begin) {
        let Law::Lugre { stiffness_n_per_m, static_ratio, stribeck_m_per_s, sigma1, sigma2 } = problem.law else { return };
        let per_force = self.unit_s * stiffness_n_per_m / begin.coulomb_n;
        let (damping, viscous) = (sigma1 / begin.coulomb_n, sigma2 / begin.coulomb_n);
        self.damping = damping;
        let per_square = 1.0 / (stribeck_m_per_s * stribeck_m_per_s);
        let motion = Recurrence::new(problem, begin.coulomb_n, self.unit_s);
        // k times (V / Vs)^2; exp(-(V / Vs)^2); its contribution to the level; b over the level;
        // and V times that.
        let zero = [0.0; N];
        let (mut q, mut peak, mut above, mut y, mut slid) = (zero, zero, zero, zero, zero);
        let (mut squares, mut peaks, mut levels, mut slides) = (zero, zero, zero, zero);
        let mut over_level = 1.0;
        self.beyond = static_ratio == 1.0;
        for k in 0..N {
            self.slip_from(&motion, k);
            if k == 1 && !self.beyond {
                self.beyond = self.is_beyond_the_peak(stribeck_m_per_s);
            }
            y[k] = self.bristle[k];
            if k == 0 && !self.beyond {
                peak[0] = (-self.slip[0] * self.slip[0] * per_square).exp();
                above[0] = (static_ratio - 1.0) * peak[0];
                over_level = 1.0 / (1.0 + above[0]);
                y[0] *= over_level;
            } else if !self.beyond {
                let square = newest(&self.slip, &self.slip, &squares, k) * per_square;
                add_known(&mut squares, &self.slip, &self.slip, k);
                // q[0] is zero; the first coefficient of the level is on the other side of the
                // equation.
                q[k] = k as f64 * square;
                peak[k] = -(peaks[k] + q[k] * peak[0]) * INVERSE[k - 1];
                above[k] = (static_ratio - 1.0) * peak[k];
                y[k] = (y[k] - (levels[k] + above[k] * y[0])) * over_level;
                add_known(&mut peaks, &q, &peak, k);
                add_known(&mut levels, &above, &y, k);
            }
            slid[k] = newest(&self.slip, &y, &slides, k);
            add_known(&mut slides, &self.slip, &y, k);
            let z_rate = self.slip[k] - begin.sense * slid[k];
            self.f[k] = self.bristle[k] + damping * z_rate + viscous * self.slip[k];
            if k + 1 < N {
                self.bristle[k + 1] = per_force * z_rate * INVERSE[k];
                self.motion_from(&motion, self.f[k], k);
            }
        }
    }

    /// Computes coefficient `k` of the slip from that of the velocity.
    #[inline]
    fn slip_from(&mut self, motion: &Recurrence, k: usize) {
        if motion.kinematic {
            self.v[k] = self.u[k];
        }
        self.slip[k] = motion.sign * self.v[k] + if k == 0 { motion.sliding } else { 0.0 };
    }

    /// Computes the next coefficients of the motion.
    #[inline]
    fn motion_from(&mut self, motion: &Recurrence, f: f64, k: usize) {
        if !motion.kinematic {
            // The newest value, friction, enters last.
            let free = self.u[k] - motion.damping * self.v[k] - motion.stiffness * self.x[k];
            self.v[k + 1] = (free - motion.coulomb_n * f) * (motion.per_mass * INVERSE[k]);
        }
        self.x[k + 1] = motion.unit_s * INVERSE[k] * self.v[k];
    }

    /// Returns the largest permitted last term.
    pub fn largest_last_term() -> f64 {
        LARGEST_LAST_TERM.iter().find(|(order, _)| order + 1 == N).map_or(f64::EPSILON, |(_, most)| *most)
    }

    /// Returns the coefficients of friction over Fc.
    pub fn friction(&self, law: &Law) -> &[f64; N] {
        if matches!(law, Law::Lugre { .. }) { &self.f } else { &self.bristle }
    }

    /// Shortens the step until the last terms are small; returns the remaining fraction.
    pub fn shorten(&mut self, law: &Law) -> f64 {
        let last = |c: &[f64; N]| c[N - 1].abs().max(c[N - 2].abs());
        let size = self.slip[0].abs().max(self.slip[1].abs()).max(self.slip[2].abs());
        // A constant slip of zero has no size.
        let of_slip = if size > 0.0 { last(&self.slip) / size } else { 0.0 };
        let last = last(&self.bristle).max(last(self.friction(law))).max(of_slip);
        let most = Self::largest_last_term();
        let by_terms = if last <= most { 1.0 } else { power(most / last, 1.0 / (N - 2) as f64) };
        let part = self.before_the_peak(law, by_terms);
        if part == 1.0 {
            return part;
        }
        self.unit_s *= part;
        let mut power = 1.0;
        let lugre = matches!(law, Law::Lugre { .. });
        for k in 0..N {
            for c in [&mut self.u, &mut self.x, &mut self.v, &mut self.slip, &mut self.bristle] {
                c[k] *= power;
            }
            if lugre {
                self.f[k] *= power;
            }
            power *= part;
        }
        part
    }

    /// Returns `true` if all coefficients are finite.
    pub fn is_finite(&self) -> bool {
        let last = self.slip[N - 1] + self.slip[N - 2] + self.bristle[N - 1] + self.bristle[N - 2];
        last.is_finite()
    }

    /// Returns `true` if the slip is so far from the Stribeck peak, and stays there, that the peak
    /// is negligible.
    fn is_beyond_the_peak(&self, stribeck_m_per_s: f64) -> bool {
        let here = self.slip[0].abs();
        let rises = self.slip[0] * self.slip[1] > 0.0;
        here > if rises { BEYOND_RISING_STRIBECK } else { BEYOND_FALLING_STRIBECK } * stribeck_m_per_s
    }

    /// Returns the slip velocity at which the contribution of the peak to friction equals the
    /// largest permitted last term.
    ///
    /// In a series from far outside the peak, the last terms of the peak are negligible, and the
    /// peak grows unnoticed:
    ///
    /// ```text
    /// exp(-(x - d)^2) = exp(-x^2) (1 + 2 x d + ... (2 x d)^n / n! ...)      largest term at n = 2 x d
    /// ```
    fn edge_of_the_peak(&self, static_ratio: f64, stribeck_m_per_s: f64) -> f64 {
        let size = (static_ratio - 1.0) * (1.0 + self.damping * self.slip[0].abs());
        (size / Self::largest_last_term()).ln().max(0.0).sqrt() * stribeck_m_per_s
    }

    /// Returns the fraction of the step within which the slip stays where the series represents the
    /// Stribeck peak, or where the peak is negligible.
    fn before_the_peak(&self, law: &Law, mut part: f64) -> f64 {
        let Law::Lugre { static_ratio, stribeck_m_per_s, .. } = *law else { return part };
        if static_ratio == 1.0 {
            return part;
        }
        let here = self.slip[0].abs();
        let sum = |part: f64, of: &dyn Fn(f64) -> f64| {
            let add = |(sum, power): (f64, f64), c: &f64| (sum + power * part * of(*c), power * part);
            self.slip.iter().skip(1).fold((0.0, 1.0), add).0
        };
        if self.beyond {
            let sense = self.slip[0].signum();
            let most = here - PEAK_GONE_STRIBECK * stribeck_m_per_s;
            while sum(part, &|c| (-sense * c).max(0.0)) > most {
                part *= 0.7;
            }
            return part;
        }
        let most = LARGEST_CHANGE_OF_SLIP * here + LARGEST_CHANGE_STRIBECK * stribeck_m_per_s;
        let further_out = EDGE_DISTANCE_STRIBECK * stribeck_m_per_s;
        let unseen = if here > further_out { here - self.edge_of_the_peak(static_ratio, stribeck_m_per_s) } else { 0.0 };
        let most = if unseen > further_out { most.min(unseen) } else { most };
        while sum(part, &|c| c.abs()) > most {
            part *= 0.7;
        }
        part
    }
}

/// Constants of the recurrence for the motion's coefficients.
struct Recurrence {
    kinematic: bool,
    /// Sign of x' in the slip velocity.
    sign: f64,
    /// Sliding speed, m/s.
    sliding: f64,
    unit_s: f64,
    coulomb_n: f64,
    /// Time unit over the mass, s/kg.
    per_mass: f64,
    /// Stiffness Ks, N/m.
    stiffness: f64,
    /// Damping c, N s/m.
    damping: f64,
}

impl Recurrence {
    fn new(problem: &Problem, coulomb_n: f64, unit_s: f64) -> Self {
        let (sign, sliding) = (problem.sign.factor(), problem.sliding_m_per_s);
        let (kinematic, per_mass, stiffness, damping) = match problem.motion {
            Motion::Kinematic => (true, 0.0, 0.0, 0.0),
            Motion::Sdof { mass_kg, stiffness_n_per_m, damping_n_s_per_m } => {
                (false, unit_s / mass_kg, stiffness_n_per_m, damping_n_s_per_m)
            }
        };
        Recurrence { kinematic, sign, sliding, unit_s, coulomb_n, per_mass, stiffness, damping }
    }
}

/// Returns coefficient `k` of a product, from the sum over the inner coefficients and the two
/// newest products.
#[inline]
fn newest<const N: usize>(a: &[f64; N], b: &[f64; N], known: &[f64; N], k: usize) -> f64 {
    if k == 0 { a[0] * b[0] } else { known[k] + (a[k] * b[0] + a[0] * b[k]) }
}

/// Adds the products of the coefficients `k` of two series with each other's coefficients 1 to `k`
/// to the later coefficients of their product. These sums are independent of each other, so none
/// waits for the preceding coefficient.
#[inline]
fn add_known<const N: usize>(known: &mut [f64; N], a: &[f64; N], b: &[f64; N], k: usize) {
    let below = k.min(N.saturating_sub(k));
    if k == 0 {
        return;
    }
    let (newest_a, newest_b) = (a[k], b[k]);
    if below > 1 {
        let sums = known[k + 1..k + below].iter_mut();
        for ((sum, a), b) in sums.zip(&a[1..below]).zip(&b[1..below]) {
            *sum += newest_a * b + a * newest_b;
        }
    }
    if 2 * k < N {
        known[2 * k] += newest_a * newest_b;
    }
}

/// Raises a positive number to a power, accurate to a few percent and identical on every machine:
/// the mantissa approximates its own logarithm.
fn power(base: f64, exponent: f64) -> f64 {
    const ONE: f64 = (1u64 << 52) as f64;
    const BIAS: f64 = 1023.0;
    let logarithm = base.to_bits() as f64 / ONE - BIAS;
    f64::from_bits(((exponent * logarithm + BIAS).clamp(1.0, 2.0 * BIAS) * ONE) as u64)
}
