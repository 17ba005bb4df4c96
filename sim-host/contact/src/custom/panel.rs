//! One interval by collocation: the polynomial through the start and twelve Radau points that
//! satisfies the equations of motion and friction at these points. Newton's method finds it.
//!
//! ```text
//! y = z, or (z, x, x')    internal states; displacement and velocity if the motion is not given
//! m x'' = Fe - c x' - Ks x - F,   V = Vt + s x'                                 (4.14, 4.16)
//! D u = h f(y0 + u)       u, change of y at the points; D, derivative of the polynomial
//! ```
//!
//! The solution at the end has order 23. The error inside is judged in two ways, of which the
//! larger counts: by the highest Chebyshev coefficients of y and of the friction, and by the rates
//! and the friction half-way between the points, which the polynomials through the points must
//! meet.

use nalgebra::{DMatrix, DVector};

use super::{At, FrictionLaw, Partial};
use crate::forcing::Forcing;
use crate::problem::{Motion, Problem};
use crate::radau::{STAGES, halfway, rule};

/// Maximum number of Newton's steps.
const MAX_STEPS: usize = 12;
/// Change, relative to the size, below which Newton's method, which doubles its digits in each
/// step, is at round-off.
const SMALL_STEP: f64 = 1e-9;
/// Relative displacement for derivatives by differences.
const DIFFERENCE_REL: f64 = 1e-7;
/// Share of the second highest coefficient in the error of a polynomial.
const SECOND_SHARE: f64 = 0.1;

/// Equations of motion and friction between two events.
pub(super) struct Equations<'a> {
    pub(super) law: &'a dyn FrictionLaw,
    pub(super) problem: &'a Problem,
    /// Number of internal states.
    pub(super) states: usize,
    /// Coulomb force, N.
    pub(super) coulomb_n: f64,
    /// Sign of the slip velocity.
    pub(super) sign: f64,
    pub(super) switches: Vec<bool>,
    /// Largest size of each part of y so far.
    pub(super) scale: Vec<f64>,
    /// Largest friction so far, N.
    pub(super) largest_n: f64,
    /// Largest length of an interval, s.
    pub(super) most_s: f64,
}

/// Forces and velocities at one point.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Point {
    /// Vibration velocity x', m/s.
    pub(super) v_m_per_s: f64,
    /// Slip velocity V, m/s.
    pub(super) slip_m_per_s: f64,
    /// Friction, N.
    pub(super) force_n: f64,
    /// Excitation, N or m/s.
    pub(super) forcing: f64,
}

/// Solved interval.
pub(super) struct Panel {
    /// Values of y at the start and at the points.
    pub(super) values: Vec<Vec<f64>>,
    /// Forces and velocities at the points.
    pub(super) points: Vec<Point>,
    /// Error of the polynomial, relative to the size of each part.
    pub(super) error: f64,
}

