//! The energy account of [`linexp`](super): energies of forcing, damper and friction over a piece.
//!
//! Friction acts through its first terms, which are smooth, and through kicks at the nodes. The
//! work of a kick is exactly its impulse times the mean of the velocities before and after it. All
//! else is smooth between kicks and integrated by Gauss-Legendre quadrature, which is independent
//! of the flow. So the account closes to round-off at any step if, and only if, flow, signs and
//! kicks are right.

use super::exact_step::Exact;
use super::quadrature::{self, Nodes};
use super::simd_nodes::Places;
use super::substep::{Piece, Substep};
use crate::method::polynomial::value;

impl<const K: usize, const N: usize> Exact<K, N>
where
    Nodes<K>: Places,
{
    /// Adds a piece of a part; the present state is that at its beginning.
    pub(super) fn add_energy(&mut self, part: &Substep<N>, piece: &Piece<K>) {
        if self.oscillator.kinematic {
            self.add_given(part, piece);
        } else {
            self.add_oscillator(part, piece);
        }
    }

    /// Adds a piece of a kinematic motion, which the work of friction drives.
    fn add_given(&mut self, part: &Substep<N>, piece: &Piece<K>) {
        let (h, s, excess) = (part.unit_s, self.sense, self.f - self.sense);
        let totals = &mut self.meter.totals;
        for (at, weight) in quadrature::nodes(piece.from, piece.to) {
            let slip = self.sliding * (at - piece.from) * h + self.sign * (value(&part.x, at) - self.x);
            let impulse = weight * h * self.coulomb_n * (s + excess * (-self.per_metre * s * slip).exp());
            totals.felt_n_s += impulse;
            totals.input_j += impulse * value(&part.v, at);
        }
    }

    fn add_oscillator(&mut self, part: &Substep<N>, piece: &Piece<K>) {
        let (h, mass) = (part.unit_s, 1.0 / self.oscillator.per_mass);
        let mut totals = self.meter.totals;
        let mut before = Substep { count: part.count - K, ..*part };
        let mut from = piece.from;
        for l in 0..=K {
            let kick = part.kicks[before.count.min(part.count - 1)];
            let to = if l < K { kick.0 } else { piece.to };
            for (at, weight) in quadrature::nodes(from, to) {
                let weight = weight * h;
                let x = value(&part.x, at) - self.answer(&before, at);
                let v = value(&part.v, at) - self.answer_velocity(&before, at);
                let friction = self.coulomb_n * value(&part.f, at);
                totals.input_j += weight * mass * value(&part.u, at) * v;
                totals.damping_j += weight * mass * self.oscillator.damping * v * v;
                totals.kinetic_j_s += weight * 0.5 * mass * v * v;
                totals.potential_j_s += weight * 0.5 * mass * self.oscillator.stiffness * x * x;
                totals.felt_n_s += weight * friction;
                totals.felt_work_j += weight * friction * (self.sliding + self.sign * v);
            }
            if l < K {
                let v = value(&part.v, to) - self.answer_velocity(&before, to) - 0.5 * kick.1;
                totals.felt_n_s += mass * kick.1;
                totals.felt_work_j += mass * kick.1 * (self.sliding + self.sign * v);
                before.count += 1;
            }
            from = to;
        }
        self.meter.totals = totals;
    }
}
