//! The case that is advised on: a scene of only a stack with its sensors and amplifier.

use plant::circuit::Circuit;
use plant::circuit_of;
use scene::load::{LoadError, Loaded, load_text};
use scene::resolved::resolved_toml;
use scene::shown;
use scene::{Amplifier, Bvd, Controller, Driven, Scene, Sensors, Stack, Tracking, TrackingMode, Transducer};

/// Largest errors of the nominal values.
pub const NOMINAL_ERROR: Spread = Spread { resonance: 0.02, q: 2.0, lm: 0.1 };
/// Possible coupling of a stack.
const COUPLING_RANGE: std::ops::RangeInclusive<f64> = 1e-4..=0.99;
/// Number of digits of nominal values.
const DIGITS: i32 = 4;

/// Largest errors of nominal values, to either side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Error of the series resonance, relative.
    pub resonance: f64,
    /// Error of Q, as a factor.
    pub q: f64,
    /// Error of the motional inductance, relative.
    pub lm: f64,
}

/// Values of a transducer, as printed by telemetry or a report.
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

/// Settings in addition to the transducer; `None` keeps the value of the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wishes {
    /// Peak drive voltage, V.
    pub volts: Option<f64>,
    /// Noise of a conversion, LSB rms.
    pub noise_lsb: Option<f64>,
    /// Samples in a block; if `None`, the length is advised too.
    pub block_samples: Option<u16>,
}

/// Reason that a case cannot be advised on.
#[derive(Debug, thiserror::Error)]
pub enum CaseError {
    /// The scene has no controller.
    #[error(
        "`{0}` is a contact study and drives no transducer. Name a scene with [controller] and [stack]; `sim-host list` lists \
         them"
    )]
    NoController(String),
    /// The scene has a motor.
    #[error("`{0}` drives the stator of a motor; this advice does not support its two modes. Name a scene with a [stack]")]
    Stator(String),
    /// The numbers contradict each other.
    #[error(
        "the numbers contradict each other: at {frequency_hz} Hz, Lm = {} H resonates with Cm = {cm_f:.3e} F; with C0 = {} F \
         this is a coupling of {coupling:.4}, but a transducer has 0.0001 to 0.99. Check the units: farads and henries",
        shown(*lm_h),
        shown(*c0_f)
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
    /// The resulting scene is not valid.
    #[error(transparent)]
    Scene(#[from] LoadError),
}

/// A case that is advised on.
#[derive(Clone, Debug)]
pub struct Case {
    /// Scene of one stack, driven continuously at its resonance and tracked by the observer, with
    /// the true values as nominal ones.
    scene: Scene,
    /// Requested peak voltage, V.
    pub asked_v: f64,
    /// Original samples in a block, and `true` if this length must stay.
    pub block_samples: (u16, bool),
    /// Number of further modes in the scene.
    pub modes: usize,
}

/// Parts of a case for its equations.
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
    /// Creates a case from a scene; `numbers` replace its transducer.
    pub fn of(loaded: &Loaded, numbers: Option<Numbers>, wishes: &Wishes) -> Result<Self, CaseError> {
        let Some(driven) = loaded.scene.driven() else { return Err(CaseError::NoController(loaded.name.clone())) };
        let Transducer::Stack(stack, _) = driven.transducer else { return Err(CaseError::Stator(loaded.name.clone())) };
        let circuit = numbers.map_or_else(|| circuit_of(&driven), |numbers| numbers.circuit(stack.bvd.force_factor_n_per_v));
        let Circuit { cm_f, c0_f, lm_h, .. } = circuit;
        let coupling = (cm_f / (c0_f + cm_f)).sqrt();
        if !COUPLING_RANGE.contains(&coupling) {
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
        // The warnings report a voltage that is too high for a scene.
        case.with(block_samples, asked_v.min(most_v))
    }

    /// Returns the case with another block length and voltage.
    pub fn with(&self, block_samples: u16, volts: f64) -> Result<Self, CaseError> {
        self.changed(|controller| {
            controller.block_samples = block_samples;
            controller.drive.amplitude_v = Some(volts);
        })
    }

    /// Returns the case with another window and another bandwidth of the fall-back loop.
    pub fn tracking(&self, span: f64, bandwidth_hz: f64) -> Result<Self, CaseError> {
        self.changed(|controller| (controller.tracking.span, controller.tracking.bandwidth_hz) = (span, bandwidth_hz))
    }

    fn changed(&self, change: impl FnOnce(&mut Controller)) -> Result<Self, CaseError> {
        let mut scene = self.scene.clone();
        if let Some(controller) = &mut scene.controller {
            change(controller);
        }
        // The scene is read again, so that values given by the user are checked as in any scene.
        let scene = load_text("the advised scene", &resolved_toml(&scene), &[])?.scene;
        Ok(Case { scene, ..self.clone() })
    }

    /// Returns the scene of the case.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Returns the scene as a driven one.
    pub fn driven(&self) -> Option<Driven<'_>> {
        self.scene.driven()
    }

    /// Returns the parts of the case; never `None`, because the case was created from them.
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

/// Returns the scene with only this stack: without contact, disturbances, faults and comparisons.
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
        stack: Some(Stack { temperature_k: 0.0, thermal: None, design: None, bvd, mode: Vec::new() }),
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

/// Rounds to the digits of a nominal value.
pub fn rounded(value: f64) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return value;
    }
    // Rounded as text, to obtain the number nearest to the printed one.
    format!("{value:.*e}", DIGITS as usize - 1).parse().unwrap_or(value)
}