impl Equations<'_> {
    /// Returns the forces at a state y, and its rates.
    pub(super) fn point(&self, y: &[f64], forcing: f64, rates: &mut [f64]) -> Point {
        let v = match self.problem.motion {
            Motion::Kinematic => forcing,
            Motion::Sdof { .. } => y[self.states + 1],
        };
        let slip = self.problem.sliding_m_per_s + self.problem.sign.factor() * v;
        let force = self.law.rates(&self.at(&y[..self.states], slip), &mut rates[..self.states]);
        if let Motion::Sdof { mass_kg, stiffness_n_per_m, damping_n_s_per_m } = self.problem.motion {
            rates[self.states] = v;
            rates[self.states + 1] = (forcing - damping_n_s_per_m * v - stiffness_n_per_m * y[self.states] - force) / mass_kg;
        }
        Point { v_m_per_s: v, slip_m_per_s: slip, force_n: force, forcing }
    }

    pub(super) fn at<'b>(&'b self, states: &'b [f64], slip_m_per_s: f64) -> At<'b> {
        At { slip_m_per_s, sign: self.sign, coulomb_n: self.coulomb_n, states, switches: &self.switches }
    }

    /// Returns the margins of all events at a state y: of the slip's sign, then of the switches.
    pub(super) fn margins(&self, y: &[f64], forcing: f64) -> Vec<f64> {
        let v = if self.problem.motion == Motion::Kinematic { forcing } else { y[self.states + 1] };
        let slip = self.problem.sliding_m_per_s + self.problem.sign.factor() * v;
        let at = self.at(&y[..self.states], slip);
        let switches = (0..self.switches.len()).map(|switch| self.law.margin(switch, &at));
        std::iter::once(self.sign * slip).chain(switches).collect()
    }

    /// Solves the interval of `length_s` from `from_s` of the forcing; `None` if Newton's method
    /// fails.
    pub(super) fn solve(&self, forcing: &Forcing, (from_s, length_s): (f64, f64), y0: &[f64]) -> Option<Panel> {
        let (rule, parts) = (rule(), y0.len());
        let unit: Vec<f64> = self.scale.iter().map(|scale| if *scale > 0.0 { *scale } else { 1.0 }).collect();
        let forces: Vec<f64> = rule.at.iter().map(|at| forcing.value(from_s + at * length_s)).collect();
        let mut values = vec![y0.to_vec(); STAGES];
        let (mut rates, mut jacobian) = (vec![0.0; parts], vec![0.0; parts * parts]);
        for step in 0..MAX_STEPS {
            let mut points = Vec::with_capacity(STAGES);
            let mut all_rates = Vec::with_capacity(STAGES * parts);
            let mut jacobians = Vec::with_capacity(STAGES);
            for (node, y) in values.iter().enumerate() {
                points.push(self.point(y, forces[node], &mut rates));
                all_rates.extend_from_slice(&rates);
                if parts > 0 {
                    self.jacobian(y, forces[node], &rates, &mut jacobian);
                    jacobians.push(jacobian.clone());
                }
            }
            let mut largest = vec![0.0f64; parts];
            for group in groups(&jacobians, parts) {
                let place = |node: usize, index: usize| node * group.len() + index;
                let size = STAGES * group.len();
                let mut matrix = DMatrix::<f64>::zeros(size, size);
                let mut side = DVector::<f64>::zeros(size);
                for node in 0..STAGES {
                    for (index, &i) in group.iter().enumerate() {
                        let row = place(node, index);
                        let slopes = rule.slope[node].iter().zip(&values);
                        let slope: f64 = slopes.map(|(slope, y)| slope * (y[i] - y0[i])).sum();
                        side[row] = (length_s * all_rates[node * parts + i] - slope) / unit[i];
                        for (column, slope) in rule.slope[node].iter().enumerate() {
                            matrix[(row, place(column, index))] += slope;
                        }
                        for (other, &j) in group.iter().enumerate() {
                            let derivative = jacobians[node][i * parts + j];
                            matrix[(row, place(node, other))] -= length_s * derivative * unit[j] / unit[i];
                        }
                    }
                }
                let change = matrix.lu().solve(&side)?;
                for (node, y) in values.iter_mut().enumerate() {
                    for (index, &i) in group.iter().enumerate() {
                        let change = unit[i] * change[place(node, index)];
                        y[i] += change;
                        largest[i] = largest[i].max(change.abs());
                    }
                }
            }
            if !largest.iter().all(|change| change.is_finite()) {
                return None;
            }
            let sizes = (0..parts).map(|i| self.size(i, y0, &values));
            if (step > 0 || parts == 0) && largest.iter().zip(sizes).all(|(change, size)| *change <= SMALL_STEP * size) {
                values.insert(0, y0.to_vec());
                let mut panel = Panel { values, points, error: 0.0 };
                // An error of the friction counts by the part of the mean that the interval has.
                let share = (length_s / self.most_s).min(1.0);
                let (rates, friction) = self.halfway_errors(&panel, &all_rates, forcing, (from_s, length_s));
                let of_force = larger(self.force_error(&panel.points), friction);
                panel.error = larger(self.error(&panel.values), larger(rates, share * of_force));
                return panel.error.is_finite().then_some(panel);
            }
        }
        None
    }

    /// Returns the size of a part of y that counts as one: its largest value so far.
    fn size(&self, i: usize, y0: &[f64], values: &[Vec<f64>]) -> f64 {
        values.iter().fold(self.scale[i].max(y0[i].abs()), |size, y| size.max(y[i].abs()))
    }

    /// Computes the derivatives of all rates by all parts of y, by rows.
    fn jacobian(&self, y: &[f64], forcing: f64, rates: &[f64], jacobian: &mut [f64]) {
        let (states, parts) = (self.states, y.len());
        jacobian.fill(0.0);
        let mut partial = self.partial(y, forcing, rates);
        // A root has an infinite derivative at zero; without it, Newton's method is only slower.
        let Partial { rates_by_states, rates_by_slip, force_by_states, force_by_slip, .. } = &mut partial;
        let all = rates_by_states.iter_mut().chain(rates_by_slip).chain(force_by_states).chain([force_by_slip]);
        all.filter(|derivative| !derivative.is_finite()).for_each(|derivative| *derivative = 0.0);
        for i in 0..states {
            jacobian[i * parts..i * parts + states].copy_from_slice(&partial.rates_by_states[i * states..(i + 1) * states]);
        }
        let Motion::Sdof { mass_kg, stiffness_n_per_m, damping_n_s_per_m } = self.problem.motion else { return };
        let (x, v, sign) = (states, states + 1, self.problem.sign.factor());
        for i in 0..states {
            jacobian[i * parts + v] = sign * partial.rates_by_slip[i];
            jacobian[v * parts + i] = -partial.force_by_states[i] / mass_kg;
        }
        jacobian[x * parts + v] = 1.0;
        jacobian[v * parts + x] = -stiffness_n_per_m / mass_kg;
        jacobian[v * parts + v] = -(damping_n_s_per_m + sign * partial.force_by_slip) / mass_kg;
    }

    /// Returns the partial derivatives of the law: its own, or by differences.
    fn partial(&self, y: &[f64], forcing: f64, rates: &[f64]) -> Partial {
        let states = self.states;
        let mut partial = Partial::new(states);
        partial.is_motion_given = self.problem.motion == Motion::Kinematic;
        let v = if self.problem.motion == Motion::Kinematic { forcing } else { y[states + 1] };
        let slip = self.problem.sliding_m_per_s + self.problem.sign.factor() * v;
        if self.law.derivatives(&self.at(&y[..states], slip), &mut partial) {
            return partial;
        }
        let (mut moved, mut after) = (y[..states].to_vec(), vec![0.0; states]);
        let force_n = self.law.rates(&self.at(&moved, slip), &mut after);
        for j in 0..states {
            // A state that is zero, and has always been: any small step serves.
            let by = DIFFERENCE_REL * Some(y[j].abs().max(self.scale[j])).filter(|size| *size > 0.0).unwrap_or(1.0);
            moved[j] = y[j] + by;
            let by = moved[j] - y[j];
            partial.force_by_states[j] = (self.law.rates(&self.at(&moved, slip), &mut after) - force_n) / by;
            for i in 0..states {
                partial.rates_by_states[i * states + j] = (after[i] - rates[i]) / by;
            }
            moved[j] = y[j];
        }
        if self.problem.motion != Motion::Kinematic {
            let by = DIFFERENCE_REL * (slip.abs() + self.problem.sliding_m_per_s.abs() + self.scale[states + 1]);
            partial.force_by_slip = (self.law.rates(&self.at(&moved, slip + by), &mut after) - force_n) / by;
            for i in 0..states {
                partial.rates_by_slip[i] = (after[i] - rates[i]) / by;
            }
        }
        partial
    }

    /// Returns the error of a polynomial through values at the start and the points, relative to
    /// the size of each part.
    fn error(&self, values: &[Vec<f64>]) -> f64 {
        // Leading coefficients of the shifted Chebyshev polynomials.
        let highest = 0.5f64.powi(2 * STAGES as i32 - 1);
        let second = 0.5f64.powi(2 * STAGES as i32 - 3);
        let weights = &rule().barycentric;
        let of_part = |i: usize| {
            let all: f64 = weights.iter().zip(values).map(|(weight, y)| weight * y[i]).sum();
            // Without the start the weights of the other points lack one factor.
            let others = weights.iter().zip(values).zip(std::iter::once(&0.0).chain(&rule().at)).skip(1);
            let without: f64 = others.map(|((weight, y), at)| weight * at * y[i]).sum();
            let error = (highest * all.abs()).max(SECOND_SHARE * second * without.abs());
            if error > 0.0 { error / self.size(i, &values[0], values) } else { 0.0 }
        };
        (0..values[0].len()).map(of_part).fold(0.0, f64::max)
    }

    /// Returns the error of the polynomial through the friction at the points, relative to the
    /// largest friction: the force of a law without states has no other error.
    fn force_error(&self, points: &[Point]) -> f64 {
        let rule = rule();
        let weights = rule.barycentric[1..].iter().zip(rule.at);
        let highest: f64 = weights.zip(points).map(|((weight, at), point)| weight * at * point.force_n).sum();
        let size = points.iter().fold(self.largest_n, |size, point| size.max(point.force_n.abs()));
        if highest == 0.0 { 0.0 } else { 0.5f64.powi(2 * STAGES as i32 - 3) * highest.abs() / size }
    }
}

