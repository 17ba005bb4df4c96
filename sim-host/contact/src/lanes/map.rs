//! The friction ratio over a grid, on all cores.
//!
//! The slip at the nodes of a rule depends on the velocity ratio alone, as long as the integral is not cut (A <= 37). A column of the grid
//! therefore computes it once for all its kappas, which lie in the lanes, and each takes one exponential a node.

use rayon::prelude::*;

use super::super::closed::gauss;
use super::super::closed::swing::{CUT, Swing};
use super::functions::{Lanes, exponential, less_one};
use super::{LANES, friction_ratios, lanes_of, ratio};

/// Points of a row that one thread takes at a time.
const BLOCK: usize = 64 * LANES;

/// Kappas from which on a column is worth its slips.
const TALL: usize = 4 * LANES;

/// Friction ratio over a grid, on all cores: row by row of kappa, along each the velocity ratios. Infinite kappa is Coulomb friction.
pub fn friction_map(xi: &[f64], kappa: &[f64]) -> Vec<f64> {
    if kappa.len() >= TALL {
        let columns: Vec<Vec<f64>> = xi.par_iter().map(|&xi| column(xi, kappa)).collect();
        return (0..kappa.len()).flat_map(|row| columns.iter().map(move |column| column[row])).collect();
    }
    let row = |&kappa: &f64| xi.par_chunks(BLOCK).map(move |part| part.iter().map(|&xi| (xi, kappa)).collect::<Vec<_>>());
    kappa.par_iter().flat_map(row).flat_map_iter(|points| friction_ratios(&points)).collect()
}

fn column(xi: f64, kappa: &[f64]) -> Vec<f64> {
    let points: Vec<_> = kappa.iter().map(|&kappa| (xi, kappa)).collect();
    if !(xi != 0.0 && xi.abs() < 1.0) {
        return friction_ratios(&points);
    }
    let mut shared = Swing::both(xi.abs(), 1.0).map(Shared::new);
    let mut out = Vec::with_capacity(kappa.len());
    for chunk in points.chunks(LANES) {
        // At kappa of one the exponent is the slip itself.
        let most = chunk.iter().map(|point| point.1).fold(0.0, f64::max) * shared[0].swing.exponent();
        if most <= CUT {
            let mut abreast = |xi: Lanes, kappa: Lanes| {
                let ways = [0, 1].map(|way| shared[way].forgotten_and_integral(kappa));
                ratio(ways.map(|way| way.0), ways.map(|way| way.1), xi, Lanes::splat(shared[1].half_rad))
            };
            out.extend(lanes_of(chunk, &mut abreast, super::closed::friction_ratio));
        } else {
            out.extend(friction_ratios(chunk));
        }
    }
    out
}

/// One way, whatever kappa.
struct Shared {
    swing: Swing,
    half_rad: f64,
    /// Weight and slip at the nodes of each rule; none yet if empty.
    nodes: [Vec<(f64, f64)>; gauss::HALF_RULES.len()],
}

impl Shared {
    fn new(swing: Swing) -> Self {
        Shared { swing, half_rad: 0.5 * swing.length_rad(), nodes: Default::default() }
    }

    #[inline]
    fn forgotten_and_integral(&mut self, kappa: Lanes) -> (Lanes, Lanes) {
        let exponent = kappa * self.swing.exponent();
        let most = exponent.to_array().into_iter().fold(0.0, f64::max);
        let nodes = &mut self.nodes[gauss::rule(most)];
        if nodes.is_empty() {
            let slip = |node: &gauss::Node| (node.weight, self.swing.slip(self.half_rad * node.at));
            nodes.extend(gauss::half(most).iter().map(slip));
        }
        let whole = exponential(-2.0 * exponent);
        let mut sum = Lanes::ZERO;
        for &(weight, slip) in nodes.iter() {
            let kept = exponential(-kappa * slip);
            sum += (kept + whole / kept) * weight;
        }
        (-less_one(-2.0 * exponent), sum * self.half_rad)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed;

    #[test]
    fn a_map_is_its_points() {
        let xi: Vec<f64> = (0..37).map(|i| f64::from(i - 3) / 30.0).collect();
        let tall: Vec<f64> = (0..61).map(|j| 10f64.powf(f64::from(j) / 3.0 - 10.0)).chain([0.0, f64::INFINITY]).collect();
        let mut worst = 0.0f64;
        for kappa in [&tall[..], &tall[..3], &tall[25..]] {
            let map = friction_map(&xi, kappa);
            assert_eq!(map.len(), 37 * kappa.len());
            for (index, ratio) in map.iter().enumerate() {
                let (xi, kappa) = (xi[index % 37], kappa[index / 37]);
                let off = (ratio - closed::friction_ratio(xi, kappa)).abs();
                assert!(off < 3e-15, "{xi} {kappa:e}: {ratio}");
                worst = worst.max(off);
            }
        }
        println!("worst {worst:e}");
        assert!(friction_map(&xi, &[]).is_empty() && friction_map(&[], &tall).is_empty());
    }

    /// Gain over the scalar loop, all cores: `cargo test --release -p sonoglide-contact --lib map::tests::gain -- --ignored --nocapture`.
    #[test]
    #[ignore = "a measurement"]
    fn gain() {
        let xi: Vec<f64> = (0..200).map(|i| (f64::from(i) + 0.5) / 200.0).collect();
        for (from, to) in [(-2.0, 1.0), (-3.0, 6.0)] {
            let kappa: Vec<f64> = (0..200).map(|j| 10f64.powf(from + (to - from) * f64::from(j) / 199.0)).collect();
            let best = |of: &dyn Fn() -> Vec<f64>| {
                let run = |_| {
                    let began = std::time::Instant::now();
                    std::hint::black_box(of());
                    began.elapsed().as_secs_f64() * 1e9 / 40_000.0
                };
                (0..10).map(run).fold(f64::INFINITY, f64::min)
            };
            let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
            let scalar = best(&|| kappa.iter().flat_map(|&k| xi.iter().map(move |&x| closed::friction_ratio(x, k))).collect());
            let (alone, all) = (best(&|| one.install(|| friction_map(&xi, &kappa))), best(&|| friction_map(&xi, &kappa)));
            println!(
                "kappa 1e{from} to 1e{to}: scalar {scalar:.0} ns a point, map on one core {alone:.0} (gain {:.2}), on all {all:.0}",
                scalar / alone
            );
        }
    }
}
