//! Parts of a step of [`exact_step`](super::exact_step): substeps, in which the motion is one
//! polynomial, and their pieces, in which the slip has one sign.

/// Largest number of kicks in a part: those of two pieces, before and after a reversal.
const MAX_KICKS: usize = 10;

/// Motion over one part, with the difference of friction from its first terms as kicks.
pub(super) struct Substep<const N: usize> {
    pub unit_s: f64,
    /// Displacement from the forcing and the first terms of friction, m.
    pub x: [f64; N],
    /// Velocity from the forcing and the first terms of friction, m/s.
    pub v: [f64; N],
    /// Forcing, m/s^2 or m/s.
    pub u: [f64; N],
    /// First terms of friction over Fc.
    pub f: [f64; 3],
    /// Kicks in order of time: moment in units of `unit_s`, and size, m/s.
    pub kicks: [(f64, f64); MAX_KICKS],
    pub count: usize,
}

impl<const N: usize> Substep<N> {
    /// Creates a part without kicks.
    pub fn new(unit_s: f64, (x, v): ([f64; N], [f64; N]), u: [f64; N], f: [f64; 3]) -> Self {
        Substep { unit_s, x, v, u, f, kicks: [(0.0, 0.0); MAX_KICKS], count: 0 }
    }
}

/// Interval of a substep without a reversal of the slip, with the state at its end.
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
