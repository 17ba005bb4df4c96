//! Random compliant contacts under vibration across them: arcs compared with return mapping in time
//! steps.
//!
//! | group | range |
//! |---|---|
//! | amplitude over indentation without vibration, A | 1e-3 to 1e3 |
//! | sliding speed over the critical speed while contact lasts, s | 1e-4 to 10 |
//! | tangential over normal stiffness | 1e-3 to 1e3 |
//! | coefficient of friction | 0.01 to 1 |
//! | held | mean load, or mean indentation |

pub mod model;

use std::f64::consts::TAU;

use rayon::prelude::*;

use crate::campaign::{self, cells, columns, worst};
use crate::evidence::Error;
use crate::random::Random;
use contact::compliant::stepped::{self, SteppedMeans};
use contact::compliant::{CompliantProblem, CompliantSolution, Press, solve};
use report::TableBlock;

/// Seed of the contact with number 0; the seeds of the others follow.
const SEED: u64 = 0xc0_4711;
/// Distance between the sets of two seeds (the golden ratio, in 64 bits).
const SEED_STRIDE: u64 = 0x9e37_79b9_7f4a_7c15;
/// Number of steps a period of the reference, which consists of three runs.
const STEPS: u32 = 1 << 17;
/// Largest difference between the runs of a usable reference.
const MAX_UNCERTAINTY: f64 = 1e-5;
/// Ratio of the reference's error to the difference between its runs, whose errors fall unevenly.
const UNCERTAINTY_FACTOR: f64 = 4.0;
/// Round-off of the reference's sums. A ratio is wrong if its error exceeds the uncertainty of the
/// reference by more.
const ROUND_OFF: f64 = (2 * STEPS) as f64 * f64::EPSILON;
/// Uncertainty of the reference at the ends of a stick, steps.
const STICK_STEPS: f64 = 4.0;
const CAPTION: &str = "Amplitude 1e-3 to 1e3 indentations, sliding speed 1e-4 to 10 times mu kz w a / kx, ratio of the \
     stiffnesses 1e-3 to 1e3. The reference is return mapping in 131 072 to 262 144 steps a period, by three runs. Reference \
     unknown: these differ by more than 1e-5. Wrong: the ratio of the arcs differs from the finest run by more than four times \
     the difference of the three. Stick wrong: the sticking part of the period is off by more than four steps, in contacts whose \
     stick is long enough for the reference to resolve.";

/// A contact, its solution and its reference.
pub struct Compared {
    number: u32,
    problem: CompliantProblem,
    indentations: f64,
    speed: f64,
    solution: CompliantSolution,
    steps: SteppedMeans,
}

/// Draws a contact by its number in the set of a seed.
fn draw(number: u32, seed: u64) -> (CompliantProblem, f64, f64) {
    let mut random = Random::new(SEED ^ seed.wrapping_mul(SEED_STRIDE) ^ u64::from(number));
    let (normal_n, normal_n_per_m, frequency_hz) = (10.0, 1e7, 20e3);
    let (indentations, speed) = (random.log(1e-3, 1e3), random.log(1e-4, 10.0));
    let tangential_n_per_m = normal_n_per_m * random.log(1e-3, 1e3);
    let mu = random.log(0.01, 1.0);
    let press = if random.part() < 0.5 { Press::Load(normal_n) } else { Press::Indentation(normal_n / normal_n_per_m) };
    let amplitude_m = indentations * normal_n / normal_n_per_m;
    let sliding_m_per_s = speed * mu * normal_n_per_m * TAU * frequency_hz * amplitude_m / tangential_n_per_m;
    let problem = CompliantProblem { mu, press, normal_n_per_m, tangential_n_per_m, amplitude_m, frequency_hz, sliding_m_per_s };
    (problem, indentations, speed)
}

/// Solves `count` contacts by both methods.
pub fn compare(count: u32, seed: u64) -> Result<Vec<Compared>, Error> {
    let one = |number: u32| {
        let (problem, indentations, speed) = draw(number, seed);
        let solution = solve(&problem)?;
        Ok(Compared { number, problem, indentations, speed, solution, steps: stepped::solve(&problem, STEPS) })
    };
    (0..count).into_par_iter().map(one).collect()
}

