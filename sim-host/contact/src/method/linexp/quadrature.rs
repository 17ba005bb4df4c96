//! Gauss-Legendre nodes on a step from 0 to 1, and weights for a time mean that also uses the
//! values known at the ends.

use super::simd_nodes::{Lanes, Places, SimdNodes};

/// `K` Gauss-Legendre nodes, for K of 1, 2, 3 and 5.
pub struct Nodes<const K: usize>;

impl<const K: usize> Nodes<K> {
    /// Positions of the nodes, as fractions of the step.
    pub const AT: [f64; K] = symmetric(
        match K {
            1 => &[0.5],
            2 => &[0.211_324_865_405_187_13],
            3 => &[0.112_701_665_379_258_31, 0.5],
            _ => &[0.046_910_077_030_668_004, 0.230_765_344_947_158_45, 0.5],
        },
        true,
    );
    /// Weights of the nodes, whose sum is one.
    pub const WEIGHT: [f64; K] = symmetric(
        match K {
            1 => &[1.0],
            2 => &[0.5],
            3 => &[5.0 / 18.0, 8.0 / 18.0],
            _ => &[0.118_463_442_528_094_54, 0.239_314_335_249_683_23, 0.284_444_444_444_444_44],
        },
        false,
    );
    /// Weights of the nodes in a mean that also uses value, slope and curvature at the ends; exact
    /// for degree 7, 7, 9 and 11.
    pub const MEAN: [f64; K] = symmetric(
        match K {
            1 => &[16.0 / 35.0],
            2 => &[27.0 / 35.0],
            3 => &[125.0 / 189.0, 352.0 / 945.0],
            _ => &[-0.175_300_771_095_161_74, 0.252_607_168_401_559_05, 0.278_287_638_287_638_3],
        },
        false,
    );
    /// Weights of the end values, of their slopes and of their curvatures in that mean, for each K.
    pub const OUTER: (f64, f64, f64) = match K {
        1 => (19.0 / 70.0, 1.0 / 35.0, 1.0 / 840.0),
        2 => (-19.0 / 70.0, -1.0 / 20.0, -1.0 / 420.0),
        3 => (-73.0 / 210.0, -13.0 / 420.0, -1.0 / 1260.0),
        _ => (131.0 / 462.0, 1.0 / 84.0, 1.0 / 5544.0),
    };

    /// Returns the displacement at the nodes and the end from friction at each node, per kick by
    /// the weight of that node: at the nodes by the polynomial through them, at the end by the
    /// kicks.
    /// `response` is the displacement after a kick, as a function of the part of a step since.
    pub fn answers(response: impl Fn(f64) -> f64) -> [Lanes<K>; K]
    where
        Self: Places,
    {
        let at_end = Self::AT.map(|node| response(1.0 - node));
        let of: [[f64; K]; K] = Self::AT.map(|to| {
            let mut sums = [0.0; K];
            for (s, weight) in nodes(0.0, to) {
                let responded = weight * response(to - s);
                for (node, sum) in sums.iter_mut().enumerate() {
                    let others = Self::AT.iter().enumerate().filter(|(other, _)| *other != node);
                    let part: f64 = others.map(|(_, other)| (s - other) / (Self::AT[node] - other)).product();
                    *sum += responded * part / Self::WEIGHT[node];
                }
            }
            sums
        });
        std::array::from_fn(|node| Lanes::<K>::each(|lane| of.get(lane).unwrap_or(&at_end)[node]))
    }

    /// Returns the weights of the nodes times a number; zero for the end.
    pub fn weights(times: f64) -> Lanes<K>
    where
        Self: Places,
    {
        Lanes::<K>::each(|lane| Self::WEIGHT.get(lane).map_or(0.0, |weight| weight * times))
    }

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

/// Returns a list of `K` numbers from its first half: the second repeats it backwards, or mirrors
/// it about a half.
const fn symmetric<const K: usize>(half: &[f64], mirrored: bool) -> [f64; K] {
    let mut out = [0.0; K];
    let mut i = 0;
    while i < half.len() {
        out[i] = half[i];
        out[K - 1 - i] = if mirrored { 1.0 - half[i] } else { half[i] };
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
        for degree in 0..=11 {
            let exact = 1.0 / f64::from(degree + 1);
            let powers = [(power::<1>(degree), 7), (power::<2>(degree), 7), (power::<3>(degree), 9), (power::<5>(degree), 11)];
            for (value, highest) in powers {
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
