//! Gauss-Legendre nodes on a step from 0 to 1, and weights for a time mean that also uses the
//! values known at the ends.

/// `K` Gauss-Legendre nodes, for K from 1 to 3.
pub struct Nodes<const K: usize>;

/// Distance of two nodes from the middle: `sqrt(1/3) / 2`.
const TWO: f64 = 0.288_675_134_594_812_88;
/// Distance of the outer of three nodes from the middle: `sqrt(3/5) / 2`.
const THREE: f64 = 0.387_298_334_620_741_7;

impl<const K: usize> Nodes<K> {
    /// Positions of the nodes, as fractions of the step.
    pub const AT: [f64; K] = pick([0.5], [0.5 - TWO, 0.5 + TWO], [0.5 - THREE, 0.5, 0.5 + THREE]);
    /// Weights of the nodes, whose sum is one.
    pub const WEIGHT: [f64; K] = pick([1.0], [0.5, 0.5], [5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0]);
    /// Weights of the nodes in a mean that also uses value, slope and curvature at the ends; exact
    /// for degree 7, 7 and 9.
    pub const MEAN: [f64; K] = pick([16.0 / 35.0], [27.0 / 35.0; 2], [125.0 / 189.0, 352.0 / 945.0, 125.0 / 189.0]);
    /// Weights of the end values, of their slopes and of their curvatures in that mean, for each K.
    pub const OUTER: (f64, f64, f64) = match K {
        1 => (19.0 / 70.0, 1.0 / 35.0, 1.0 / 840.0),
        2 => (-19.0 / 70.0, -1.0 / 20.0, -1.0 / 420.0),
        _ => (-73.0 / 210.0, -13.0 / 420.0, -1.0 / 1260.0),
    };

    /// Returns the mean over a step of length `h` of a function with these values at the nodes, and
    /// these values, slopes and curvatures at the ends.
    #[inline]
    pub fn mean(nodes: &[f64; K], ends: [End; 2], h: f64) -> f64 {
        let [first, last] = ends;
        let inner: f64 = nodes.iter().zip(Self::MEAN).map(|(value, weight)| value * weight).sum();
        let (value, slope, curvature) = Self::OUTER;
        let outer = value * (first.value + last.value) + slope * h * (first.slope - last.slope);
        inner + outer + curvature * h * h * (first.curvature + last.curvature)
    }
}

/// Function at an end of a step.
#[derive(Clone, Copy, Debug)]
pub struct End {
    /// Value of the function at the end.
    pub value: f64,
    /// Slope of the function at the end.
    pub slope: f64,
    /// Second derivative of the function at the end.
    pub curvature: f64,
}

/// Returns the list that has `K` entries.
const fn pick<const K: usize>(one: [f64; 1], two: [f64; 2], three: [f64; 3]) -> [f64; K] {
    let mut out = [0.0; K];
    let mut i = 0;
    while i < K {
        out[i] = match K {
            1 => one[i],
            2 => two[i],
            _ => three[i],
        };
        i += 1;
    }
    out
}

/// Returns positions and weights of eight Gauss-Legendre nodes from `a` to `b` (exact for degree
/// 15).
#[inline]
pub fn nodes(a: f64, b: f64) -> [(f64, f64); 8] {
    const HALF: [(f64, f64); 4] = [
        (0.183_434_642_495_649_8, 0.362_683_783_378_362),
        (0.525_532_409_916_329, 0.313_706_645_877_887_27),
        (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
        (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
    ];
    let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
    std::array::from_fn(|i| {
        let (at, weight) = HALF[i / 2];
        (if i % 2 == 0 { middle - half * at } else { middle + half * at }, half * weight)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the mean of s^degree over 0 to 1 by the rule.
    fn power<const K: usize>(degree: i32) -> f64 {
        let p = f64::from(degree);
        let start = [(0, [1.0, 0.0, 0.0]), (1, [0.0, 1.0, 0.0]), (2, [0.0, 0.0, 2.0])];
        let [value, slope, curvature] = start.into_iter().find(|(of, _)| *of == degree).map_or([0.0; 3], |(_, start)| start);
        let ends = [End { value, slope, curvature }, End { value: 1.0, slope: p, curvature: p * (p - 1.0) }];
        Nodes::<K>::mean(&Nodes::<K>::AT.map(|s| s.powi(degree)), ends, 1.0)
    }

    #[test]
    fn rules_have_their_degree() {
        for degree in 0..=9 {
            let exact = 1.0 / f64::from(degree + 1);
            for (value, highest) in [(power::<1>(degree), 7), (power::<2>(degree), 7), (power::<3>(degree), 9)] {
                assert_eq!((value - exact).abs() < 1e-14, degree <= highest, "degree {degree}: {value} {exact}");
            }
        }
    }

    #[test]
    fn eight_nodes_have_degree_fifteen() {
        let error = |degree: i32| {
            let exact = 10f64.powi(degree + 1) / f64::from(degree + 1);
            let sum: f64 = nodes(0.0, 10.0).iter().map(|(at, weight)| weight * at.powi(degree)).sum();
            (sum / exact - 1.0).abs()
        };
        assert!((0..=15).all(|degree| error(degree) < 1e-14) && error(16) > 1e-10, "{:e}", error(16));
    }
}
