//! The elements of a stack on their way through a run: what the scene's disturbances say, what breaks, and what temperature and
//! amplitude make of it.

use crate::breakage::{Breakage, Scheduled};
use crate::circuit::Branch;
use crate::circuit::Circuit;
use crate::parts::Parts;
use crate::shift::Shift;
use crate::stack::Stack;
use crate::webbing::{damped, with_damping};
use scene::{DisturbedKey, Driven, FaultKind};

/// What a stack's elements are made from.
#[derive(Clone, Debug)]
pub struct Elements {
    /// The working mode at rest and at ambient temperature.
    rest: Circuit,
    shift: Option<Shift>,
    temperature_k: f64,
    breaks: Vec<Scheduled>,
    /// What the disturbances of a block have made of the further modes and the leak.
    disturbed: Option<Parts>,
    /// What changing the elements has added to the energy in the stack, J.
    pub disturbed_j: f64,
}

impl Elements {
    /// The elements of a scene's stack, and its parts at rest.
    pub fn new(scene: &Driven, stack: &scene::Stack) -> (Self, Parts) {
        let mut parts = Parts::of(stack);
        parts.circuit = damped(parts.circuit, scene);
        let rest = parts.circuit;
        let shift = Shift::of(&stack.bvd);
        if let Some(shift) = shift {
            parts.circuit = shift.apply(&rest, stack.temperature_k, 0.0);
        }
        let block_s = f64::from(scene.controller.block_samples) / scene.sensors.sample_hz;
        let breaks = scene
            .fault
            .iter()
            .filter_map(|fault| Some(Scheduled { at_block: (fault.at_s / block_s) as u64, breakage: breakage(fault.kind)? }));
        let elements = Elements {
            rest,
            shift,
            temperature_k: stack.temperature_k,
            breaks: breaks.collect(),
            disturbed: None,
            disturbed_j: 0.0,
        };
        (elements, parts)
    }

    /// Gives the stack what the disturbances have set, what breaks in block `block`, and what temperature and amplitude make of it: once
    /// for all of it.
    pub fn begin(&mut self, block: u64, stack: &mut Stack) {
        let due = self.breaks.extract_if(.., |scheduled| scheduled.at_block <= block).map(|scheduled| scheduled.breakage);
        let due: Vec<Breakage> = due.collect();
        if self.disturbed.is_none() && due.is_empty() && self.shift.is_none() {
            return;
        }
        let mut parts = self.disturbed.take().unwrap_or_else(|| stack.parts().clone());
        for breakage in due {
            parts = breakage.of(Parts { circuit: self.rest, ..parts });
            self.rest = parts.circuit;
        }
        let shifted = |shift: Shift| shift.apply(&self.rest, self.temperature_k, stack.oscillation_a());
        let circuit = self.shift.map_or(self.rest, shifted);
        let stored = stack.stored_j();
        stack.set(Parts { circuit, ..parts });
        self.disturbed_j += stack.stored_j() - stored;
    }

    /// The present value of a key, if it is one of a stack.
    pub fn value(&self, key: DisturbedKey, stack: &Stack) -> Option<f64> {
        match key {
            DisturbedKey::SeriesResonance => Some(self.rest.series_resonance_hz()),
            DisturbedKey::Q => Some(self.rest.q()),
            DisturbedKey::ClampedCapacitance => Some(self.rest.c0_f),
            DisturbedKey::Temperature => Some(self.temperature_k),
            _ => self.disturbed.as_ref().unwrap_or(stack.parts()).further.get(further(key)?).map(Branch::series_resonance_hz),
        }
    }

    /// Adds damping at the tip, N s/m, for the block that is about to begin.
    pub fn damp(&mut self, n_s_per_m: f64, stack: &Stack) {
        self.rest = with_damping(self.rest, n_s_per_m);
        self.disturbed.get_or_insert_with(|| stack.parts().clone());
    }

    /// Sets a key, if it is one of a stack, for the block that is about to begin.
    pub fn set(&mut self, key: DisturbedKey, value: f64, stack: &Stack) {
        let mut parts = self.disturbed.take().unwrap_or_else(|| stack.parts().clone());
        match key {
            DisturbedKey::SeriesResonance => self.rest = self.rest.with_series_resonance(value),
            DisturbedKey::Q => self.rest = self.rest.with_q(value),
            DisturbedKey::ClampedCapacitance => self.rest.c0_f = value,
            DisturbedKey::Temperature => self.temperature_k = value,
            _ => {
                if let Some(branch) = further(key).and_then(|k| parts.further.get_mut(k)) {
                    *branch = branch.with_series_resonance(value);
                }
            }
        }
        self.disturbed = Some(parts);
    }
}

/// What a scene's fault breaks in a stack, if it does.
fn breakage(kind: FaultKind) -> Option<Breakage> {
    match kind {
        FaultKind::Short => Some(Breakage::Shorted),
        FaultKind::Depoled => Some(Breakage::Depoled),
        FaultKind::Cracked => Some(Breakage::Cracked),
        // Of the converters and what is around them.
        FaultKind::Open
        | FaultKind::Swapped
        | FaultKind::SensorStuck
        | FaultKind::Saturation
        | FaultKind::Dropout
        | FaultKind::LateBlock
        | FaultKind::BeltStopped
        | FaultKind::EncoderStuck
        | FaultKind::EncoderLost
        | FaultKind::EncoderLies
        | FaultKind::ForceStuck
        | FaultKind::Overtemperature => None,
        // Of a motor.
        FaultKind::LaneOpen | FaultKind::LaneWeak | FaultKind::LaneReversed | FaultKind::LanesExchanged => None,
    }
}

/// Which further mode a key is of.
fn further(key: DisturbedKey) -> Option<usize> {
    match key {
        DisturbedKey::FurtherResonance0 => Some(0),
        DisturbedKey::FurtherResonance1 => Some(1),
        DisturbedKey::FurtherResonance2 => Some(2),
        _ => None,
    }
}
