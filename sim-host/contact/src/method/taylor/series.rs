//! The series of a contact about a moment: each coefficient follows from the ones before.
//!
//! Dahl, with `f = F / Fc`: `f' = (Kt / Fc) (V - s V f)`; one Cauchy product, which is the friction power, too.
//!
//! LuGre, with `b = Kt z / Fc` (rates of [`rates`](crate::method::rates)) takes three more:
//!
//! ```text
//! E  = exp(-(V / Vs)^2)       k E[k] = -sum of j q[j] E[k-j],  q = (V / Vs)^2
//! y  = b / (1 + (Fs/Fc - 1) E)
//! z' = V - s V y              b' = (Kt / Fc) z',   F = Fc b + sigma1 z' + sigma2 V
//! ```

use crate::forcing::INVERSE;
use crate::problem::{Law, Motion, Problem};

/// The step ends where the last coefficients, of friction over Fc and of the slip over its size, are as large as this: orders and what they are
/// good for, a few times as much in the end.
const LARGEST_LAST_TERM: [(usize, f64); 7] =
    [(8, 1e-5), (12, 1e-7), (16, 1e-10), (20, 1e-13), (24, 1e-15), (28, 1e-15), (32, 1e-15)];
/// Largest change of the slip in a step, of the slip itself and of the Stribeck velocity: a series about a moment far from a narrow
/// Stribeck peak does not see it.
const LARGEST_CHANGE: (f64, f64) = (0.5, 0.5);
/// A step that begins so many Stribeck velocities further out than where the peak is as large as the last terms may be ends there.
const FURTHER_OUT: f64 = 1.0;
/// Beyond so many Stribeck velocities the peak is less than round-off: exp(-42). A series that stays there has none, if it begins so far out, with a
/// slip that rises or falls.
const GONE: f64 = 6.5;
const RISES: f64 = 7.0;
const FALLS: f64 = 13.0;

/// Coefficients over one step, in units of the step.
pub struct Series<const N: usize> {
    pub unit_s: f64,
    /// Whether it is beyond the Stribeck peak, of which it has nothing.
    beyond: bool,
    /// What bristle damping makes of a slip velocity, of Fc, s/m.
    damping: f64,
    pub u: [f64; N],
    pub x: [f64; N],
    pub v: [f64; N],
    pub slip: [f64; N],
    /// Force in the bristles, over Fc: for Dahl friction all of it.
    pub bristle: [f64; N],
    /// Friction over Fc, of LuGre's law.
    pub f: [f64; N],
}

/// Where a series begins, and under what.
#[derive(Clone, Copy, Debug)]
pub struct Begin {
    /// Displacement, m; velocity, m/s; bristle force over Fc.
    pub x: f64,
    pub v: f64,
    pub bristle: f64,
    /// Sign of the slip velocity.
    pub sense: f64,
    pub coulomb_n: f64,
}

impl<const N: usize> Series<N> {
    /// A series of nothing.
    pub fn new() -> Self {
        let zero = [0.0; N];
        Series { unit_s: 0.0, beyond: false, damping: 0.0, u: zero, x: zero, v: zero, slip: zero, bristle: zero, f: zero }
    }

    /// Makes it the series that begins so under a forcing's, which is in units of `unit_s`.
    pub fn expand(&mut self, problem: &Problem, begin: &Begin, u: [f64; N], unit_s: f64) {
        (self.unit_s, self.u) = (unit_s, u);
        (self.x[0], self.v[0], self.bristle[0]) = (begin.x, begin.v, begin.bristle);
        match problem.law {
            Law::Coulomb => {}
            Law::Dahl { stiffness_n_per_m } => self.dahl(problem, begin, stiffness_n_per_m),
            Law::Lugre { .. } => self.lugre(problem, begin),
        }
    }

