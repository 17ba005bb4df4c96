//! The rotor: pressed on the crests, moved by their friction, and acting back on the modes.
//!
//! ```text
//! (I / r^2) v' = F - T / r          v: surface speed of the rotor, F: friction of all crests, T: load torque
//! Q_s = z k (C cos phi - S sin phi),  Q_c = -z k (C sin phi + S cos phi)
//! ```
//!
//! `Q` is the friction force on the modes, by the work of `u' = -z dw'/dx`; `C` and `S` are the
//! friction weighted with `cos p` and `sin p`. The modes therefore lose exactly the work on the
//! rotor plus the heat, and the energy balance closes. The *pressure* acts on the modes too, as a
//! spring of about `preload / amplitude`. It does no work over a period, and is included in the
//! resonance of a stator with its rotor. [`Rotor::normal_shift_hz`] computes the shift that it
//! would cause.
//!
//! The friction is a function of the instantaneous state; a step uses the mean of both ends (second
//! order). If one step of friction could stop the part that it acts on (a decayed wave, a rotor at
//! rest), the value at the end is used instead, limited to the force that stops it. Standstill is
//! exact, and any load torque below `mu N r` is held.

use crate::motor::crest::{Crest, CrestFriction, Layer, length};
use crate::motor::linear::Linear;
use crate::motor::model::Model;
use crate::motor::participation::MODES;
use crate::motor::seat;
use crate::quad::Registers;

/// Relative change of the speed in one step above which the friction at the end of the step is
/// used.
const STIFF_CHANGE_REL: f64 = 0.1;
/// Surface speed below which the surface is at rest, m/s.
const STANDSTILL_M_PER_S: f64 = 1e-12;

/// Effect of the friction in one step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RotorFriction {
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
    last: RotorFriction,
}

/// Returns the wave's crest, and cosine and sine of its phase.
fn crest(linear: &Linear, slope: f64, rotor_m: f64) -> (Crest, f64, f64) {
    let ([qs, qc], [ss, sc]) = (linear.amplitudes(), linear.velocities());
    let height_m = length(qs, qc);
    let (cos, sin) = if height_m == 0.0 { (1.0, 0.0) } else { (qc / height_m, qs / height_m) };
    let crest =
        Crest { height_m, rotor_m, along_m_per_s: -slope * (ss * cos - sc * sin), across_m_per_s: slope * (ss * sin + sc * cos) };
    (crest, cos, sin)
}

