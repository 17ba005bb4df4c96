//! Linear least squares, row by row: each row is folded into a triangular factor `R` by Givens rotations as it arrives.
//!
//! Nothing is stored but the factor, and the condition number is not squared, which is what makes f32 enough (W. Givens 1958). Of real numbers the
//! factor is `R = sqrt(D) U` with ones on the diagonal of `U`, which needs no root (W. M. Gentleman 1973). Rows of them are divided by their standard
//! deviations. Of complex rows whose right-hand sides have independent circular noise of variance `s^2`, the
//! unknowns `x` scatter by `R^-1 e`, so that any real number that follows from them, `dy = Re{g x}`, has the variance
//!
//! ```text
//! var y = s^2 / 2 |R^-T g|^2,    s^2 = (what is left of the right-hand sides) / (rows - unknowns)
//! ```

use crate::seam::phasor::Phasor;

/// A triangular factor of `N` real unknowns, with its right-hand side.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RealTriangle<const N: usize> {
    /// `U`, and `D` in the place of its ones.
    rows: [[f32; N]; N],
    right: [f32; N],
    /// Sum of squares that no choice of the unknowns explains.
    rest: f32,
}

impl<const N: usize> Default for RealTriangle<N> {
    fn default() -> Self {
        RealTriangle { rows: [[0.0; N]; N], right: [0.0; N], rest: 0.0 }
    }
}

impl<const N: usize> RealTriangle<N> {
    /// Forgets all equations.
    pub(crate) fn restart(&mut self) {
        self.rows.as_flattened_mut().fill(0.0);
        self.right.fill(0.0);
        self.rest = 0.0;
    }

    /// Folds in one equation `row . unknowns = right`, divided by its standard deviation.
    pub(crate) fn fold(&mut self, row: [f32; N], right: f32) {
        self.fold_among(N, row, right);
    }

