//! The integrals along the wrap that a table stores, in one pass: those of
//! [`exponent`](super::exponent) for both ends that can pull.
//!
//! ```text
//! G   = int r_s dp
//! H_s = int r_s f exp(-q mu G(p)) dp               the shoulder pulls
//! H_r = int r_s f exp(-q mu (G - G(p))) dp         the retractor pulls: counted from there, G(p)
//!                                                  becomes G - G(p)
//! ```
//!
//! Panels are those of `gauss.rs`, but a panel is halved if its last Legendre coefficients are too
//! large. For a function that is analytic around the panel they fall as a power. The error of 16
//! Gauss points, from coefficient 32 on, is then the square of the last coefficients over the
//! first.
//!
//! [`exponent`](super::exponent) instead compares each panel with its halves. It needs three times
//! as many evaluations of the law, and serves as the reference for the table.

use super::super::empirical::EmpiricalLaw;
use super::Ring;
use super::gauss::{NODES, RULE, between};
use super::normal::Normal;

/// Largest last coefficient of a panel, over the panel; the relative error is its square.
const TAIL_REL: f64 = 1e-6;
/// Largest number of halvings of a panel.
const MAX_HALVINGS: u32 = 24;

/// Integrals so far: G, H_s, and H_r over `exp(-q mu G)`.
type Sums = [f64; 3];

/// Pass along the wrap.
struct Pass<'a> {
    ring: &'a Ring,
    velocity_ratio: f64,
    normal: Option<&'a Normal>,
    /// Product q mu.
    decay: f64,
}

impl Pass<'_> {
    /// Adds a panel between two kinks, for a range of s.
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
            rule.last.iter().all(|row| dot(row) <= TAIL_REL * size)
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
    /// Returns G, H_s and H_r at a velocity ratio, rad; the latter two are zero without a normal
    /// part.
    pub(super) fn integrals(&self, velocity_ratio: f64, normal: Option<&Normal>) -> [f64; 3] {
        let kinks = self.kinks(velocity_ratio, &normal.map(Normal::saturated).into_iter().collect::<Vec<_>>());
        let decay = EmpiricalLaw::FITTED.load_exponent * self.mu;
        let pass = Pass { ring: self, velocity_ratio, normal, decay };
        let [in_surface, shoulder, retractor] =
            kinks.windows(2).fold([0.0; 3], |sums, ends| pass.panel(ends, (0.0, 1.0), MAX_HALVINGS, sums));
        [in_surface, shoulder, retractor * (-decay * in_surface).exp()]
    }
}
