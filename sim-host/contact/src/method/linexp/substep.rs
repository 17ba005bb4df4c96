//! What a step of [`exact_step`](super::exact_step) is made of: substeps, along which the motion is one polynomial, and pieces of them, along which
//! the slip has one sign.

/// Most kicks in a part: those of two pieces, before and after a reversal.
const KICKS: usize = 6;

/// The motion over one part, and what friction differs from its first terms.
pub(super) struct Substep<const N: usize> {
    pub unit_s: f64,
    /// What the forcing and friction's first terms do to displacement, m, and velocity, m/s; and the forcing alone, m/s^2 or m/s.
    pub x: [f64; N],
    pub v: [f64; N],
    pub u: [f64; N],
    /// The first terms of friction over Fc.
    pub f: [f64; 3],
    /// Kicks, m/s, each at a moment in units of `unit_s`; in order.
    pub kicks: [(f64, f64); KICKS],
    pub count: usize,
}

impl<const N: usize> Substep<N> {
    /// A part without kicks.
    pub fn new(unit_s: f64, (x, v): ([f64; N], [f64; N]), u: [f64; N], f: [f64; 3]) -> Self {
        Substep { unit_s, x, v, u, f, kicks: [(0.0, 0.0); KICKS], count: 0 }
    }
}

/// A stretch of a part without a reversal, and the state at its end.
pub(super) struct Piece<const K: usize> {
    pub from: f64,
    pub to: f64,
    pub forces: [f64; K],
    pub x: f64,
    pub v: f64,
    pub f: f64,
    pub slip: f64,
    pub slip_velocity: f64,
    pub steepness: f64,
}
