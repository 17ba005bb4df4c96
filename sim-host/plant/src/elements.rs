//! Elements of a stack during a run, as changed by the scene's disturbances, breakages, temperature
//! and amplitude. A stack that heats itself has its own temperature; others have that of their
//! surroundings.

use crate::breakage::{Breakage, SHORT_OHM, Scheduled};
use crate::circuit::Branch;
use crate::circuit::Circuit;
use crate::parts::Parts;
use crate::shift::Shift;
use crate::stack::Stack;
use crate::thermal::{Body, Losses};
use crate::truth::HeatTruth;
use crate::webbing::{damped, with_damping};
use scene::{DisturbedKey, Driven, Fault, FaultKind};

/// The quantities from which a stack's elements are computed.
#[derive(Clone, Debug)]
pub struct Elements {
    /// The working mode at rest and at ambient temperature.
    rest: Circuit,
    shift: Option<Shift>,
    /// Temperature of the surroundings over ambient, K.
    surroundings_k: f64,
    /// Thermal model of a stack that heats itself.
    body: Option<Body>,
    breaks: Vec<Scheduled>,
    /// Further modes and leak as changed by the disturbances of a block.
    disturbed: Option<Parts>,
    /// Energy that changes of the elements have added to the stack, J.
    pub disturbed_j: f64,
}

impl Elements {
    /// Creates the elements of a scene's stack, and its parts at rest.
    pub fn new(scene: &Driven, stack: &scene::Stack) -> (Self, Parts) {
        let mut parts = Parts::from_stack(stack);
        parts.circuit = damped(parts.circuit, scene);
        let rest = parts.circuit;
        let shift = Shift::from_bvd(&stack.bvd);
        if let Some(shift) = shift {
            parts.circuit = shift.apply(&rest, stack.temperature_k, 0.0);
        }
        let block_s = f64::from(scene.controller.block_samples) / scene.sensors.sample_hz;
        let breaks = scene
            .fault
            .iter()
            .filter_map(|fault| Some(Scheduled { at_block: (fault.at_s / block_s) as u64, breakage: breakage(fault)? }));
        let elements = Elements {
            rest,
            shift,
            surroundings_k: stack.temperature_k,
            body: stack.thermal.map(|thermal| Body::new(thermal, stack.temperature_k, block_s)),
            breaks: breaks.collect(),
            disturbed: None,
            disturbed_j: 0.0,
        };
        (elements, parts)
    }

    /// Applies the disturbances, the breakages of block `block`, and the effects of temperature and
    /// amplitude to the stack, all in one update.
    pub fn begin(&mut self, block: u64, stack: &mut Stack) {
        let due = self.breaks.extract_if(.., |scheduled| scheduled.at_block <= block).map(|scheduled| scheduled.breakage);
        let mut due: Vec<Breakage> = due.collect();
        if self.body.as_mut().is_some_and(Body::take_depolarisation) {
            due.push(Breakage::Depoled);
        }
        if self.disturbed.is_none() && due.is_empty() && self.shift.is_none() {
            return;
        }
        let mut parts = self.disturbed.take().unwrap_or_else(|| stack.parts().clone());
        for breakage in due {
            parts = breakage.apply(Parts { circuit: self.rest, ..parts });
            self.rest = parts.circuit;
        }
        let shifted = |shift: Shift| shift.apply(&self.rest, self.temperature_k(), stack.oscillation_a());
        let circuit = self.shift.map_or(self.rest, shifted);
        let stored = stack.stored_j();
        stack.set(Parts { circuit, ..parts });
        self.disturbed_j += stack.stored_j() - stored;
    }

    /// Returns the temperature over ambient, K.
    fn temperature_k(&self) -> f64 {
        self.body.as_ref().map_or(self.surroundings_k, Body::temperature_k)
    }

    /// Returns `true` if the losses heat the stack.
    pub fn heats(&self) -> bool {
        self.body.is_some()
    }

