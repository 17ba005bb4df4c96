//! Networks of several stacks side by side, one a lane, each with a flow of its own: [`Stack::advance`] and [`Stack::sample`] without friction, further
//! modes and a late drive, in the same order of the same operations.

use super::{STILL, Stack};
use crate::network::{D, E, I, STATES, V0, VC};
use crate::quad::{Four, LANES, Quad, Wide};
use crate::step_flow::{Look, StepFlow, TOTAL};
use wide::f64x2;

/// What a number follows from: the drive, and each state.
type Row = [Quad; 1 + STATES];
/// Place of the drive in a row; the states come after it.
const DRIVE: usize = 0;
/// The states, and the total current.
const NUMBERS: usize = TOTAL + 1;

/// The flows of several stacks.
#[derive(Clone, Debug, Default)]
pub(crate) struct Flows {
    rows: [Row; NUMBERS],
    /// Of each conversion in a step the voltage and the current.
    looks: Vec<[Row; 2]>,
    /// Which of a stack's flows each lane has, from one.
    remade: [Option<u64>; LANES],
}

/// The states of several stacks and their total currents at the end of a step, and at its beginning.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct States {
    x: [Quad; NUMBERS],
    before: [Quad; NUMBERS],
}

/// The same in registers.
#[derive(Clone, Copy)]
pub(crate) struct StatesIn<F: Four> {
    x: [Wide<F>; NUMBERS],
    before: [Wide<F>; NUMBERS],
}

/// The pair of a flow, and the place in it, of a state or of the total current.
fn place(state: usize) -> (usize, usize) {
    (state / 2, state % 2)
}

impl Flows {
    /// Brings a lane to the present flow of its stack.
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

    /// How many conversions there are in a step.
    #[inline(always)]
    pub(crate) fn conversions(&self) -> usize {
        self.looks.len()
    }

    /// Moves by one step with the drives held.
    #[inline(always)]
    pub(crate) fn advance<F: Four>(&self, states: &mut StatesIn<F>, volts: Wide<F>) {
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

    /// Voltage and current at a conversion within the step just made.
    #[inline(always)]
    pub(crate) fn look<F: Four>(&self, conversion: usize, states: &StatesIn<F>, volts: Wide<F>) -> [Wide<F>; 2] {
        let [v, i] = &self.looks[conversion];
        [response(v, &states.before, volts), response(i, &states.before, volts)]
    }
}

/// The amplifier's states, on which the stack does not act back. Here and below no closure and no adapter is between the registers and their
/// instructions: what is not inlined is not compiled for them.
#[inline(always)]
fn amplified<F: Four>(row: &Row, x: &[Wide<F>; NUMBERS], volts: Wide<F>) -> Wide<F> {
    let four = volts.four();
    row[DRIVE].wide(four) * volts + row[1 + E].wide(four) * x[E] + row[1 + D].wide(four) * x[D]
}

#[inline(always)]
fn response<F: Four>(row: &Row, x: &[Wide<F>; NUMBERS], volts: Wide<F>) -> Wide<F> {
    let four = volts.four();
    let amplifier = amplified(row, x, volts);
    amplifier + row[1 + V0].wide(four) * x[V0] + row[1 + I].wide(four) * x[I] + row[1 + VC].wide(four) * x[VC]
}

impl<F: Four> StatesIn<F> {
    /// Puts them into memory.
    #[inline(always)]
    pub(crate) fn stored(&self) -> States {
        let mut states = States::default();
        for n in 0..NUMBERS {
            (states.x[n], states.before[n]) = (self.x[n].quad(), self.before[n].quad());
        }
        states
    }

    /// Voltage at the stack, V.
    #[inline(always)]
    pub(crate) fn voltage(&self) -> Wide<F> {
        self.x[V0]
    }

    /// Motional current of the working mode, A.
    #[inline(always)]
    pub(crate) fn motional_current(&self) -> Wide<F> {
        self.x[I]
    }

    /// Voltage of the motional capacitor, V.
    #[inline(always)]
    pub(crate) fn motional_voltage(&self) -> Wide<F> {
        self.x[VC]
    }
}

impl States {
    /// Takes the state of a stack.
    pub(crate) fn take(&mut self, lane: usize, stack: &Stack) {
        self.x.iter_mut().enumerate().for_each(|(n, quad)| quad[lane] = stack.state(n));
    }

    /// Gives a stack its state, which the last step has led to with its drive held at `volts`.
    pub(crate) fn give_back(&self, lane: usize, stack: &mut Stack, volts: f64) {
        for (n, quad) in self.before.iter().enumerate() {
            let (pair, number) = place(n);
            stack.x[pair].as_mut_array()[number] = quad[lane];
        }
        stack.advance(&stack.held(volts), 0.0);
        debug_assert!((0..NUMBERS).all(|n| stack.state(n) == self.x[n][lane]), "a lane is what its stack is alone");
    }

    /// Takes them into registers.
    #[inline(always)]
    pub(crate) fn wide<F: Four>(&self, four: F) -> StatesIn<F> {
        let zero = Wide::splat(four, 0.0);
        let mut states = StatesIn { x: [zero; NUMBERS], before: [zero; NUMBERS] };
        for n in 0..NUMBERS {
            (states.x[n], states.before[n]) = (self.x[n].wide(four), self.before[n].wide(four));
        }
        states
    }

    /// Which of them have not moved in the last step, as [`Stack::is_still`] says it.
    pub(crate) fn are_still(&self) -> [bool; LANES] {
        std::array::from_fn(|lane| {
            let pairs = self.x.iter().zip(&self.before).map(|(x, before)| (x[lane], before[lane]));
            let (moved, largest) = pairs
                .fold((0.0f64, 0.1f64), |(moved, largest), (x, before)| (moved.max((x - before).abs()), largest.max(x.abs())));
            moved <= STILL * largest
        })
    }
}
