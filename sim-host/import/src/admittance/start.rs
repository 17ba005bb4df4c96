//! Initial values of a fit, from the data alone: the next resonance is at the largest reduction of
//! the residuals.
//!
//! For given `fs` and `Q` the circuit is linear in the other parameters: `C0`, `C0 tan d` and the
//! conductance `G` of each branch. The known branches and the clamped one are projected out once. A
//! candidate `h = 1 / (1 + j Q (f / fs - fs / f))` then reduces the sum of squares by
//! `(h' r)^2 / h' h`, if its `G` is positive. Frequencies are tried in steps of a fraction of the
//! candidate's bandwidth, quality factors in steps of a constant ratio.

use std::f64::consts::TAU;

use nalgebra::{Cholesky, DMatrix, DVector};
use num_complex::Complex64;

use super::circuit::{Branch, Equivalent};

/// Smallest tried quality factor.
const MIN_Q: f64 = 2.0;
/// Largest tried quality factor.
const MAX_Q: f64 = 1e5;
/// Ratio of successive quality factors.
const Q_RATIO: f64 = 1.8;
/// Number of frequency steps per bandwidth.
const STEPS_PER_BANDWIDTH: f64 = 3.0;
/// Maximum number of points of a search; a longer sweep is thinned out.
const MAX_POINTS: usize = 1200;
/// Maximum number of frequencies per quality factor.
const MAX_FREQUENCIES: usize = 600;
/// Distance, in bandwidths of the candidate, up to which points are used if the bandwidth contains
/// few of them.
const WINDOW_BANDWIDTHS: f64 = 24.0;

/// Weighted admittances of a search.
pub(super) struct Points<'a> {
    /// Frequencies, Hz, in ascending order.
    pub(super) hz: &'a [f64],
    /// Measured admittances, S.
    pub(super) admittance: &'a [Complex64],
    /// Complex weight of each admittance, 1/S.
    pub(super) weight: &'a [Complex64],
}

/// Vector of the search: real and imaginary parts of all points.
type Vector = Vec<Complex64>;

fn dot(a: &[Complex64], b: &[Complex64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.re * b.re + a.im * b.im).sum()
}

/// Returns the admittance of a resonance with a conductance of one at a frequency.
fn unit(hz: f64, (own, q): (f64, f64)) -> Complex64 {
    Complex64::new(1.0, q * (hz / own - own / hz)).inv()
}

/// Fits the clamped branch alone, by linear least squares.
pub(super) fn clamped(points: &Points) -> Option<Equivalent> {
    linear(points, &[])
}

/// Returns circuits with one more resonance than `known`: the best candidate of each quality
/// factor, limited to the best five of them. Several starts are needed, because a single one may
/// mislead the fit if much of a circle is lost in noise. The list is empty if no candidate has a
/// positive conductance.
pub(super) fn next(points: &Points, known: &[Branch]) -> Vec<Equivalent> {
    const MAX_STARTS: usize = 5;
    let shapes: Vec<(f64, f64)> = known.iter().map(|branch| (branch.hz, branch.q)).collect();
    let mut found = search(points, &shapes).unwrap_or_default();
    found.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    found.into_iter().take(MAX_STARTS).filter_map(|(_, shape)| linear(points, &[shapes.as_slice(), &[shape]].concat())).collect()
}

/// Returns the largest reduction of the sum of squares by one resonance.
pub(super) fn gain(points: &Points) -> f64 {
    search(points, &[]).unwrap_or_default().into_iter().map(|(gain, _)| gain).fold(0.0, f64::max)
}

/// Fits the circuit with resonances at these frequencies and quality factors.
fn linear(points: &Points, shapes: &[(f64, f64)]) -> Option<Equivalent> {
    let mut columns = base(points);
    columns.extend(shapes.iter().map(|shape| column(points, |hz| unit(hz, *shape))));
    let target: Vector = points.admittance.iter().zip(points.weight).map(|(y, w)| y * w).collect();
    let scales: Vec<f64> = columns.iter().map(|column| dot(column, column).sqrt().max(f64::MIN_POSITIVE)).collect();
    let n = columns.len();
    let matrix =
        DMatrix::from_fn(n, n, |i, j| dot(&columns[i], &columns[j]) / scales[i] / scales[j] + if i == j { 1e-12 } else { 0.0 });
    let right = DVector::from_fn(n, |i, _| dot(&columns[i], &target) / scales[i]);
    let found = Cholesky::new(matrix)?.solve(&right);
    let value = |at: usize| found[at] / scales[at];
    let c0_f = value(0);
    // A start needs positive values; the fit finds out how small they are.
    let largest = points.admittance.iter().map(|y| y.norm_sqr()).fold(0.0, f64::max).sqrt();
    let least = 1e-6 * largest;
    let c0_f = if c0_f > 0.0 { c0_f } else { least / (TAU * points.hz[0]) };
    let branch = |(at, (hz, q)): (usize, &(f64, f64))| Branch { hz: *hz, q: *q, siemens: value(2 + at).max(least) };
    let circuit = Equivalent {
        c0_f,
        loss_tangent: (value(1) / c0_f).clamp(-1.0, 1.0),
        branches: shapes.iter().enumerate().map(branch).collect(),
    };
    (c0_f.is_finite() && circuit.loss_tangent.is_finite()).then_some(circuit)
}

fn column(points: &Points, of: impl Fn(f64) -> Complex64) -> Vector {
    points.hz.iter().zip(points.weight).map(|(hz, w)| of(*hz) * w).collect()
}

/// Returns the columns of the clamped branch.
fn base(points: &Points) -> Vec<Vector> {
    vec![column(points, |hz| Complex64::new(0.0, TAU * hz)), column(points, |hz| Complex64::new(TAU * hz, 0.0))]
}

