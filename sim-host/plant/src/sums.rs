//! Sums over the steps of one block.

use crate::quad::{Quad, Registers, Wide};
use crate::stack::Stack;

/// Sums over the steps of a block.
#[derive(Clone, Debug)]
pub(super) struct Sums {
    pub(super) lost: f64,
    pub(super) current_peak: f64,
    /// Sum of the power into the further modes, W.
    pub(super) further_supplied: f64,
    /// Sum of the power lost in the further modes, W.
    pub(super) further_lost: f64,
    pub(super) in_phase: f64,
    pub(super) quadrature: f64,
    pub(super) friction: f64,
    pub(super) friction_on_tip: f64,
    pub(super) friction_min: f64,
    pub(super) friction_max: f64,
    /// Sum of the squares of the voltage, V^2.
    pub(super) voltage_square: f64,
}

/// Friction in one step.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct StepFriction {
    /// Mean friction, N.
    pub(super) mean_n: f64,
    /// Work on the tip, J.
    pub(super) work_j: f64,
    /// `true` if the friction at the end differs from that at the beginning.
    pub(super) changed: bool,
}

/// Result of one step.
///
/// Absent parts are zero, not an `Option`: the compiler multiplies the payload before it tests the
/// flag, and an unset payload is often a subnormal number, which costs 150 cycles.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Step {
    /// Friction; zero without a contact.
    pub(super) friction: StepFriction,
    /// Voltage at the stack at the end, V.
    pub(super) voltage: f64,
    /// Current of the working mode at the end, A.
    pub(super) current: f64,
    /// Voltage of the working mode's capacitor at the end, V.
    pub(super) motional_voltage: f64,
    /// Sum of the currents of the further modes, A, and power lost in them, W; zero without such
    /// modes.
    pub(super) further: (f64, f64),
}

impl Step {
    /// Reads the state of a stack after a step.
    #[inline(always)]
    pub(super) fn from_stack(stack: &Stack, friction: StepFriction) -> Self {
        Step {
            friction,
            voltage: stack.voltage(),
            current: stack.motional_current(),
            motional_voltage: stack.motional_voltage(),
            further: stack.further(),
        }
    }
}

impl Sums {
    pub(super) fn new() -> Self {
        Sums {
            lost: 0.0,
            current_peak: 0.0,
            further_supplied: 0.0,
            further_lost: 0.0,
            in_phase: 0.0,
            quadrature: 0.0,
            friction: 0.0,
            friction_on_tip: 0.0,
            friction_min: f64::INFINITY,
            friction_max: f64::NEG_INFINITY,
            voltage_square: 0.0,
        }
    }

    /// Adds a step.
    #[inline(always)]
    pub(super) fn add(&mut self, step: &Step) {
        let Step {
            friction: StepFriction { mean_n: mean, work_j, .. },
            voltage: v,
            current: i,
            further: (further, further_lost),
            ..
        } = *step;
        self.friction += mean;
        self.friction_on_tip += work_j;
        // Not f64::min, which handles NaN and costs three times as much.
        self.friction_min = if mean < self.friction_min { mean } else { self.friction_min };
        self.friction_max = if mean > self.friction_max { mean } else { self.friction_max };
        self.in_phase += v * i;
        self.quadrature += v * step.motional_voltage;
        self.lost += i * i;
        self.current_peak = if i.abs() > self.current_peak { i.abs() } else { self.current_peak };
        self.voltage_square += v * v;
        self.further_supplied += v * further;
        self.further_lost += further_lost;
    }
}

/// Batched sums of several stacks without contact and further modes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct BatchSums {
    lost: Quad,
    current_peak: Quad,
    in_phase: Quad,
    quadrature: Quad,
}

/// Batched sums in registers.
#[derive(Clone, Copy)]
pub(super) struct BatchSumsIn<F: Registers> {
    lost: Wide<F>,
    current_peak: Wide<F>,
    in_phase: Wide<F>,
    quadrature: Wide<F>,
}

impl BatchSums {
    /// Loads the sums into registers.
    #[inline(always)]
    pub(super) fn wide<F: Registers>(&self, four: F) -> BatchSumsIn<F> {
        BatchSumsIn {
            lost: self.lost.wide(four),
            current_peak: self.current_peak.wide(four),
            in_phase: self.in_phase.wide(four),
            quadrature: self.quadrature.wide(four),
        }
    }

    /// Copies the sums of a lane to its stack, which has none of its own yet.
    pub(super) fn give(&self, lane: usize, sums: &mut Sums) {
        (sums.lost, sums.current_peak) = (self.lost[lane], self.current_peak[lane]);
        (sums.in_phase, sums.quadrature) = (self.in_phase[lane], self.quadrature[lane]);
    }
}

impl<F: Registers> BatchSumsIn<F> {
    /// Adds a step of each stack, as in [`Sums::add`].
    #[inline(always)]
    pub(super) fn add(&mut self, v: Wide<F>, i: Wide<F>, motional_voltage: Wide<F>) {
        self.in_phase = self.in_phase + v * i;
        self.quadrature = self.quadrature + v * motional_voltage;
        self.lost = self.lost + i * i;
        self.current_peak = i.abs().larger(self.current_peak);
    }

    /// Stores the sums in memory.
    #[inline(always)]
    pub(super) fn stored(&self) -> BatchSums {
        BatchSums {
            lost: self.lost.quad(),
            current_peak: self.current_peak.quad(),
            in_phase: self.in_phase.quad(),
            quadrature: self.quadrature.quad(),
        }
    }
}
