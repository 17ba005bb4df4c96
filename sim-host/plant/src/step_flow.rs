//! The flow of a stack's network over a step, as the coefficients of a step.
//!
//! Everything is linear in the underlying matrix exponentials, so Taylor coefficients of those give
//! Taylor coefficients of the flow.

use wide::f64x2;

use crate::network::{D, DRIVE, E, FORCE, FURTHER, I, STATES, V0, VC};
use crate::quad::Quad;
use crate::timing::Timing;
use contact::flow::Matrix;

/// Index of the total current `(e - v0) / Rs`, a sixth row that is not a state; the flow provides
/// it at no cost.
pub(super) const TOTAL: usize = STATES;

/// The states and the total current, in pairs that fill vector registers: (e, d), (v0, i), (vc,
/// total).
pub(super) type Pairs = [f64x2; 3];

fn pairs(rows: [f64; 6]) -> Pairs {
    [f64x2::new([rows[E], rows[D]]), f64x2::new([rows[V0], rows[I]]), f64x2::new([rows[VC], rows[TOTAL]])]
}

/// Times within a sample, and the resistance through which the current is measured.
#[derive(Clone, Debug)]
pub struct Layout {
    /// Division of a sample.
    pub timing: Timing,
    /// Time for which the previous value is held into this sample, s: the fraction of the drive's
    /// delay beyond whole samples.
    pub late_s: f64,
    /// Source resistance of the amplifier, ohm.
    pub source_ohm: f64,
    /// Number of further modes.
    pub further: usize,
}

/// Coefficients of voltage and current (v, i, v, i) at two times within a step, by the exact flow
/// from its beginning, with drive and friction held. The flow back from the end would be unstable:
/// the clamped capacitance settles within nanoseconds.
#[derive(Clone, Debug, Default)]
pub(super) struct Look {
    /// Number of conversions, 1 or 2; with one, the second half is zero.
    pub(super) conversions: usize,
    pub(super) state: [Quad; STATES],
    pub(super) drive: Quad,
    pub(super) force: Quad,
    /// Response to the previous drive minus the present one.
    pub(super) late: Quad,
    /// Responses to current and voltage of each further mode.
    pub(super) further: Vec<[Quad; 2]>,
}

/// Coefficients of a further mode in a step. Its states are a pair: current, voltage of its
/// capacitor.
#[derive(Clone, Debug)]
pub(super) struct Further {
    /// Effect of its current and its voltage on the first five states and the total current.
    pub(super) onto: [Pairs; 2],
    /// Effect of the first five states on it.
    pub(super) state: [f64x2; STATES],
    pub(super) drive: f64x2,
    pub(super) force: f64x2,
    /// Effect of a late drive on it, for each step of a sample.
    pub(super) late: Vec<f64x2>,
    /// Effect of current and voltage of every further mode on it.
    pub(super) modes: Vec<[f64x2; 2]>,
}

/// The flow over a step.
#[derive(Clone, Debug, Default)]
pub struct StepFlow {
    /// Columns of the flow, one for each state. The stack does not act back on the amplifier, so
    /// the last three have no first pair.
    pub(super) state: [Pairs; STATES],
    /// Response to the drive, held over the step, V.
    pub(super) drive: Pairs,
    /// Response to the friction, held over the step, N.
    pub(super) force: Pairs,
    /// Response to the previous drive minus the present one, for each step of a sample. Empty
    /// without a fractional delay.
    pub(super) late: Vec<Pairs>,
    /// Conversions in each step of a sample.
    pub(super) looks: Vec<Vec<Look>>,
    pub(super) further: Vec<Further>,
}

impl StepFlow {
    /// Computes the flow from `over`, which returns the transition matrix of the states over the
    /// given seconds.
    pub(super) fn new<const N: usize>(layout: &Layout, over: &mut impl FnMut(f64) -> Matrix<N>) -> Self {
        let step_s = layout.timing.step_s();
        let step = over(step_s);
        let total = |m: &Matrix<N>, c: usize| (m[E][c] - m[V0][c]) / layout.source_ohm;
        let column = |m: &Matrix<N>, c: usize| pairs(std::array::from_fn(|r| if r == TOTAL { total(m, c) } else { m[r][c] }));
        let late_steps = if layout.late_s > 0.0 { layout.timing.steps as usize } else { 0 };
        // Time for which the previous drive continues in each step, and the difference of its
        // response from that of the present one.
        let lates: Vec<_> = (0..late_steps).map(|n| late(over, layout.late_s - n as f64 * step_s, step_s)).collect();
        let branch = |k: usize| [FURTHER + 2 * k, FURTHER + 2 * k + 1];
        let row = |m: &Matrix<N>, k: usize, c: usize| f64x2::new(branch(k).map(|r| m[r][c]));
        let further = (0..layout.further).map(|k| Further {
            onto: branch(k).map(|c| column(&step, c)),
            state: std::array::from_fn(|c| row(&step, k, c)),
            drive: row(&step, k, DRIVE),
            force: row(&step, k, FORCE),
            late: lates.iter().map(|m| row(m, k, DRIVE)).collect(),
            modes: (0..layout.further).map(|j| branch(j).map(|c| row(&step, k, c))).collect(),
        });
        StepFlow {
            state: std::array::from_fn(|c| column(&step, c)),
            drive: column(&step, DRIVE),
            force: column(&step, FORCE),
            further: further.collect(),
            looks: looks(layout, over, total),
            late: lates.iter().map(|m| column(m, DRIVE)).collect(),
        }
    }