/// Returns `true` if a number is beyond its limit or NaN.
fn is_beyond(off: f64, limit: f64) -> bool {
    off.is_nan() || off > limit
}

impl Compared {
    fn is_known(&self) -> bool {
        self.steps.unknown <= MAX_UNCERTAINTY
    }

    fn off(&self) -> f64 {
        (self.solution.coefficient_ratio - self.steps.coefficient_ratio).abs()
    }

    fn is_wrong(&self) -> bool {
        is_beyond(self.off(), UNCERTAINTY_FACTOR * self.steps.unknown + ROUND_OFF)
    }

    fn stick_is_off(&self) -> bool {
        let off = (self.solution.stick_share - self.steps.stick_share).abs();
        is_beyond(off, STICK_STEPS / f64::from(2 * STEPS)) && self.is_resolved()
    }

    /// Returns `false` for a short stick. There the limit and the line separate only with the
    /// fourth power of its length, which time steps do not resolve.
    fn is_resolved(&self) -> bool {
        self.solution.stick_share == 0.0 || self.solution.stick_share > 1e-2
    }

    fn held(&self) -> &'static str {
        if matches!(self.problem.press, Press::Load(_)) { "load" } else { "indentation" }
    }
}

/// Returns the table of the comparison, by the held quantity.
pub fn table(set: &[Compared]) -> TableBlock {
    let header = columns("held | contacts | contact lost | sticking | reference unknown | wrong | largest error | stick wrong");
    let row = |held: &str| {
        let of: Vec<&Compared> = set.iter().filter(|compared| compared.held() == held).collect();
        let count = |is: fn(&Compared) -> bool| campaign::count(of.iter().copied(), is);
        let worst = worst(of.iter().filter(|compared| compared.is_known()).map(|compared| compared.off()));
        let (lost, sticking) =
            (count(|compared| compared.solution.contact_share < 1.0), count(|compared| compared.solution.stick_share > 0.0));
        let [unknown, wrong, stick] =
            [|compared: &Compared| !compared.is_known(), Compared::is_wrong, Compared::stick_is_off].map(count);
        cells![held, of.len(), lost, sticking, unknown, wrong, format!("{worst:.1e}"), stick]
    };
    let title = "Compliant contacts under vibration across them: arcs compared with time steps";
    TableBlock::new("compliant", title, CAPTION, &header, ["load", "indentation"].map(row).to_vec())
}

/// Returns the contacts whose solution is wrong.
pub fn missed(set: &[Compared]) -> Vec<String> {
    let bad = set.iter().filter(|compared| compared.is_wrong() || compared.stick_is_off());
    bad.map(|compared| {
        format!(
            "compliant contact {}: A {:e}, s {:e}, {} held: {:?} by arcs, {:?} by steps",
            compared.number,
            compared.indentations,
            compared.speed,
            compared.held(),
            compared.solution,
            compared.steps
        )
    })
    .collect()
}

/// Returns one row of CSV per contact.
pub fn csv(set: &[Compared]) -> Result<String, Error> {
    let rows = set.iter().map(|compared| {
        let Compared { number, indentations, speed, solution, steps, .. } = compared;
        let [indentations, speed] = [indentations, speed].map(|ratio| format!("{ratio:.4e}"));
        let [ratio, by_steps] = [solution.coefficient_ratio, steps.coefficient_ratio].map(|ratio| format!("{ratio:.12}"));
        let [stick, stick_by_steps] = [solution.stick_share, steps.stick_share].map(|share| format!("{share:.6}"));
        let unknown = format!("{:.1e}", steps.unknown);
        cells![number, compared.held(), indentations, speed, ratio, by_steps, unknown, stick, stick_by_steps]
    });
    campaign::csv("number,held,indentations,speed_ratio,ratio,ratio_by_steps,unknown,stick,stick_by_steps", rows)
}
