//! The case that is advised on: a stack, and the sensors and the amplifier around it, as a scene of their own.

use plant::circuit::Circuit;
use plant::circuit_of;
use scene::load::{LoadError, Loaded, load_text};
use scene::resolved::resolved_toml;
use scene::{Amplifier, Bvd, Controller, Driven, Scene, Sensors, Stack, Tracking, TrackingMode, Transducer};

/// Largest error of the nominal values: the resonance and the inductance relative, Q by a factor.
pub const NOMINAL_ERROR: Spread = Spread { resonance: 0.02, q: 2.0, lm: 0.1 };
/// Coupling that a stack can have.
const COUPLING: std::ops::RangeInclusive<f64> = 1e-4..=0.99;
/// Digits with which nominal values are written.
const DIGITS: i32 = 4;

/// Half widths of the errors of the nominal values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Error of the series resonance, relative.
    pub resonance: f64,
    /// Error of Q, a factor.
    pub q: f64,
    /// Error of the motional inductance, relative.
    pub lm: f64,
}

/// A transducer by its numbers, as telemetry or a report print them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Numbers {
    /// Series resonance of the stack, Hz.
    pub frequency_hz: f64,
    /// Quality factor of the stack.
    pub q: f64,
    /// Clamped capacitance of the stack, F.
    pub c0_f: f64,
    /// Motional inductance of the stack, H.
    pub lm_h: f64,
}

/// What is asked for beside the transducer; nothing keeps what the scene says.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wishes {
    /// Peak drive voltage, V.
    pub volts: Option<f64>,
    /// Noise of a conversion, LSB rms.
    pub noise_lsb: Option<f64>,
    /// Samples in a block; without it, that is advised, too.
    pub block_samples: Option<u16>,
}

/// Why nothing can be advised.
#[derive(Debug, thiserror::Error)]
pub enum CaseError {
    /// The scene has no controller.
    #[error(
        "`{0}` is a contact study: it drives no transducer. Name a scene with [controller] and [stack]; `sim-host list` lists them"
    )]
    NoController(String),
    /// The scene has a motor.
    #[error("`{0}` drives the stator of a motor, whose two modes this advice does not know. Name a scene with a [stack]")]
    Stator(String),
    /// The numbers contradict each other.
    #[error(
        "the numbers contradict each other: at {frequency_hz} Hz, Lm = {lm_h:e} H rings with Cm = {cm_f:.3e} F, which with C0 = {c0_f:e} F is a \
         coupling of {coupling:.4}; a transducer has 0.0001 to 0.99. Check the units: farads and henries"
    )]
    Coupling {
        /// Series resonance, Hz.
        frequency_hz: f64,
        /// Motional inductance, H.
        lm_h: f64,
        /// Motional capacitance, F.
        cm_f: f64,
        /// Clamped capacitance, F.
        c0_f: f64,
        /// Coupling.
        coupling: f64,
    },
    /// What comes out is no scene.
    #[error(transparent)]
    Scene(#[from] LoadError),
}

/// A case that is advised on.
#[derive(Clone, Debug)]
pub struct Case {
    /// The scene: one stack, driven continuously at its resonance and followed by the observer, with the true values as nominal ones.
    scene: Scene,
    /// As asked for, V.
    pub asked_v: f64,
    /// Samples in a block as they were, and whether they must stay.
    pub block_samples: (u16, bool),
    /// Further modes that the scene knows of.
    pub modes: usize,
}

/// The parts of a case, as its equations need them.
#[derive(Clone, Copy, Debug)]
pub struct Parts<'a> {
    /// Settings of the controller.
    pub controller: &'a Controller,
    /// Amplifier between DAC and stack.
    pub amplifier: &'a Amplifier,
    /// Converters of voltage and current.
    pub sensors: &'a Sensors,
    /// Equivalent circuit of the stack.
    pub circuit: Circuit,
}

impl Case {
    /// A case from a scene, whose transducer the numbers replace.
    pub fn of(loaded: &Loaded, numbers: Option<Numbers>, wishes: &Wishes) -> Result<Self, CaseError> {
        let Some(driven) = loaded.scene.driven() else { return Err(CaseError::NoController(loaded.name.clone())) };
        let Transducer::Stack(stack, _) = driven.transducer else { return Err(CaseError::Stator(loaded.name.clone())) };
        let circuit = numbers.map_or_else(|| circuit_of(&driven), |numbers| numbers.circuit(stack.bvd.force_factor_n_per_v));
        let Circuit { cm_f, c0_f, lm_h, .. } = circuit;
        let coupling = (cm_f / (c0_f + cm_f)).sqrt();
        if !COUPLING.contains(&coupling) {
            return Err(CaseError::Coupling { frequency_hz: circuit.series_resonance_hz(), lm_h, cm_f, c0_f, coupling });
        }
        let drive = &driven.controller.drive;
        let asked_v = wishes.volts.or(drive.amplitude_v).or(drive.scan_v).unwrap_or(1.0);
        let most_v = driven.controller.limits.voltage_v.min(driven.amplifier.full_scale_v);
        let modes = if numbers.is_some() { 0 } else { stack.mode.len() };
        let block_samples = wishes.block_samples.unwrap_or(driven.controller.block_samples);
        let mut scene = alone(&loaded.scene, driven, circuit);
        if let (Some(sensors), Some(noise_lsb)) = (&mut scene.sensors, wishes.noise_lsb) {
            sensors.noise_lsb = noise_lsb;
        }
        let case = Case { scene, asked_v, block_samples: (block_samples, wishes.block_samples.is_some()), modes };
        // What is too much for a scene is advised against later.
        case.with(block_samples, asked_v.min(most_v))
    }

