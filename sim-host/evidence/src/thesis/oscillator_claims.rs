//! Claims about waveforms on the oscillator (4.4.2).

use super::case::PLOTTED_RATIO;
use super::case::{Case, SHORT_S, TABLE_4_1};
use super::claim::{Check, Claim, number, series};
use super::oscillator_waveforms::{Results, problem, waveforms};
use super::trace::power_w;
use super::waveforms::{CHIRP_HZ, NamedWaveform, labels};
use super::{StudyResult, sweep};
use contact::{Shape, SolveError};

/// Indices of the waveforms in [`waveforms`].
const SINE: usize = 0;
const CHIRP: usize = 3;
const RANDOM_TENTH: usize = 4;
const RANDOM_STEP: usize = 5;

/// Computes Figures 4.21 to 4.26 and their claims.
pub fn study() -> Result<StudyResult, SolveError> {
    let results = Results::new()?;
    Ok(StudyResult { figures: results.figures(), claims: claims(&results)? })
}

/// Judges all claims.
fn claims(results: &Results) -> Result<Vec<Claim>, SolveError> {
    let displacement = results.largest(|_, state| 1e6 * state.x_m.abs());
    let velocity = results.largest(|_, state| state.v_m_per_s.abs());
    let settled = |time_s: f64| time_s > 0.1 * SHORT_S;
    let lowest: Vec<f64> = results
        .largest(|problem, state| if settled(state.time_s) { -state.force_n / problem.coulomb_n } else { f64::MIN })
        .iter()
        .map(|low| -low)
        .collect();
    let power = results.largest(|problem, state| 1e3 * power_w(problem, state));
    let largest: fn(&[f64], usize) -> bool = |values, index| values.iter().all(|&value| value <= values[index]);
    let least: fn(&[f64], usize) -> bool = |values, index| values.iter().all(|&value| value >= values[index]);
    let peaks = |name: &str, values: &[f64], extreme| both_readings(results, name, values, extreme);
    Ok(vec![
        random_is_small(results, &displacement),
        Claim {
            id: "chirp-largest-displacement",
            section: "4.4.2, Fig. 4.21",
            says: "The chirp produces the largest displacement.",
            checks: peaks("peak x [um]", &displacement, largest),
        },
        Claim {
            id: "chirp-largest-velocity",
            section: "4.4.2, Fig. 4.22",
            says: "The chirp produces the largest velocity.",
            checks: peaks("peak x' [m/s]", &velocity, largest),
        },
        Claim {
            id: "chirp-friction-bottoms-lower",
            section: "4.4.2, Fig. 4.23",
            says: "Under the chirp the friction force bottoms out at a lower, more negative value.",
            checks: peaks("smallest F/Fc", &lowest, least),
        },
        Claim {
            id: "chirp-power-peaks-higher",
            section: "4.4.2, Fig. 4.24",
            says: "The chirp's instantaneous power peaks higher than that of other waveforms.",
            checks: peaks("peak F V [mW]", &power, largest),
        },
        chirp_best(results)?,
        chirp_power(results),
    ])
}

/// Compares a quantity of all waveforms, for both hold times of the random one.
fn both_readings(results: &Results, name: &str, values: &[f64], extreme: fn(&[f64], usize) -> bool) -> Vec<Check> {
    let check = |condition: &str, left_out: usize| {
        let included: Vec<usize> = (0..values.len()).filter(|&index| index != left_out).collect();
        let labels: Vec<String> = included.iter().map(|&index| results.waveforms[index].name.to_owned()).collect();
        let values: Vec<f64> = included.iter().map(|&index| values[index]).collect();
        Check::new(condition, extreme(&values, CHIRP), series(name, &labels, &values))
    };
    vec![
        check("first ms, random held for a solver step", RANDOM_TENTH),
        check("first ms, random held for a tenth of a period", RANDOM_STEP),
    ]
}

fn random_is_small(results: &Results, displacement: &[f64]) -> Claim {
    let check = |condition: &str, random: usize| {
        let numbers =
            [SINE, CHIRP, random].map(|i| number(format!("peak x, {} [um]", results.waveforms[i].name), displacement[i]));
        Check::new(condition, displacement[random] < 0.5 * displacement[CHIRP], numbers.to_vec())
    };
    Claim {
        id: "random-displaces-little",
        section: "4.4.2, Fig. 4.21",
        says: "Random excitation displaces little (less than half of the chirp's displacement).",
        checks: vec![
            check("held for a solver step", RANDOM_STEP),
            check("held for a tenth of a period: the undamped oscillator walks at random", RANDOM_TENTH),
        ],
    }
}

