//! Least squares of a few unknowns, row by row: each row is folded into a triangular factor by Givens rotations as it arrives.
//!
//! Nothing is stored but the factor, and the condition number is not squared, which is what makes f32 enough.

/// A triangular factor of `N` unknowns and its right-hand side.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Triangle<const N: usize> {
    rows: [[f32; N]; N],
    right: [f32; N],
    /// Sum of squares that no choice of the unknowns explains.
    rest: f32,
}

impl<const N: usize> Default for Triangle<N> {
    fn default() -> Self {
        Triangle { rows: [[0.0; N]; N], right: [0.0; N], rest: 0.0 }
    }
}

impl<const N: usize> Triangle<N> {
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
        for n in 0..unknowns {
            let (kept, b) = (&mut self.rows[n], row[n]);
            if b == 0.0 {
                continue;
            }
            let a = kept[n];
            let size = libm::sqrtf(a * a + b * b);
            let (cosine, sine) = (a / size, b / size);
            kept[n] = cosine * a + sine * b;
            for k in n + 1..unknowns {
                (kept[k], row[k]) = (cosine * kept[k] + sine * row[k], cosine * row[k] - sine * kept[k]);
            }
            let kept_right = &mut self.right[n];
            (*kept_right, right) = (cosine * *kept_right + sine * right, cosine * right - sine * *kept_right);
        }
        self.rest += right * right;
    }

    /// The unknowns; zero where nothing was said of one.
    pub(crate) fn solve(&self) -> [f32; N] {
        let mut unknowns = [0.0; N];
        for n in (0..N).rev() {
            let known = (n + 1..N).fold(self.right[n], |rest, k| rest - self.rows[n][k] * unknowns[k]);
            unknowns[n] = if self.rows[n][n] == 0.0 { 0.0 } else { known / self.rows[n][n] };
        }
        unknowns
    }

    /// Standard deviation of the sum `of . unknowns`, for rows that were divided by theirs: `|R^-T of|`.
    pub(crate) fn deviation(&self, of: &[f32; N]) -> f32 {
        let mut forward = [0.0; N];
        for n in 0..N {
            let known = (0..n).fold(of[n], |rest, k| rest - self.rows[k][n] * forward[k]);
            forward[n] = if self.rows[n][n] == 0.0 { 0.0 } else { known / self.rows[n][n] };
        }
        libm::sqrtf(forward.iter().map(|x| x * x).sum())
    }

    /// Sum of squares that the unknowns leave.
    pub(crate) fn rest(&self) -> f32 {
        self.rest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A straight line through four points, with one unknown of which nothing is said.
    #[test]
    fn a_line_and_its_error_bars() {
        let mut triangle = Triangle::<3>::default();
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
}