impl Rotor {
    /// Creates the rotor of a scene, at rest on a stator at rest.
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
            last: RotorFriction::default(),
        }
    }

    /// Returns the speed of the rotor, rad/s.
    pub fn rad_per_s(&self) -> f64 {
        self.speed / self.radius_m
    }

    /// Returns the surface speed of the rotor, m/s.
    pub fn speed(&self) -> f64 {
        self.speed
    }

    /// Returns the torque of a force along the ring, N m.
    pub fn torque_of(&self, force_n: f64) -> f64 {
        force_n * self.radius_m
    }

    /// Returns the load torque, N m, against forward rotation.
    pub fn torque_nm(&self) -> f64 {
        self.torque_nm
    }

    /// Changes the load torque, N m.
    pub fn set_torque(&mut self, torque_nm: f64) {
        self.torque_nm = torque_nm;
    }

    /// Returns the preload of the rotor, N.
    pub fn preload_n(&self) -> f64 {
        self.preload_n
    }

    /// Changes the preload, N.
    pub fn set_preload(&mut self, preload_n: f64) {
        self.preload_n = preload_n;
    }

    /// Updates the height for waves of these amplitudes, m.
    pub fn sit(&mut self, forward: f64, backward: f64) {
        self.height_m = seat::height(forward, backward, self.layer.stiffness_n_per_m, self.preload_n, self.height_m);
    }

    /// Returns half the angle over which crests of this height, m, touch, rad.
    pub fn zone(&self, height_m: f64) -> f64 {
        Crest { height_m, rotor_m: self.height_m, ..Crest::default() }.zone()
    }

    /// Returns the shift of the resonance, Hz, that the omitted spring of the contact would cause
    /// for crests of this height, m.
    ///
    /// The pressure's first harmonic over the amplitude is
    /// `(S / 2 pi) (pc + sin pc cos pc - 2 (h / R) sin pc)`, N/m.
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

    /// Returns the force of a pull on the modes, N.
    fn on_modes(&self, pull: &CrestFriction, cos: f64, sin: f64) -> [f64; MODES] {
        [self.slope * (pull.cos_n * cos - pull.sin_n * sin), -self.slope * (pull.cos_n * sin + pull.sin_n * cos)]
    }

    /// Computes the friction over the step that `linear` has just made without it.
    #[inline(always)]
    pub(crate) fn drag<F: Registers>(&mut self, four: F, linear: &mut Linear, step_s: f64) -> RotorFriction {
        let gain = linear.velocity_per_newton();
        let per_newton = step_s / self.mass_kg;
        let load = self.torque_nm / self.radius_m;
        let free = linear.velocities();
        let moving = length(free[0], free[1]);

        linear.push(four, self.last.modes_n);
        let (wave, cos, sin) = crest(linear, self.slope, self.height_m);
        let ahead = self.speed + per_newton * (self.last.force_n - load);
        let pull = wave.friction(&self.layer, ahead);
        let end = RotorFriction { force_n: pull.force_n, modes_n: self.on_modes(&pull, cos, sin), normal_n: pull.normal_n };
        let size = |newtons: [f64; MODES]| length(newtons[0], newtons[1]);
        let mean = |a: f64, b: f64| 0.5 * (a + b);
        let mut dragged = RotorFriction {
            modes_n: [0, 1].map(|mode| mean(self.last.modes_n[mode], end.modes_n[mode])),
            force_n: mean(self.last.force_n, end.force_n),
            normal_n: end.normal_n,
        };
        let mut last = end;
        // The friction can at most stop the wave.
        if gain * size(end.modes_n).max(size(self.last.modes_n)) > STIFF_CHANGE_REL * moving {
            let newtons = size(end.modes_n).min(moving / gain);
            let against = |velocity: f64| if moving > 0.0 { -newtons * velocity / moving } else { 0.0 };
            dragged.modes_n = free.map(against);
            last.modes_n = dragged.modes_n;
        }
        linear.push(four, [0, 1].map(|mode| dragged.modes_n[mode] - self.last.modes_n[mode]));

        let surface = length(wave.along_m_per_s, wave.across_m_per_s);
        let most = self.layer.mu * pull.normal_n;
        let near = self.speed.abs() <= surface + 2.0 * per_newton * (most + load.abs());
        if near && per_newton * most > STIFF_CHANGE_REL * surface {
            let (wave, ..) = crest(linear, self.slope, self.height_m);
            dragged.force_n = self.holding(&wave, per_newton, load, most);
            last.force_n = dragged.force_n;
        }
        self.speed += per_newton * (dragged.force_n - load);
        if self.speed.abs() < STANDSTILL_M_PER_S {
            self.speed = 0.0;
        }
        self.last = last;
        dragged
    }

    /// Returns the friction of a rotor near standstill that is consistent with the resulting speed.
    /// One step of friction can change that speed by far more than the surface speed. The solution
    /// is therefore found as a speed within the range of the surface; outside it the friction is at
    /// its limit.
    fn holding(&self, wave: &Crest, per_newton: f64, load: f64, most: f64) -> f64 {
        let surface = length(wave.along_m_per_s, wave.across_m_per_s);
        let needed = |speed: f64| load + (speed - self.speed) / per_newton;
        if surface < STANDSTILL_M_PER_S {
            return needed(0.0).clamp(-most, most);
        }
        if needed(-surface) >= most {
            return most;
        }
        if needed(surface) <= -most {
            return -most;
        }
        // The friction falls with the speed, so the root is unique.
        let excess = |speed: f64| wave.friction(&self.layer, speed).force_n - needed(speed);
        needed(fall(excess, -surface, surface, 1e-9 * most * per_newton))
    }
}