    /// The case with another length of a block and another voltage.
    pub fn with(&self, block_samples: u16, volts: f64) -> Result<Self, CaseError> {
        self.changed(|controller| {
            controller.block_samples = block_samples;
            controller.drive.amplitude_v = Some(volts);
        })
    }

    /// The case with another window and another bandwidth of the fall-back loop.
    pub fn tracking(&self, span: f64, bandwidth_hz: f64) -> Result<Self, CaseError> {
        self.changed(|controller| (controller.tracking.span, controller.tracking.bandwidth_hz) = (span, bandwidth_hz))
    }

    fn changed(&self, change: impl FnOnce(&mut Controller)) -> Result<Self, CaseError> {
        let mut scene = self.scene.clone();
        if let Some(controller) = &mut scene.controller {
            change(controller);
        }
        // Read again, so that what a user has given by hand is judged like any scene.
        let scene = load_text("the advised scene", &resolved_toml(&scene), &[])?.scene;
        Ok(Case { scene, ..self.clone() })
    }

    /// The scene of the case.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The scene as one that is driven.
    pub fn driven(&self) -> Option<Driven<'_>> {
        self.scene.driven()
    }

    /// The parts of the case. They are never `None`: the case was made of them.
    pub fn parts(&self) -> Option<Parts<'_>> {
        let driven = self.scene.driven()?;
        let (controller, amplifier, sensors) = (driven.controller, driven.amplifier, driven.sensors);
        Some(Parts { controller, amplifier, sensors, circuit: circuit_of(&driven) })
    }
}

impl Parts<'_> {
    /// Length of a block, s.
    pub fn block_s(&self) -> f64 {
        f64::from(self.controller.block_samples) / self.sensors.sample_hz
    }

    /// Peak drive voltage, V.
    pub fn volts(&self) -> f64 {
        self.controller.drive.amplitude_v.unwrap_or_default()
    }
}

impl Numbers {
    fn circuit(&self, force_factor_n_per_v: f64) -> Circuit {
        let omega = std::f64::consts::TAU * self.frequency_hz;
        let (c0_f, lm_h) = (self.c0_f, self.lm_h);
        Circuit { c0_f, cm_f: 1.0 / (omega * omega * lm_h), lm_h, rm_ohm: omega * lm_h / self.q, force_factor_n_per_v }
    }
}

/// The scene with this stack alone: nothing rubs on it, nothing changes on the way, and nothing is run beside it.
fn alone(scene: &Scene, driven: Driven<'_>, circuit: Circuit) -> Scene {
    let Circuit { c0_f, cm_f, lm_h, force_factor_n_per_v, .. } = circuit;
    let bvd = Bvd {
        c0_f,
        ct_f: None,
        cm_f: None,
        lm_h: None,
        rm_ohm: None,
        series_resonance_hz: Some(circuit.series_resonance_hz()),
        parallel_resonance_hz: None,
        q: Some(circuit.q()),
        coupling: Some((cm_f / (c0_f + cm_f)).sqrt()),
        force_factor_n_per_v,
        loss_tangent: 0.0,
        temperature_hz_per_k: 0.0,
        temperature_c0_per_k: 0.0,
        duffing_hz_per_a2: 0.0,
        temperature_rm_per_k: 0.0,
        temperature_force_factor_per_k: 0.0,
        amplitude_rm_per_a2: 0.0,
        amplitude_rm_most: None,
    };
    let mut controller = driven.controller.clone();
    let drive = &mut controller.drive;
    drive.frequency_hz = rounded(circuit.series_resonance_hz());
    (drive.velocity_m_per_s, drive.scan_v, drive.detune_hz) = (None, None, 0.0);
    drive.shape = scene::Shape::Sine;
    (drive.noise_low_hz, drive.noise_high_hz, drive.lanes) = (None, None, 1);
    controller.phasing = scene::Phasing::default();
    controller.tracking = Tracking {
        mode: TrackingMode::Observer,
        nominal_q: rounded(circuit.q()),
        nominal_lm_h: Some(rounded(lm_h)),
        nominal_c0_f: Some(rounded(c0_f)),
        ..controller.tracking
    };
    (controller.sweep, controller.burst) = (None, None);
    Scene {
        title: "The advised settings".into(),
        source: String::new(),
        notes: Vec::new(),
        runs: 1,
        controller: Some(controller),
        stack: Some(Stack { temperature_k: 0.0, thermal: None, bvd, mode: Vec::new() }),
        contact: None,
        rig: None,
        disturbance: Vec::new(),
        fault: Vec::new(),
        vary: Vec::new(),
        grid: None,
        comparison: None,
        trace: None,
        expect: Vec::new(),
        ..scene.clone()
    }
}

/// With as many digits as a nominal value has.
pub fn rounded(value: f64) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return value;
    }
    // By way of text, so that it is the number nearest to what is printed.
    format!("{value:.*e}", DIGITS as usize - 1).parse().unwrap_or(value)
}
