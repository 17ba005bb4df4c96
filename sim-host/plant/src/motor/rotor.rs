//! The rotor: pressed on the crests, dragged along by them, and dragging back.
//!
//! ```text
//! (I / r^2) v' = F - T / r          v: surface speed of the rotor, F: friction of all crests, T: load torque
//! Q_s = z k (C cos phi - S sin phi),  Q_c = -z k (C sin phi + S cos phi)
//! ```
//!
//! `Q` is what the friction does to the modes, by the work of `u' = -z dw'/dx`; `C` and `S` are the friction weighted with `cos p` and
//! `sin p`. So the modes lose exactly what the rotor and the heat take, and the energy closes. The *pressure* acts on the modes too,
//! as a spring of about `preload / amplitude`: it does no work over a period, and is taken as part of the resonance of a stator that
//! has its rotor on. How far it would move that resonance is measured ([`Rotor::normal_shift_hz`]).
//!
//! The friction is a function of the state at an instant. Over a step it counts with the mean of both ends (second order). Where a
//! step of it could stop what it acts on (a wave that has rung down, a rotor that stands), it is taken at the end instead, and is at
//! most what stops it: standstill is exact, and holds any load torque less than `mu N r`.

use crate::motor::crest::{Crest, Layer, Pull, length};
use crate::motor::linear::Linear;
use crate::motor::model::Model;
use crate::motor::participation::MODES;
use crate::motor::seat;

/// Friction counts at the end of a step, if a step of it changes the speed by more than this part.
const STIFF: f64 = 0.1;
/// A surface slower than this, m/s, stands.
const STANDSTILL: f64 = 1e-12;
/// Steps to find the speed at the end of a step.
const MOST_STEPS: usize = 60;

/// What the friction did in one step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Dragged {
    /// Mean friction on the rotor along the ring, N.
    pub force_n: f64,
    /// Mean friction on the sine and the cosine mode, N.
    pub modes_n: [f64; MODES],
    /// Normal force on the rotor, N.
    pub normal_n: f64,
}

/// The rotor and its contact.
#[derive(Clone, Debug)]
pub struct Rotor {
    layer: Layer,
    preload_n: f64,
    radius_m: f64,
    /// Inertia over radius squared, kg.
    mass_kg: f64,
    torque_nm: f64,
    slope: f64,
    /// Height over the neutral line of the surface, m.
    height_m: f64,
    /// Surface speed, m/s.
    speed: f64,
    /// The friction at the end of the last step.
    last: Dragged,
}

/// The wave's crest, and cosine and sine of its phase.
fn crest(linear: &Linear, slope: f64, rotor_m: f64) -> (Crest, f64, f64) {
    let ([qs, qc], [ss, sc]) = (linear.amplitudes(), linear.velocities());
    let height_m = length(qs, qc);
    let (cos, sin) = if height_m == 0.0 { (1.0, 0.0) } else { (qc / height_m, qs / height_m) };
    let crest =
        Crest { height_m, rotor_m, along_m_per_s: -slope * (ss * cos - sc * sin), across_m_per_s: slope * (ss * sin + sc * cos) };
    (crest, cos, sin)
}

impl Rotor {
    /// The rotor of a scene at rest on a stator at rest.
    pub fn new(rotor: &scene::Rotor, model: &Model) -> Self {
        Rotor {
            layer: Layer { mu: rotor.mu, stiffness_n_per_m: rotor.contact_stiffness_n_per_m },
            preload_n: rotor.preload_n,
            radius_m: rotor.radius_m,
            mass_kg: rotor.inertia_kg_m2 / rotor.radius_m.powi(2),
            torque_nm: rotor.torque_nm,
            slope: model.slope,
            height_m: -rotor.preload_n / rotor.contact_stiffness_n_per_m,
            speed: 0.0,
            last: Dragged::default(),
        }
    }

    /// Speed of the rotor, rad/s.
    pub fn rad_per_s(&self) -> f64 {
        self.speed / self.radius_m
    }

    /// Surface speed of the rotor, m/s.
    pub fn speed(&self) -> f64 {
        self.speed
    }

    /// Torque of a force along the ring, N m.
    pub fn torque_of(&self, force_n: f64) -> f64 {
        force_n * self.radius_m
    }

    /// Load torque, N m, against forward rotation.
    pub fn torque_nm(&self) -> f64 {
        self.torque_nm
    }

    /// Changes the load torque, N m.
    pub fn set_torque(&mut self, torque_nm: f64) {
        self.torque_nm = torque_nm;
    }

    /// Preload of the rotor, N.
    pub fn preload_n(&self) -> f64 {
        self.preload_n
    }

    /// Changes the preload, N.
    pub fn set_preload(&mut self, preload_n: f64) {
        self.preload_n = preload_n;
    }

