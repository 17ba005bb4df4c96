//! Controller and plant of a scene in the caller's time: block by block, each alone, or as a board.

use firmware::seam::block::{Amplitude, DriveBlock, Gate, Orders, Request, SenseBlock, Target};
use firmware::seam::config::FrontEnd;
use firmware::seam::telemetry::Telemetry;
use firmware::seam::units::Hertz;
use hal_mock::analog::Analog;
use hal_mock::block_clock::BlockClock;
use hal_mock::fault_injector::FaultInjector;
use hal_mock::tracer::DriveHash;
use plant::Plant;
use scene::{DisturbedKey, Driven};

use crate::processor::{Here, Lost, Processor};
use crate::run::{RunError, Script, breakable_plant};

/// Order that the controller of a scene cannot carry out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum OrderError {
    /// An amplitude is negative or not finite.
    #[error("an amplitude is a finite number, zero or more")]
    Amplitude,
    /// A detuning is not finite.
    #[error("the detuning is not a finite number")]
    Detuning,
    /// A friction target is out of its range.
    #[error("a friction ratio is from 0 to 1, and a friction force is not negative")]
    Friction,
    /// The controller does not switch friction.
    #[error("the scene has no [controller.friction]")]
    NoFriction,
}

/// The controller of a scene, with the scene's orders until the first one of the caller.
pub struct Stepping {
    here: Here,
    script: Script,
    /// While `true`, the friction steps of the scene are ordered.
    scripted: bool,
    /// Report of the last block.
    pub report: Telemetry,
    /// Conversion between codes and physical units.
    pub front_end: FrontEnd,
    /// Sampling rate of the converters, Hz.
    pub sample_hz: f64,
    /// Samples in a block.
    pub samples: usize,
    detune: Hertz,
    switches_friction: bool,
    block: u64,
}

impl Stepping {
    /// Creates the controller of a scene, with silence in its queue.
    ///
    /// # Errors
    /// If the firmware refuses the settings of the scene.
    pub fn new(scene: &Driven) -> Result<Self, RunError> {
        let config = scene::settings::config(scene);
        Ok(Stepping {
            here: Here::new(&config)?,
            script: Script::new(scene),
            scripted: true,
            report: Telemetry::default(),
            front_end: config.front_end,
            sample_hz: f64::from(config.sample_hz),
            samples: config.block_samples.into(),
            detune: Hertz(scene.controller.drive.detune_hz as f32),
            switches_friction: scene.controller.friction.is_some(),
            block: 0,
        })
    }

    /// Returns a block of silence.
    pub fn silence(&self) -> DriveBlock {
        self.here.silence()
    }

    /// Returns the time of the blocks processed so far, s.
    pub fn time_s(&self) -> f64 {
        self.block as f64 * self.samples as f64 / self.sample_hz
    }

    /// Processes one block, and overwrites the drive.
    ///
    /// # Errors
    /// Never, in this process.
    pub fn process(&mut self, sense: &SenseBlock, drive: &mut DriveBlock) -> Result<(), Lost> {
        if self.scripted {
            self.script.order_friction(self.time_s());
        }
        self.here.process_into(&self.script.orders, sense, drive, &mut self.report)?;
        self.script.follow(self.report.mode);
        self.block += 1;
        Ok(())
    }

    /// Gives an order of the caller, from the next block on. The friction steps of the scene end.
    fn change(&mut self, order: impl FnOnce(&mut Orders)) {
        let orders = &mut self.script.orders;
        orders.sequence += 1;
        orders.clear_fault = false;
        order(orders);
        self.scripted = false;
    }

    /// Orders a run with the drive always on, at an amplitude and a detuning, or as the scene.
    ///
    /// # Errors
    /// If a number is not possible.
    pub fn drive(&mut self, amplitude: Option<Amplitude>, detune_hz: Option<f32>) -> Result<(), OrderError> {
        check(amplitude)?;
        if detune_hz.is_some_and(|hz| !hz.is_finite()) {
            return Err(OrderError::Detuning);
        }
        let scene_hz = self.detune;
        self.change(|orders| {
            (orders.request, orders.gate, orders.amplitude) = (Request::Run, Gate::On, amplitude);
            orders.detune = detune_hz.map_or(scene_hz, Hertz);
            orders.attempt += 1;
        });
        Ok(())
    }

    /// Orders an amplitude in the present run, or that of the scene.
    ///
    /// # Errors
    /// If it is not possible.
    pub fn set_amplitude(&mut self, amplitude: Option<Amplitude>) -> Result<(), OrderError> {
        check(amplitude)?;
        self.change(|orders| orders.amplitude = amplitude);
        Ok(())
    }

