//! Linear least squares, row by row: each row is folded into a triangular factor `R` by Givens
//! rotations as it arrives.
//!
//! Only the factor is stored. The condition number is not squared, therefore f32 is sufficient
//! (W. Givens 1958). For real numbers the factor is `R = sqrt(D) U` with ones on the diagonal of
//! `U`, which needs no square roots (W. M. Gentleman 1973). Real rows are divided by their standard
//! deviations. For complex rows whose right-hand sides have independent circular noise of variance
//! `s^2`, the unknowns `x` scatter by `R^-1 e`. Any real number that follows from them,
//! `dy = Re{g x}`, has the variance
//!
//! ```text
//! var y = s^2 / 2 |R^-T g|^2,    s^2 = (sum of squared residuals) / (rows - unknowns)
//! ```

use crate::seam::phasor::Phasor;

/// Triangular factor of `N` real unknowns, with its right-hand side.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RealTriangle<const N: usize> {
    /// Off-diagonal elements of `U`; the diagonal contains `D`.
    rows: [[f32; N]; N],
    right: [f32; N],
    /// Sum of squared residuals.
    rest: f32,
}

impl<const N: usize> Default for RealTriangle<N> {
    fn default() -> Self {
        RealTriangle { rows: [[0.0; N]; N], right: [0.0; N], rest: 0.0 }
    }
}

impl<const N: usize> RealTriangle<N> {
    /// Removes all equations.
    pub(crate) fn restart(&mut self) {
        self.rows.as_flattened_mut().fill(0.0);
        self.right.fill(0.0);
        self.rest = 0.0;
    }

    /// Folds in one equation `row . unknowns = right`, divided by its standard deviation.
    pub(crate) fn fold(&mut self, row: [f32; N], right: f32) {
        self.fold_among(N, row, right);
    }

    /// Folds in one equation in the first `unknowns` unknowns; no earlier equation may contain
    /// others.
    pub(crate) fn fold_among(&mut self, unknowns: usize, mut row: [f32; N], mut right: f32) {
        let unknowns = unknowns.min(N);
        let mut weight = 1.0;
        for n in 0..unknowns {
            let (own, b) = (&mut self.rows[n], row[n]);
            let (before, weighted) = (own[n], weight * b);
            let after = before + weighted * b;
            // The first row that contains an unknown is absorbed by it without a residual.
            if weighted == 0.0 || after == 0.0 {
                continue;
            }
            let (keep, take) = (before / after, weighted / after);
            (own[n], weight) = (after, weight * keep);
            for (own, row) in own[n + 1..unknowns].iter_mut().zip(&mut row[n + 1..unknowns]) {
                let left = *row - b * *own;
                *own = keep * *own + take * *row;
                *row = left;
            }
            let own = self.right[n];
            (self.right[n], right) = (keep * own + take * right, right - b * own);
        }
        self.rest += weight * right * right;
    }

    /// Returns the unknowns; zero for an unknown that no equation contains.
    pub(crate) fn solve(&self) -> [f32; N] {
        let mut unknowns = [0.0; N];
        for n in (0..N).rev() {
            let known = (n + 1..N).fold(self.right[n], |rest, k| rest - self.rows[n][k] * unknowns[k]);
            unknowns[n] = if self.rows[n][n] == 0.0 { 0.0 } else { known };
        }
        unknowns
    }

    /// Returns the standard deviation of the sum `of . unknowns`, for rows that were divided by
    /// theirs: `|R^-T of|`.
    pub(crate) fn deviation(&self, of: &[f32; N]) -> f32 {
        let (mut forward, mut square) = (*of, 0.0);
        let mut later = forward.as_mut_slice();
        for (n, row) in self.rows.iter().enumerate() {
            let Some((&mut x, rest)) = later.split_first_mut() else { break };
            let Some((&of_row, row)) = row.get(n..).and_then(<[f32]>::split_first) else { break };
            // Unknowns that the sum does not depend on, or that no equation contains, are skipped.
            if x != 0.0 && of_row != 0.0 {
                square += x * x / of_row;
                for (later, own) in rest.iter_mut().zip(row) {
                    *later -= own * x;
                }
            }
            later = rest;
        }
        fpu::sqrtf(square)
    }

