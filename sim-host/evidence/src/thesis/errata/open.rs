//! Points that the thesis leaves undefined, the choices made here, and the effect of other choices
//! on the friction ratio.

use crate::thesis::case::PLOTTED_RATIO;
use crate::thesis::case::{Case, SHORT_S, TABLE_4_1};
use crate::thesis::claim::number;
use crate::thesis::comparison::settled;
use crate::thesis::kinematic_waveforms::{self, Match};
use crate::thesis::oscillator_waveforms;
use crate::thesis::waveforms::{Hold, NamedWaveform, all};
use crate::thesis::{steady, sweep};
use contact::SolveError;
use contact::{Shape, Sign};

/// Choice that is needed before the equations have a solution.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// Point that the thesis leaves open.
    pub what: &'static str,
    /// Choice made here.
    pub here: &'static str,
    /// Friction ratio at a velocity ratio of one half under each choice.
    pub numbers: Vec<(String, f64)>,
}

/// Computes all choices that the thesis leaves open.
pub fn choices() -> Result<Vec<Choice>, SolveError> {
    Ok([oscillator()?, waveforms()?].concat())
}

fn oscillator() -> Result<Vec<Choice>, SolveError> {
    let case = TABLE_4_1;
    let first = |duration_s: f64| sweep::friction(&case.at_ratio(PLOTTED_RATIO, duration_s));
    let short = first(SHORT_S)?;
    let mut forced = case.at_ratio(PLOTTED_RATIO, SHORT_S);
    forced.start.x_m = case.force_n / (case.stiffness_n_per_m - case.mass_kg * case.omega().powi(2));
    let mut slid = forced.clone();
    slid.start.force_n = case.coulomb_n();
    let solution = sweep::solution(&case.at_ratio(PLOTTED_RATIO, SHORT_S))?;
    let peak = solution.tally.unwrap_or_default().peak_velocity_m_per_s;
    let by_peak = sweep::friction(&case.oscillator(Shape::Sine, PLOTTED_RATIO * peak, SHORT_S))?;
    let literal = Case { sign: Sign::Literal, ..case };
    let mut sliding_only = case.oscillator(Shape::Still, PLOTTED_RATIO * case.vibration_m_per_s(), SHORT_S);
    sliding_only.window_s = (0.0, SHORT_S);
    let without = sweep::friction(&sliding_only)?;
    Ok(vec![
        Choice {
            what: "simulation time and averaging window",
            here: "the first millisecond, and also the steady state",
            numbers: vec![
                number("0-1 ms", short),
                number("0-10 ms", first(10.0 * SHORT_S)?),
                number("0.72-0.8 s", settled(PLOTTED_RATIO)?),
                number("steady, closed form", steady::dahl(PLOTTED_RATIO, case.kappa()).friction),
            ],
        },
        Choice {
            what: "initial conditions",
            here: "rest: x = x' = F = 0",
            numbers: vec![
                number("rest", short),
                number("forced motion, F = 0", sweep::friction(&forced)?),
                number("forced motion, F = Fc", sweep::friction(&slid)?),
            ],
        },
        Choice {
            what: "vibration velocity with two frequencies",
            here: "the steady forced velocity of the sine, w F0/|Ks - m w^2|",
            numbers: vec![
                number("Vt/Vv 0.5", short),
                number("Vt over the peak of x' 0.5", by_peak),
                number("peak of x' over Vv", peak / case.vibration_m_per_s()),
            ],
        },
        Choice {
            what: "sign of x' in the slip velocity",
            here: "V = Vt + x'",
            numbers: vec![
                number("passive", short),
                number("literal", sweep::friction(&literal.at_ratio(PLOTTED_RATIO, SHORT_S))?),
            ],
        },
        Choice {
            what: "friction without ultrasonics",
            here: "mu m g",
            numbers: vec![number("over mu m g", short), number("over the mean of a run without ultrasonics", short / without)],
        },
    ])
}

fn waveforms() -> Result<Vec<Choice>, SolveError> {
    let kinematic = |shape: Shape, matched: Match| {
        let problem = kinematic_waveforms::problem(&TABLE_4_1, shape, matched, PLOTTED_RATIO);
        sweep::friction(&problem)
    };
    let coupled = |named: &NamedWaveform, duration_s: f64| {
        sweep::friction(&oscillator_waveforms::problem(named, PLOTTED_RATIO, duration_s))
    };
    // With the sign reversed, a prescribed rising sawtooth is a falling one.
    let turned = Case { sign: Sign::Literal, ..TABLE_4_1 };
    let falling = kinematic_waveforms::problem(&turned, Shape::Sawtooth, Match::Peak, PLOTTED_RATIO);
    let [_, _, _, chirp, tenth] = all(SHORT_S, Hold::TenthPeriod);
    let [_, _, _, chirp_5, _] = all(5.0 * SHORT_S, Hold::TenthPeriod);
    let [_, _, _, _, stepped] = all(SHORT_S, Hold::SolverStep);
    Ok(vec![
        Choice {
            what: "quantity that is equal among waveforms",
            here: "the peak, and also the root mean square",
            numbers: vec![
                number("square, equal peaks", kinematic(Shape::Square, Match::Peak)?),
                number("square, equal rms", kinematic(Shape::Square, Match::Rms)?),
                number("sawtooth, equal peaks", kinematic(Shape::Sawtooth, Match::Peak)?),
                number("sawtooth, equal rms", kinematic(Shape::Sawtooth, Match::Rms)?),
            ],
        },
        Choice {
            what: "sense of the sawtooth, duty of the square",
            here: "rising; one half",
            numbers: vec![
                number("rising", kinematic(Shape::Sawtooth, Match::Peak)?),
                number("falling", sweep::friction(&falling)?),
            ],
        },
        Choice {
            what: "hold time of the random waveform (oscillator)",
            here: "a tenth of a period, and also the solver's step",
            numbers: vec![
                number("held T/10", coupled(&tenth, SHORT_S)?),
                number("held a solver step", coupled(&stepped, SHORT_S)?),
            ],
        },
        Choice {
            what: "end of the chirp, equal to the simulation time (oscillator)",
            here: "one millisecond",
            numbers: vec![number("1 ms", coupled(&chirp, SHORT_S)?), number("5 ms", coupled(&chirp_5, 5.0 * SHORT_S)?)],
        },
    ])
}
