//! Collocation at the right Radau points: nodes, derivatives and weights on a panel from 0 to 1,
//! computed once.
//!
//! The polynomial of degree s through the start and the nodes satisfies the equation at the nodes,
//! the last of which is the end. This is Radau IIA, of order 2 s - 1, L-stable (Hairer and Wanner
//! 1996, *Solving ordinary differential equations II*, IV.5). Nodes are the zeros of
//! `P_s - P_(s-1)` on [-1, 1].

use std::sync::LazyLock;

/// Number of nodes of a panel, s.
pub(crate) const STAGES: usize = 12;
/// Number of brackets in which zeros are searched, evenly spaced in the angle; the closest two
/// zeros are a sixtieth of it apart.
const BRACKETS: usize = 4000;

/// Collocation rule.
#[derive(Debug)]
pub(crate) struct Rule {
    /// Positions of the nodes, 0 to 1.
    pub(crate) at: [f64; STAGES],
    /// Weights of the integral from 0 to 1.
    pub(crate) weight: [f64; STAGES],
    /// Derivative at each node, from the values at all nodes.
    pub(crate) slope: [[f64; STAGES]; STAGES],
    /// Barycentric weights of the start and the nodes: factors of the values in the coefficient of
    /// the highest power.
    pub(crate) barycentric: [f64; STAGES + 1],
    /// Integral from the start to each node, from the values at all nodes: the inverse of `slope`.
    pub(crate) integral: [[f64; STAGES]; STAGES],
}

/// Returns the rule.
pub(crate) fn rule() -> &'static Rule {
    static RULE: LazyLock<Rule> = LazyLock::new(Rule::new);
    &RULE
}

/// Places half-way between two neighbours of the start and the nodes, with the factors of the
/// values in polynomials there.
#[derive(Debug)]
pub(crate) struct Halfway {
    pub(crate) at: [f64; STAGES],
    /// Factors of the values at the start and the nodes.
    pub(crate) of_all: [[f64; STAGES + 1]; STAGES],
    /// Factors of the values at the nodes alone, a polynomial of one degree less.
    pub(crate) of_nodes: [[f64; STAGES]; STAGES],
}

/// Returns the places half-way.
pub(crate) fn halfway() -> &'static Halfway {
    static HALFWAY: LazyLock<Halfway> = LazyLock::new(|| {
        let rule = rule();
        let at: [f64; STAGES] = std::array::from_fn(|k| 0.5 * (if k == 0 { 0.0 } else { rule.at[k - 1] } + rule.at[k]));
        let of_nodes = at.map(|place| {
            // Without the start, a barycentric weight has one factor less.
            let factors: [f64; STAGES] =
                std::array::from_fn(|node| rule.barycentric[node + 1] * rule.at[node] / (place - rule.at[node]));
            let sum: f64 = factors.iter().sum();
            factors.map(|factor| factor / sum)
        });
        Halfway { at, of_all: at.map(|place| rule.factors(place)), of_nodes }
    });
    &HALFWAY
}

/// Returns the Legendre polynomials of degree s and s - 1.
fn legendre(x: f64) -> (f64, f64) {
    let (mut before, mut now) = (1.0, x);
    for k in 2..=STAGES {
        let k = k as f64;
        (before, now) = (now, ((2.0 * k - 1.0) * x * now - (k - 1.0) * before) / k);
    }
    (now, before)
}

impl Rule {
    fn new() -> Self {
        let off = |x: f64| legendre(x).0 - legendre(x).1;
        let place = |bracket: usize| -(std::f64::consts::PI * bracket as f64 / BRACKETS as f64).cos();
        // The end is the last zero.
        let (mut zeros, mut found) = ([1.0; STAGES], 0);
        for bracket in 0..BRACKETS - 1 {
            let (mut low, mut high) = (place(bracket), place(bracket + 1));
            if found + 1 < STAGES && off(low) * off(high) <= 0.0 {
                let rises = off(high) > off(low);
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if (off(middle) > 0.0) == rises {
                        high = middle;
                    } else {
                        low = middle;
                    }
                }
                zeros[found] = 0.5 * (low + high);
                found += 1;
            }
        }
        let at = zeros.map(|x| 0.5 * (1.0 + x));
        let square = (STAGES * STAGES) as f64;
        let weight = zeros.map(|x| if x == 1.0 { 1.0 / square } else { 0.5 * (1.0 + x) / (square * legendre(x).1.powi(2)) });
        // Barycentric weights of the nodes and the start.
        let others = |own: usize| at.iter().enumerate().filter(move |(other, _)| *other != own);
        let barycentric: [f64; STAGES] =
            std::array::from_fn(|own| others(own).map(|(_, other)| at[own] - other).product::<f64>().recip() / at[own]);
        let mut slope = [[0.0; STAGES]; STAGES];
        for (row, slopes) in slope.iter_mut().enumerate() {
            for (column, slope) in slopes.iter_mut().enumerate() {
                *slope = if row == column {
                    at[row].recip() + others(row).map(|(_, other)| (at[row] - other).recip()).sum::<f64>()
                } else {
                    barycentric[column] / barycentric[row] / (at[row] - at[column])
                };
            }
        }
        let start = at.iter().product::<f64>().recip();
        let barycentric = std::array::from_fn(|point| if point == 0 { start } else { barycentric[point - 1] });
        Rule { at, weight, slope, barycentric, integral: inverse(slope) }
    }

    /// Returns the factors of the values at the start and the nodes in the value of the polynomial
    /// at a place from 0 to 1.
    pub(crate) fn factors(&self, place: f64) -> [f64; STAGES + 1] {
        let at = |point: usize| if point == 0 { 0.0 } else { self.at[point - 1] };
        if let Some(point) = (0..=STAGES).find(|point| at(*point) == place) {
            return std::array::from_fn(|other| f64::from(u8::from(other == point)));
        }
        let factors: [f64; STAGES + 1] = std::array::from_fn(|point| self.barycentric[point] / (place - at(point)));
        let sum: f64 = factors.iter().sum();
        factors.map(|factor| factor / sum)
    }
}

