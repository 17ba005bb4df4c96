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

use crate::problem::{Law, Motion, Problem};

/// Where the last coefficients of friction over Fc are larger than this, the step is too long for the series: of low orders, whose steps
/// are chosen for their error, and of high ones, which go to round-off.
const LARGEST_LAST_TERM: [f64; 2] = [1e-9, 1e-13];
/// The orders that go to round-off.
const HIGH_ORDER: usize = 20;
/// Largest change of the slip in a step, of the slip itself and of the Stribeck velocity: a series about a moment far from a narrow
/// Stribeck peak does not see it.
const LARGEST_CHANGE: (f64, f64) = (0.5, 0.5);
/// Beyond so many Stribeck velocities the peak is gone, and so is this bound.
const FAR: f64 = 1e6;

/// Coefficients over one step, in units of the step.
pub struct Series<const N: usize> {
    pub unit_s: f64,
    pub u: [f64; N],
    pub x: [f64; N],
    pub v: [f64; N],
    pub slip: [f64; N],
    /// Force in the bristles, over Fc: for Dahl friction all of it.
    pub bristle: [f64; N],
    /// Friction over Fc.
    pub f: [f64; N],
    /// f V, m/s.
    pub power: [f64; N],
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
    /// The series under a forcing's, which is in units of `unit_s`.
    pub fn new(problem: &Problem, begin: &Begin, u: [f64; N], unit_s: f64) -> Self {
        let zero = [0.0; N];
        let mut series = Series { unit_s, u, x: zero, v: zero, slip: zero, bristle: zero, f: zero, power: zero };
        (series.x[0], series.v[0], series.bristle[0]) = (begin.x, begin.v, begin.bristle);
        match problem.law {
            Law::Coulomb => {}
            Law::Dahl { stiffness_n_per_m } => series.dahl(problem, begin, stiffness_n_per_m),
            Law::Lugre { .. } => series.lugre(problem, begin),
        }
        series
    }

    fn dahl(&mut self, problem: &Problem, begin: &Begin, kt: f64) {
        let per_force = self.unit_s * kt / begin.coulomb_n;
        for k in 0..N {
            self.f[k] = self.bristle[k];
            self.slip_from(problem, k);
            self.power[k] = self.cauchy(k, |series| (&series.slip, &series.f));
            if k + 1 < N {
                self.bristle[k + 1] = per_force * (self.slip[k] - begin.sense * self.power[k]) * over(k);
                self.motion_from(problem, begin.coulomb_n, k);
            }
        }
    }

    fn lugre(&mut self, problem: &Problem, begin: &Begin) {
        let Law::Lugre { stiffness_n_per_m, static_ratio, stribeck_m_per_s, sigma1, sigma2 } = problem.law else { return };
        let per_force = self.unit_s * stiffness_n_per_m / begin.coulomb_n;
        let (damping, viscous) = (sigma1 / begin.coulomb_n, sigma2 / begin.coulomb_n);
        // (V / Vs)^2 times its index, exp of minus that, b over the level, and V times that.
        let (mut q, mut peak, mut y, mut slid) = ([0.0; N], [0.0; N], [0.0; N], [0.0; N]);
        let mut above = [0.0; N];
        for k in 0..N {
            self.slip_from(problem, k);
            let square = self.cauchy(k, |series| (&series.slip, &series.slip)) / (stribeck_m_per_s * stribeck_m_per_s);
            q[k] = k as f64 * square;
            peak[k] = if k == 0 { (-square).exp() } else { -(1..=k).map(|j| q[j] * peak[k - j]).sum::<f64>() / k as f64 };
            above[k] = (static_ratio - 1.0) * peak[k];
            y[k] = (self.bristle[k] - (1..=k).map(|j| above[j] * y[k - j]).sum::<f64>()) / (1.0 + above[0]);
            slid[k] = (0..=k).map(|j| self.slip[j] * y[k - j]).sum();
            let z_rate = self.slip[k] - begin.sense * slid[k];
            self.f[k] = self.bristle[k] + damping * z_rate + viscous * self.slip[k];
            self.power[k] = self.cauchy(k, |series| (&series.slip, &series.f));
            if k + 1 < N {
                self.bristle[k + 1] = per_force * z_rate * over(k);
                self.motion_from(problem, begin.coulomb_n, k);
            }
        }
    }

    fn cauchy(&self, k: usize, of: impl Fn(&Self) -> (&[f64; N], &[f64; N])) -> f64 {
        let (a, b) = of(self);
        (0..=k).map(|j| a[j] * b[k - j]).sum()
    }

    /// The slip's coefficient, from the velocity's.
    fn slip_from(&mut self, problem: &Problem, k: usize) {
        if problem.motion == Motion::Kinematic {
            self.v[k] = self.u[k];
        }
        self.slip[k] = problem.sign.factor() * self.v[k] + if k == 0 { problem.sliding_m_per_s } else { 0.0 };
    }

    /// The motion's next coefficients.
    fn motion_from(&mut self, problem: &Problem, coulomb_n: f64, k: usize) {
        if let Motion::Sdof { mass_kg, stiffness_n_per_m, damping_n_s_per_m } = problem.motion {
            let force = self.u[k] - damping_n_s_per_m * self.v[k] - stiffness_n_per_m * self.x[k] - coulomb_n * self.f[k];
            self.v[k + 1] = self.unit_s / mass_kg * force * over(k);
        }
        self.x[k + 1] = self.unit_s * self.v[k] * over(k);
    }

    /// Shortens the step to where the last terms of the friction are small; tells to which part.
    pub fn shorten(&mut self, law: &Law) -> f64 {
        let last = |c: &[f64; N]| c[N - 1].abs().max(c[N - 2].abs());
        let last = last(&self.bristle).max(last(&self.f));
        let most = LARGEST_LAST_TERM[usize::from(N > HIGH_ORDER)];
        let by_terms = if last <= most { 1.0 } else { (most / last).powf(1.0 / (N - 2) as f64) };
        let part = by_terms.min(self.before_the_peak(law));
        if part == 1.0 {
            return part;
        }
        self.unit_s *= part;
        for c in [&mut self.u, &mut self.x, &mut self.v, &mut self.slip, &mut self.bristle, &mut self.f, &mut self.power] {
            c.iter_mut().fold(1.0, |power, c| {
                *c *= power;
                power * part
            });
        }
        part
    }

    /// The part of the step in which the slip comes no closer to a Stribeck peak than the series can see.
    fn before_the_peak(&self, law: &Law) -> f64 {
        let Law::Lugre { static_ratio, stribeck_m_per_s, .. } = *law else { return 1.0 };
        let here = self.slip[0].abs();
        if static_ratio == 1.0 || here > FAR * stribeck_m_per_s {
            return 1.0;
        }
        let most = LARGEST_CHANGE.0 * here + LARGEST_CHANGE.1 * stribeck_m_per_s;
        let change = |part: f64| {
            let add = |(sum, power): (f64, f64), c: &f64| (sum + power * part * c.abs(), power * part);
            self.slip.iter().skip(1).fold((0.0, 1.0), add).0
        };
        let mut part = 1.0;
        while change(part) > most {
            part *= 0.7;
        }
        part
    }
}

fn over(k: usize) -> f64 {
    1.0 / (k + 1) as f64
}