    /// The same of an equation among so many of the unknowns, the first; of the others nothing has been said so far.
    pub(crate) fn fold_among(&mut self, unknowns: usize, mut row: [f32; N], mut right: f32) {
        let unknowns = unknowns.min(N);
        let mut weight = 1.0;
        for n in 0..unknowns {
            let (own, b) = (&mut self.rows[n], row[n]);
            let (before, weighted) = (own[n], weight * b);
            let after = before + weighted * b;
            // Of a row that was the first to say something of an unknown nothing is left.
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

    /// The unknowns; zero where nothing was said of one.
    pub(crate) fn solve(&self) -> [f32; N] {
        let mut unknowns = [0.0; N];
        for n in (0..N).rev() {
            let known = (n + 1..N).fold(self.right[n], |rest, k| rest - self.rows[n][k] * unknowns[k]);
            unknowns[n] = if self.rows[n][n] == 0.0 { 0.0 } else { known };
        }
        unknowns
    }

    /// Standard deviation of the sum `of . unknowns`, for rows that were divided by theirs: `|R^-T of|`.
    pub(crate) fn deviation(&self, of: &[f32; N]) -> f32 {
        let (mut forward, mut square) = (*of, 0.0);
        let mut later = forward.as_mut_slice();
        for (n, row) in self.rows.iter().enumerate() {
            let Some((&mut x, rest)) = later.split_first_mut() else { break };
            let Some((&of_row, row)) = row.get(n..).and_then(<[f32]>::split_first) else { break };
            // But for what it does not depend on, and of what nothing was said.
            if x != 0.0 && of_row != 0.0 {
                square += x * x / of_row;
                for (later, own) in rest.iter_mut().zip(row) {
                    *later -= own * x;
                }
            }
            later = rest;
        }
        libm::sqrtf(square)
    }

    /// Sum of squares that the unknowns leave.
    pub(crate) fn rest(&self) -> f32 {
        self.rest
    }
}

/// A triangular factor of at most `N` complex unknowns, with its right-hand side. A row is folded in over several calls.
#[derive(Clone, Debug)]
pub(crate) struct ComplexTriangle<const N: usize> {
    unknowns: usize,
    rows: [[Phasor; N]; N],
    right: [Phasor; N],
    /// Sum of squares that no unknowns explain.
    left: f32,
    count: u16,
    /// The row that is being folded in, its right-hand side, and how far it has come.
    row: [Phasor; N],
    row_right: Phasor,
    pivot: usize,
}

impl<const N: usize> ComplexTriangle<N> {
    /// A factor without rows.
    pub(crate) fn new(unknowns: usize) -> Self {
        let (unknowns, none) = (unknowns.min(N), [Phasor::default(); N]);
        let (rows, right) = ([none; N], none);
        ComplexTriangle { unknowns, rows, right, left: 0.0, count: 0, row: none, row_right: Phasor::default(), pivot: unknowns }
    }

    /// Removes all rows, for so many unknowns.
    pub(crate) fn restart(&mut self, unknowns: usize) {
        let unknowns = unknowns.min(N);
        for row in &mut self.rows[..unknowns] {
            row[..unknowns].fill(Phasor::default());
        }
        self.right[..unknowns].fill(Phasor::default());
        (self.unknowns, self.pivot) = (unknowns, unknowns);
        (self.left, self.count) = (0.0, 0);
    }

    /// Whether no row is being folded in.
    pub(crate) fn is_idle(&self) -> bool {
        self.pivot == self.unknowns
    }

    /// Takes an equation, `row * x = right`, to be folded in.
    pub(crate) fn add(&mut self, row: [Phasor; N], right: Phasor) {
        (self.row, self.row_right, self.pivot) = (row, right, 0);
    }

    /// Folds the row in by so many rotations or a few more. Returns whether it is complete.
    pub(crate) fn fold(&mut self, rotations: usize) -> bool {
        // They are no more anyway: said here, no place is checked below.
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
            let scale = 1.0 / libm::sqrtf(square);
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

    /// The unknowns; `None` where the rows do not determine them.
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

    /// Variance of a right-hand side, from what is left; zero where there are no more rows than unknowns.
    pub(crate) fn variance(&self) -> f32 {
        let free = usize::from(self.count).saturating_sub(self.unknowns);
        if free == 0 { 0.0 } else { self.left / free as f32 }
    }

    /// `s R^-T gradient`: what a complex number with this gradient by the unknowns scatters by, in independent parts of variance one half
    /// each way. Sums of such numbers are sums of these.
    pub(crate) fn spread(&self, gradient: &[Phasor; N]) -> [Phasor; N] {
        let mut z = [Phasor::default(); N];
        for n in 0..self.unknowns.min(N) {
            let rest = (0..n).fold(gradient[n], |rest, k| rest - self.rows[k][n] * z[k]);
            z[n] = rest / self.rows[n][n];
        }
        let scale = libm::sqrtf(self.variance());
        z.map(|part| part * scale)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::find::scan::bench::Noise;

    /// A straight line through four points, with one unknown of which nothing is said.
    #[test]
    fn a_line_and_its_error_bars() {
        let mut triangle = RealTriangle::<3>::default();
        for (x, y) in [(0.0, 1.1), (1.0, 2.9), (2.0, 5.1), (3.0, 6.9)] {
            triangle.fold([1.0 / 0.1, x / 0.1, 0.0], y / 0.1);
        }
        let [offset, slope, nothing] = triangle.solve();
        assert!((offset - 1.06).abs() < 1e-5 && (slope - 1.96).abs() < 1e-5 && nothing == 0.0, "{offset} {slope}");
        // Textbook: sigma / sqrt(sum (x - mean)^2), and of the value in the middle, sigma / sqrt(n).
        assert!((triangle.deviation(&[0.0, 1.0, 0.0]) - 0.1 / 5.0f32.sqrt()).abs() < 1e-6);
        assert!((triangle.deviation(&[1.0, 1.5, 0.0]) - 0.05).abs() < 1e-6);
        assert!((triangle.rest() - 3.2).abs() < 1e-3, "{}", triangle.rest());
    }

    #[test]
    fn finds_the_unknowns_and_how_far_they_scatter() {
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
        // 1.03 here; the square of a scatter over 400 runs scatters by 7 % itself.
        assert!((sum / stated - 1.0).abs() < 0.2, "{}", sum / stated);
    }

    #[test]
    fn without_rows_there_is_no_answer() {
        assert!(ComplexTriangle::<3>::new(3).solve().is_none());
    }
}
