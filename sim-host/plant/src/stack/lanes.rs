//! Networks of several stacks in a batch, one a lane, each with its own flow. Same operations in
//! the same order as [`Stack::advance`] and [`Stack::sample`] without friction, further modes and a
//! late drive.

use super::{STILL_CHANGE_REL, Stack};
use crate::network::{D, E, I, STATES, V0, VC};
use crate::quad::{LANES, Quad, Registers, Wide};
use crate::step_flow::{Look, StepFlow, TOTAL};
use wide::f64x2;

/// Coefficients of a number: those of the drive and of each state.
type Row = [Quad; 1 + STATES];
/// Index of the drive in a row; the states come after it.
const DRIVE: usize = 0;
/// Number of values: the states, and the total current.
const VALUES: usize = TOTAL + 1;

/// The flows of several stacks.
#[derive(Clone, Debug, Default)]
pub(crate) struct Flows {
    rows: [Row; VALUES],
    /// Rows of voltage and current for each conversion in a step.
    looks: Vec<[Row; 2]>,
    /// Version of the stack's flow in each lane.
    remade: [Option<u64>; LANES],
}

/// States and total currents of several stacks at the end of a step, and at its beginning.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct States {
    x: [Quad; VALUES],
    before: [Quad; VALUES],
}

/// States in registers.
#[derive(Clone, Copy)]
pub(crate) struct StatesIn<F: Registers> {
    x: [Wide<F>; VALUES],
    before: [Wide<F>; VALUES],
}

/// Returns the pair of a flow that contains a state or the total current, and its index in the
/// pair.
fn place(state: usize) -> (usize, usize) {
    (state / 2, state % 2)
}

impl Flows {
    /// Updates a lane to the present flow of its stack.
    pub(crate) fn take(&mut self, lane: usize, stack: &Stack) {
        if self.remade[lane].replace(stack.remade) == Some(stack.remade) {
            return;
        }
        let StepFlow { state, drive, looks, .. } = &stack.flow;
        for (n, row) in self.rows.iter_mut().enumerate() {
            let (pair, number) = place(n);
            let of = |column: &[f64x2; 3]| column[pair].to_array()[number];
            row[DRIVE][lane] = of(drive);
            row[1..].iter_mut().zip(state).for_each(|(quad, column)| quad[lane] = of(column));
        }
        let conversions: usize = looks[0].iter().map(|look| look.conversions).sum();
        self.looks.resize(conversions, [[Quad::default(); 1 + STATES]; 2]);
        for (n, rows) in self.looks.iter_mut().enumerate() {
            let Look { state, drive, .. } = &looks[0][n / 2];
            for (channel, row) in rows.iter_mut().enumerate() {
                let number = n % 2 * 2 + channel;
                row[DRIVE][lane] = drive[number];
                row[1..].iter_mut().zip(state).for_each(|(quad, column)| quad[lane] = column[number]);
            }
        }
    }

    /// Returns the number of conversions in a step.
    #[inline(always)]
    pub(crate) fn conversions(&self) -> usize {
        self.looks.len()
    }

    /// Advances by one step with the drives held.
    #[inline(always)]
    pub(crate) fn advance<F: Registers>(&self, states: &mut StatesIn<F>, volts: Wide<F>) {
        let x = states.x;
        let [e, d, v0, i, vc, total] = &self.rows;
        let next = [
            amplified(e, &x, volts),
            amplified(d, &x, volts),
            response(v0, &x, volts),
            response(i, &x, volts),
            response(vc, &x, volts),
            response(total, &x, volts),
        ];
        *states = StatesIn { x: next, before: x };
    }

    /// Returns the voltage and current at a conversion within the step just made.
    #[inline(always)]
    pub(crate) fn look<F: Registers>(&self, conversion: usize, states: &StatesIn<F>, volts: Wide<F>) -> [Wide<F>; 2] {
        let [v, i] = &self.looks[conversion];
        [response(v, &states.before, volts), response(i, &states.before, volts)]
    }
}

/// Computes the amplifier's states, which do not depend on the stack. No closure or adapter is used
/// here and below: code that is not inlined is not compiled for these registers.
#[inline(always)]
fn amplified<F: Registers>(row: &Row, x: &[Wide<F>; VALUES], volts: Wide<F>) -> Wide<F> {
    let four = volts.four();
    row[DRIVE].wide(four) * volts + row[1 + E].wide(four) * x[E] + row[1 + D].wide(four) * x[D]
}

#[inline(always)]
fn response<F: Registers>(row: &Row, x: &[Wide<F>; VALUES], volts: Wide<F>) -> Wide<F> {
    let four = volts.four();
    let amplifier = amplified(row, x, volts);
    amplifier + row[1 + V0].wide(four) * x[V0] + row[1 + I].wide(four) * x[I] + row[1 + VC].wide(four) * x[VC]
}

impl<F: Registers> StatesIn<F> {
    /// Stores the states in memory.
    #[inline(always)]
    pub(crate) fn stored(&self) -> States {
        let mut states = States::default();
        for n in 0..VALUES {
            (states.x[n], states.before[n]) = (self.x[n].quad(), self.before[n].quad());
        }
        states
    }

    /// Returns the voltage at the stack, V.
    #[inline(always)]
    pub(crate) fn voltage(&self) -> Wide<F> {
        self.x[V0]
    }

    /// Returns the motional current of the working mode, A.
    #[inline(always)]
    pub(crate) fn motional_current(&self) -> Wide<F> {
        self.x[I]
    }

    /// Returns the voltage of the motional capacitor, V.
    #[inline(always)]
    pub(crate) fn motional_voltage(&self) -> Wide<F> {
        self.x[VC]
    }
}

impl States {
    /// Copies the state of a stack.
    pub(crate) fn take(&mut self, lane: usize, stack: &Stack) {
        self.x.iter_mut().enumerate().for_each(|(n, quad)| quad[lane] = stack.state(n));
    }

    /// Returns its state to a stack. The last step had its drive held at `volts`.
    pub(crate) fn give_back(&self, lane: usize, stack: &mut Stack, volts: f64) {
        for (n, quad) in self.before.iter().enumerate() {
            let (pair, number) = place(n);
            stack.x[pair].as_mut_array()[number] = quad[lane];
        }
        stack.advance(&stack.held(volts), 0.0);
        debug_assert!((0..VALUES).all(|n| stack.state(n) == self.x[n][lane]), "a lane differs from its stack alone");
    }

    /// Loads the states into registers.
    #[inline(always)]
    pub(crate) fn wide<F: Registers>(&self, four: F) -> StatesIn<F> {
        let zero = Wide::splat(four, 0.0);
        let mut states = StatesIn { x: [zero; VALUES], before: [zero; VALUES] };
        for n in 0..VALUES {
            (states.x[n], states.before[n]) = (self.x[n].wide(four), self.before[n].wide(four));
        }
        states
    }

    /// Returns, for each lane, `true` if it did not move in the last step, as in
    /// [`Stack::is_still`].
    pub(crate) fn are_still(&self) -> [bool; LANES] {
        std::array::from_fn(|lane| {
            let pairs = self.x.iter().zip(&self.before).map(|(x, before)| (x[lane], before[lane]));
            let (moved, largest) = pairs
                .fold((0.0f64, 0.1f64), |(moved, largest), (x, before)| (moved.max((x - before).abs()), largest.max(x.abs())));
            moved <= STILL_CHANGE_REL * largest
        })
    }
}