    /// Ends a block of a stack that heats itself, with the losses in its motional branches and in
    /// the conductance in parallel with C0, W.
    pub fn heat(&mut self, motional_w: f64, dielectric_w: f64, stack: &Stack) {
        if let Some(body) = &mut self.body {
            let slope = |shift: Shift| shift.rm_per_k(stack.circuit(), body.temperature_k());
            let per_k = self.shift.map_or(0.0, slope);
            body.heat(&Losses { motional_w, dielectric_w, per_k }, self.surroundings_k);
        }
    }

    /// Returns the thermal state after the last block, if the stack heats itself.
    pub fn heat_truth(&self) -> Option<HeatTruth> {
        self.body.as_ref().map(Body::truth)
    }

    /// Returns the present value of a key, if it belongs to a stack.
    pub fn value(&self, key: DisturbedKey, stack: &Stack) -> Option<f64> {
        match key {
            DisturbedKey::SeriesResonance => Some(self.rest.series_resonance_hz()),
            DisturbedKey::Q => Some(self.rest.q()),
            DisturbedKey::ClampedCapacitance => Some(self.rest.c0_f),
            DisturbedKey::Temperature => Some(self.surroundings_k),
            _ => self.disturbed.as_ref().unwrap_or(stack.parts()).further.get(further(key)?).map(Branch::series_resonance_hz),
        }
    }

    /// Adds damping at the tip, N s/m, for the block that is about to begin.
    pub fn damp(&mut self, n_s_per_m: f64, stack: &Stack) {
        self.rest = with_damping(self.rest, n_s_per_m);
        self.disturbed.get_or_insert_with(|| stack.parts().clone());
    }

    /// Sets a key, if it belongs to a stack, for the block that is about to begin.
    pub fn set(&mut self, key: DisturbedKey, value: f64, stack: &Stack) {
        let mut parts = self.disturbed.take().unwrap_or_else(|| stack.parts().clone());
        match key {
            DisturbedKey::SeriesResonance => self.rest = self.rest.with_series_resonance(value),
            DisturbedKey::Q => self.rest = self.rest.with_q(value),
            DisturbedKey::ClampedCapacitance => self.rest.c0_f = value,
            DisturbedKey::Temperature => self.surroundings_k = value,
            _ => {
                if let Some(branch) = further(key).and_then(|k| parts.further.get_mut(k)) {
                    *branch = branch.with_series_resonance(value);
                }
            }
        }
        self.disturbed = Some(parts);
    }
}

/// Returns the breakage of a stack that a scene's fault causes, if any.
fn breakage(fault: &Fault) -> Option<Breakage> {
    match fault.kind {
        FaultKind::Short => Some(Breakage::Shorted(fault.ohm.unwrap_or(SHORT_OHM))),
        FaultKind::Depoled => Some(Breakage::Depoled),
        FaultKind::Cracked => Some(Breakage::Cracked),
        // Faults of the converters and around them.
        FaultKind::Open
        | FaultKind::Swapped
        | FaultKind::SensorStuck
        | FaultKind::CurrentLate
        | FaultKind::Saturation
        | FaultKind::Dropout
        | FaultKind::LateBlock
        | FaultKind::BeltStopped
        | FaultKind::EncoderStuck
        | FaultKind::EncoderLost
        | FaultKind::EncoderLies
        | FaultKind::ForceStuck
        | FaultKind::Overtemperature => None,
        // Faults of a motor.
        FaultKind::LaneOpen | FaultKind::LaneWeak | FaultKind::LaneReversed | FaultKind::LanesExchanged => None,
    }
}

/// Returns the index of the further mode that a key belongs to.
fn further(key: DisturbedKey) -> Option<usize> {
    match key {
        DisturbedKey::FurtherResonance0 => Some(0),
        DisturbedKey::FurtherResonance1 => Some(1),
        DisturbedKey::FurtherResonance2 => Some(2),
        _ => None,
    }
}
