//! A contact study with vibration normal to the surface, on a Hertzian contact. The vibration is
//! given (`rig.kinematic`), or a force shakes a mass on the contact (`rig.sdof`), which bounces if
//! the force is large.

mod compliant;

use std::f64::consts::TAU;

use contact::hertz::vibration::{self, DrivenContact, DrivenMotion, Moment};
use contact::hertz::{self, HertzProblem};
use contact::tally::Ratios;
use contact::{Clock, Method, Motion, Numerics, Problem, Solution, SolveError, State};
use scene::Hertz;

pub use compliant::Compliance;
pub(super) use compliant::solve as solve_compliant;

/// Largest initial step, in radians of the contact's own resonance.
const STEP_RAD: f64 = 0.2;
/// Minimum initial number of steps per period.
const MIN_STEPS: u32 = 64;
/// Maximum number of steps per period.
const MAX_STEPS: u32 = 1 << 14;
/// Round-off error of a mean over many steps.
const ROUND_OFF: f64 = 1e-13;

/// Results for the normal direction in addition to the solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Across {
    /// Fraction of the window in contact.
    pub contact_share: f64,
    /// Mean deflection while in contact, over the whole window, m.
    pub mean_indentation_m: f64,
    /// Mean normal force, N.
    pub mean_normal_n: f64,
    /// Largest normal force, N.
    pub peak_normal_n: f64,
    /// Results of a compliant contact only.
    pub compliant: Option<Compliance>,
}

/// Solves the problem; `pause` is called repeatedly in the runs without `watch`.
pub(super) fn solve(
    problem: &Problem,
    model: &Hertz,
    numerics: &Numerics,
    (pause, clock): (&dyn Fn(), Option<Clock>),
    watch: &mut impl FnMut(&State),
) -> Result<(Solution, Across), SolveError> {
    match problem.motion {
        Motion::Kinematic => given(problem, model, clock, watch),
        Motion::Sdof { mass_kg, stiffness_n_per_m, damping_n_s_per_m } => {
            let shaken = Shaken::new(problem, model, (mass_kg, stiffness_n_per_m, damping_n_s_per_m))?;
            shaken.solve(numerics, (pause, clock), watch)
        }
    }
}

/// Solves a given vibration in closed form: the body moves by `vibration / w` about its mean
/// distance.
fn given(
    problem: &Problem,
    model: &Hertz,
    clock: Option<Clock>,
    watch: &mut impl FnMut(&State),
) -> Result<(Solution, Across), SolveError> {
    let hz = problem.waveform.frequency_hz();
    let across = HertzProblem {
        normal_n: problem.coulomb_n / model.mu,
        stiffness_n_per_m15: model.stiffness_n_per_m15,
        amplitude_m: problem.vibration_m_per_s() / (TAU * hz),
        shape: problem.waveform.shape(),
    };
    let (found, ns) = timed(clock, || hertz::solve(&across));
    let found = found?;
    let mut peak_normal_n = 0.0f64;
    for point in hertz::period(&across, &found) {
        peak_normal_n = peak_normal_n.max(point.normal_n);
        watch(&State {
            time_s: point.phase_turns / hz,
            x_m: point.deflection_m - found.mean_deflection_m,
            v_m_per_s: -problem.vibration_m_per_s() * (TAU * point.phase_turns).sin(),
            force_n: friction_n(problem, point.deflection_m / found.static_deflection_m),
        });
    }
    let solution = Solution {
        method: Method::Closed,
        why: format!(
            "vibration normal to a Hertzian contact, quasi-static: in contact for {:.1} % of the period",
            100.0 * found.contact_share
        ),
        steps_per_period: None,
        order: None,
        ratios: ratios(found.friction_ratio),
        tally: None,
        error_estimate: None,
        record_error_estimate: None,
        tolerance_met: true,
        warnings: Vec::new(),
        states: 0,
        orbit: None,
        ns_per_period: ns.map(|ns| ns / (problem.duration_s * hz)),
    };
    let across = Across {
        contact_share: found.contact_share,
        mean_indentation_m: found.friction_ratio * found.static_deflection_m,
        mean_normal_n: across.normal_n,
        peak_normal_n,
        compliant: None,
    };
    Ok((solution, across))
}

/// Returns the result of `work`, and its duration, ns, if there is a clock.
fn timed<T>(clock: Option<Clock>, work: impl FnOnce() -> T) -> (T, Option<f64>) {
    let began = clock.map(|clock| clock());
    let done = work();
    (done, clock.zip(began).map(|(clock, began)| (clock() - began).as_secs_f64() * 1e9))
}

/// Returns the friction at a deflection relative to the static one, N. It is proportional to the
/// contact area, and thus to the deflection.
fn friction_n(problem: &Problem, deflection: f64) -> f64 {
    problem.coulomb_n * deflection.max(0.0)
}

/// Returns the ratios; the slip velocity is constant, so power is proportional to force.
fn ratios(friction: f64) -> Ratios {
    Ratios { friction, power: Some(friction), ..Ratios::default() }
}

/// Mass shaken by a force, and the units of its motion.
struct Shaken<'a> {
    problem: &'a Problem,
    contact: DrivenContact,
    load_n: f64,
    static_m: f64,
    /// Small-amplitude resonance on the contact, rad/s.
    resonance_rad_per_s: f64,
}