/// Returns the inverse of a matrix, three columns at a time.
fn inverse(matrix: [[f64; STAGES]; STAGES]) -> [[f64; STAGES]; STAGES] {
    let mut inverse = [[f64::NAN; STAGES]; STAGES];
    for first in (0..STAGES).step_by(3) {
        let sides = std::array::from_fn(|row| std::array::from_fn(|k| f64::from(u8::from(row == first + k))));
        let columns = solve(matrix, sides).unwrap_or([[f64::NAN; 3]; STAGES]);
        for (row, values) in inverse.iter_mut().zip(columns) {
            row[first..first + 3].copy_from_slice(&values);
        }
    }
    inverse
}

/// Solves the equations of a panel for three right-hand sides; `None` if they have no solution.
pub(crate) fn solve(mut matrix: [[f64; STAGES]; STAGES], mut sides: [[f64; 3]; STAGES]) -> Option<[[f64; 3]; STAGES]> {
    for column in 0..STAGES {
        let size = |row: &usize| matrix[*row][column].abs();
        let pivot = (column..STAGES).max_by(|a, b| size(a).total_cmp(&size(b)))?;
        matrix.swap(column, pivot);
        sides.swap(column, pivot);
        let (upper, lower) = matrix.split_at_mut(column + 1);
        let (done, left) = sides.split_at_mut(column + 1);
        let (pivot, side) = (&upper[column], done[column]);
        for (row, own) in lower.iter_mut().zip(left) {
            let factor = row[column] / pivot[column];
            for k in column + 1..STAGES {
                row[k] -= factor * pivot[k];
            }
            for (own, side) in own.iter_mut().zip(side) {
                *own -= factor * side;
            }
        }
    }
    for row in (0..STAGES).rev() {
        let (upper, known) = sides.split_at_mut(row + 1);
        for (which, side) in upper[row].iter_mut().enumerate() {
            let sum: f64 = known.iter().zip(&matrix[row][row + 1..]).map(|(known, factor)| factor * known[which]).sum();
            *side = (*side - sum) / matrix[row][row];
        }
    }
    sides.iter().flatten().all(|value| value.is_finite()).then_some(sides)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integrates_and_derives_polynomials() {
        let rule = rule();
        assert!(rule.at.windows(2).all(|pair| pair[0] < pair[1]) && rule.at[STAGES - 1] == 1.0);
        for degree in 0..2 * STAGES as i32 - 1 {
            let integral: f64 = rule.at.iter().zip(rule.weight).map(|(at, weight)| weight * at.powi(degree)).sum();
            assert!((integral * f64::from(degree + 1) - 1.0).abs() < 1e-13, "{degree}: {integral}");
        }
        for degree in 0..STAGES as i32 {
            for (row, at) in rule.integral.iter().zip(rule.at) {
                let integral: f64 = row.iter().zip(rule.at).map(|(factor, at)| factor * at.powi(degree)).sum();
                assert!((integral * f64::from(degree + 1) - at.powi(degree + 1)).abs() < 1e-13, "{degree} {at}: {integral}");
            }
            for place in [0.0, 0.3, 0.77, 1.0] {
                let factors = rule.factors(place);
                let others = factors[1..].iter().zip(rule.at).map(|(factor, at)| factor * at.powi(degree));
                let value = others.sum::<f64>() + if degree == 0 { factors[0] } else { 0.0 };
                assert!((value - place.powi(degree)).abs() < 1e-12, "{degree} {place}: {value}");
            }
        }
        // Polynomials that are zero at the start.
        for degree in 1..=STAGES as i32 {
            for (row, at) in rule.slope.iter().zip(rule.at) {
                let slope: f64 = row.iter().zip(rule.at).map(|(slope, at)| slope * at.powi(degree)).sum();
                let exact = f64::from(degree) * at.powi(degree - 1);
                assert!((slope - exact).abs() < 1e-11 * exact.abs().max(1.0), "{degree} {at}: {slope} {exact}");
            }
        }
    }

    /// `y' = L (sin t - y)`, whose steady solution is in phase only for large L.
    #[test]
    fn a_stiff_equation_is_followed() {
        let rule = rule();
        for rate in [1e-3, 1.0, 1e3, 1e9] {
            let mut matrix = rule.slope;
            let mut sides = [[0.0; 3]; STAGES];
            for (node, at) in rule.at.iter().enumerate() {
                matrix[node][node] += rate;
                // y - start, of y = (L^2 sin t - L cos t) / (1 + L^2)
                let start = -rate / (1.0 + rate * rate);
                sides[node] = [rate * (at.sin() - start); 3];
            }
            let end = solve(matrix, sides).unwrap()[STAGES - 1][0] - rate / (1.0 + rate * rate);
            let exact = (rate * rate * 1f64.sin() - rate * 1f64.cos()) / (1.0 + rate * rate);
            assert!((end - exact).abs() < 1e-14 * exact.abs().max(0.1), "{rate}: {end} {exact}");
        }
    }
}