    /// Multiplies the responses to the friction.
    pub(super) fn scale_force(&mut self, factor: f64) {
        self.force.iter_mut().for_each(|pair| *pair *= factor);
        self.further.iter_mut().for_each(|mode| mode.force *= factor);
        self.looks.iter_mut().flatten().for_each(|look| look.force.0.iter_mut().for_each(|x| *x *= factor));
    }

    /// Passes every number of the flow to `with`, always in the same order, two or four at a time.
    pub(super) fn each(&mut self, mut with: impl FnMut(&mut [f64])) {
        let mut pair = |pair: &mut f64x2| with(pair.as_mut_array());
        self.state.iter_mut().flatten().for_each(&mut pair);
        self.drive.iter_mut().chain(&mut self.force).for_each(&mut pair);
        self.late.iter_mut().flatten().for_each(&mut pair);
        for mode in &mut self.further {
            mode.onto.iter_mut().flatten().for_each(&mut pair);
            mode.state.iter_mut().chain(&mut mode.late).for_each(&mut pair);
            [&mut mode.drive, &mut mode.force].into_iter().for_each(&mut pair);
            mode.modes.iter_mut().flatten().for_each(&mut pair);
        }
        for look in self.looks.iter_mut().flatten() {
            let quads = look.state.iter_mut().chain([&mut look.drive, &mut look.force, &mut look.late]);
            quads.chain(look.further.iter_mut().flatten()).for_each(|quad| with(&mut quad.0));
        }
    }
}

/// Returns the matrix over `seconds` minus that over the time after `late_s`: the response to a
/// drive that is late by `late_s`.
fn late<const N: usize>(over: &mut impl FnMut(f64) -> Matrix<N>, late_s: f64, seconds: f64) -> Matrix<N> {
    if late_s <= 0.0 {
        return [[0.0; N]; N];
    }
    let mut whole = over(seconds);
    if late_s < seconds {
        let rest = over(seconds - late_s);
        whole.iter_mut().flatten().zip(rest.iter().flatten()).for_each(|(x, y)| *x -= y);
    }
    whole
}

fn looks<const N: usize>(
    layout: &Layout,
    over: &mut impl FnMut(f64) -> Matrix<N>,
    total: impl Fn(&Matrix<N>, usize) -> f64,
) -> Vec<Vec<Look>> {
    let step_s = layout.timing.step_s();
    let steps = layout.timing.instants().into_iter().enumerate();
    let of_step = |(number, instants): (usize, Vec<[f64; 2]>)| {
        let late_s = layout.late_s - number as f64 * step_s;
        let look = |instants: &[[f64; 2]]| {
            let mut flows = [[[0.0; N]; N]; 4];
            let mut lates = [0.0; 4];
            for (n, &[v, i]) in instants.iter().enumerate() {
                flows[2 * n..][..2].copy_from_slice(&[over(v), over(i)]);
                let [early, lately] = [late(over, late_s, v), late(over, late_s, i)];
                lates[2 * n..][..2].copy_from_slice(&[early[V0][DRIVE], total(&lately, DRIVE)]);
            }
            let column = |c: usize| {
                let seen = |n: usize| if n.is_multiple_of(2) { flows[n][V0][c] } else { total(&flows[n], c) };
                Quad(std::array::from_fn(seen))
            };
            Look {
                conversions: instants.len(),
                state: std::array::from_fn(column),
                drive: column(DRIVE),
                force: column(FORCE),
                late: Quad(lates),
                further: (0..layout.further).map(|k| [FURTHER + 2 * k, FURTHER + 2 * k + 1].map(column)).collect(),
            }
        };
        instants.chunks(2).map(look).collect()
    };
    steps.map(of_step).collect()
}