impl<'a> Shaken<'a> {
    fn new(problem: &'a Problem, model: &Hertz, (mass_kg, spring_n_per_m, damping): (f64, f64, f64)) -> Result<Self, SolveError> {
        let hz = problem.waveform.frequency_hz();
        let whole = |time_s: f64| {
            let periods = time_s * hz;
            ((periods - periods.round()).abs() < 1e-9 * periods.max(1.0)).then_some(periods.round() as u32)
        };
        let Some((from, to)) = whole(problem.window_s.0).zip(whole(problem.window_s.1)) else {
            let reason = "the window is not whole periods: give `integrator.window_periods`".to_owned();
            return Err(SolveError::Unsuited { method: Method::Rk4Events.name(), reason });
        };
        let load_n = problem.coulomb_n / model.mu;
        let static_m = (load_n / model.stiffness_n_per_m15).powf(2.0 / 3.0);
        let contact_n_per_m = 1.5 * model.stiffness_n_per_m15 * static_m.sqrt();
        let resonance = (contact_n_per_m / mass_kg).sqrt();
        let contact = DrivenContact {
            force_ratio: problem.waveform.amplitude() / load_n,
            frequency_ratio: TAU * hz / resonance,
            damping_ratio: damping / (2.0 * mass_kg * resonance),
            guide_ratio: spring_n_per_m / contact_n_per_m,
            start: (1.0 + problem.start.x_m / static_m, problem.start.v_m_per_s / (resonance * static_m)),
            settle_periods: from,
            mean_periods: to - from,
            steps_per_period: MIN_STEPS,
        };
        Ok(Shaken { problem, contact, load_n, static_m, resonance_rad_per_s: resonance })
    }

    /// Halves the step until the friction ratio has converged within the tolerance. A mass that
    /// bounces without a period never converges: the solution then states the error of the mean.
    fn solve(
        &self,
        numerics: &Numerics,
        (pause, clock): (&dyn Fn(), Option<Clock>),
        watch: &mut impl FnMut(&State),
    ) -> Result<(Solution, Across), SolveError> {
        let at = |steps: u32| {
            let contact = DrivenContact { steps_per_period: steps, ..self.contact };
            self.finite(vibration::run(&contact, &mut |_| pause()))
        };
        let resolved = (TAU / self.contact.frequency_ratio / STEP_RAD).ceil().clamp(1.0, f64::from(MAX_STEPS) / 2.0) as u32;
        let mut steps = numerics.steps_per_period.unwrap_or(resolved.max(MIN_STEPS));
        let (mut coarse, mut fine) = (at(steps)?, at(2 * steps)?);
        let apart = |a: &DrivenMotion, b: &DrivenMotion| (a.friction_ratio - b.friction_ratio).abs().max(ROUND_OFF);
        while numerics.steps_per_period.is_none() && apart(&coarse, &fine) > numerics.tolerance && 4 * steps <= MAX_STEPS {
            let finer = at(4 * steps)?;
            let settles = apart(&fine, &finer) < 0.5 * apart(&coarse, &fine);
            steps *= 2;
            (coarse, fine) = (fine, finer);
            if !settles {
                break;
            }
        }
        // A requested step is used unchanged; otherwise the finer of the last two steps.
        let shown = if numerics.steps_per_period.is_none() { 2 * steps } else { steps };
        let error = apart(&coarse, &fine);
        let asked = numerics.tolerance;
        let missed = format!("the tolerance of {asked:e} is not met: the error of the friction ratio is {error:.1e}");
        let (motion, ns) = timed(clock, || at(shown));
        let motion = motion?;
        vibration::run(&DrivenContact { steps_per_period: shown, ..self.whole() }, &mut |moment| watch(&self.state(moment)));
        let sliding_j =
            self.problem.coulomb_n * self.problem.sliding_m_per_s * (self.problem.window_s.1 - self.problem.window_s.0);
        let residual_j = motion.energy_residual * self.load_n * self.static_m;
        let energy_residual = (sliding_j != 0.0).then(|| residual_j / sliding_j);
        let solution = Solution {
            method: Method::Rk4Events,
            why: format!(
                "a mass on a Hertzian contact, shaken normal to it at {:.3} of its resonance: in contact for {:.1} % of the \
                 window",
                self.contact.frequency_ratio,
                100.0 * motion.contact_share
            ),
            steps_per_period: Some(shown),
            order: None,
            ratios: Ratios { energy_residual, ..ratios(motion.friction_ratio) },
            tally: None,
            error_estimate: Some(error),
            record_error_estimate: None,
            tolerance_met: error <= asked,
            warnings: (error > asked).then_some(missed).into_iter().collect(),
            states: 2,
            orbit: None,
            ns_per_period: ns.map(|ns| ns / f64::from(self.contact.settle_periods + self.contact.mean_periods)),
        };
        let across = Across {
            contact_share: motion.contact_share,
            mean_indentation_m: motion.friction_ratio * self.static_m,
            mean_normal_n: motion.force_balance * self.load_n,
            peak_normal_n: self.load_n * motion.reach.0.max(0.0).powf(1.5),
            compliant: None,
        };
        Ok((solution, across))
    }

    /// Returns the contact with all periods of the run, independent of the window.
    fn whole(&self) -> DrivenContact {
        let periods = self.problem.duration_s * self.problem.waveform.frequency_hz();
        DrivenContact { settle_periods: 0, mean_periods: (periods + 1e-9).floor() as u32, ..self.contact }
    }

    fn finite(&self, motion: DrivenMotion) -> Result<DrivenMotion, SolveError> {
        let diverged = SolveError::Diverged { method: Method::Rk4Events.name(), time_s: self.problem.window_s.1 };
        if motion.energy_residual.is_finite() && motion.friction_ratio.is_finite() { Ok(motion) } else { Err(diverged) }
    }

    fn state(&self, moment: &Moment) -> State {
        State {
            time_s: moment.periods / self.problem.waveform.frequency_hz(),
            x_m: (moment.deflection - 1.0) * self.static_m,
            v_m_per_s: moment.velocity * self.resonance_rad_per_s * self.static_m,
            force_n: friction_n(self.problem, moment.deflection),
        }
    }
}