impl Equations<'_> {
    /// Returns the largest difference between the rates half-way between the points and the
    /// polynomials through those at the points, and the same of the friction.
    fn halfway_errors(&self, panel: &Panel, rates: &[f64], forcing: &Forcing, (from_s, length_s): (f64, f64)) -> (f64, f64) {
        let (halfway, parts) = (halfway(), panel.values[0].len());
        let sizes: Vec<f64> = (0..parts).map(|i| self.size(i, &panel.values[0], &panel.values)).collect();
        let largest_n = panel.points.iter().fold(self.largest_n, |size, point| size.max(point.force_n.abs()));
        let mut found = vec![0.0; parts];
        let (mut of_rates, mut of_friction) = (0.0f64, 0.0f64);
        // The first place is outside of the points.
        for place in 1..STAGES {
            let y = panel.sum(&halfway.of_all[place]);
            let point = self.point(&y, forcing.value(from_s + halfway.at[place] * length_s), &mut found);
            let factors = &halfway.of_nodes[place];
            let friction_n: f64 = factors.iter().zip(&panel.points).map(|(factor, point)| factor * point.force_n).sum();
            if friction_n != point.force_n {
                of_friction = larger(of_friction, (friction_n - point.force_n).abs() / largest_n);
            }
            for i in 0..parts {
                let expected: f64 = factors.iter().enumerate().map(|(node, factor)| factor * rates[node * parts + i]).sum();
                if expected != found[i] {
                    of_rates = larger(of_rates, length_s * (expected - found[i]).abs() / sizes[i]);
                }
            }
        }
        (of_rates, of_friction)
    }
}

