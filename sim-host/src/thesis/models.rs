//! Coulomb's and Dahl's friction under a given vibration: Figures 4.6 and 4.7, and how LuGre's becomes Dahl's.

use super::case::{Case, SHORT_S, TABLE_4_1};
use super::claim::{Check, Claim, number};
use super::picture::{FRICTION_RATIO, STEADY, VELOCITY_RATIO, axis, dashed, figure, line, ranged};
use super::{Part, steady, sweep, trace};
use crate::contact::{Law, Shape, State, Trouble};

/// Velocity ratio of the thesis's time plots (4.3.1).
pub const PLOTTED_RATIO: f64 = 0.5;

/// Figures 4.6 and 4.7 with their claims.
pub fn study() -> Result<Part, Trouble> {
    let instant = Instant::new()?;
    Ok(Part {
        figures: vec![ratios()?, instant.coulomb_figure(), instant.dahl_figure()],
        claims: vec![coulomb_reduces_more()?, dahl_depends()?, instant.pulses(), lugre_becomes_dahl()?],
    })
}

fn ratios() -> Result<crate::report::Figure, Trouble> {
    let xi = sweep::spaced(0.01, 1.0, 100);
    let kappa = TABLE_4_1.kappa();
    let dahl = |kappa: f64| sweep::each(&xi, |&xi| Ok(steady::dahl(xi, kappa)?.friction));
    let series = vec![
        line("Coulomb", "coulomb", &xi, xi.iter().map(|&xi| steady::coulomb(xi).friction).collect()),
        line(format!("Dahl, 384 N (κ = {kappa:.3})"), "dahl_384_n", &xi, dahl(kappa)?),
        line(format!("Dahl, 1920 N (κ = {:.2})", 5.0 * kappa), "dahl_1920_n", &xi, dahl(5.0 * kappa)?),
        dashed("Dahl, κ → 0", "dahl_limit", &xi, xi.iter().map(|&xi| steady::compliant(xi)).collect()),
    ];
    let caption = format!(
        "The vibration velocity is given as a sine. Coulomb's curve is the limit of Dahl's for κ = Kt Vv/(ω Fc) → ∞; every Dahl curve \
         lies between it and the limit for κ → 0. {STEADY}"
    );
    let axes = [ranged(VELOCITY_RATIO, 0.0, 1.0), ranged(FRICTION_RATIO, 0.0, 1.0)];
    Ok(figure("fig-4-06", "Figure 4.6: Coulomb and Dahl, friction ratio over velocity ratio", caption, axes, series))
}

fn coulomb_reduces_more() -> Result<Claim, Trouble> {
    let grid: Vec<(f64, f64)> = [0.05, 0.1, 0.2, TABLE_4_1.kappa(), 1.0, 2.0, 4.0, 10.0, 20.0]
        .into_iter()
        .flat_map(|kappa| (1..=19).map(move |i| (0.05 * f64::from(i), kappa)))
        .collect();
    let excess = sweep::each(&grid, |&(xi, kappa)| Ok(steady::dahl(xi, kappa)?.friction - steady::coulomb(xi).friction))?;
    let least = excess.iter().copied().fold(f64::INFINITY, f64::min);
    let here = steady::dahl(PLOTTED_RATIO, TABLE_4_1.kappa())?.friction;
    let numbers = vec![
        number("r Dahl(0.5)", here),
        number("r Coulomb(0.5)", steady::coulomb(PLOTTED_RATIO).friction),
        number("least r Dahl - r Coulomb on the grid", least),
    ];
    let condition = format!("{} points, velocity ratios 0.05 to 0.95, kappa 0.05 to 20", grid.len());
    Ok(Claim {
        id: "coulomb-reduces-more",
        section: "4.3, Fig. 4.6",
        says: "Without system dynamics, Coulomb friction is reduced more than Dahl friction.",
        checks: vec![Check::new(condition, least > 0.0, numbers)],
    })
}

fn dahl_depends() -> Result<Claim, Trouble> {
    let base = TABLE_4_1;
    let ratio = |kappa: f64| Ok(steady::dahl(PLOTTED_RATIO, kappa)?.friction);
    let here = ratio(base.kappa())?;
    let doubled = [
        ("m", Case { mass_kg: 2.0 * base.mass_kg, ..base }),
        ("mu", Case { mu: 2.0 * base.mu, ..base }),
        ("Kt", Case { contact_n_per_m: 2.0 * base.contact_n_per_m, ..base }),
    ];
    let mut numbers = vec![number("r", here)];
    for (name, case) in doubled {
        // The vibration velocity is given here: the mass acts through the load only.
        let kappa = case.contact_n_per_m * base.vibration_m_per_s() / (base.omega() * case.coulomb_n());
        numbers.push(number(format!("r, {name} doubled"), ratio(kappa)?));
    }
    let all_differ = numbers[1..].iter().all(|(_, r)| (r - here).abs() > 1e-3);
    Ok(Claim {
        id: "dahl-depends-on-m-mu-kt",
        section: "4.3",
        says: "With Dahl friction the reduction depends on mass, coefficient of friction and contact stiffness too.",
        checks: vec![Check::new("velocity ratio 0.5, through kappa = Kt Vv / (w mu m g) only", all_differ, numbers)],
    })
}