    /// The product V f is taken apart, so that as little as possible waits for the newest coefficient of the friction:
    ///
    /// ```text
    /// (k+1) f[k+1] = (Kt / Fc) ((1 - s f[0]) V[k] - s (V f)[k]' - s V[0] f[k])      (V f)[k]' of coefficients from 1 to k - 1
    /// ```
    fn dahl(&mut self, problem: &Problem, begin: &Begin, kt: f64) {
        let per_force = self.unit_s * kt / begin.coulomb_n;
        let motion = Recurrence::of(problem, begin.coulomb_n, self.unit_s);
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
        let motion = Recurrence::of(problem, begin.coulomb_n, self.unit_s);
        // (V / Vs)^2 times its index, exp of minus that, what it adds to the level, b over the level, and V times that.
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
                // q[0] is zero, and the level's own first coefficient on the other side of the equation.
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

    /// The slip's coefficient, from the velocity's.
    #[inline]
    fn slip_from(&mut self, motion: &Recurrence, k: usize) {
        if motion.kinematic {
            self.v[k] = self.u[k];
        }
        self.slip[k] = motion.sign * self.v[k] + if k == 0 { motion.sliding } else { 0.0 };
    }

    /// The motion's next coefficients.
    #[inline]
    fn motion_from(&mut self, motion: &Recurrence, f: f64, k: usize) {
        if !motion.kinematic {
            // What friction is comes last.
            let free = self.u[k] - motion.damping * self.v[k] - motion.stiffness * self.x[k];
            self.v[k + 1] = (free - motion.coulomb_n * f) * (motion.per_mass * INVERSE[k]);
        }
        self.x[k + 1] = motion.unit_s * INVERSE[k] * self.v[k];
    }

    /// As large the last terms may be.
    pub fn largest_last_term() -> f64 {
        LARGEST_LAST_TERM.iter().find(|(order, _)| order + 1 == N).map_or(f64::EPSILON, |(_, most)| *most)
    }

    /// Friction over Fc.
    pub fn friction(&self, law: &Law) -> &[f64; N] {
        if matches!(law, Law::Lugre { .. }) { &self.f } else { &self.bristle }
    }

    /// Shortens the step to where the last terms are small; tells to which part.
    pub fn shorten(&mut self, law: &Law) -> f64 {
        let last = |c: &[f64; N]| c[N - 1].abs().max(c[N - 2].abs());
        let size = self.slip[0].abs().max(self.slip[1].abs()).max(self.slip[2].abs());
        // A slip that changes by nothing has no size.
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

    /// Whether all of it is numbers.
    pub fn is_finite(&self) -> bool {
        let last = self.slip[N - 1] + self.slip[N - 2] + self.bristle[N - 1] + self.bristle[N - 2];
        last.is_finite()
    }

    /// Whether the slip is so far from a Stribeck peak, and stays there, that nothing is seen of it.
    fn is_beyond_the_peak(&self, stribeck_m_per_s: f64) -> bool {
        let here = self.slip[0].abs();
        let rises = self.slip[0] * self.slip[1] > 0.0;
        here > if rises { RISES } else { FALLS } * stribeck_m_per_s
    }

    /// The slip velocity at which the peak makes as much of the friction as the last terms may be. From far outside of it the peak's last terms
    /// are nothing, and the peak grows behind them:
    ///
    /// ```text
    /// exp(-(x - d)^2) = exp(-x^2) (1 + 2 x d + ... (2 x d)^n / n! ...)      largest term at n = 2 x d
    /// ```
    fn edge_of_the_peak(&self, static_ratio: f64, stribeck_m_per_s: f64) -> f64 {
        let size = (static_ratio - 1.0) * (1.0 + self.damping * self.slip[0].abs());
        (size / Self::largest_last_term()).ln().max(0.0).sqrt() * stribeck_m_per_s
    }

    /// The part of the step in which the slip comes no closer to a Stribeck peak than the series can see, or than where nothing is seen of it.
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
            let most = here - GONE * stribeck_m_per_s;
            while sum(part, &|c| (-sense * c).max(0.0)) > most {
                part *= 0.7;
            }
            return part;
        }
        let most = LARGEST_CHANGE.0 * here + LARGEST_CHANGE.1 * stribeck_m_per_s;
        let further_out = FURTHER_OUT * stribeck_m_per_s;
        let unseen = if here > further_out { here - self.edge_of_the_peak(static_ratio, stribeck_m_per_s) } else { 0.0 };
        let most = if unseen > further_out { most.min(unseen) } else { most };
        while sum(part, &|c| c.abs()) > most {
            part *= 0.7;
        }
        part
    }
}

/// What the motion's coefficients follow from.
struct Recurrence {
    kinematic: bool,
    /// Sign of x' in the slip velocity; sliding speed, m/s.
    sign: f64,
    sliding: f64,
    unit_s: f64,
    coulomb_n: f64,
    /// The unit of time over the mass; stiffness and damping.
    per_mass: f64,
    stiffness: f64,
    damping: f64,
}

impl Recurrence {
    fn of(problem: &Problem, coulomb_n: f64, unit_s: f64) -> Self {
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

/// Coefficient `k` of a product, of what is known of it by the coefficients before, and the two newest.
#[inline]
fn newest<const N: usize>(a: &[f64; N], b: &[f64; N], known: &[f64; N], k: usize) -> f64 {
    if k == 0 { a[0] * b[0] } else { known[k] + (a[k] * b[0] + a[0] * b[k]) }
}

/// Adds what coefficients `k` of two series do to the later ones of their product, together with those from 1 to `k`. Each of these sums is on its
/// own, so they are done side by side, and none waits for the coefficient before.
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

/// A positive number to a power, to a few percent, and the same on every machine: the mantissa stands for its own logarithm.
fn power(base: f64, exponent: f64) -> f64 {
    const ONE: f64 = (1u64 << 52) as f64;
    const BIAS: f64 = 1023.0;
    let logarithm = base.to_bits() as f64 / ONE - BIAS;
    f64::from_bits(((exponent * logarithm + BIAS).clamp(1.0, 2.0 * BIAS) * ONE) as u64)
}