/// Returns the parts of y in groups that do not affect each other, by the derivatives at all
/// points.
fn groups(jacobians: &[Vec<f64>], parts: usize) -> Vec<Vec<usize>> {
    let mut of: Vec<usize> = (0..parts).collect();
    for i in 0..parts {
        for j in 0..parts {
            if of[i] != of[j] && jacobians.iter().any(|jacobian| jacobian[i * parts + j] != 0.0) {
                let (kept, joined) = (of[i], of[j]);
                of.iter_mut().filter(|group| **group == joined).for_each(|group| *group = kept);
            }
        }
    }
    let all = (0..parts).map(|group| (0..parts).filter(|part| of[*part] == group).collect::<Vec<_>>());
    all.filter(|group| !group.is_empty()).collect()
}

/// Returns the larger of two errors, or NaN if one is not a number.
fn larger(a: f64, b: f64) -> f64 {
    if b.is_nan() || b > a { b } else { a }
}

impl Panel {
    /// Returns the sum of y at the start and the points by factors.
    pub(super) fn sum(&self, factors: &[f64]) -> Vec<f64> {
        let of_part = |i: usize| factors.iter().zip(&self.values).map(|(factor, y)| factor * y[i]).sum();
        (0..self.values[0].len()).map(of_part).collect()
    }
}
