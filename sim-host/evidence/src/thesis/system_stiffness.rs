//! Effect of the system stiffness, including resonance: Figure 4.15 (4.3.3.5).

use super::case::{Case, SHORT_S, TABLE_4_1};
use super::claim::{Check, Claim, number, series};
use super::parametric::JUDGED_RATIO;
use super::picture::{FRICTION_RATIO, POWER_RATIO, column, figure, line, log_axis, ranged};
use super::{StudyResult, sweep};
use contact::tally::Ratios;
use contact::tally::Tally;
use contact::{Shape, SolveError};
use report::Figure;

/// Damping ratio of the damped resonance; the thesis has no damping.
const DAMPING_RATIO: f64 = 0.01;
const CHOICES_CAPTION: &str = "The sliding speed is the abscissa times the steady vibration velocity at the stiffness of Table 4.1 \
                        (0.0534 m/s), as an undamped oscillator at resonance has no steady velocity. Chosen here, open in \
                        the thesis: this definition, from rest, passive sign, means over the first millisecond.";

/// System stiffnesses with their results.
struct Stiffnesses {
    labels: Vec<String>,
    ratios: Vec<f64>,
    results: Vec<Vec<(Ratios, Tally)>>,
}

/// Computes Figure 4.15 and its claims.
pub fn study() -> Result<StudyResult, SolveError> {
    let data = Stiffnesses::new()?;
    Ok(StudyResult {
        figures: data.figures(),
        claims: vec![data.resonance(), data.power(), data.compliant(), bounded()?, data.by_velocity()?],
    })
}

/// Returns the stiffness at which Table 4.1's excitation is at resonance, N/m.
pub fn resonant_n_per_m() -> f64 {
    TABLE_4_1.mass_kg * TABLE_4_1.omega().powi(2)
}

impl Stiffnesses {
    fn new() -> Result<Self, SolveError> {
        let resonant = resonant_n_per_m();
        let values = [1e6, TABLE_4_1.stiffness_n_per_m, 1.33e9, resonant, 1.33e10];
        let ratios = sweep::velocity_ratios();
        let base = TABLE_4_1.vibration_m_per_s();
        let results = sweep::curves(&values, &ratios, |&stiffness_n_per_m, xi| {
            let case = Case { stiffness_n_per_m, ..TABLE_4_1 };
            let solution = sweep::solution(&case.oscillator(Shape::Sine, xi * base, SHORT_S))?;
            Ok((solution.ratios, solution.tally.unwrap_or_default()))
        })?;
        let label =
            |k: f64| if k == resonant { format!("{:.0} N/µm (resonance)", k / 1e6) } else { format!("{} N/µm", k / 1e6) };
        Ok(Stiffnesses { labels: values.iter().map(|&k| label(k)).collect(), ratios, results })
    }

    fn at(&self, velocity_ratio: f64, of: impl Fn(&(Ratios, Tally)) -> f64) -> Vec<f64> {
        let index = self.ratios.iter().position(|&xi| xi > velocity_ratio - 1e-9).unwrap_or(0);
        self.results.iter().map(|curve| of(&curve[index])).collect()
    }

    fn figures(&self) -> Vec<Figure> {
        let draw = |id: &str, title: &str, label: &str, of: &dyn Fn(&Ratios) -> f64| {
            let named = self.labels.iter().zip(&self.results);
            let curve = |(label, curve): (&String, &Vec<(Ratios, Tally)>)| {
                line(
                    format!("Ks {label}"),
                    column("ks", label),
                    &self.ratios,
                    curve.iter().map(|(ratios, _)| of(ratios)).collect(),
                )
            };
            let axes = [ranged("velocity ratio Vt/Vv at the stiffness of Table 4.1", 0.0, 1.0), log_axis(label)];
            figure(id, title, CHOICES_CAPTION.into(), axes, named.map(curve).collect())
        };
        vec![
            draw("fig-4-15a", "Figure 4.15(a): effect of the system stiffness on the friction ratio", FRICTION_RATIO, &|r| {
                r.friction
            }),
            draw("fig-4-15b", "Figure 4.15(b): effect of the system stiffness on the power ratio", POWER_RATIO, &|r| {
                r.power.unwrap_or(f64::NAN)
            }),
        ]
    }

    /// Index of the resonance among the curves.
    const RESONANCE: usize = 3;

    fn resonance(&self) -> Claim {
        let check = |xi: f64| {
            let r = self.at(xi, |(ratios, _)| ratios.friction);
            let least = r.iter().enumerate().all(|(i, &r_i)| i == Self::RESONANCE || r_i > r[Self::RESONANCE]);
            Check::new(
                format!("first ms from rest, velocity ratio {xi} at the stiffness of Table 4.1"),
                least,
                series("r", &self.labels, &r),
            )
        };
        Claim {
            id: "resonance-lowers-friction",
            section: "4.3.3.5, Fig. 4.15a",
            says: "Excited at the natural frequency, the system has the largest vibration and the lowest friction ratio.",
            checks: vec![check(0.1), check(JUDGED_RATIO), check(1.0)],
        }
    }