    /// Orders the gate of the drive.
    pub fn gate(&mut self, gate: Gate) {
        self.change(|orders| orders.gate = gate);
    }

    /// Orders a friction ratio or force; the friction switch then sets the amplitude.
    ///
    /// # Errors
    /// If it is out of its range, or the controller does not switch friction.
    pub fn friction(&mut self, target: Target) -> Result<(), OrderError> {
        if !self.switches_friction {
            return Err(OrderError::NoFriction);
        }
        if !target.is_plausible() {
            return Err(OrderError::Friction);
        }
        self.change(|orders| (orders.friction, orders.amplitude) = (Some(target), None));
        Ok(())
    }

    /// Orders silence, and clears a fault if wanted.
    pub fn stop(&mut self, clear_fault: bool) {
        self.change(|orders| (orders.request, orders.clear_fault) = (Request::Idle, clear_fault));
    }
}

/// Checks that an amplitude is possible.
fn check(amplitude: Option<Amplitude>) -> Result<(), OrderError> {
    match amplitude {
        Some(Amplitude::Volts(value) | Amplitude::MotionalCurrent(value)) if !(value.is_finite() && value >= 0.0) => {
            Err(OrderError::Amplitude)
        }
        _ => Ok(()),
    }
}

/// The plant of a scene, with the hash of the codes that it plays.
pub struct Playing {
    plant: FaultInjector<Plant>,
    hash: DriveHash,
}

impl Playing {
    /// Creates the plant of a scene, at rest.
    pub fn new(scene: &Driven) -> Self {
        Playing { plant: breakable_plant(scene), hash: DriveHash::default() }
    }

    /// Returns the plant.
    pub fn plant(&self) -> &Plant {
        &self.plant.inner
    }

    /// Changes a value of the plant from the next block on.
    pub fn set(&mut self, key: DisturbedKey, value: f64) {
        self.plant.inner.set(key, value);
    }

    /// Returns the hash of all codes played, as in the summary of a run.
    pub fn drive_hash(&self) -> u64 {
        self.hash.value()
    }
}

impl Analog for Playing {
    fn exchange(&mut self, drive: &DriveBlock, sense: &mut SenseBlock) {
        self.plant.exchange(drive, sense);
        self.hash.add(drive);
    }
}

/// Controller and plant of a scene as a board: codes play some blocks later.
pub struct Coupled {
    /// Controller of the board.
    pub controller: Stepping,
    clock: BlockClock<Playing>,
}

impl Coupled {
    /// Creates the board of a scene.
    ///
    /// # Errors
    /// If the firmware refuses the settings of the scene.
    pub fn new(scene: &Driven) -> Result<Self, RunError> {
        let controller = Stepping::new(scene)?;
        Ok(Coupled { clock: BlockClock::new(Playing::new(scene), &controller.silence()), controller })
    }

    /// Returns the plant of the board.
    pub fn playing(&mut self) -> &mut Playing {
        &mut self.clock.analog
    }

    /// Plays and processes one block.
    ///
    /// # Errors
    /// Never, in this process.
    pub fn tick(&mut self) -> Result<(), Lost> {
        let controller = &mut self.controller;
        self.clock.tick(|sense, drive| controller.process(sense, drive))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::{Watch, run};
    use scene::load::load;

    /// Bursts, friction steps, a motor and a belt that stops.
    #[test]
    fn a_board_plays_the_codes_of_the_run() {
        for name in ["lock", "friction-ratio", "usm", "belt-stop"] {
            let loaded = load(name, &[]).unwrap_or_else(|error| panic!("{error}"));
            let scene = loaded.scene.driven().unwrap();
            let record = run(&scene, Watch::default()).unwrap();
            let mut board = Coupled::new(&scene).unwrap();
            while board.controller.time_s() < scene.duration_s - 1e-9 {
                board.tick().unwrap();
            }
            assert_eq!(board.playing().drive_hash(), record.drive_hash, "{name}");
        }
    }

    #[test]
    fn a_changed_load_changes_the_friction() {
        let loaded = load("experiment-1", &["controller.burst.off_s=[9]".to_owned()]).unwrap();
        let scene = loaded.scene.driven().unwrap();
        let mut board = Coupled::new(&scene).unwrap();
        let mut friction_n = |set: Option<f64>| {
            if let Some(load_n) = set {
                board.playing().set(DisturbedKey::Load, load_n);
            }
            (0..3000).for_each(|_| board.tick().unwrap());
            board.playing().plant().truth().friction_mean_n
        };
        let before = friction_n(None);
        let after = friction_n(Some(20.0));
        assert!(before > 0.0 && after > 1.5 * before, "{before} {after}");
    }
}
