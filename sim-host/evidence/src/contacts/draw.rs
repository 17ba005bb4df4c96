//! Draws random contacts: contact spring, friction, velocity ratio and damping over ten decades,
//! natural frequency over three.

use std::f64::consts::TAU;

use contact::auto::stable_steps;
use contact::plane::Direction;
use contact::{Law, Motion, Problem, Shape, Sign, State, Waveform};

use crate::random::Random;

/// Seed of the contact with number 0; the seeds of the others follow.
const SEED: u64 = 0x5eed_c0de;
/// Distance between the sets of two seeds (the golden ratio, in 64 bits).
const SEED_STRIDE: u64 = 0x9e37_79b9_7f4a_7c15;
/// Mass of every contact, kg; all other quantities are relative to mass, frequency and force.
const MASS_KG: f64 = 0.02;
/// Drive frequency of every contact, Hz.
const DRIVE_HZ: f64 = 60e3;
/// Force of every contact, N.
const FORCE_N: f64 = 384.0;
/// Range of the number of periods of a contact.
const PERIODS: (f64, f64) = (20.0, 1000.0);
/// Largest number of steps a period at which Runge-Kutta must be stable for a LuGre contact.
const MAX_STEPS: f64 = 200.0;
/// Smallest Stribeck velocity of a LuGre contact, over the velocity of the vibration.
const MIN_STRIBECK_REL: f64 = 1e-2;
/// Range of the number of periods of a LuGre contact.
const LUGRE_PERIODS: (f64, f64) = (20.0, 60.0);

/// The friction law of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Friction {
    /// Dahl friction.
    Dahl,
    /// LuGre friction.
    Lugre,
    /// Dahl friction, with a given vibration at an angle to the sliding.
    PlaneDahl,
    /// LuGre friction, with a given vibration at an angle to the sliding.
    PlaneLugre,
}

impl Friction {
    /// All laws.
    pub const ALL: [Friction; 4] = [Friction::Dahl, Friction::Lugre, Friction::PlaneDahl, Friction::PlaneLugre];
    /// Laws for which the record from the start on is compared too.
    pub const RECORDED: [Friction; 2] = [Friction::Dahl, Friction::Lugre];

    /// Returns the name of the law.
    pub fn name(self) -> &'static str {
        match self {
            Friction::Dahl => "Dahl",
            Friction::Lugre => "LuGre",
            Friction::PlaneDahl => "Dahl at an angle",
            Friction::PlaneLugre => "LuGre at an angle",
        }
    }
}

/// A random contact.
#[derive(Clone, Debug)]
pub struct Contact {
    /// Number of the draw.
    pub number: u32,
    /// The contact as a problem.
    pub problem: Problem,
    /// Direction of the vibration, if it is at an angle to the sliding.
    pub direction: Option<Direction>,
}

impl Contact {
    /// Draws the contact of a number in the set of a seed; seed 0 is the default set.
    ///
    /// | group | range |
    /// |---|---|
    /// | contact spring, `Kt / (m w^2)` | 1e-8 to 1e2 |
    /// | friction over force, `Fc / F0` | 1e-10 to 1 |
    /// | velocity ratio, `Vt / Vv` | 1e-7 to 1e3 |
    /// | Stribeck velocity over that of the vibration | 1e-2 to 1e2 |
    /// | bristle damping, `sigma1 / (m w)` | none, or 1e-8 to 1e2 |
    /// | damping ratio | none, or 1e-9 to 10 |
    /// | natural over drive frequency | 1e-2 to 10 |
    ///
    /// A LuGre contact is drawn again until Runge-Kutta is stable at [`MAX_STEPS`] steps a period,
    /// so that a reference takes only seconds.
    pub fn draw(number: u32, friction: Friction, seed: u64) -> Self {
        // Sets of neighbouring seeds have no contact in common.
        let set = SEED ^ seed.wrapping_mul(SEED_STRIDE);
        if friction == Friction::PlaneDahl || friction == Friction::PlaneLugre {
            let lugre = u64::from(friction == Friction::PlaneLugre);
            let mut random = Random::new(set.rotate_left(17) ^ (u64::from(number) << 1) ^ lugre);
            let (problem, direction) = in_plane(&mut random, friction);
            return Contact { number, problem, direction: Some(direction) };
        }
        let mut random = Random::new(set ^ (u64::from(number) << 1) ^ u64::from(friction == Friction::Lugre));
        loop {
            let problem = draw(&mut random, friction);
            if friction == Friction::Dahl || stable_steps(&problem) <= MAX_STEPS {
                return Contact { number, problem, direction: None };
            }
        }
    }
}

