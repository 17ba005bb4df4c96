//! The integrals along the wrap that a table holds, in one pass: those of [`exponent`](super::exponent) for both ends that can pull.
//!
//! ```text
//! G   = int r_s dp
//! H_s = int r_s f exp(-q mu G(p)) dp               the shoulder pulls
//! H_r = int r_s f exp(-q mu (G - G(p))) dp         the retractor pulls: seen from there, G(p) is what is left of G
//! ```
//!
//! Panels are those of `gauss.rs`, but a panel is halved by its last Legendre coefficients: of a function that is analytic about a panel they fall like a power, and
//! what 16 Gauss points leave out, from the coefficient 32 on, is the square of the last ones over the first. [`exponent`](super::exponent), which compares each panel with
//! its halves, takes three times as many laws, and is what the table is tested against.

use super::super::empirical::EmpiricalLaw;
use super::Ring;
use super::gauss::{NODES, RULE, between};
use super::normal::Normal;

/// The last coefficients of a panel of the wrap over the whole panel; the error is the square of it.
const TAIL: f64 = 1e-6;
/// How many times a panel is halved at most.
const HALVINGS: u32 = 24;

/// Integrals so far: G, that of H_s, and that of H_r over `exp(-q mu G)`.
type Sums = [f64; 3];

/// A pass along the wrap.
struct Pass<'a> {
    ring: &'a Ring,
    velocity_ratio: f64,
    normal: Option<&'a Normal>,
    /// q mu
    decay: f64,
}

impl Pass<'_> {
    /// Adds a panel between two kinks, from one s to another.
    fn panel(&self, ends: &[f64], (from, to): (f64, f64), halvings: u32, sums: Sums) -> Sums {
        let rule = &*RULE;
        let long = to - from;
        let (mut ratios, mut shares) = ([0.0; NODES], [0.0; NODES]);
        for ((ratio, share), (at, _)) in ratios.iter_mut().zip(&mut shares).zip(&rule.nodes) {
            let (place, per_s) = between(ends, from + long * at);
            let parts = self.ring.parts(place);
            *ratio = long * per_s * self.ring.of_tangential(parts.tangential, self.velocity_ratio);
            *share = self.normal.map_or(0.0, |normal| *ratio * normal.share(parts.normal));
        }
        let small = |values: &[f64; NODES]| {
            let size = values.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
            let dot = |row: &[f64; NODES]| row.iter().zip(values).map(|(a, b)| a * b).sum::<f64>().abs();
            rule.last.iter().all(|row| dot(row) <= TAIL * size)
        };
        if halvings > 0 && !(small(&ratios) && (self.normal.is_none() || small(&shares))) {
            let middle = 0.5 * (from + to);
            let sums = self.panel(ends, (from, middle), halvings - 1, sums);
            return self.panel(ends, (middle, to), halvings - 1, sums);
        }
        let dot = |values: &[f64; NODES]| rule.nodes.iter().zip(values).map(|((_, weight), value)| weight * value).sum::<f64>();
        let [mut in_surface, mut shoulder, mut retractor] = sums;
        if self.normal.is_some() {
            for ((row, share), (_, weight)) in rule.until.iter().zip(&shares).zip(&rule.nodes) {
                let until = in_surface + row.iter().zip(&ratios).map(|(part, ratio)| part * ratio).sum::<f64>();
                let decayed = (-self.decay * until).exp();
                shoulder += weight * share * decayed;
                retractor += weight * share / decayed;
            }
        }
        in_surface += dot(&ratios);
        [in_surface, shoulder, retractor]
    }
}

impl Ring {
    /// G, H_s and H_r at a velocity ratio, rad; the latter are zero without a normal part.
    pub(super) fn integrals(&self, velocity_ratio: f64, normal: Option<&Normal>) -> [f64; 3] {
        let kinks = self.kinks(velocity_ratio, &normal.map(Normal::saturated).into_iter().collect::<Vec<_>>());
        let decay = EmpiricalLaw::FITTED.load_exponent * self.mu;
        let pass = Pass { ring: self, velocity_ratio, normal, decay };
        let [in_surface, shoulder, retractor] =
            kinks.windows(2).fold([0.0; 3], |sums, ends| pass.panel(ends, (0.0, 1.0), HALVINGS, sums));
        [in_surface, shoulder, retractor * (-decay * in_surface).exp()]
    }
}
