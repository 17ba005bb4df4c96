//! The contact on its slider or carriage: the load, the motion, and the number of steps.

use crate::belt_motion::BeltMotion;
use crate::carriage::Carriage;
use crate::circuit::Circuit;
use crate::dahl::Dahl;
use scene::{self, Driven, Slider};

/// The surface on which a driven tip slides.
#[derive(Clone, Debug)]
pub enum Sliding {
    /// A slider of given speed.
    Slider(OnSlider),
    /// A carriage that moves under forces.
    Carriage(Box<Carriage>),
}

impl Sliding {
    /// Returns the surface of a scene's stack, at rest, if it has one. The seed determines the
    /// ripple of the speed.
    pub fn from_scene(scene: &Driven, slider: Option<(&scene::Dahl, &Slider)>, seed: u64) -> Option<Self> {
        let carriage = || scene.carriage().map(|(contact, carriage)| Carriage::new(contact, carriage));
        let slider = slider.map(|(contact, slider)| OnSlider::new(contact, slider, seed));
        slider.map(Sliding::Slider).or_else(|| carriage().map(Box::new).map(Sliding::Carriage))
    }

    /// Returns the present friction, N; for a carriage, that of the bristles alone.
    #[inline(always)]
    pub fn force(&self) -> f64 {
        match self {
            Sliding::Slider(slider) => slider.force(),
            Sliding::Carriage(carriage) => carriage.force(),
        }
    }

    /// Slides for `step_s` seconds, while the tip moves by `moved` metres and its velocity goes
    /// from `v0` to `v1`. Returns the mean friction, N.
    #[inline(always)]
    pub fn slide(&mut self, v0: f64, v1: f64, moved: f64, step_s: f64) -> f64 {
        match self {
            Sliding::Slider(slider) => slider.slide(v0, v1, moved, step_s),
            Sliding::Carriage(carriage) => carriage.slide(v0, v1, moved, step_s),
        }
    }

    /// Returns the slider of given speed, if it is one.
    pub fn slider(&self) -> Option<&OnSlider> {
        if let Sliding::Slider(slider) = self { Some(slider) } else { None }
    }

    /// Returns the slider of given speed, if it is one.
    pub fn slider_mut(&mut self) -> Option<&mut OnSlider> {
        if let Sliding::Slider(slider) = self { Some(slider) } else { None }
    }

    /// Returns the carriage, if it is one.
    pub fn carriage(&self) -> Option<&Carriage> {
        if let Sliding::Carriage(carriage) = self { Some(carriage) } else { None }
    }
}

/// A contact with its load and motion: `V = speed + tip velocity`, `N = load + own weight`.
#[derive(Clone, Debug)]
pub struct OnSlider {
    dahl: Dahl,
    mu: f64,
    self_weight_n: f64,
    load_n: f64,
    /// Belt or slider that the tip touches.
    pub belt: BeltMotion,
}

impl OnSlider {
    /// Creates the relaxed contact of a scene. The seed determines the ripple of the speed.
    pub fn new(contact: &scene::Dahl, slider: &Slider, seed: u64) -> Self {
        let mut sliding = OnSlider {
            dahl: Dahl::new(contact.stiffness_n_per_m, 0.0),
            mu: contact.mu,
            self_weight_n: slider.self_weight_n,
            load_n: 0.0,
            belt: BeltMotion::new(slider.speed_m_per_s).with_ripple(slider.ripple_rms, slider.ripple_hz, seed),
        };
        sliding.set_load(slider.load_n);
        sliding
    }

    /// Returns the load on the lever, N.
    pub fn load_n(&self) -> f64 {
        self.load_n
    }

    /// Changes the load on the lever, N.
    pub fn set_load(&mut self, load_n: f64) {
        self.load_n = load_n;
        self.dahl.set_coulomb_force(self.mu * (load_n + self.self_weight_n));
    }

    /// Returns the present friction, N.
    pub fn force(&self) -> f64 {
        self.dahl.force()
    }

    /// Slides for `step_s` seconds, while the tip moves by `moved` metres and its velocity goes
    /// from `v0` to `v1`. Returns the mean friction, N.
    #[inline(always)]
    pub fn slide(&mut self, v0: f64, v1: f64, moved: f64, step_s: f64) -> f64 {
        let speed = self.belt.speed_m_per_s();
        self.dahl.slip(speed + v0, speed + v1, speed * step_s + moved, step_s)
    }
}

/// Returns the number of steps a sample that the contact requires; one for a stack alone, whose
/// flow is exact.
///
/// The criterion is `kappa = Kt Vv / (omega Fc)`, the vibration amplitude in Dahl lengths: 16 steps
/// a period below 1, 32 below 10, 64 below 100, otherwise 128. A scene can set another number.
pub fn steps_per_sample(scene: &Driven, sliding: Option<(&scene::Dahl, &Slider)>, circuit: &Circuit) -> u32 {
    let slider =
        sliding.map(|(contact, slider)| (contact.stiffness_n_per_m, contact.mu * (slider.load_n + slider.self_weight_n)));
    let carriage = || scene.carriage().map(|(contact, carriage)| (contact.stiffness_n_per_m, contact.mu * carriage.normal_n));
    let Some((stiffness_n_per_m, coulomb)) = slider.or_else(carriage) else { return 1 };
    let drive = &scene.controller.drive;
    let by_voltage = drive.amplitude_v.unwrap_or(0.0) / circuit.rm_ohm / circuit.force_factor_n_per_v;
    let displacement = drive.velocity_m_per_s.unwrap_or(by_voltage) / circuit.omega();
    let kappa = stiffness_n_per_m * displacement / coulomb;
    let by_stiffness = match kappa {
        k if k < 1.0 => 16,
        k if k < 10.0 => 32,
        k if k < 100.0 => 64,
        _ => 128,
    };
    let per_period = f64::from(scene.integrator.steps_per_period.unwrap_or(by_stiffness));
    (per_period * circuit.series_resonance_hz() / scene.sensors.sample_hz).ceil() as u32
}
