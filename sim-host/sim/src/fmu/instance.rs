//! An instance of a unit: its present values, and its steps.

use firmware::seam::block::{Amplitude, BeltSense, DriveBlock, Gate, SenseBlock, SlowSense, Target};
use scene::load::{Loaded, load_text};
use scene::{DisturbedKey, Driven};

use super::variables::{moved, reference};
use super::{Causality, Kind, SCENE_FILE, Value, Variable, token, variables};
use crate::run::RunError;
use crate::stepping::{Coupled, OrderError, Stepping};

/// Largest relative difference of a step from the fixed one.
const STEP_TOLERANCE_REL: f64 = 1e-9;
/// Reference of the time.
const TIME: u32 = 0;
/// Part of a block by which a step may end early: round-off of the time.
const BLOCK_TOLERANCE: f64 = 1e-6;

/// Reason that a unit cannot be created, set or advanced.
#[derive(Debug, thiserror::Error)]
pub enum StepError {
    /// The scene of the unit is invalid.
    #[error("the scene of the unit is not valid: {0}")]
    Scene(String),
    /// The token is not that of the scene and of this version.
    #[error("the description does not belong to this library and its scene: export the unit again")]
    Token,
    /// The firmware refuses the settings.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The step is another one than the unit's.
    #[error("a step of {given} s: this unit has a fixed step of {fixed} s")]
    Step {
        /// Given step, s.
        given: f64,
        /// Step of the unit, s.
        fixed: f64,
    },
    /// There is no such variable, or it has another type.
    #[error("there is no variable {0} of this type")]
    Unknown(u32),
    /// An output cannot be set.
    #[error("`{0}` is not an input")]
    NotAnInput(&'static str),
    /// An array has another number of values.
    #[error("`{name}` has {fixed} values, not {given}")]
    Length {
        /// Name of the variable.
        name: &'static str,
        /// Given number of values.
        given: usize,
        /// Number of values of the variable.
        fixed: usize,
    },
    /// A value is not possible.
    #[error("`{0}` cannot be {1}")]
    Value(&'static str, f64),
    /// The controller refuses an order.
    #[error(transparent)]
    Order(#[from] OrderError),
}

/// Controller, alone or as a board.
enum Part {
    Board(Box<Coupled>),
    Controller(Box<Stepping>, DriveBlock),
}

/// Instance of a unit.
pub struct Instance {
    loaded: Loaded,
    kind: Kind,
    part: Part,
    variables: Vec<Variable>,
    values: Vec<Value>,
    moved: Option<[(DisturbedKey, f64); 2]>,
    step_s: f64,
    /// End of the last step, s.
    time: Value,
}

impl Instance {
    /// Creates an instance from the text of its scene; the token tells its kind.
    ///
    /// # Errors
    /// If the scene is invalid, or the token belongs to another one.
    pub fn new(text: &str, given: &str) -> Result<Self, StepError> {
        let kind = Kind::ALL.into_iter().find(|kind| token(text, *kind) == given).ok_or(StepError::Token)?;
        let loaded = load_text(SCENE_FILE, text, &[]).map_err(|error| StepError::Scene(error.to_string()))?;
        Self::of(loaded, kind)
    }

    fn of(loaded: Loaded, kind: Kind) -> Result<Self, StepError> {
        let scene = loaded.scene.driven().ok_or_else(|| StepError::Scene("the firmware does not drive it".into()))?;
        let variables = variables(&scene, kind);
        let instance = Instance {
            part: Part::new(&scene, kind)?,
            values: variables.iter().map(|variable| variable.start.clone()).collect(),
            moved: moved(&scene),
            step_s: kind.step_s(&scene),
            time: Value::Float(0.0),
            variables,
            kind,
            loaded,
        };
        Ok(instance)
    }

    /// Returns the instance to its start.
    ///
    /// # Errors
    /// Never, once the instance exists.
    pub fn reset(&mut self) -> Result<(), StepError> {
        *self = Self::of(self.loaded.clone(), self.kind)?;
        Ok(())
    }

    /// Returns the value of a variable.
    pub fn get(&self, reference: u32) -> Option<&Value> {
        if reference == TIME { Some(&self.time) } else { Some(&self.values[self.index(reference)?]) }
    }

    /// Returns the end of the last step, s.
    pub fn time_s(&self) -> f64 {
        if let Value::Float(time_s) = self.time { time_s } else { 0.0 }
    }

    fn index(&self, reference: u32) -> Option<usize> {
        self.variables.iter().position(|variable| variable.reference == reference)
    }

    /// Sets an input; an order to the controller acts from the next block on.
    ///
    /// # Errors
    /// If there is no input of this type, or the value is not possible.
    pub fn set(&mut self, reference: u32, value: Value) -> Result<(), StepError> {
        let index = self.index(reference).ok_or(StepError::Unknown(reference))?;
        let Variable { name, causality, start, .. } = &self.variables[index];
        if std::mem::discriminant(start) != std::mem::discriminant(&value) {
            return Err(StepError::Unknown(reference));
        }
        if *causality != Causality::Input {
            return Err(StepError::NotAnInput(name));
        }
        match (&value, start) {
            (Value::Codes(given), Value::Codes(fixed)) if given.len() != fixed.len() => {
                return Err(StepError::Length { name, given: given.len(), fixed: fixed.len() });
            }
            (Value::Float(number), _) if !number.is_finite() => return Err(StepError::Value(name, *number)),
            _ => {}
        }
        // Until an input changes, the scene gives the orders.
        if self.values[index] != value {
            self.order(reference, name, &value)?;
            self.values[index] = value;
        }
        Ok(())
    }

    /// Carries out the change of an input.
    fn order(&mut self, input: u32, name: &'static str, value: &Value) -> Result<(), StepError> {
        if let (reference::LOAD | reference::SPEED, Value::Float(number)) = (input, value) {
            let [load, speed] = self.moved.ok_or(StepError::Unknown(input))?;
            let (key, _) = if input == reference::LOAD { load } else { speed };
            if input == reference::LOAD && *number < 0.0 {
                return Err(StepError::Value(name, *number));
            }
            if let Part::Board(board) = &mut self.part {
                board.playing().set(key, *number);
            }
            return Ok(());
        }
        let controller = match &mut self.part {
            Part::Board(board) => &mut board.controller,
            Part::Controller(controller, _) => controller,
        };
        match (input, value) {
            (reference::ON, Value::Boolean(on)) => controller.gate(if *on { Gate::On } else { Gate::Off }),
            (reference::AMPLITUDE, Value::Float(volts)) => controller.set_amplitude(Amplitude::Volts(*volts as f32))?,
            (reference::FRICTION_TARGET, Value::Float(ratio)) => controller.friction(Target::Ratio(*ratio as f32))?,
            _ => {}
        }
        Ok(())
    }

    /// Advances by one step from a time, s.
    ///
    /// # Errors
    /// If the step is not the fixed one.
    pub fn step(&mut self, from_s: f64, step_s: f64) -> Result<(), StepError> {
        let fixed = self.step_s;
        if !((step_s - fixed).abs() <= STEP_TOLERANCE_REL * fixed) {
            return Err(StepError::Step { given: step_s, fixed });
        }
        if let Part::Board(board) = &mut self.part {
            let until_s = from_s + step_s - BLOCK_TOLERANCE * board.controller.samples as f64 / board.controller.sample_hz;
            let (mut friction_n, mut tip, mut power_w, mut blocks) = (0.0, 0.0, 0.0, 0.0f64);
            while board.controller.time_s() < until_s {
                board.tick().map_err(RunError::from)?;
                let truth = board.playing().plant().truth();
                friction_n += truth.friction_mean_n;
                tip += truth.tip_velocity_m_per_s;
                power_w += truth.power_w;
                blocks += 1.0;
            }
            let hash = board.playing().drive_hash();
            if blocks > 0.0 {
                self.put(reference::FRICTION, Value::Float(friction_n / blocks));
                self.put(reference::TIP_VELOCITY, Value::Float(tip / blocks));
                self.put(reference::POWER, Value::Float(power_w / blocks));
            }
            self.put(reference::HASH, Value::Unsigned(hash));
        } else {
            let codes = |reference: u32| match self.get(reference) {
                Some(Value::Codes(codes)) => codes.iter().copied().collect(),
                _ => Default::default(),
            };
            let float = |reference: u32| match self.get(reference) {
                Some(Value::Float(value)) => Some(*value as f32),
                _ => None,
            };
            let belt = match self.get(reference::COUNTS) {
                Some(Value::Integer(counts)) => Some(BeltSense { counts: *counts, broken: false }),
                _ => None,
            };
            let (force, temperature) = (float(reference::FORCE), float(reference::TEMPERATURE));
            let slow = SlowSense { belt, force, temperature, ..SlowSense::default() };
            let sense = SenseBlock { v: codes(reference::V), i: codes(reference::I), slow };
            if let Part::Controller(controller, drive) = &mut self.part {
                controller.process(&sense, drive).map_err(RunError::from)?;
                let codes = drive.lanes.iter().flatten().copied().collect();
                let (drops_queue, listen) = (drive.drops_queue, i32::from(drive.listen));
                self.put(reference::CODES, Value::Codes(codes));
                self.put(reference::DROPS_QUEUE, Value::Boolean(drops_queue));
                self.put(reference::LISTEN, Value::Integer(listen));
            }
        }
        self.time = Value::Float(from_s + step_s);
        let report = match &self.part {
            Part::Board(board) => board.controller.report,
            Part::Controller(controller, _) => controller.report,
        };
        self.put(reference::FAULT, Value::Integer(report.fault.map_or(0, |fault| fault.code().into())));
        self.put(reference::LOCKED, Value::Boolean(report.locked));
        self.put(reference::FREQUENCY, Value::Float(report.frequency.0.into()));
        self.put(reference::FRICTION_RATIO, Value::Float(report.friction.map_or(0.0, |friction| friction.ratio.into())));
        Ok(())
    }

    fn put(&mut self, reference: u32, value: Value) {
        if let Some(index) = self.index(reference) {
            self.values[index] = value;
        }
    }
}

impl Part {
    fn new(scene: &Driven, kind: Kind) -> Result<Self, RunError> {
        Ok(match kind {
            Kind::Board => Part::Board(Box::new(Coupled::new(scene)?)),
            Kind::Controller => {
                let controller = Stepping::new(scene)?;
                let silence = controller.silence();
                Part::Controller(Box::new(controller), silence)
            }
        })
    }
}