/// Returns the zero of a falling function between `low` and `high`, to `within`.
///
/// ITP method, with bisection's bound on the steps and the speed of a secant (Oliveira and
/// Takahashi, ACM Trans. Math. Softw. 47, 5, 2021), `k2 = 2`, `n0 = 1`.
fn fall(of: impl Fn(f64) -> f64, mut low: f64, mut high: f64, within: f64) -> f64 {
    let (mut above, mut below) = (of(low), of(high));
    if above <= 0.0 {
        return low;
    }
    if below >= 0.0 {
        return high;
    }
    let bend = 0.2 / (high - low);
    let mut reach = within * libm::exp2((libm::log2((high - low) / within)).ceil());
    while high - low > within {
        let middle = 0.5 * (low + high);
        let secant = (above * high - below * low) / (above - below);
        let towards = (middle - secant).signum();
        let shift = (bend * (high - low).powi(2)).max(0.5 * within);
        let bent = if shift <= (middle - secant).abs() { secant + towards * shift } else { middle };
        let most = (reach - 0.5 * (high - low)).max(0.0);
        let at = if (bent - middle).abs() <= most { bent } else { middle - towards * most };
        let there = of(at);
        if there > 0.0 {
            (low, above) = (at, there);
        } else if there < 0.0 {
            (high, below) = (at, there);
        } else {
            return at;
        }
        reach *= 0.5;
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motor::tests::{rotor, stator};

    #[test]
    fn root_search_is_no_slower_than_bisection() {
        let smooth: fn(f64) -> f64 = |x| 0.625 - x.powi(3) - x;
        let steep: fn(f64) -> f64 = |x| if x < 0.12345 { 1.0 } else { -1e-9 };
        let flat: fn(f64) -> f64 = |x| libm::acos(x) - 3.0;
        for (of, root, most) in [(smooth, 0.5, 12), (steep, 0.12345, 33), (flat, libm::cos(3.0), 33)] {
            let steps = std::cell::Cell::new(0);
            let counted = |x: f64| {
                steps.set(steps.get() + 1);
                of(x)
            };
            let found = fall(counted, -1.0, 1.0, 1e-9);
            assert!((found - root).abs() < 1e-9, "{found}");
            assert!(steps.get() <= 2 + most, "{}", steps.get());
        }
    }

    /// The force is consistent with the resulting speed, or is at its limit.
    #[test]
    fn holding_force_is_consistent_with_its_speed() {
        let scene = rotor();
        let mut held = [0; 2];
        for n in 0..2000 {
            let at = |k: f64| (f64::from(n) * k).sin();
            let mut rotor = Rotor::new(&scene, &Model::from_stator(&stator()));
            rotor.speed = 2e-3 * at(0.91);
            let wave = Crest {
                height_m: 1e-6,
                rotor_m: 1.5e-6 * at(0.37) - 0.6e-6,
                along_m_per_s: 1e-3 * at(1.7),
                across_m_per_s: 1e-3 * at(2.3),
            };
            let most = rotor.layer.mu * wave.friction(&rotor.layer, rotor.speed).normal_n;
            if most == 0.0 {
                continue;
            }
            let (per_newton, load) = (2e-3 / most, 1.2 * most * at(0.53));
            let force = rotor.holding(&wave, per_newton, load, most);
            let agrees = wave.friction(&rotor.layer, rotor.speed + per_newton * (force - load)).force_n;
            // Near the end of the contact the friction rises like a square root, with an infinite
            // slope, which limits the accuracy.
            assert!((agrees - force).abs() < 1e-4 * most, "{n}: {force} of {agrees}");
            held[usize::from(force.abs() == most)] += 1;
        }
        assert!(held.iter().all(|&held| held > 100), "{held:?}");
    }
}
