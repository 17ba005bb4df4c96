//! Random compliant contacts under vibration across them: the arcs against return mapping in steps of time.
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

use crate::evidence::Error;
use crate::random::Random;
use contact::compliant::stepped::{self, SteppedMeans};
use contact::compliant::{CompliantProblem, CompliantSolution, Press, solve};
use report::TableBlock;

/// Seed of the contact with number 0; the others follow.
const SEED: u64 = 0xc0_4711;
const FAR_APART: u64 = 0x9e37_79b9_7f4a_7c15;
/// Steps a period of the reference, of which there are three runs.
const STEPS: u32 = 1 << 17;
/// The reference is known where its runs agree on this.
const KNOWN: f64 = 1e-5;
/// Three runs whose errors fall unevenly may be off by so many times what they differ by.
const SPREADS: f64 = 4.0;
/// A ratio that is off by more than the reference is unknown and this, which its additions may round, is wrong.
const ROUND_OFF: f64 = (2 * STEPS) as f64 * f64::EPSILON;
/// Steps at either end of a stick that the reference may see elsewhere.
const ENDS: f64 = 4.0;
const CAPTION: &str = "Amplitude 1e-3 to 1e3 indentations, sliding speed 1e-4 to 10 times mu kz w a / kx, stiffnesses apart by up to 1e3. The reference is return mapping in 131 072 to 262 144 steps a period, \
     by three runs. Not known: these differ by more than 1e-5. Wrong: the ratio of the arcs is off from the finest run by more than four times what the three differ by. Stick: the part of the period that sticks is off by more than four steps, of \
     contacts whose stick is not shorter than the reference resolves.";

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
    let mut random = Random::new(SEED ^ seed.wrapping_mul(FAR_APART) ^ u64::from(number));
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

/// Solves so many contacts both ways.
pub fn compare(count: u32, seed: u64) -> Result<Vec<Compared>, Error> {
    let one = |number: u32| {
        let (problem, indentations, speed) = draw(number, seed);
        let solution = solve(&problem)?;
        Ok(Compared { number, problem, indentations, speed, solution, steps: stepped::solve(&problem, STEPS) })
    };
    (0..count).into_par_iter().map(one).collect()
}

/// Whether a number is beyond its limit, or none.
fn is_beyond(off: f64, limit: f64) -> bool {
    off.is_nan() || off > limit
}

impl Compared {
    fn is_known(&self) -> bool {
        self.steps.unknown <= KNOWN
    }

    fn off(&self) -> f64 {
        (self.solution.coefficient_ratio - self.steps.coefficient_ratio).abs()
    }

    fn is_wrong(&self) -> bool {
        is_beyond(self.off(), SPREADS * self.steps.unknown + ROUND_OFF)
    }

    fn stick_is_off(&self) -> bool {
        let off = (self.solution.stick_share - self.steps.stick_share).abs();
        is_beyond(off, ENDS / f64::from(2 * STEPS)) && self.is_resolved()
    }

    /// The limit and the line part by the fourth power of a short stick, which steps do not see.
    fn is_resolved(&self) -> bool {
        self.solution.stick_share == 0.0 || self.solution.stick_share > 1e-2
    }

    fn held(&self) -> &'static str {
        if matches!(self.problem.press, Press::Load(_)) { "load" } else { "indentation" }
    }
}

/// How the arcs do, for either of what is held.
pub fn table(set: &[Compared]) -> TableBlock {
    let header = ["held", "contacts", "contact lost", "sticking", "not known", "wrong", "largest error", "stick wrong"];
    let row = |held: &str| {
        let of: Vec<&Compared> = set.iter().filter(|compared| compared.held() == held).collect();
        let count = |is: &dyn Fn(&Compared) -> bool| of.iter().filter(|compared| is(compared)).count().to_string();
        let worst = of.iter().filter(|compared| compared.is_known()).map(|compared| compared.off()).fold(0.0, f64::max);
        vec![
            held.to_owned(),
            of.len().to_string(),
            count(&|compared| compared.solution.contact_share < 1.0),
            count(&|compared| compared.solution.stick_share > 0.0),
            count(&|compared| !compared.is_known()),
            count(&Compared::is_wrong),
            format!("{worst:.1e}"),
            count(&Compared::stick_is_off),
        ]
    };
    let rows = ["load", "indentation"].map(row).to_vec();
    TableBlock::new("compliant", "Compliant contacts under vibration across them: arcs against steps", CAPTION, &header, rows)
}

/// The contacts that are wrong.
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

/// Each contact.
pub fn csv(set: &[Compared]) -> Result<String, Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record([
        "number",
        "held",
        "indentations",
        "speed_ratio",
        "ratio",
        "ratio_by_steps",
        "unknown",
        "stick",
        "stick_by_steps",
    ])?;
    for compared in set {
        let Compared { number, indentations, speed, solution, steps, .. } = compared;
        writer.write_record([
            number.to_string(),
            compared.held().into(),
            format!("{indentations:.4e}"),
            format!("{speed:.4e}"),
            format!("{:.12}", solution.coefficient_ratio),
            format!("{:.12}", steps.coefficient_ratio),
            format!("{:.1e}", steps.unknown),
            format!("{:.6}", solution.stick_share),
            format!("{:.6}", steps.stick_share),
        ])?;
    }
    let bytes = writer.into_inner().map_err(|error| csv::Error::from(error.into_error()))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}