fn draw(random: &mut Random, friction: Friction) -> Problem {
    let omega = TAU * DRIVE_HZ;
    let (least, most) = if friction == Friction::Dahl { PERIODS } else { LUGRE_PERIODS };
    let periods = random.log(least, most).round();
    let duration_s = periods / DRIVE_HZ;
    let natural = omega * random.log(1e-2, 10.0);
    let stiffness_n_per_m = MASS_KG * natural * natural;
    let ratio = if random.part() < 0.3 { 0.0 } else { random.log(1e-9, 10.0) };
    let sdof = Motion::Sdof { mass_kg: MASS_KG, stiffness_n_per_m, damping_n_s_per_m: 2.0 * ratio * MASS_KG * natural };
    let (kind, shape) = (random.part(), shape(random, periods));
    let mut problem = Problem {
        motion: sdof,
        law: Law::Coulomb,
        coulomb_n: FORCE_N * random.log(1e-10, 1.0),
        sliding_m_per_s: 0.0,
        sign: if random.part() < 0.1 { Sign::Literal } else { Sign::Passive },
        waveform: Waveform::new(shape, FORCE_N, DRIVE_HZ, duration_s),
        start: State::default(),
        load_steps: Vec::new(),
        window_s: (duration_s * [0.0, 0.5, 0.9][random.whole(0, 2) as usize], duration_s),
        duration_s,
    };
    if kind < 0.1 {
        problem.waveform = Waveform::new(shape, problem.vibration_m_per_s(), DRIVE_HZ, duration_s);
        problem.motion = Motion::Kinematic;
    }
    let vibration = problem.vibration_m_per_s();
    problem.sliding_m_per_s = vibration * random.log(1e-7, 1e3);
    let kt = MASS_KG * omega * omega * random.log(1e-8, 1e2);
    problem.law = match friction {
        Friction::Dahl | Friction::PlaneDahl => Law::Dahl { stiffness_n_per_m: kt },
        Friction::Lugre | Friction::PlaneLugre => Law::Lugre {
            stiffness_n_per_m: kt,
            static_ratio: random.log(1.0, 3.0),
            stribeck_m_per_s: vibration * random.log(MIN_STRIBECK_REL, 1e2),
            sigma1: if random.toss() { 0.0 } else { MASS_KG * omega * random.log(1e-8, 1e2) },
            sigma2: 0.0,
        },
    };
    problem
}

/// Largest slip in a period, bristle lengths; the number of steps of the reference is proportional
/// to it.
const MAX_SLIP: f64 = 1e4;

/// Draws a contact with a given vibration at any angle.
///
/// | group | range |
/// |---|---|
/// | angle, degrees | 0 to 90, uniform; in half of the contacts 1e-6 to 45 from either end, on a logarithmic scale |
/// | vibration in bristle lengths, kappa | 1e-8 to 1e4, less if the sliding is faster than the vibration |
/// | velocity ratio | 1e-7 to 1e3 |
/// | Stribeck velocity over that of the vibration | 1e-2 to 1e2 |
/// | bristle damping, `sigma1 Vv / Fc` | none, or 1e-8 to 1e2 |
fn in_plane(random: &mut Random, friction: Friction) -> (Problem, Direction) {
    let angle_deg = match random.whole(0, 3) {
        0 => random.log(1e-6, 45.0),
        1 => 90.0 - random.log(1e-6, 45.0),
        _ => 90.0 * random.part(),
    };
    let (least, most) = PERIODS;
    let periods = random.log(least, most).round();
    let duration_s = periods / DRIVE_HZ;
    let shape =
        [Shape::Sine, Shape::Sine, Shape::Sine, Shape::Square, Shape::Sawtooth, Shape::Triangle][random.whole(0, 5) as usize];
    let (vibration, velocity_ratio) = (1.0, random.log(1e-7, 1e3));
    let coulomb_n = FORCE_N * random.log(1e-10, 1.0);
    let kappa = random.log(1e-8, MAX_SLIP / velocity_ratio.max(1.0));
    let stiffness_n_per_m = kappa * TAU * DRIVE_HZ * coulomb_n / vibration;
    let law = match friction {
        Friction::PlaneDahl => Law::Dahl { stiffness_n_per_m },
        _ => Law::Lugre {
            stiffness_n_per_m,
            static_ratio: random.log(1.0, 3.0),
            stribeck_m_per_s: vibration * random.log(MIN_STRIBECK_REL, 1e2),
            sigma1: if random.toss() { 0.0 } else { coulomb_n / vibration * random.log(1e-8, 1e2) },
            sigma2: 0.0,
        },
    };
    let problem = Problem {
        motion: Motion::Kinematic,
        law,
        coulomb_n,
        sliding_m_per_s: vibration * velocity_ratio,
        sign: if random.part() < 0.1 { Sign::Literal } else { Sign::Passive },
        waveform: Waveform::new(shape, vibration, DRIVE_HZ, duration_s),
        start: State::default(),
        load_steps: Vec::new(),
        window_s: (duration_s * [0.0, 0.5, 0.9][random.whole(0, 2) as usize], duration_s),
        duration_s,
    };
    (problem, Direction::from_degrees(angle_deg))
}

/// Draws the shape of the force: a sine in two of three contacts.
fn shape(random: &mut Random, periods: f64) -> Shape {
    match random.whole(0, 14) {
        0 => Shape::Square,
        1 => Shape::Sawtooth,
        2 => Shape::Triangle,
        3 => Shape::Random { hold_s: 0.3 / DRIVE_HZ, seed: 1 },
        4 => Shape::Chirp { start_hz: 0.5 * DRIVE_HZ, stop_hz: 2.0 * DRIVE_HZ, sweep_s: 0.5 * periods / DRIVE_HZ },
        _ => Shape::Sine,
    }
}
