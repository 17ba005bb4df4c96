//! Claims about waveforms on Dahl's equation (4.4.1).

use super::case::PLOTTED_RATIO;
use super::case::{Case, TABLE_4_1};
use super::claim::{Check, Claim, number, series};
use super::kinematic_waveforms::{self, Curves, Match, STIFFER_FACTOR, Traces, problem};
use super::spectrum::Spectrum;
use super::trace::{power_w, trace};
use super::waveforms::CHIRP_HZ;
use super::{StudyResult, sweep};
use contact::tally::Ratios;
use contact::{Problem, Shape, SolveError, State};

/// Indices of the waveforms in [`super::waveforms::all`].
const SINE: usize = 0;
const SQUARE: usize = 1;
const SAWTOOTH: usize = 2;
const CHIRP: usize = 3;

/// Computes Figures 4.17 to 4.20 and their claims.
pub fn study() -> Result<StudyResult, SolveError> {
    let (curves, traces, figures) = kinematic_waveforms::results()?;
    Ok(StudyResult { figures, claims: claims(&curves, &traces)? })
}

/// Judges all claims.
fn claims(curves: &Curves, traces: &Traces) -> Result<Vec<Claim>, SolveError> {
    let stiff = Case { contact_n_per_m: STIFFER_FACTOR * TABLE_4_1.contact_n_per_m, ..TABLE_4_1 };
    let stiff_traces = Traces::new(&curves.waveforms, &stiff)?;
    let stiff_ratios =
        sweep::each(&curves.waveforms, |named| sweep::ratios(&problem(&stiff, named.shape, Match::Peak, PLOTTED_RATIO)))?;
    Ok(vec![
        resembles_coulomb(curves, traces, &stiff_traces),
        sawtooth(curves),
        chirp(traces),
        fourier()?,
        many_frequencies(curves, traces),
        square_best(curves),
        square_power(curves, &stiff_ratios),
    ])
}

fn extreme(values: &[f64], index: usize, least: bool) -> bool {
    values.iter().enumerate().all(|(other, &value)| other == index || (value > values[index]) == least)
}

fn resembles_coulomb(curves: &Curves, soft: &Traces, stiff: &Traces) -> Claim {
    // Root mean square distance of F/Fc from the sign of the slip, over the trace.
    let distance = |problem: &Problem, states: &[State]| {
        let off = |state: &State| {
            let slip = problem.sliding_m_per_s + state.v_m_per_s;
            (state.force_n / problem.coulomb_n - slip.signum()).powi(2)
        };
        (states.iter().map(off).sum::<f64>() / states.len() as f64).sqrt()
    };
    let check = |condition: &str, traces: &Traces| {
        let values: Vec<f64> = traces.problems.iter().zip(&traces.states).map(|(p, states)| distance(p, states)).collect();
        Check::new(condition, values[SQUARE] < 0.25, series("rms(F/Fc - sgn V)", &curves.labels(), &values))
    };
    Claim {
        id: "square-resembles-coulomb",
        section: "4.4.1, Fig. 4.17",
        says: "Under a square wave Dahl's force resembles Coulomb's (rms distance below a quarter of Fc).",
        checks: vec![
            check("contact of Table 4.1 (kappa 0.40), velocity ratio 0.5", soft),
            check("contact a hundred times stiffer (kappa 40)", stiff),
        ],
    }
}

fn sawtooth(curves: &Curves) -> Claim {
    let check = |matched: Match, word: &str, xi: f64| {
        let r = curves.at(matched, xi, |ratios| ratios.friction);
        let numbers = vec![number("r sawtooth", r[SAWTOOTH]), number("r sine", r[SINE])];
        Check::new(format!("equal {word}, velocity ratio {xi}"), r[SAWTOOTH] > r[SINE], numbers)
    };
    Claim {
        id: "sawtooth-higher-friction",
        section: "4.4.1",
        says: "Under a sawtooth the mean friction is higher than under a sine.",
        checks: vec![
            check(Match::Peak, "peaks", 0.1),
            check(Match::Peak, "peaks", 0.5),
            check(Match::Peak, "peaks", 0.9),
            check(Match::Rms, "rms", 0.5),
        ],
    }
}

fn chirp(traces: &Traces) -> Claim {
    // The intervals of the force's upward zero crossings give its frequency over time.
    let problem = &traces.problems[CHIRP];
    let states = &traces.states[CHIRP];
    let mean = states.iter().map(|state| state.force_n).sum::<f64>() / states.len() as f64;
    let crossings: Vec<f64> =
        states.windows(2).filter(|pair| pair[0].force_n < mean && pair[1].force_n >= mean).map(|pair| pair[0].time_s).collect();
    let hz: Vec<f64> = crossings.windows(2).map(|pair| 1.0 / (pair[1] - pair[0])).collect();
    let (first, last) = (hz.first().copied().unwrap_or(f64::NAN), hz.last().copied().unwrap_or(f64::NAN));
    let at = |time_s: f64| CHIRP_HZ.0 + (CHIRP_HZ.1 - CHIRP_HZ.0) * time_s / problem.duration_s;
    let middle = |index: usize| 0.5 * (crossings[index] + crossings[index + 1]);
    let expected = [at(middle(0)), at(middle(hz.len() - 1))];
    let follows = (first / expected[0] - 1.0).abs() < 0.03 && (last / expected[1] - 1.0).abs() < 0.03;
    let numbers = vec![
        number("force, first cycle [kHz]", first / 1e3),
        number("chirp at that time [kHz]", expected[0] / 1e3),
        number("force, last cycle [kHz]", last / 1e3),
        number("chirp at that time [kHz]", expected[1] / 1e3),
    ];
    Claim {
        id: "chirp-force-follows",
        section: "4.4.1",
        says: "Under a chirp the frequency of the friction force follows that of the chirp over time.",
        checks: vec![Check::new("1.0 to 1.3 ms, by the intervals of zero crossings (within 3 %)", follows, numbers)],
    }
}