/// Candidate: its reduction of the sum of squares, its frequency and quality factor.
type Candidate = (f64, (f64, f64));

/// Returns the candidate with the largest reduction, for each quality factor.
fn search(points: &Points, known: &[(f64, f64)]) -> Option<Vec<Candidate>> {
    let stride = points.hz.len().div_ceil(MAX_POINTS);
    let all = View::new(points, known)?;
    let hz: Vec<f64> = points.hz.iter().copied().step_by(stride).collect();
    let weight: Vec<Complex64> = points.weight.iter().copied().step_by(stride).collect();
    let admittance: Vec<Complex64> = points.admittance.iter().copied().step_by(stride).collect();
    let thin_points = Points { hz: &hz, admittance: &admittance, weight: &weight };
    let thin = View::new(&thin_points, known)?;
    let (from, to) = (points.hz[0], points.hz[points.hz.len() - 1]);
    let spacing = (to - from) / (hz.len() - 1).max(1) as f64;
    let mut found = Vec::new();
    let mut q = MIN_Q;
    let finest = points.hz.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
    while q <= MAX_Q && from / q > 0.25 * finest {
        let mut best: Option<Candidate> = None;
        let mut consider = |gain: Option<f64>, shape: (f64, f64)| {
            if let Some(gain) = gain.filter(|gain| best.is_none_or(|(most, _)| *gain > most)) {
                best = Some((gain, shape));
            }
        };
        let step = (from.max(to / 4.0) / q / STEPS_PER_BANDWIDTH).min(to - from);
        let count = ((to - from) / step).ceil() as usize + 1;
        if count <= MAX_FREQUENCIES && (stride == 1 || from / q > 4.0 * spacing) {
            for n in 0..count {
                let shape = ((from + n as f64 * step).min(to), q);
                consider(thin.gain(shape, None), shape);
            }
        } else {
            for own in all.peaks(q) {
                for shift in [-0.3, 0.0, 0.3] {
                    let shape = (own * (1.0 + shift / q), q);
                    consider(all.gain(shape, Some(WINDOW_BANDWIDTHS)), shape);
                }
            }
        }
        found.extend(best);
        q *= Q_RATIO;
    }
    Some(found)
}

/// Points with the known part projected out.
struct View<'a> {
    hz: &'a [f64],
    weight: &'a [Complex64],
    /// Orthonormal basis of the known part.
    basis: Vec<Vector>,
    residual: Vector,
}

impl<'a> View<'a> {
    fn new(points: &Points<'a>, known: &[(f64, f64)]) -> Option<Self> {
        let mut basis: Vec<Vector> = Vec::new();
        let columns = base(points).into_iter().chain(known.iter().map(|shape| column(points, |hz| unit(hz, *shape))));
        for mut vector in columns {
            let before = dot(&vector, &vector);
            for _ in 0..2 {
                for known in &basis {
                    let along = dot(known, &vector);
                    vector.iter_mut().zip(known).for_each(|(v, k)| *v -= along * k);
                }
            }
            let square = dot(&vector, &vector);
            if square > 1e-20 * before {
                let length = square.sqrt();
                basis.push(vector.into_iter().map(|v| v / length).collect());
            }
        }
        let mut residual: Vector = points.admittance.iter().zip(points.weight).map(|(y, w)| y * w).collect();
        for known in &basis {
            let along = dot(known, &residual);
            residual.iter_mut().zip(known).for_each(|(r, k)| *r -= along * k);
        }
        dot(&residual, &residual).is_finite().then_some(View { hz: points.hz, weight: points.weight, basis, residual })
    }

    /// Returns the reduction of the sum of squares by a candidate; `None` if its conductance is not
    /// positive. With a window only the points near it are used, for which the known part is
    /// negligible.
    fn gain(&self, (own, q): (f64, f64), window: Option<f64>) -> Option<f64> {
        let reach = window.map_or(f64::INFINITY, |window| window * own / q);
        let range = self.hz.partition_point(|hz| *hz < own - reach)..self.hz.partition_point(|hz| *hz <= own + reach);
        let shape: Vector = range.clone().map(|at| unit(self.hz[at], (own, q)) * self.weight[at]).collect();
        let along = dot(&shape, &self.residual[range.clone()]);
        let mut square = dot(&shape, &shape);
        if window.is_none() {
            square -= self.basis.iter().map(|known| dot(known, &shape).powi(2)).sum::<f64>();
        }
        (along > 0.0 && square > 0.0).then(|| along * along / square)
    }

    /// Returns the frequencies of the largest residuals within a bandwidth.
    fn peaks(&self, q: f64) -> Vec<f64> {
        const MAX_PEAKS: usize = 48;
        let energy = |at: usize| {
            let half = 0.5 * self.hz[at] / q;
            let from = self.hz.partition_point(|hz| *hz < self.hz[at] - half);
            let to = self.hz.partition_point(|hz| *hz <= self.hz[at] + half);
            self.residual[from..to].iter().map(Complex64::norm_sqr).sum::<f64>()
        };
        let energies: Vec<f64> = (0..self.hz.len()).map(energy).collect();
        let is_peak = |at: &usize| {
            let before = at.checked_sub(1).map_or(0.0, |before| energies[before]);
            energies[*at] >= before && energies[*at] >= energies.get(at + 1).copied().unwrap_or(0.0)
        };
        let mut peaks: Vec<usize> = (0..self.hz.len()).filter(is_peak).collect();
        peaks.sort_by(|a, b| energies[*b].total_cmp(&energies[*a]));
        peaks.into_iter().take(MAX_PEAKS).map(|at| self.hz[at]).collect()
    }
}