/// Force over time under a given vibration, steady.
struct Instant {
    time_us: Vec<f64>,
    vibration: f64,
    states: Vec<State>,
    /// Largest change of F/Fc between neighbours at a hundred and at a thousand samples a period.
    jumps: [f64; 2],
    coulomb_jumps: [f64; 2],
}

impl Instant {
    fn new() -> Result<Self, Trouble> {
        let vibration = TABLE_4_1.vibration_m_per_s();
        let period_s = 1.0 / TABLE_4_1.frequency_hz;
        let problem = TABLE_4_1.kinematic(Shape::Sine, vibration, PLOTTED_RATIO * vibration, SHORT_S);
        let jump = |values: &[f64]| values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
        let at = |samples: f64| trace::trace(&problem, period_s / samples, 50.0 * period_s, 53.0 * period_s);
        let force = |states: &[State]| states.iter().map(|state| state.force_n / problem.coulomb_n).collect::<Vec<_>>();
        let (coarse, fine) = (at(100.0)?, at(1000.0)?);
        Ok(Instant {
            time_us: fine.iter().map(|state| 1e6 * (state.time_s - 50.0 * period_s)).collect(),
            vibration,
            jumps: [jump(&force(&coarse)), jump(&force(&fine))],
            coulomb_jumps: [jump(&coulomb_force(&coarse, vibration)), jump(&coulomb_force(&fine, vibration))],
            states: fine,
        })
    }

    fn coulomb_figure(&self) -> crate::report::Figure {
        let y = coulomb_force(&self.states, self.vibration);
        let caption = format!("F = Fc sgn(Vt + Vv cos ωt) (4.3) at a velocity ratio of 0.5, 60 kHz, three periods. {STEADY}");
        let axes = [axis("time [µs]"), ranged("friction / Fc", -1.1, 1.1)];
        let series = vec![line("Coulomb", "friction_over_coulomb", &self.time_us, y)];
        figure("fig-4-07a", "Figure 4.7(a): instantaneous friction force, Coulomb", caption, axes, series)
    }

    fn dahl_figure(&self) -> crate::report::Figure {
        let fc = TABLE_4_1.coulomb_n();
        let y = self.states.iter().map(|state| state.force_n / fc).collect();
        let caption = format!(
            "Dahl's equation (4.15) under the same given vibration, Table 4.1 (κ = {:.3}): the vibration is too small for the force to \
             reach −Fc. {STEADY}",
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
        // A jump stays as the samples close up; a slope shrinks with their distance.
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

fn lugre_becomes_dahl() -> Result<Claim, Trouble> {
    let dahl = TABLE_4_1.at_ratio(PLOTTED_RATIO, SHORT_S);
    let reference = sweep::ratios(&dahl)?.friction;
    let lugre = |static_ratio: f64, stribeck_over_vv: f64, sigma1: f64| {
        let law = Law::Lugre {
            stiffness_n_per_m: TABLE_4_1.contact_n_per_m,
            static_ratio,
            stribeck_m_per_s: stribeck_over_vv * TABLE_4_1.vibration_m_per_s(),
            sigma1,
            sigma2: 0.0,
        };
        let mut problem = dahl.clone();
        problem.law = law;
        Ok::<_, Trouble>(sweep::ratios(&problem)?.friction)
    };
    let (plain, fast, slow) = (lugre(1.0, 0.01, 0.0)?, lugre(1.5, 0.01, 0.0)?, lugre(1.5, 1.0, 0.0)?);
    let check = |condition: &str, r: f64, within: f64| {
        let numbers = vec![number("r LuGre", r), number("r Dahl", reference)];
        Check::new(condition, (r / reference - 1.0).abs() < within, numbers)
    };
    Ok(Claim {
        id: "lugre-becomes-dahl",
        section: "4.1.3, 4.13",
        says: "Without bristle damping and with a Stribeck velocity far below the slip velocity, LuGre friction is Dahl friction.",
        checks: vec![
            check("no static peak, no damping (equal within 1e-6)", plain, 1e-6),
            check("static peak 1.5 Fc, Stribeck velocity Vv/100 (equal within 1 %)", fast, 0.01),
            check("static peak 1.5 Fc, Stribeck velocity Vv (equal within 1 %)", slow, 0.01),
        ],
    })
}