    fn power(&self) -> Claim {
        let phi = self.at(JUDGED_RATIO, |(ratios, _)| ratios.power.unwrap_or(f64::NAN));
        let most = phi.iter().enumerate().all(|(i, &phi_i)| i == Self::RESONANCE || phi_i < phi[Self::RESONANCE]);
        Claim {
            id: "resonance-raises-power",
            section: "4.3.3.5, Fig. 4.15b",
            says: "At the higher vibration velocity of resonance the power dissipated by friction is also high.",
            checks: vec![Check::new("first ms from rest, velocity ratio 0.5", most, series("phi", &self.labels, &phi))],
        }
    }

    fn compliant(&self) -> Claim {
        let phi = self.at(JUDGED_RATIO, |(ratios, _)| ratios.power.unwrap_or(f64::NAN));
        let numbers = series("phi", &self.labels[..3], &phi[..3]);
        Claim {
            id: "low-stiffness-power-unaffected",
            section: "4.3.3.5, Fig. 4.15b",
            says: "For low system stiffness the power dissipation ratio is not affected significantly.",
            checks: vec![
                Check::new(
                    "1e6 compared with Table 4.1's 133e6 N/m, velocity ratio 0.5 (within 2 %)",
                    (phi[0] / phi[1] - 1.0).abs() < 0.02,
                    numbers.clone(),
                ),
                Check::new(
                    "Table 4.1's stiffness compared with ten times it, velocity ratio 0.5 (within 2 %)",
                    (phi[2] / phi[1] - 1.0).abs() < 0.02,
                    numbers,
                ),
            ],
        }
    }

    /// Judges if resonance does more than raise the velocity.
    fn by_velocity(&self) -> Result<Claim, SolveError> {
        let peak = self.at(JUDGED_RATIO, |(_, tally)| tally.peak_velocity_m_per_s);
        let r = |stiffness_n_per_m: f64, peak: f64| {
            let case = Case { stiffness_n_per_m, ..TABLE_4_1 };
            sweep::friction(&case.oscillator(Shape::Sine, JUDGED_RATIO * peak, SHORT_S))
        };
        let (base, resonant) = (r(TABLE_4_1.stiffness_n_per_m, peak[1])?, r(resonant_n_per_m(), peak[Self::RESONANCE])?);
        let numbers = vec![
            number("r, Table 4.1", base),
            number("r, resonance", resonant),
            number("peak x', Table 4.1 [m/s]", peak[1]),
            number("peak x', resonance [m/s]", peak[Self::RESONANCE]),
        ];
        let fixed = self.at(JUDGED_RATIO, |(ratios, _)| ratios.friction);
        let same_speed = vec![number("r, Table 4.1", fixed[1]), number("r, resonance", fixed[Self::RESONANCE])];
        Ok(Claim {
            id: "operate-at-resonance",
            section: "4.3.3.5, 5.2",
            says: "Operation at the natural frequency is desirable to maximise friction reduction.",
            checks: vec![
                Check::new("same force, same sliding speed", fixed[Self::RESONANCE] < fixed[1], same_speed),
                Check::new("same velocity ratio of the peak of x', 0.5 (lower by a tenth)", resonant < 0.9 * base, numbers),
            ],
        })
    }
}

/// Compares the peak velocities at resonance over runs of growing duration.
fn bounded() -> Result<Claim, SolveError> {
    let check = |condition: &str, damping_ratio: f64| {
        let case = Case { stiffness_n_per_m: resonant_n_per_m(), damping_ratio, ..TABLE_4_1 };
        let speed = JUDGED_RATIO * TABLE_4_1.vibration_m_per_s();
        let durations = [SHORT_S, 2.0 * SHORT_S, 4.0 * SHORT_S];
        let peaks = sweep::each(&durations, |&duration_s| {
            let solution = sweep::solution(&case.oscillator(Shape::Sine, speed, duration_s))?;
            Ok(solution.tally.unwrap_or_default().peak_velocity_m_per_s)
        })?;
        let labels = durations.map(|duration_s| format!("{} ms", 1e3 * duration_s));
        Ok::<_, SolveError>(Check::new(condition, peaks[2] < 1.01 * peaks[1], series("peak x' [m/s]", &labels, &peaks)))
    };
    Ok(Claim {
        id: "resonance-has-a-finite-velocity",
        section: "4.3.3.5",
        says: "At the natural frequency the vibration velocity rises to a value set by the system's properties.",
        checks: vec![
            check("undamped, as in the thesis (the last doubling adds less than 1 %)", 0.0)?,
            check("damping ratio 0.01, not in the thesis (the last doubling adds less than 1 %)", DAMPING_RATIO)?,
        ],
    })
}