fn chirp_best(results: &Results) -> Result<Claim, SolveError> {
    let friction = results.at(PLOTTED_RATIO, |ratios| ratios.friction);
    let mut checks = both_readings(results, "r", &friction, |values, index| values.iter().all(|&value| value >= values[index]));
    for duration_s in [0.5e-3, 2e-3, 5e-3, 10e-3] {
        let without_tenth: Vec<NamedWaveform> =
            waveforms(duration_s).into_iter().enumerate().filter(|(i, _)| *i != RANDOM_TENTH).map(|(_, named)| named).collect();
        let r = sweep::each(&without_tenth, |named| sweep::friction(&problem(named, PLOTTED_RATIO, duration_s)))?;
        let condition = format!("first {} ms, the chirp ending at their end, random held for a solver step", 1e3 * duration_s);
        checks.push(Check::new(condition, r.iter().all(|&r_i| r_i >= r[CHIRP]), series("r", &labels(&without_tenth), &r)));
    }
    checks.push(many_seeds(SHORT_S)?);
    checks.push(many_seeds(10.0 * SHORT_S)?);
    checks.push(same_peak_velocity(results)?);
    checks.push(against_low_sine(friction[CHIRP])?);
    Ok(Claim {
        id: "chirp-best-oscillator",
        section: "4.4.2, 5.1, Fig. 4.25",
        says: "With system dynamics the chirp reduces friction most.",
        checks,
    })
}

/// Compares the chirp with the mean of many seeds, as one random waveform proves little.
fn many_seeds(duration_s: f64) -> Result<Check, SolveError> {
    let all = waveforms(duration_s);
    let of = |shape: Shape| sweep::friction(&problem(&NamedWaveform { shape, ..all[CHIRP] }, PLOTTED_RATIO, duration_s));
    let Shape::Random { hold_s, .. } = all[RANDOM_TENTH].shape else { return Ok(Check::new("", false, Vec::new())) };
    let seeds: Vec<u64> = (1..=32).collect();
    let random = sweep::each(&seeds, |&seed| of(Shape::Random { hold_s, seed }))?;
    let chirp = of(all[CHIRP].shape)?;
    let count = random.len() as f64;
    let mean = random.iter().sum::<f64>() / count;
    let numbers = vec![
        number("r chirp", chirp),
        number("r random, mean", mean),
        number("share of the seeds in which random is lower", random.iter().filter(|&&r| r < chirp).count() as f64 / count),
    ];
    let condition = format!("first {} ms, random held for a tenth of a period, mean of 32 seeds", 1e3 * duration_s);
    Ok(Check::new(condition, mean > chirp, numbers))
}

/// Compares the waveforms with the sliding speed at half of each one's peak velocity.
fn same_peak_velocity(results: &Results) -> Result<Check, SolveError> {
    let peak = results.largest(|_, state| state.v_m_per_s.abs());
    let paired: Vec<(NamedWaveform, f64)> = results.waveforms.iter().copied().zip(peak).collect();
    let r =
        sweep::each(&paired, |(named, peak)| sweep::friction(&TABLE_4_1.oscillator(named.shape, PLOTTED_RATIO * peak, SHORT_S)))?;
    let best = r.iter().all(|&r_i| r_i >= r[CHIRP]);
    Ok(Check::new("velocity ratio 0.5 of each waveform's own peak velocity, first ms", best, series("r", &results.labels(), &r)))
}

/// Compares the chirp with a plain sine at 20 kHz. The chirp's advantage is the higher compliance
/// of the oscillator there, which the sine has as well.
fn against_low_sine(chirp: f64) -> Result<Check, SolveError> {
    let low = Case { frequency_hz: CHIRP_HZ.0, ..TABLE_4_1 };
    let speed = PLOTTED_RATIO * TABLE_4_1.vibration_m_per_s();
    let sine = sweep::friction(&low.oscillator(Shape::Sine, speed, SHORT_S))?;
    let compliance = |case: &Case| 1.0 / (case.stiffness_n_per_m - case.mass_kg * case.omega().powi(2)).abs();
    let numbers = vec![
        number("r chirp", chirp),
        number("r sine at 20 kHz", sine),
        number("compliance at 20 kHz over 60 kHz", compliance(&low) / compliance(&TABLE_4_1)),
    ];
    Ok(Check::new("against a sine of the chirp's first frequency, 20 kHz, first ms", chirp < sine, numbers))
}

fn chirp_power(results: &Results) -> Claim {
    let largest: fn(&[f64], usize) -> bool = |values, index| values.iter().all(|&value| value <= values[index]);
    let direct = results.at(PLOTTED_RATIO, |ratios| ratios.power.unwrap_or(f64::NAN));
    let printed = results.at(PLOTTED_RATIO, |ratios| ratios.power_as_printed.unwrap_or(f64::NAN));
    let mut checks = both_readings(results, "phi", &direct, largest);
    checks.extend(
        both_readings(results, "phi by 4.35", &printed, largest)
            .into_iter()
            .map(|check| Check { condition: format!("{}, by 4.35 as printed", check.condition), ..check }),
    );
    Claim {
        id: "chirp-highest-power",
        section: "4.4.2, Fig. 4.26",
        says: "With system dynamics the chirp has the highest power dissipation ratio.",
        checks,
    }
}