/// Judges if Fourier transforms can resolve the frequency of a chirp's force over time.
fn fourier() -> Result<Claim, SolveError> {
    let (window_s, every_s) = (0.25e-3, 1.0 / (64.0 * TABLE_4_1.frequency_hz));
    let sweep_s = kinematic_waveforms::RUN_S;
    let shape = Shape::Chirp { start_hz: CHIRP_HZ.0, stop_hz: CHIRP_HZ.1, sweep_s };
    let states = trace(&problem(&TABLE_4_1, shape, Match::Peak, PLOTTED_RATIO), every_s, 0.0, sweep_s)?;
    let force: Vec<f64> = states.iter().map(|state| state.force_n).collect();
    let count = (window_s / every_s).round() as usize;
    let strongest = |spectrum: &Spectrum| {
        let lines = spectrum.lines(CHIRP_HZ.0 - 5e3, CHIRP_HZ.1 + 5e3, 0.0);
        lines.into_iter().max_by(|a, b| a.amplitude.total_cmp(&b.amplitude)).map_or(f64::NAN, |line| line.hz)
    };
    let off = |(index, part): (usize, &[f64])| {
        let middle_s = (index as f64 + 0.5) * window_s;
        strongest(&Spectrum::new(part, every_s)) - (CHIRP_HZ.0 + (CHIRP_HZ.1 - CHIRP_HZ.0) * middle_s / sweep_s)
    };
    let most = force.chunks_exact(count).enumerate().map(|part| off(part).abs()).fold(0.0, f64::max);
    let whole = Spectrum::new(&force, every_s);
    let bins = (CHIRP_HZ.0 / whole.bin_hz) as usize..(CHIRP_HZ.1 / whole.bin_hz) as usize;
    let mean = whole.amplitude[bins.clone()].iter().sum::<f64>() / bins.len() as f64;
    let top = whole.amplitude[bins].iter().copied().fold(0.0, f64::max);
    Ok(Claim {
        id: "fourier-fails-for-chirp",
        section: "4.4.1, 4.5",
        says: "The response to a chirp cannot be analysed by Fourier transforms.",
        checks: vec![
            Check::new(
                "one transform of the whole run: no line stands out (peak below ten times the mean)",
                top < 10.0 * mean,
                vec![number("largest over mean amplitude, 20-200 kHz", top / mean)],
            ),
            Check::new(
                "transforms of 0.25 ms each: the strongest line is off the chirp by more than a bin of 4 kHz",
                most > 1.0 / window_s,
                vec![number("largest deviation from the chirp's frequency [kHz]", most / 1e3)],
            ),
        ],
    })
}

fn many_frequencies(curves: &Curves, traces: &Traces) -> Claim {
    let counts: Vec<f64> = traces
        .problems
        .iter()
        .zip(&traces.states)
        .map(|(problem, states)| {
            let power: Vec<f64> = states[1..].iter().map(|state| power_w(problem, state)).collect();
            let spectrum = Spectrum::new(&power, states[1].time_s - states[0].time_s);
            let top = spectrum.lines(20e3, 600e3, 0.0).iter().map(|line| line.amplitude).fold(0.0, f64::max);
            spectrum.lines(20e3, 600e3, 0.01 * top).len() as f64
        })
        .collect();
    Claim {
        id: "power-has-many-frequencies",
        section: "4.4.1, Fig. 4.18",
        says: "With every waveform the instantaneous power has several frequencies.",
        checks: vec![Check::new(
            "lines above 1 % of the largest, 20-600 kHz, velocity ratio 0.5",
            counts.iter().all(|&count| count >= 2.0),
            series("lines", &curves.labels(), &counts),
        )],
    }
}

fn square_best(curves: &Curves) -> Claim {
    let check = |matched: Match, word: &str, xi: f64| {
        let r = curves.at(matched, xi, |ratios| ratios.friction);
        Check::new(format!("equal {word}, velocity ratio {xi}"), extreme(&r, SQUARE, true), series("r", &curves.labels(), &r))
    };
    Claim {
        id: "square-best-kinematic",
        section: "4.4.1, Fig. 4.19",
        says: "Without system dynamics the square wave reduces friction most.",
        checks: vec![
            check(Match::Peak, "peaks", 0.1),
            check(Match::Peak, "peaks", 0.5),
            check(Match::Peak, "peaks", 0.9),
            check(Match::Rms, "rms", 0.1),
            check(Match::Rms, "rms", 0.5),
            check(Match::Rms, "rms", 0.9),
        ],
    }
}

fn square_power(curves: &Curves, stiff: &[Ratios]) -> Claim {
    let power = |ratios: &Ratios| ratios.power.unwrap_or(f64::NAN);
    let check = |condition: &str, phi: Vec<f64>| {
        Check::new(condition, extreme(&phi, SQUARE, false), series("phi", &curves.labels(), &phi))
    };
    Claim {
        id: "square-highest-power-kinematic",
        section: "4.4.1, Fig. 4.20",
        says: "Without system dynamics the square wave has the highest power dissipation ratio.",
        checks: vec![
            check("equal peaks, contact of Table 4.1 (kappa 0.40), velocity ratio 0.1", curves.at(Match::Peak, 0.1, power)),
            check("equal peaks, contact of Table 4.1, velocity ratio 0.5", curves.at(Match::Peak, 0.5, power)),
            check(
                "equal peaks, contact a hundred times stiffer (kappa 40), velocity ratio 0.5",
                stiff.iter().map(power).collect(),
            ),
        ],
    }
}
