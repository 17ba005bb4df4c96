//! Coulomb's and Dahl's friction under a prescribed vibration: Figures 4.6 and 4.7.

use super::case::{PLOTTED_RATIO, SHORT_S, TABLE_4_1};
use super::claim::{Check, Claim, number};
use super::picture::{FRICTION_RATIO, STEADY, VELOCITY_RATIO, axis, dashed, figure, line, ranged};
use super::{StudyResult, model_claims, steady, sweep, trace};
use contact::{Shape, SolveError, State};
use report::Figure;

/// Computes Figures 4.6 and 4.7 and their claims.
pub fn study() -> Result<StudyResult, SolveError> {
    let instant = InstantaneousForce::new()?;
    Ok(StudyResult {
        figures: vec![ratios(), instant.coulomb_figure(), instant.dahl_figure()],
        claims: [model_claims::claims()?, vec![instant.pulses()]].concat(),
    })
}

fn ratios() -> Figure {
    let xi = sweep::spaced(0.01, 1.0, 100);
    let kappa = TABLE_4_1.kappa();
    let dahl = |kappa: f64| xi.iter().map(|&xi| steady::dahl(xi, kappa).friction).collect();
    let series = vec![
        line("Coulomb", "coulomb", &xi, xi.iter().map(|&xi| steady::coulomb(xi)).collect()),
        line(format!("Dahl, 384 N (κ = {kappa:.3})"), "dahl_384_n", &xi, dahl(kappa)),
        line(format!("Dahl, 1920 N (κ = {:.2})", 5.0 * kappa), "dahl_1920_n", &xi, dahl(5.0 * kappa)),
        dashed("Dahl, κ → 0", "dahl_limit", &xi, xi.iter().map(|&xi| steady::compliant(xi)).collect()),
    ];
    let caption = format!(
        "The vibration velocity is a prescribed sine. Coulomb's curve is the limit of Dahl's for κ = Kt Vv/(ω Fc) → ∞; \
         every Dahl curve lies between it and the limit for κ → 0. {STEADY}"
    );
    let axes = [ranged(VELOCITY_RATIO, 0.0, 1.0), ranged(FRICTION_RATIO, 0.0, 1.0)];
    figure("fig-4-06", "Figure 4.6: Coulomb and Dahl, friction ratio over velocity ratio", caption, axes, series)
}

/// Steady force over time under a prescribed vibration.
struct InstantaneousForce {
    time_us: Vec<f64>,
    vibration: f64,
    states: Vec<State>,
    /// Largest change of F/Fc between neighbouring samples, at a hundred and at a thousand samples
    /// a period.
    jumps: [f64; 2],
    coulomb_jumps: [f64; 2],
}

impl InstantaneousForce {
    fn new() -> Result<Self, SolveError> {
        let vibration = TABLE_4_1.vibration_m_per_s();
        let period_s = 1.0 / TABLE_4_1.frequency_hz;
        let problem = TABLE_4_1.kinematic(Shape::Sine, vibration, PLOTTED_RATIO * vibration, SHORT_S);
        let jump = |values: &[f64]| values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
        let at = |samples: f64| trace::trace(&problem, period_s / samples, 50.0 * period_s, 53.0 * period_s);
        let force = |states: &[State]| states.iter().map(|state| state.force_n / problem.coulomb_n).collect::<Vec<_>>();
        let (coarse, fine) = (at(100.0)?, at(1000.0)?);
        Ok(InstantaneousForce {
            time_us: fine.iter().map(|state| 1e6 * (state.time_s - 50.0 * period_s)).collect(),
            vibration,
            jumps: [jump(&force(&coarse)), jump(&force(&fine))],
            coulomb_jumps: [jump(&coulomb_force(&coarse, vibration)), jump(&coulomb_force(&fine, vibration))],
            states: fine,
        })
    }

    fn coulomb_figure(&self) -> Figure {
        let y = coulomb_force(&self.states, self.vibration);
        let caption = format!("F = Fc sgn(Vt + Vv cos ωt) (4.3) at a velocity ratio of 0.5, 60 kHz, three periods. {STEADY}");
        let axes = [axis("time [µs]"), ranged("friction / Fc", -1.1, 1.1)];
        let series = vec![line("Coulomb", "friction_over_coulomb", &self.time_us, y)];
        figure("fig-4-07a", "Figure 4.7(a): instantaneous friction force, Coulomb", caption, axes, series)
    }

    fn dahl_figure(&self) -> Figure {
        let fc = TABLE_4_1.coulomb_n();
        let y = self.states.iter().map(|state| state.force_n / fc).collect();
        let caption = format!(
            "Dahl's equation (4.15) under the same prescribed vibration, Table 4.1 (κ = {:.3}): the vibration is too small \
             for the force to reach −Fc. {STEADY}",
            TABLE_4_1.kappa()
        );
        let axes = [axis("time [µs]"), ranged("friction / Fc", -1.1, 1.1)];
        let series = vec![line("Dahl", "friction_over_coulomb", &self.time_us, y)];
        figure("fig-4-07b", "Figure 4.7(b): instantaneous friction force, Dahl", caption, axes, series)
    }

    fn pulses(&self) -> Claim {
        let numbers = vec![
            number("Coulomb: largest jump of F/Fc at 100 samples a period", self.coulomb_jumps[0]),
            number("at 1000", self.coulomb_jumps[1]),
            number("Dahl: at 100", self.jumps[0]),
            number("at 1000", self.jumps[1]),
        ];
        // As the sample interval shrinks, a jump stays and the step of a slope shrinks.
        let pulse = self.coulomb_jumps[1] > 0.99 * self.coulomb_jumps[0];
        let continuous = self.jumps[1] < 0.2 * self.jumps[0];
        Claim {
            id: "coulomb-pulses",
            section: "4.3, Fig. 4.7",
            says: "Coulomb's instantaneous force is discontinuous, like pulses; Dahl's is continuous and oscillates.",
            checks: vec![Check::new("velocity ratio 0.5, Table 4.1", pulse && continuous, numbers)],
        }
    }
}

fn coulomb_force(states: &[State], vibration: f64) -> Vec<f64> {
    states.iter().map(|state| (PLOTTED_RATIO * vibration + state.v_m_per_s).signum()).collect()
}