    /// Takes its seat on waves of these amplitudes, m.
    pub fn sit(&mut self, forward: f64, backward: f64) {
        self.height_m = seat::height(forward, backward, self.layer.stiffness_n_per_m, self.preload_n, self.height_m);
    }

    /// Half angle over which crests of this height, m, touch, rad.
    pub fn zone(&self, height_m: f64) -> f64 {
        Crest { height_m, rotor_m: self.height_m, ..Crest::default() }.zone()
    }

    /// How far the spring of the contact, which is left out, would move the resonance for crests of this height, m, Hz.
    ///
    /// The pressure's first harmonic over the amplitude is `(S / 2 pi) (pc + sin pc cos pc - 2 (h / R) sin pc)`, N/m.
    pub fn normal_shift_hz(&self, height_m: f64, model: &Model) -> f64 {
        if height_m == 0.0 {
            return 0.0;
        }
        let (sin, cos) = libm::sincos(self.zone(height_m));
        let zone = self.zone(height_m);
        let spring =
            self.layer.stiffness_n_per_m / std::f64::consts::TAU * (zone + sin * cos - 2.0 * self.height_m / height_m * sin);
        let omega = std::f64::consts::TAU * model.series_resonance_hz;
        model.series_resonance_hz * spring / (2.0 * omega * omega * model.mass_kg)
    }

    /// What a pull does to the modes, N.
    fn on_modes(&self, pull: &Pull, cos: f64, sin: f64) -> [f64; MODES] {
        [self.slope * (pull.cos_n * cos - pull.sin_n * sin), -self.slope * (pull.cos_n * sin + pull.sin_n * cos)]
    }

    /// The friction over the step that `linear` has just made without it.
    #[inline]
    pub fn drag(&mut self, linear: &mut Linear, step_s: f64) -> Dragged {
        let gain = linear.velocity_per_newton();
        let per_newton = step_s / self.mass_kg;
        let load = self.torque_nm / self.radius_m;
        let free = linear.velocities();
        let moving = length(free[0], free[1]);

        linear.push(self.last.modes_n);
        let (wave, cos, sin) = crest(linear, self.slope, self.height_m);
        let ahead = self.speed + per_newton * (self.last.force_n - load);
        let pull = wave.friction(&self.layer, ahead);
        let end = Dragged { force_n: pull.force_n, modes_n: self.on_modes(&pull, cos, sin), normal_n: pull.normal_n };
        let size = |newtons: [f64; MODES]| length(newtons[0], newtons[1]);
        let mean = |a: f64, b: f64| 0.5 * (a + b);
        let mut dragged = Dragged {
            modes_n: [0, 1].map(|mode| mean(self.last.modes_n[mode], end.modes_n[mode])),
            force_n: mean(self.last.force_n, end.force_n),
            normal_n: end.normal_n,
        };
        let mut last = end;
        // The friction can at most stop the wave.
        if gain * size(end.modes_n).max(size(self.last.modes_n)) > STIFF * moving {
            let newtons = size(end.modes_n).min(moving / gain);
            let against = |velocity: f64| if moving > 0.0 { -newtons * velocity / moving } else { 0.0 };
            dragged.modes_n = free.map(against);
            last.modes_n = dragged.modes_n;
        }
        linear.push([0, 1].map(|mode| dragged.modes_n[mode] - self.last.modes_n[mode]));

        let surface = length(wave.along_m_per_s, wave.across_m_per_s);
        let most = self.layer.mu * pull.normal_n;
        let near = self.speed.abs() <= surface + 2.0 * per_newton * (most + load.abs());
        if near && per_newton * most > STIFF * surface {
            let (wave, ..) = crest(linear, self.slope, self.height_m);
            dragged.force_n = self.holding(&wave, per_newton, load, most);
            last.force_n = dragged.force_n;
        }
        self.speed += per_newton * (dragged.force_n - load);
        if self.speed.abs() < STANDSTILL {
            self.speed = 0.0;
        }
        self.last = last;
        dragged
    }

    /// The friction that agrees with the speed it leads to: of a rotor near standstill.
    fn holding(&self, wave: &Crest, per_newton: f64, load: f64, most: f64) -> f64 {
        let surface = length(wave.along_m_per_s, wave.across_m_per_s);
        if surface < STANDSTILL {
            return (load - self.speed / per_newton).clamp(-most, most);
        }
        // The friction falls with the speed, so the root is unique.
        let (mut low, mut high) = (-most, most);
        for _ in 0..MOST_STEPS {
            let force = 0.5 * (low + high);
            let speed = self.speed + per_newton * (force - load);
            if wave.friction(&self.layer, speed).force_n > force {
                low = force
            } else {
                high = force
            }
            if high - low < 1e-9 * most {
                break;
            }
        }
        0.5 * (low + high)
    }
}
