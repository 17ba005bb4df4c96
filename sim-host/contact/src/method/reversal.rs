//! Reversals of the slip within a step: crossings of zero, and dips that only touch it.
//!
//! `p` is the slip times its present sign, so it is positive until the slip reverses. Time runs
//! from 0 to 1 over the step. Between the ends, whose values and slopes are known, Hermite's cubic
//! gives a first guess. The method then takes a step of its own to that point.

/// Slip times sign at a moment of a step, with its slope.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Time as a fraction of the step.
    pub at: f64,
    /// Slip times sign, m/s.
    pub value: f64,
    /// Slope of the value over the whole step, m/s.
    pub slope: f64,
}

/// Conclusion from two points about the slip between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// The slip velocity keeps its sign.
    Keeps,
    /// The slip velocity changes its sign at the first point.
    AtOnce,
    /// The slip velocity reverses between `low` and `high`, near `guess`.
    Reverses {
        /// Fraction of the step at which the slip is still positive, or rises from zero.
        low: f64,
        /// Fraction of the step at which the slip is already negative.
        high: f64,
        /// Fraction of the step at which the cubic crosses zero.
        guess: f64,
    },
    /// The slip velocity has a minimum near this fraction of the step; it may be below zero.
    Dips(f64),
}

/// Judges the slip between two points; values down to `-round_off` count as zero.
#[inline]
pub fn between(first: &Point, last: &Point, round_off: f64) -> Verdict {
    if first.value <= round_off && first.slope < 0.0 {
        Verdict::AtOnce
    } else if last.value < -round_off {
        cross(first, last)
    } else if first.slope < 0.0 && last.slope > 0.0 {
        dip(first, last)
    } else {
        Verdict::Keeps
    }
}

/// Hermite cubic over a span, in powers of the fraction of the span.
struct Cubic([f64; 4]);

impl Cubic {
    fn new(first: &Point, last: &Point) -> Self {
        let span = last.at - first.at;
        let (s0, s1, rise) = (first.slope * span, last.slope * span, last.value - first.value);
        Cubic([first.value, s0, 3.0 * rise - 2.0 * s0 - s1, s0 + s1 - 2.0 * rise])
    }

    fn value(&self, u: f64) -> f64 {
        self.0[0] + u * (self.0[1] + u * (self.0[2] + u * self.0[3]))
    }

    /// Returns the fractions at which the slope is zero, in ascending order.
    fn flat(&self) -> [f64; 2] {
        // 3 c3 u^2 + 2 c2 u + c1 = 0 without cancellation
        let [_, c1, c2, c3] = self.0;
        let root = (c2 * c2 - 3.0 * c1 * c3).max(0.0).sqrt();
        let q = -(c2 + root.copysign(c2));
        let (a, b) = (q / (3.0 * c3), c1 / q);
        if a < b { [a, b] } else { [b, a] }
    }
}

/// Returns the first crossing. The cubic is monotone between its flat points, so the first section
/// that ends below zero contains it.
fn cross(first: &Point, last: &Point) -> Verdict {
    let (cubic, span) = (Cubic::new(first, last), last.at - first.at);
    let (mut low, mut high) = (0.0, 1.0);
    for flat in cubic.flat() {
        if flat > low && flat < high {
            if cubic.value(flat) < 0.0 {
                high = flat;
            } else {
                low = flat;
            }
        }
    }
    let (mut a, mut b) = (low, high);
    // The guess need not be more accurate than the cubic itself.
    for _ in 0..30 {
        let middle = 0.5 * (a + b);
        if cubic.value(middle) < 0.0 { b = middle } else { a = middle }
    }
    // The cubic's flat points are only guesses, so the bracket starts at zero. Only a rise from
    // zero needs a later start.
    let low = if first.value > 0.0 { 0.0 } else { low };
    Verdict::Reverses { low: first.at + span * low, high: last.at, guess: first.at + span * 0.5 * (a + b) }
}

/// Returns the minimum between a falling and a rising end, if the cubic comes close to zero there.
fn dip(first: &Point, last: &Point) -> Verdict {
    let (cubic, span) = (Cubic::new(first, last), last.at - first.at);
    // A cubic that falls at one end and rises at the other has one flat point in between.
    let Some(flat) = cubic.flat().into_iter().find(|flat| *flat > 0.0 && *flat < 1.0) else { return Verdict::Keeps };
    // The error of the cubic is far below a tenth of the change of the slip within the step.
    let near = 0.1 * span * (last.slope - first.slope);
    if cubic.value(flat) < near { Verdict::Dips(first.at + span * flat) } else { Verdict::Keeps }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the ends of a step over which p(u) has this value and slope.
    fn ends(p: impl Fn(f64) -> (f64, f64)) -> (Point, Point) {
        let point = |at: f64| Point { at, value: p(at).0, slope: p(at).1 };
        (point(0.0), point(1.0))
    }

    #[test]
    fn a_cubic_is_found_exactly() {
        // (u - 0.3) (u - 0.8) (u + 2) falls through zero at 0.3 and rises through zero at 0.8.
        let p = |u: f64| {
            let (a, b, c) = (u - 0.3, u - 0.8, u + 2.0);
            (a * b * c, b * c + a * c + a * b)
        };
        let (first, last) = ends(p);
        // Both roots are inside: both ends are positive, but the minimum between them is negative.
        let Verdict::Dips(at) = between(&first, &last, 1e-14) else { panic!() };
        let dip = Point { at, value: p(at).0, slope: p(at).1 };
        assert!(dip.value < 0.0 && dip.slope.abs() < 1e-12, "{dip:?}");
        let Verdict::Reverses { low, high, guess } = between(&first, &dip, 1e-14) else { panic!() };
        assert!(low == 0.0 && high == at && (guess - 0.3).abs() < 1e-8, "{guess}");
    }

    #[test]
    fn a_rise_from_zero_is_not_a_reversal() {
        // u (0.6 - u)
        let (first, last) = ends(|u| (u * (0.6 - u), 0.6 - 2.0 * u));
        let Verdict::Reverses { low, guess, .. } = between(&first, &last, 1e-14) else { panic!() };
        assert!((guess - 0.6).abs() < 1e-8 && low > 0.29 && low < 0.31, "{low} {guess}");
        // A slip that falls from zero reverses at once.
        let (first, last) = ends(|u| (-u, -1.0));
        assert_eq!(between(&first, &last, 1e-14), Verdict::AtOnce);
    }

    #[test]
    fn a_dip_far_from_zero_is_ignored() {
        let (first, last) = ends(|u| (1.0 + (u - 0.5) * (u - 0.5), 2.0 * (u - 0.5)));
        assert_eq!(between(&first, &last, 1e-14), Verdict::Keeps);
        let (first, last) = ends(|u| (0.01 + (u - 0.5) * (u - 0.5), 2.0 * (u - 0.5)));
        assert!(matches!(between(&first, &last, 1e-14), Verdict::Dips(at) if (at - 0.5).abs() < 1e-12));
    }
}
