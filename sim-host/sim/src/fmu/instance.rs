//! An instance of a unit: its present values, and its steps.

use firmware::seam::block::{Amplitude, BeltSense, DriveBlock, Gate, SenseBlock, SlowSense, Target};
use scene::load::{Loaded, load_text};
use scene::{DisturbedKey, Driven};

use super::variables::{moved, reference};
use super::{Causality, Kind, SCENE_FILE, Value, Variable, token, variables};
use crate::run::RunError;
use crate::stepping::{Coupled, OrderError, Stepping};

/// Largest relative difference of a step from the fixed one.
const STEP_TOLERANCE_REL: f64 = 1e-6;
/// Round-off of a time, relative.
const TIME_TOLERANCE_REL: f64 = 1e-15;
/// Largest load, N.
const MAX_LOAD_N: f64 = 1e6;
/// Largest sliding speed, m/s.
const MAX_SPEED_M_PER_S: f64 = 1e3;
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
    /// The step does not begin at the end of the last one.
    #[error("a step from {given} s: the last one ended at {reached} s")]
    Time {
        /// Given begin, s.
        given: f64,
        /// End of the last step, s.
        reached: f64,
    },
    /// A result is not finite.
    #[error("the step has no finite result: an input is too large")]
    NotFinite,
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
    Controller(Box<(Stepping, DriveBlock)>),
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
        if self.values[index] != value {
            let before = std::mem::replace(&mut self.values[index], value);
            if let Err(error) = self.order(reference, name) {
                self.values[index] = before;
                return Err(error);
            }
        }
        Ok(())
    }

    fn float(&self, reference: u32) -> Option<f64> {
        match self.get(reference) {
            Some(Value::Float(value)) => Some(*value),
            _ => None,
        }
    }

    /// Carries out the change of an input.
    fn order(&mut self, input: u32, name: &'static str) -> Result<(), StepError> {
        let value = self.float(input).unwrap_or_default();
        match input {
            reference::LOAD | reference::SPEED => {
                let [load, speed] = self.moved.ok_or(StepError::Unknown(input))?;
                let (key, most) = if input == reference::LOAD { (load.0, MAX_LOAD_N) } else { (speed.0, MAX_SPEED_M_PER_S) };
                if value > most || value < if input == reference::LOAD { 0.0 } else { -most } {
                    return Err(StepError::Value(name, value));
                }
                if let Part::Board(board) = &mut self.part {
                    board.playing().set(key, value);
                }
            }
            reference::GATE => {
                let gate = match self.get(input) {
                    Some(Value::Integer(0)) => Gate::Scheduled,
                    Some(Value::Integer(1)) => Gate::On,
                    Some(Value::Integer(2)) => Gate::Off,
                    Some(Value::Integer(other)) => return Err(StepError::Value(name, f64::from(*other))),
                    _ => return Ok(()),
                };
                self.controller().gate(gate);
            }
            // An amplitude replaces the friction switch; without it, a ratio is ordered.
            reference::AMPLITUDE | reference::FRICTION_TARGET => {
                let given = |reference: u32| self.float(reference).filter(|value| *value >= 0.0).map(|value| value as f32);
                match (given(reference::AMPLITUDE), given(reference::FRICTION_TARGET)) {
                    (Some(volts), _) => self.controller().set_amplitude(Some(Amplitude::Volts(volts)))?,
                    (None, Some(ratio)) => self.controller().friction(Target::Ratio(ratio))?,
                    (None, None) => self.controller().set_amplitude(None)?,
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn controller(&mut self) -> &mut Stepping {
        match &mut self.part {
            Part::Board(board) => &mut board.controller,
            Part::Controller(both) => &mut both.0,
        }
    }

    /// Advances by one step from a time, s.
    ///
    /// # Errors
    /// If the step is not the fixed one.
    pub fn step(&mut self, from_s: f64, step_s: f64) -> Result<(), StepError> {
        let (fixed, reached) = (self.step_s, self.time_s());
        // A caller computes both from times, which are rounded.
        let tolerated = STEP_TOLERANCE_REL * fixed + TIME_TOLERANCE_REL * reached;
        let is_near = |a: f64, b: f64| (a - b).abs() <= tolerated;
        if !is_near(step_s, fixed) {
            return Err(StepError::Step { given: step_s, fixed });
        }
        if !is_near(from_s, reached) {
            return Err(StepError::Time { given: from_s, reached });
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
            if !(friction_n.is_finite() && tip.is_finite() && power_w.is_finite()) {
                return Err(StepError::NotFinite);
            }
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
            let float = |reference: u32| self.float(reference).map(|value| value as f32);
            let broken = self.get(reference::BROKEN) == Some(&Value::Boolean(true));
            let belt = match self.get(reference::COUNTS) {
                Some(Value::Integer(counts)) => Some(BeltSense { counts: *counts, broken }),
                _ => None,
            };
            let (force, temperature) = (float(reference::FORCE), float(reference::TEMPERATURE));
            let slow = SlowSense { belt, force, temperature, ..SlowSense::default() };
            let sense = SenseBlock { v: codes(reference::V), i: codes(reference::I), slow };
            if let Part::Controller(both) = &mut self.part {
                let (controller, drive) = &mut **both;
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
            Part::Controller(both) => both.0.report,
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
                Part::Controller(Box::new((controller, silence)))
            }
        })
    }
}
