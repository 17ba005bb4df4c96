//! Friction within a piece of an [`exact step`](super::exact_step) if the motion that it sets back
//! changes it by more than the short series of the exponential covers.

use super::quadrature::Nodes;
use super::simd_nodes::{Lanes, Places, SimdNodes, combine};

/// Number of times that friction at the nodes and the motion under it are computed from each other.
const PASSES: usize = 4;

/// Friction at the nodes of a piece and the motion that it sets back, each as a function of the
/// other.
pub(super) struct Feedback<const K: usize>
where
    Nodes<K>: Places,
{
    /// Sign of the slip velocity.
    pub sense: f64,
    /// Initial friction minus its bound, over Fc.
    pub excess: f64,
    /// Exponent of friction per slip, 1/m.
    pub steep: f64,
    /// Sign of x' in the slip velocity.
    pub sign: f64,
    /// Slip without kicks, m.
    pub slips: Lanes<K>,
    /// First terms of friction.
    pub predicted: Lanes<K>,
    /// Kick per friction over Fc, m/s.
    pub weights: Lanes<K>,
    /// Displacement by kicks of an earlier piece, m.
    pub earlier: Lanes<K>,
    /// Displacement per kick at each node, s.
    pub answers: [Lanes<K>; K],
}

impl<const K: usize> Feedback<K>
where
    Nodes<K>: Places,
{
    /// Returns friction over Fc and kicks at the nodes, the displacement by the kicks, m, and
    /// friction at the end, all by exponentials of the whole slip.
    #[cold]
    pub fn exact(&self) -> (Lanes<K>, Lanes<K>, Lanes<K>, f64) {
        // A slip against its sign is round-off: friction must not grow by it.
        let force = |back: Lanes<K>, lane: usize| {
            let exponent = self.steep * self.sign * back.lane(lane) - self.steep * self.slips.lane(lane);
            self.sense + self.excess * exponent.min(0.0).exp()
        };
        let (mut back, mut forces, mut kicks) = (self.earlier, self.predicted, self.predicted);
        for _ in 0..PASSES {
            forces = Lanes::<K>::each(|lane| force(back, lane));
            kicks = (forces - self.predicted) * self.weights;
            back = self.earlier + combine(kicks, &self.answers);
        }
        (forces, kicks, back, force(back, Lanes::<K>::END))
    }
}