    /// Returns the sum of squared residuals.
    pub(crate) fn rest(&self) -> f32 {
        self.rest
    }
}

/// Triangular factor of at most `N` complex unknowns, with its right-hand side. A row is folded in
/// over several calls.
#[derive(Clone, Debug)]
pub(crate) struct ComplexTriangle<const N: usize> {
    unknowns: usize,
    rows: [[Phasor; N]; N],
    right: [Phasor; N],
    /// Sum of squared residuals.
    left: f32,
    count: u16,
    /// Row that is being folded in.
    row: [Phasor; N],
    /// Right-hand side of that row.
    row_right: Phasor,
    /// Next column of that row to eliminate.
    pivot: usize,
}

impl<const N: usize> ComplexTriangle<N> {
    /// Creates a factor without rows.
    pub(crate) fn new(unknowns: usize) -> Self {
        let (unknowns, none) = (unknowns.min(N), [Phasor::default(); N]);
        let (rows, right) = ([none; N], none);
        ComplexTriangle { unknowns, rows, right, left: 0.0, count: 0, row: none, row_right: Phasor::default(), pivot: unknowns }
    }

    /// Removes all rows and sets the number of unknowns.
    pub(crate) fn restart(&mut self, unknowns: usize) {
        let unknowns = unknowns.min(N);
        for row in &mut self.rows[..unknowns] {
            row[..unknowns].fill(Phasor::default());
        }
        self.right[..unknowns].fill(Phasor::default());
        (self.unknowns, self.pivot) = (unknowns, unknowns);
        (self.left, self.count) = (0.0, 0);
    }

    /// Returns `true` if no row is being folded in.
    pub(crate) fn is_idle(&self) -> bool {
        self.pivot == self.unknowns
    }

    /// Sets the equation to fold in next, `row * x = right`.
    pub(crate) fn add(&mut self, row: [Phasor; N], right: Phasor) {
        (self.row, self.row_right, self.pivot) = (row, right, 0);
    }

    /// Folds the row in, by `rotations` rotations or a few more. Returns `true` if it is complete.
    pub(crate) fn fold(&mut self, rotations: usize) -> bool {
        // Always true; with this bound the compiler removes the index checks below.
        let unknowns = self.unknowns.min(N);
        let mut done = 0;
        while self.pivot < unknowns && done < rotations {
            let pivot = self.pivot;
            self.pivot += 1;
            done += unknowns - pivot + 1;
            let (a, b) = (self.rows[pivot][pivot], self.row[pivot]);
            let square = a.norm_sqr() + b.norm_sqr();
            if square == 0.0 {
                continue;
            }
            let scale = 1.0 / fpu::sqrtf(square);
            let (a, b) = (a * scale, b * scale);
            let columns = pivot..unknowns;
            for (x, y) in self.rows[pivot][columns.clone()].iter_mut().zip(&mut self.row[columns]) {
                (*x, *y) = (a.conj() * *x + b.conj() * *y, a * *y - b * *x);
            }
            let (x, y) = (self.right[pivot], self.row_right);
            (self.right[pivot], self.row_right) = (a.conj() * x + b.conj() * y, a * y - b * x);
        }
        if self.is_idle() {
            self.left += self.row_right.norm_sqr();
            self.count += 1;
        }
        self.is_idle()
    }

    /// Returns the unknowns; `None` if the rows do not determine them.
    pub(crate) fn solve(&self) -> Option<[Phasor; N]> {
        let mut unknowns = [Phasor::default(); N];
        let number = self.unknowns.min(N);
        for n in (0..number).rev() {
            let row = &self.rows[n];
            let later = row.iter().zip(&unknowns).take(number).skip(n + 1);
            let known = later.fold(self.right[n], |rest, (own, unknown)| rest - *own * *unknown);
            if row[n].norm_sqr() == 0.0 {
                return None;
            }
            unknowns[n] = known / row[n];
        }
        Some(unknowns)
    }

