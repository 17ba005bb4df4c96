//! The simulated plant: everything between DAC and ADC.
//!
//! The plant is one of: a stack with the surface on which its tip slides ([`driven_stack`];
//! [`webbing`] for a belt under a horn, [`carriage`] for a body that slides under forces); the
//! stator of a travelling-wave motor with its rotor ([`motor`]); a stack and the seat belt whose
//! friction it lowers ([`dring`]). A run costs only the plant that its scene names.
//!
//! The truth ([`Truth`]) never passes through [`Analog`]: the controller receives only codes.
//!
//! # Example
//!
//! One block of a drive into the stack of a built-in scene (`scene` is the package
//! `sonoglide-scene`):
//!
//! ```
//! use firmware::seam::block::{DriveBlock, SenseBlock};
//! use hal_mock::analog::Analog;
//! use scene::load::load;
//! use sonoglide_plant::Plant;
//!
//! let loaded = load("lock", &[]).unwrap();
//! let mut plant = Plant::new(&loaded.scene.driven().unwrap());
//! let mut drive = DriveBlock::silent(1, 32, 2048);
//! drive.lanes[0].iter_mut().enumerate().for_each(|(n, code)| *code = if n % 25 < 12 { 2148 } else { 1948 });
//! let mut sense = SenseBlock::default();
//! plant.exchange(&drive, &mut sense);
//! assert_eq!(sense.v.len(), 32); // received by the controller
//! assert!(plant.truth().tip_velocity_m_per_s != 0.0); // hidden from it
//! ```
#![forbid(unsafe_code)]

pub mod belt_motion;
pub mod breakage;
pub mod carriage;
pub mod circuit;
pub mod converter;
pub mod dahl;
pub mod delay;
pub mod disturbance;
pub mod dring;
pub mod driven_stack;
pub mod elements;
pub mod encoder;
pub mod energy;
pub mod expansion;
pub mod force_channel;
pub mod load_cell;
pub mod motor;
pub mod network;
mod noise;
pub mod parts;
pub mod quad;
pub mod shift;
pub mod sliding;
pub mod stack;
pub mod step_flow;
pub mod stream;
pub mod stribeck;
mod sums;
pub mod thermal;
pub mod timing;
pub mod truth;
pub mod webbing;

#[cfg(test)]
mod tests;

use firmware::seam::block::{DriveBlock, SenseBlock};
use hal_mock::analog::Analog;

use crate::circuit::Circuit;
use crate::dring::crash::{Crash, Playback};
use crate::driven_stack::DrivenStack;
use crate::energy::Energy;
use crate::motor::Motor;
use crate::motor::model::Model;
use crate::shift::Shift;
use crate::truth::{MotorTruth, Sample, Truth};
use scene::{DisturbedKey, Driven, Transducer};

/// Returns the circuit of a scene's transducer at the beginning of its run. For a stator, this is
/// the circuit at its first lane while all lanes play.
pub fn circuit_of(scene: &Driven) -> Circuit {
    match scene.transducer {
        Transducer::Stack(stack, _) => {
            let rest = Circuit::from_bvd(&stack.bvd);
            let shifted = Shift::from_bvd(&stack.bvd).map_or(rest, |shift| shift.apply(&rest, stack.temperature_k, 0.0));
            webbing::damped(shifted, scene)
        }
        Transducer::Stator(stator, _) => {
            Model::from_stator(stator).circuit(scene.controller.drive.lanes, scene.controller.phasing.direction)
        }
    }
}

/// The simulated plant between DAC and ADC.
#[derive(Clone, Debug)]
pub enum Plant {
    /// A plant around a piezo stack.
    Stack(Box<DrivenStack>),
    /// A plant around the stator of a motor.
    Motor(Box<Motor>),
    /// A plant around a stack whose drive lowers the friction of a seat belt.
    Crash(Box<Crash>),
}

/// Evaluates the same expression for any plant.
macro_rules! of_any {
    ($plant:expr, $inner:ident => $value:expr) => {
        match $plant {
            Plant::Stack($inner) => $value,
            Plant::Motor($inner) => $value,
            Plant::Crash($inner) => $value,
        }
    };
}

impl Plant {
    /// Creates the plant of a scene, at rest.
    pub fn new(scene: &Driven) -> Self {
        match scene.transducer {
            Transducer::Stack(stack, sliding) => {
                let stack = DrivenStack::new(scene, stack, sliding);
                match scene.dring() {
                    Some(dring) => Plant::Crash(Box::new(Crash::new(scene, stack, dring))),
                    None => Plant::Stack(Box::new(stack)),
                }
            }
            Transducer::Stator(stator, rotor) => Plant::Motor(Box::new(Motor::new(scene, stator, rotor))),
        }
    }

    /// Changes a value from the next block on, like a disturbance of the scene. Only a plant around
    /// a stack has such values.
    pub fn set(&mut self, key: DisturbedKey, value: f64) {
        if let Plant::Stack(stack) = self {
            stack.set(key, value);
        }
    }

    /// Returns the truth about the last block.
    pub fn truth(&self) -> &Truth {
        of_any!(self, plant => plant.truth())
    }

    /// Returns the part of the truth about the last block that only a motor has.
    pub fn motor_truth(&self) -> Option<&MotorTruth> {
        match self {
            Plant::Motor(motor) => Some(motor.motor_truth()),
            Plant::Stack(_) | Plant::Crash(_) => None,
        }
    }

    /// Returns the circuit that the sense channels measure, as it is now.
    pub fn circuit(&self) -> Circuit {
        of_any!(self, plant => plant.circuit())
    }

    /// Returns the energy budget since the beginning.
    pub fn energy(&self) -> Energy {
        of_any!(self, plant => plant.energy())
    }

    /// Returns the duration of one sample, s.
    pub fn sample_s(&self) -> f64 {
        of_any!(self, plant => plant.sample_s())
    }

    /// Returns the result of a crash, if the plant is one.
    pub fn playback(&self) -> Option<&Playback> {
        match self {
            Plant::Crash(crash) => Some(crash.playback()),
            Plant::Stack(_) | Plant::Motor(_) => None,
        }
    }

    /// Returns the number of states that are integrated in time.
    pub fn states(&self) -> usize {
        of_any!(self, plant => plant.states())
    }

    /// Starts or stops recording blocks sample by sample.
    pub fn keep_samples(&mut self, keep: bool) {
        of_any!(self, plant => plant.keep_samples(keep));
    }

    /// Returns the samples of the last block, if they are recorded.
    pub fn samples(&self) -> &[Sample] {
        of_any!(self, plant => plant.samples())
    }
}

impl Analog for Plant {
    fn exchange(&mut self, drive: &DriveBlock, sense: &mut SenseBlock) {
        of_any!(self, plant => plant.exchange(drive, sense));
    }
}
