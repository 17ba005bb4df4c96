//! The state that repeats after one period, by Newton's method, and the decay of a disturbance.
//!
//! ```text
//! (I - P') ds = P(s) - s          P, the map of the state over one period; P' by differences
//! ```

/// Displacement for the derivatives, in units of the scale.
const DIFFERENCE: f64 = 1e-6;
/// Residual at which the search ends, in units of the scale.
const SMALL_RESIDUAL: f64 = 1e-14;
/// Largest residual of a steady state, in units of the scale.
const MAX_RESIDUAL: f64 = 1e-9;
/// Maximum number of Newton's steps.
const MAX_STEPS: usize = 60;
/// Smallest part of a step that is tried before the motion itself is followed for some periods.
const MIN_PART: f64 = 1.0 / 64.0;
/// Number of periods that are followed then.
const FOLLOWED_PERIODS: usize = 20;
/// Smallest pivot; below it, the steady state is not unique.
const MIN_PIVOT: f64 = 1e-10;

/// Map of a state over one period, in units of its scale.
pub(crate) trait Map {
    /// Returns `true` if a part of the state is free, and does not follow from the excitation.
    fn is_free(&self, part: usize) -> bool;

    /// Returns the distance of a multiplier from one below which a disturbance neither decays nor
    /// grows.
    fn min_decay(&self) -> f64 {
        1e-7
    }

    /// Returns the state after one period, and the mean friction ratio; `None` if it cannot be
    /// computed.
    fn advance(&self, at: &[f64]) -> Option<(Vec<f64>, f64)>;
}

/// State that repeats.
#[derive(Clone, Debug)]
pub(crate) struct Fixed {
    /// State at the beginning of a period.
    pub(crate) at: Vec<f64>,
    /// Mean friction ratio over the period.
    pub(crate) mean: f64,
    /// Largest change of the state after a period.
    pub(crate) residual: f64,
    /// Derivative of the map there, by rows.
    pub(crate) derivative: Vec<Vec<f64>>,
    /// Largest modulus of a Floquet multiplier.
    pub(crate) multiplier: f64,
}

/// Reason why no state that repeats is of use.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Lost {
    /// None was found.
    NotFound,
    /// A disturbance grows by this factor per period.
    Unstable(f64),
    /// A disturbance decays too slowly, or not at all.
    NotUnique,
}

/// Finds the state that repeats, from a first guess.
pub(crate) fn find(map: &impl Map, start: Vec<f64>) -> Result<Fixed, Lost> {
    let found = search(map, start).ok_or(Lost::NotFound)?;
    let derivative = derivative(map, &found.at).ok_or(Lost::NotFound)?;
    let multiplier = spectral_radius(&derivative);
    if multiplier > 1.0 + map.min_decay() {
        return Err(Lost::Unstable(multiplier));
    }
    if multiplier > 1.0 - map.min_decay() {
        return Err(Lost::NotUnique);
    }
    Ok(Fixed { residual: size(&found.off), at: found.at, mean: found.mean, derivative, multiplier })
}

/// State at the beginning of a period, its change after one, and the mean friction ratio.
struct Guess {
    at: Vec<f64>,
    off: Vec<f64>,
    mean: f64,
}

fn search(map: &impl Map, start: Vec<f64>) -> Option<Guess> {
    let mut now = measure(map, start)?;
    for _ in 0..MAX_STEPS {
        if size(&now.off) < SMALL_RESIDUAL {
            break;
        }
        let step = derivative(map, &now.at).and_then(|derivative| newton_step(&derivative, &now.off));
        match step.and_then(|step| part(map, &now, &step)) {
            Some(next) => now = next,
            // At round-off no part of a step is better.
            None if size(&now.off) < MAX_RESIDUAL => break,
            None => {
                for _ in 0..FOLLOWED_PERIODS {
                    now.at = map.advance(&now.at)?.0;
                }
                now = measure(map, now.at)?;
            }
        }
    }
    (size(&now.off) < MAX_RESIDUAL).then_some(now)
}

