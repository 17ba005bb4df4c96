//! Spectra of velocity and friction: Figure 4.10.

use super::StudyResult;
use super::case::PLOTTED_RATIO;
use super::case::TABLE_4_1;
use super::claim::{Check, Claim, number};
use super::picture::{figure, line, log_axis, ranged};
use super::spectrum::{Line, Spectrum};
use super::trace::trace;
use contact::{Problem, SolveError, State};
use report::Axis;

/// Length of the transformed section, s: bins of 50 Hz.
const SECTION_S: f64 = 20e-3;
/// Samples a period.
const SAMPLES_PER_PERIOD: f64 = 32.0;
/// Highest evaluated frequency of the spectra, Hz.
const HIGHEST_HZ: f64 = 200e3;

/// Spectra of velocity and friction of a run.
struct Spectra {
    velocity: Spectrum,
    friction: Spectrum,
}

impl Spectra {
    fn new(problem: &Problem) -> Result<Self, SolveError> {
        let every_s = 1.0 / (SAMPLES_PER_PERIOD * TABLE_4_1.frequency_hz);
        let states = trace(problem, every_s, problem.duration_s - SECTION_S, problem.duration_s - every_s)?;
        let of = |value: &dyn Fn(&State) -> f64| Spectrum::new(&states.iter().map(value).collect::<Vec<_>>(), every_s);
        Ok(Spectra { velocity: of(&|state| state.v_m_per_s), friction: of(&|state| state.force_n / problem.coulomb_n) })
    }
}

/// Computes Figure 4.10 and its claims.
pub fn study() -> Result<StudyResult, SolveError> {
    let rest = TABLE_4_1.at_ratio(PLOTTED_RATIO, SECTION_S);
    let mut forced = rest.clone();
    // Forced motion: x = F0 cos(wt) / (Ks - m w^2).
    forced.start.x_m = TABLE_4_1.force_n / (TABLE_4_1.stiffness_n_per_m - TABLE_4_1.mass_kg * TABLE_4_1.omega().powi(2));
    let (from_rest, from_forced) = rayon::join(|| Spectra::new(&rest), || Spectra::new(&forced));
    let (from_rest, from_forced) = (from_rest?, from_forced?);
    Ok(StudyResult {
        figures: figures(&from_rest),
        claims: vec![two_frequencies(&from_rest, &from_forced), combinations(&from_rest)],
    })
}

fn figures(spectra: &Spectra) -> Vec<report::Figure> {
    let caption = "From rest, first 20 ms, passive sign (chosen here, open in the thesis); velocity ratio 0.5, 384 N, 60 \
                   kHz. Blackman-Harris window, bins of 50 Hz; a line of amplitude a has a peak of a. The natural frequency \
                   is 12.98 kHz.";
    let draw = |id: &str, title: &str, label: &str, column: &str, spectrum: &Spectrum, floor: f64| {
        let hz = spectrum.frequencies_hz(HIGHEST_HZ);
        let khz: Vec<f64> = hz.iter().map(|hz| hz / 1e3).collect();
        let y: Vec<f64> = spectrum.amplitude[..hz.len()].to_vec();
        let top = y.iter().copied().fold(0.0, f64::max);
        let axes =
            [ranged("frequency [kHz]", 0.0, HIGHEST_HZ / 1e3), Axis { range: Some((floor, 3.0 * top)), ..log_axis(label) }];
        figure(id, title, caption.into(), axes, vec![line(title, column, &khz, y)])
    };
    vec![
        draw(
            "fig-4-10a",
            "Figure 4.10(a): spectrum of the velocity",
            "amplitude [m/s]",
            "velocity_m_per_s",
            &spectra.velocity,
            1e-8,
        ),
        draw(
            "fig-4-10b",
            "Figure 4.10(b): spectrum of the friction force",
            "amplitude / Fc",
            "friction_over_coulomb",
            &spectra.friction,
            1e-5,
        ),
    ]
}

fn two_frequencies(from_rest: &Spectra, from_forced: &Spectra) -> Claim {
    let (excitation, natural) = (TABLE_4_1.frequency_hz, TABLE_4_1.natural_hz());
    let check = |condition: &str, spectrum: &Spectrum| {
        let (at_excitation, at_natural) = (spectrum.at(excitation), spectrum.at(natural));
        let rest = spectrum.elsewhere(1e3, HIGHEST_HZ, &[excitation, natural]);
        let numbers = vec![
            number("at 60 kHz [m/s]", at_excitation),
            number("at 12.98 kHz [m/s]", at_natural),
            number("share of the power elsewhere", rest),
        ];
        Check::new(condition, at_natural > 0.01 * at_excitation && rest < 1e-4, numbers)
    };
    Claim {
        id: "two-frequencies",
        section: "4.3.1, Fig. 4.10a",
        says: "The velocity is not sinusoidal: it has two frequencies, the excitation and the natural one.",
        checks: vec![
            check("started from rest, first 20 ms", &from_rest.velocity),
            check("started on the forced motion", &from_forced.velocity),
        ],
    }
}

/// Finds the combination `p f + q fn` nearest to a line.
fn combination(line: &Line) -> (i32, i32, f64) {
    let (excitation, natural) = (TABLE_4_1.frequency_hz, TABLE_4_1.natural_hz());
    let all = (0..=4).flat_map(|p| (-6..=6).map(move |q| (p, q)));
    all.map(|(p, q)| (p, q, (f64::from(p) * excitation + f64::from(q) * natural - line.hz).abs()))
        .min_by(|a, b| a.2.total_cmp(&b.2))
        .unwrap_or((0, 0, f64::NAN))
}

fn combinations(spectra: &Spectra) -> Claim {
    let lines = spectra.friction.lines(2e3, HIGHEST_HZ, 1e-4);
    let named: Vec<_> = lines.iter().map(|line| (line, combination(line))).collect();
    let explained = named.iter().filter(|(_, (_, _, off))| *off <= 1.5 * spectra.friction.bin_hz).count();
    let mixed = named.iter().filter(|(_, (p, q, _))| *p != 0 && *q != 0).count();
    let mut numbers = vec![
        number("lines above 1e-4 Fc, 2-200 kHz", lines.len() as f64),
        number("of these at p f + q fn", explained as f64),
        number("sums and differences (p and q not 0)", mixed as f64),
    ];
    let mut strongest = named;
    strongest.sort_by(|a, b| b.0.amplitude.total_cmp(&a.0.amplitude));
    for (line, (p, q, _)) in strongest.iter().take(8) {
        numbers.push(number(format!("{p} f {q:+} fn, {:.1} kHz [Fc]", line.hz / 1e3), line.amplitude));
    }
    Claim {
        id: "friction-combination-frequencies",
        section: "4.3.1, Fig. 4.10b",
        says: "Friction's spectrum has the harmonics of both frequencies and of their sums and differences.",
        checks: vec![Check::new("from rest, first 20 ms", mixed >= 4 && explained == lines.len(), numbers)],
    }
}
