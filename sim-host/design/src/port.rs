//! Linear relation between both ends of a part of the chain.
//!
//! ```text
//! [u2]   [m00 m01 m02] [u1]
//! [F2] = [m10 m11 m12] [F1],     Q = q0 u1 + q1 F1 + q2 V
//!                      [V ]
//! ```
//!
//! with displacement `u`, m, tension `F`, N, voltage `V` and charge `Q`, C, as phasors of
//! `exp(j w t)`. Without a voltage this is the mechanical four-pole of the transmission line
//! (van Randeraat and Setterington, Piezoelectric Ceramics, 1974).

use num_complex::Complex;

/// A phasor.
pub(crate) type C = Complex<f64>;

/// Displacement, m, and tension, N, at a place of the chain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct State {
    /// Displacement along the axis, m.
    pub(crate) u: C,
    /// Tension, N.
    pub(crate) f: C,
}

impl State {
    /// A free end with a displacement of 1 m.
    pub(crate) const FREE: State = State { u: C::new(1.0, 0.0), f: C::new(0.0, 0.0) };
    /// A clamped end with a tension of 1 N.
    pub(crate) const CLAMPED: State = State { u: C::new(0.0, 0.0), f: C::new(1.0, 0.0) };
}

/// Relation between the ends of a part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Port {
    /// Displacement and tension at the right end, by displacement and tension at the left end, and
    /// by the voltage.
    pub(crate) m: [[C; 3]; 2],
    /// Charge, by the same three.
    pub(crate) q: [C; 3],
}

impl Port {
    /// Creates the relation of a part without electrodes.
    pub(crate) fn mechanical([[m00, m01], [m10, m11]]: [[C; 2]; 2]) -> Self {
        let zero = C::default();
        Port { m: [[m00, m01, zero], [m10, m11, zero]], q: [zero; 3] }
    }

    /// Returns state and charge for a state at the left end and a voltage.
    pub(crate) fn apply(&self, left: State, v: C) -> (State, C) {
        let of = |row: &[C; 3]| row[0] * left.u + row[1] * left.f + row[2] * v;
        (State { u: of(&self.m[0]), f: of(&self.m[1]) }, of(&self.q))
    }

    /// Returns the relation over this part and the next, electrically in parallel.
    pub(crate) fn then(&self, next: &Port) -> Port {
        let by = |row: &[C; 3]| {
            let of = |column: usize| row[0] * self.m[0][column] + row[1] * self.m[1][column];
            [of(0), of(1), of(2) + row[2]]
        };
        let q = by(&next.q);
        Port { m: [by(&next.m[0]), by(&next.m[1])], q: [self.q[0] + q[0], self.q[1] + q[1], self.q[2] + q[2]] }
    }

    /// Returns the tension at the left end of a bolt parallel to this part, by displacement and
    /// total tension there and by the voltage: both have the same displacement at the right end.
    pub(crate) fn share_of(&self, bolt: &Port) -> [C; 3] {
        let part = (self.m[0][1] + bolt.m[0][1]).inv();
        [(self.m[0][0] - bolt.m[0][0]) * part, self.m[0][1] * part, self.m[0][2] * part]
    }

    /// Returns the relation of this part with a bolt parallel to it.
    pub(crate) fn beside(&self, bolt: &Port) -> Port {
        let share = self.share_of(bolt);
        let (one, zero) = (C::new(1.0, 0.0), C::default());
        // State at the left end of the part alone, and of the bolt alone.
        let own = [[one, zero, zero], [-share[0], one - share[1], -share[2]]];
        let of_bolt = [[one, zero, zero], share];
        let by = |row: &[C; 3], left: &[[C; 3]; 2], volt: C| {
            let of = |column: usize| row[0] * left[0][column] + row[1] * left[1][column];
            [of(0), of(1), of(2) + volt]
        };
        let own_f = by(&self.m[1], &own, self.m[1][2]);
        let bolt_f = by(&bolt.m[1], &of_bolt, zero);
        let f = [own_f[0] + bolt_f[0], own_f[1] + bolt_f[1], own_f[2] + bolt_f[2]];
        Port { m: [by(&bolt.m[0], &of_bolt, zero), f], q: by(&self.q, &own, self.q[2]) }
    }
}