/// Returns a guess with its residual.
fn measure(map: &impl Map, at: Vec<f64>) -> Option<Guess> {
    let (after, mean) = map.advance(&at)?;
    Some(Guess { off: difference(&after, &at), at, mean })
}

/// Returns the guess after the largest part of a step that reduces the residual.
fn part(map: &impl Map, now: &Guess, step: &[f64]) -> Option<Guess> {
    let mut parts = std::iter::successors(Some(1.0), |part| Some(0.5 * part)).take_while(|part| *part >= MIN_PART);
    parts.find_map(|part| {
        let next = measure(map, now.at.iter().zip(step).map(|(at, step)| at + part * step).collect())?;
        (size(&next.off) < (1.0 - 0.1 * part) * size(&now.off)).then_some(next)
    })
}

/// Returns the derivative of the map, by differences; row i by part i of the state after a period.
fn derivative(map: &impl Map, at: &[f64]) -> Option<Vec<Vec<f64>>> {
    let parts = at.len();
    let mut rows = vec![vec![0.0; parts]; parts];
    for j in (0..parts).filter(|j| map.is_free(*j)) {
        let moved = |by: f64| -> Vec<f64> { (0..parts).map(|i| at[i] + if i == j { by } else { 0.0 }).collect() };
        let (after, before) = (map.advance(&moved(DIFFERENCE))?.0, map.advance(&moved(-DIFFERENCE))?.0);
        for (i, off) in difference(&after, &before).into_iter().enumerate().filter(|(i, _)| map.is_free(*i)) {
            rows[i][j] = off / (2.0 * DIFFERENCE);
        }
    }
    Some(rows)
}

pub(crate) fn difference(one: &[f64], other: &[f64]) -> Vec<f64> {
    one.iter().zip(other).map(|(one, other)| one - other).collect()
}

fn size(vector: &[f64]) -> f64 {
    vector.iter().fold(0.0, |size, part| part.abs().max(size))
}

/// Solves `(I - P') ds = off` by elimination with pivots; `None` if it is singular.
pub(crate) fn newton_step(derivative: &[Vec<f64>], off: &[f64]) -> Option<Vec<f64>> {
    let parts = off.len();
    let row =
        |i: usize| (0..=parts).map(move |j| if j == parts { off[i] } else { f64::from(u8::from(i == j)) - derivative[i][j] });
    let mut rows: Vec<Vec<f64>> = (0..parts).map(|i| row(i).collect()).collect();
    for i in 0..parts {
        let pivot = (i..parts).max_by(|a, b| rows[*a][i].abs().total_cmp(&rows[*b][i].abs()))?;
        rows.swap(i, pivot);
        if rows[i][i].abs() < MIN_PIVOT {
            return None;
        }
        for other in (0..parts).filter(|other| *other != i) {
            let factor = rows[other][i] / rows[i][i];
            rows[other] = (0..=parts).map(|j| rows[other][j] - factor * rows[i][j]).collect();
        }
    }
    Some((0..parts).map(|i| rows[i][parts] / rows[i][i]).collect())
}

/// Returns the largest modulus of an eigenvalue: the growth of the powers of a matrix.
fn spectral_radius(matrix: &[Vec<f64>]) -> f64 {
    /// Number of squarings: the power 2^40 leaves a relative error of about 1e-12.
    const SQUARINGS: i32 = 40;
    let (mut power, mut ln) = (matrix.to_vec(), 0.0);
    for squaring in 0..=SQUARINGS {
        let size = power.iter().map(|row| size(row)).fold(0.0, f64::max);
        if size == 0.0 {
            return 0.0;
        }
        // ln |M^(2^k)| / 2^k, summed so that no power overflows.
        ln += size.ln() / 2f64.powi(squaring);
        let unit: Vec<Vec<f64>> = power.iter().map(|row| row.iter().map(|part| part / size).collect()).collect();
        let parts = 0..unit.len();
        let square = |i: usize, j: usize| parts.clone().map(|k| unit[i][k] * unit[k][j]).sum();
        power = parts.clone().map(|i| parts.clone().map(|j| square(i, j)).collect()).collect();
    }
    ln.exp()
}