    /// Returns the variance of a right-hand side, from the residuals; zero unless there are more
    /// rows than unknowns.
    pub(crate) fn variance(&self) -> f32 {
        let free = usize::from(self.count).saturating_sub(self.unknowns);
        if free == 0 { 0.0 } else { self.left / free as f32 }
    }

    /// Returns the error `s R^-T gradient` of a complex number with this gradient, as independent
    /// parts of variance one half per axis. The error of a sum is the sum of the errors.
    pub(crate) fn spread(&self, gradient: &[Phasor; N]) -> [Phasor; N] {
        let mut z = [Phasor::default(); N];
        for n in 0..self.unknowns.min(N) {
            let rest = (0..n).fold(gradient[n], |rest, k| rest - self.rows[k][n] * z[k]);
            z[n] = rest / self.rows[n][n];
        }
        let scale = fpu::sqrtf(self.variance());
        z.map(|part| part * scale)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::find::scan::bench::Noise;

    /// Fits a straight line through four points, with one unknown that no equation contains.
    #[test]
    fn line_fit_and_its_deviations() {
        let mut triangle = RealTriangle::<3>::default();
        for (x, y) in [(0.0, 1.1), (1.0, 2.9), (2.0, 5.1), (3.0, 6.9)] {
            triangle.fold([1.0 / 0.1, x / 0.1, 0.0], y / 0.1);
        }
        let [offset, slope, nothing] = triangle.solve();
        assert!((offset - 1.06).abs() < 1e-5 && (slope - 1.96).abs() < 1e-5 && nothing == 0.0, "{offset} {slope}");
        // Textbook: sigma / sqrt(sum (x - mean)^2); for the value in the middle, sigma / sqrt(n).
        assert!((triangle.deviation(&[0.0, 1.0, 0.0]) - 0.1 / 5.0f32.sqrt()).abs() < 1e-6);
        assert!((triangle.deviation(&[1.0, 1.5, 0.0]) - 0.05).abs() < 1e-6);
        assert!((triangle.rest() - 3.2).abs() < 1e-3, "{}", triangle.rest());
    }

    #[test]
    fn finds_the_unknowns_and_their_deviations() {
        let truth = [Phasor::new(1.0, -2.0), Phasor::new(0.3, 0.7)];
        let mut noise = Noise::new(1);
        let (mut sum, mut stated) = (0.0, 0.0);
        const RUNS: usize = 400;
        for _ in 0..RUNS {
            let mut triangle = ComplexTriangle::<3>::new(2);
            for n in 0..12 {
                let x = n as f32 / 11.0;
                let row = [Phasor::new(1.0, 0.0), Phasor::new(x, x * x), Phasor::default()];
                let error = Phasor::new(noise.normal() as f32, noise.normal() as f32) * 0.01;
                triangle.add(row, row[0] * truth[0] + row[1] * truth[1] + error);
                while !triangle.fold(1) {}
            }
            let found = triangle.solve().unwrap();
            sum += (found[1].im - truth[1].im).powi(2) / RUNS as f32;
            let spread = triangle.spread(&[Phasor::default(), Phasor::new(0.0, -1.0), Phasor::default()]);
            stated += 0.5 * spread.iter().map(|part| part.norm_sqr()).sum::<f32>() / RUNS as f32;
        }
        // 1.03 measured; the square of a scatter over 400 runs itself scatters by 7 %.
        assert!((sum / stated - 1.0).abs() < 0.2, "{}", sum / stated);
    }

    #[test]
    fn no_solution_without_rows() {
        assert!(ComplexTriangle::<3>::new(3).solve().is_none());
    }
}
