//! Solutions by time steps: the runs that determine the settings, the final run, and the fallback
//! if a method fails.

use super::ladder::{Ladder, Setting, stable_steps};
use super::pilot::Pilot;
use super::refine::{Found, ROUND_OFF_OF_SUMS, Ran, Refinement};
use super::runs::Runs;
use super::{Numerics, Solution, ToleranceOf};
use crate::SolveError;
use crate::method::Method;
use crate::problem::{Law, Motion, Problem};
use crate::tally::{Ratios, State, Tally};
use crate::waveform::Shape;

/// Ratio of run to window length above which the energies of the window come from a separate run.
const LONG_RUN_RATIO: f64 = 2.0;
/// Tolerance below which fourth-order methods take longer than the Taylor series. Also applies to
/// linexp if its errors decrease irregularly with the step, or if the forcing is not periodic.
const ORDER_FOUR_TOLERANCE: f64 = 1e-6;
/// Tolerance below which the Taylor series is tried before linexp if friction holds the mass, for
/// which linexp needs many short parts, or if short bristles make it ring. In such contacts two
/// runs of linexp can share a common error, which their difference does not show.
const RINGING_TOLERANCE: f64 = 1e-4;
/// Tolerance below which the Taylor series is tried before linexp in all other contacts.
const LINEXP_TOLERANCE: f64 = 3e-12;
/// Number of steps per period required for stability above which midpoint is tried before
/// Runge-Kutta.
const MANY_STEPS_PER_PERIOD: f64 = 1000.0;
/// Value of kappa above which errors decrease irregularly with the step.
const SMOOTH_KAPPA: f64 = 30.0;
/// Contact stiffness over `m w^2` above which the mass rings on its bristles.
const RINGING_STIFFNESS: f64 = 0.1;
/// Contact stiffness over `m w^2` above which the mass rings far faster than the vibration.
const FAST_RINGING_STIFFNESS: f64 = 30.0;
/// Safety factor on estimates from a pilot, or if errors decrease irregularly with the step;
/// `evidence contacts` compares them with the true error.
const UNEVEN_FACTOR: f64 = 3.0;
/// Safety factor on estimates if errors decrease very irregularly with the step.
const VERY_UNEVEN_FACTOR: f64 = 10.0;
/// Goal of a pilot over that of the one before, if that one does not represent the record.
const FINER_GOAL: f64 = 0.1;
/// Smallest goal of a pilot, above round-off.
const FINEST_GOAL: f64 = 10.0 * ROUND_OFF_OF_SUMS;
/// Value of kappa below which bristles remember many periods.
const LONG_BRISTLES_KAPPA: f64 = 1.0;
/// Safety factor for long bristles on estimates of Runge-Kutta and midpoint.
const LONG_BRISTLES_FACTOR: f64 = 10.0;
/// Smallest error that is stated for automatically chosen settings, over the tolerance: two coarse
/// runs may agree by chance.
const SMALLEST_STATED_ERROR: f64 = 1e-3;
/// Value of kappa above which bristles count as rigid.
const RIGID_KAPPA: f64 = 1e10;

/// Steps per period and order of the Taylor series that adds up the energies.
const ENERGY_SETTING: Setting = (4, Some(24));
/// Number of rungs above the setting for the friction at which another method adds them up.
const ENERGY_RUNGS_ABOVE: usize = 3;
/// Lowest rung from which the rung for the energies is counted.
const FIRST_ENERGY_RUNG: usize = 2;
/// Largest number of steps for the energies, over that of the first rung.
const MAX_ENERGY_STEP_RATIO: u32 = 32;
/// Rung from which on all settings have enough steps for a curve.
const CURVE_RUNG: usize = 6;
/// Error of friction on the wrong side of a reversal, over Fc.
const REVERSED_ERROR: f64 = 2.0;
/// Moments per period at which a Taylor series is reported; it takes few steps of its own.
const CURVE_STEPS_PER_PERIOD: u32 = 12;

/// Solves a problem by the first method that meets the tolerance, or by the one with the smallest
/// error if none does.
pub fn solve_automatically<W: FnMut(&State)>(
    problem: &Problem,
    numerics: &Numerics,
    runs: &dyn Runs,
    mut watch: Option<&mut W>,
) -> Result<Solution, SolveError> {
    let kappa = problem.kappa();
    // Expensive, but accurate to round-off at any stiffness.
    let reason = if limits_record(numerics) { "tolerance of the whole record" } else { "tight tolerance or stiff contact" };
    let series = || (Method::Taylor, format!("{reason}: Taylor series with located reversals"));
    let choices = match problem.law {
        Law::Coulomb => vec![(Method::Linexp, "Coulomb friction: exact from reversal to reversal".to_owned())],
        Law::Dahl { .. } => {
            let exact = (Method::Linexp, format!("Dahl friction, kappa {kappa:.3}: exact flow, friction exact in slip"));
            let uneven = spring(problem) > RINGING_STIFFNESS || kappa > SMOOTH_KAPPA || !problem.waveform.is_periodic();
            let tight = match uneven {
                // All settings of the series share the same moments.
                _ if limits_record(numerics) => f64::INFINITY,
                // linexp treats friction as a small perturbation of the motion, but here it can
                // hold the mass.
                _ if spring(problem) > RINGING_STIFFNESS && problem.holds() => f64::INFINITY,
                _ if spring(problem) > RINGING_STIFFNESS && kappa > SMOOTH_KAPPA || problem.holds() => RINGING_TOLERANCE,
                true => ORDER_FOUR_TOLERANCE,
                false => LINEXP_TOLERANCE,
            };
            if numerics.tolerance < tight { vec![series(), exact] } else { vec![exact, series()] }
        }
        Law::Lugre { .. } => {
            let stable = stable_steps(problem);
            let located = format!(
                "LuGre friction, stable from {:.0} steps per period: Runge-Kutta with located reversals",
                stable.ceil().max(1.0)
            );
            let bounded = format!("stiff bristles, kappa {kappa:.0}: exponential midpoint, friction exact in slip");
            let (located, bounded) = ((Method::Rk4Events, located), (Method::Midpoint, bounded));
            match stable > MANY_STEPS_PER_PERIOD {
                _ if numerics.tolerance < ORDER_FOUR_TOLERANCE || limits_record(numerics) => vec![series(), located, bounded],
                true => vec![bounded, located, series()],
                false => vec![located, bounded, series()],
            }
        }
    };
    let mut best: Option<(Method, String, Found)> = None;
    let mut failed = Vec::new();
    for (method, why) in choices {
        match find(problem, numerics, method, runs) {
            Ok(found) => {
                // The record of the series is at round-off, so no other method is closer.
                let enough = found.decisive() <= numerics.tolerance || (limits_record(numerics) && method == Method::Taylor);
                if best.as_ref().is_none_or(|(.., best)| found.decisive() < best.decisive()) {
                    best = Some((method, why, found));
                }
                if enough {
                    break;
                }
            }
            Err(SolveError::Diverged { method, time_s }) => failed.push(format!("{method} at {time_s:e} s")),
            Err(SolveError::Refused { .. }) => failed.push(format!("{} at the first steps", method.name())),
            // The series needs more parts per step than permitted.
            Err(SolveError::Unsuited { .. }) if method == Method::Taylor => {
                failed.push(format!("{} at its first step", method.name()))
            }
            Err(error) => return Err(error),
        }
    }
    if let Some((method, why, found)) = best {
        return answer(problem, numerics, (method, why), found, runs, watch);
    }
    if matches!(problem.law, Law::Dahl { .. }) && kappa > RIGID_KAPPA {
        return coulomb_limit(problem, numerics, runs, watch.take());
    }
    let reason = format!("the values grow without bound ({})", failed.join(", "));
    let advice = "use a smaller stiffness or bristle damping, a larger friction or mass, or a shorter run".into();
    Err(SolveError::Refused { reason, advice })
}

/// Solves rigid bristles, shorter than the round-off of the motion, as Coulomb friction.
///
/// After a reversal Dahl friction lags by the time in which the slip, `a t^2 / 2` with `a = w Vv`,
/// reaches the length of a bristle: `w t = sqrt(2 / kappa)`. The error of the mean is at most twice
/// that over a period.
fn coulomb_limit<W: FnMut(&State)>(
    problem: &Problem,
    numerics: &Numerics,
    runs: &dyn Runs,
    watch: Option<&mut W>,
) -> Result<Solution, SolveError> {
    let kappa = problem.kappa();
    let why = format!("Dahl friction with rigid bristles, kappa {kappa:.1e}: its limit, Coulomb friction");
    let rigid = Problem { law: Law::Coulomb, ..problem.clone() };
    let mut solution = solve(&rigid, numerics, (Method::Linexp, why), runs, watch)?;
    let lag = 2.0 * (2.0 / kappa).sqrt() / std::f64::consts::PI;
    solution.warnings = vec![format!(
        "the bristles are rigid (kappa {kappa:.1e}): solved with Coulomb friction, with an error of at most {lag:.1e}"
    )];
    let error = solution.error_estimate.unwrap_or(0.0) + lag;
    // During the lag, friction has the opposite sign.
    let of_record = solution.record_error_estimate.map(|_| REVERSED_ERROR);
    state_errors(&mut solution, (error, of_record), numerics.tolerance);
    Ok(solution)
}

/// Stores the error of the mean, and that of the record if the tolerance limits the record.
pub fn state_errors(solution: &mut Solution, (error, of_record): (f64, Option<f64>), tolerance: f64) {
    (solution.error_estimate, solution.record_error_estimate) = (Some(error), of_record);
    solution.tolerance_met = of_record.unwrap_or(error) <= tolerance;
    if solution.tolerance_met {
        return;
    }
    let good = match of_record {
        Some(error) if error < REVERSED_ERROR => {
            format!(
                "the error of the record is {error:.1e} (of the Coulomb force, the largest displacement and the largest velocity)"
            )
        }
        Some(_) => "only the beginning of the record is known".to_owned(),
        None => format!("the error of the friction ratio is {error:.1e}"),
    };
    solution.warnings.push(format!("the tolerance of {tolerance:e} is not met: {good}"));
}

/// Returns `true` if the tolerance limits the whole record.
fn limits_record(numerics: &Numerics) -> bool {
    numerics.tolerance_of == ToleranceOf::Record
}

/// Solves a problem by one method.
pub fn solve<W: FnMut(&State)>(
    problem: &Problem,
    numerics: &Numerics,
    (method, why): (Method, String),
    runs: &dyn Runs,
    watch: Option<&mut W>,
) -> Result<Solution, SolveError> {
    let found = find(problem, numerics, method, runs)?;
    answer(problem, numerics, (method, why), found, runs, watch)
}

/// Returns the contact stiffness over `m w^2`; zero for a given motion and for Coulomb friction.
fn spring(problem: &Problem) -> f64 {
    let omega = std::f64::consts::TAU * problem.waveform.frequency_hz();
    match (problem.law.stiffness_n_per_m(), problem.motion) {
        (Some(kt), Motion::Sdof { mass_kg, .. }) => kt / (mass_kg * omega * omega),
        _ => 0.0,
    }
}

/// Returns `true` if friction has a Stribeck peak.
fn has_peak(problem: &Problem) -> bool {
    matches!(problem.law, Law::Lugre { static_ratio, .. } if static_ratio != 1.0)
}

/// Returns the safety factor on an error estimate.
///
/// Errors fall unevenly from rung to rung if short bristles make the mass ring (`Kt / (m w^2)` no
/// longer small), or if the forcing is irregular. They fall even less evenly if the contact is far
/// stiffer than the inertia, or if friction is a large part of the force.
fn safety_factor(problem: &Problem) -> f64 {
    let spring = spring(problem);
    match spring > RINGING_STIFFNESS {
        true if problem.holds() || spring > FAST_RINGING_STIFFNESS => VERY_UNEVEN_FACTOR,
        true if problem.kappa() > SMOOTH_KAPPA => UNEVEN_FACTOR,
        _ if matches!(problem.waveform.shape(), Shape::Random { .. } | Shape::Measured) => UNEVEN_FACTOR,
        _ => 1.0,
    }
}

/// Finds the cheapest settings of the method that meet the tolerance, or takes the given ones;
/// returns them with their run and its error.
fn find(problem: &Problem, numerics: &Numerics, method: Method, runs: &dyn Runs) -> Result<Found, SolveError> {
    let of_record = limits_record(numerics);
    let problem = &if of_record && numerics.whole_run { problem.clone() } else { problem.up_to_window() };
    let ladder = Ladder::new(method, problem, numerics.order);
    let by = |problem: &Problem, setting: Setting| -> Result<Ran, SolveError> {
        match of_record {
            true => runs.recorded(problem, method, setting).map(|(tally, record)| (tally, Some(record))),
            false => runs.run(problem, method, setting, false).map(|tally| (tally, None)),
        }
    };
    let fixed = || method.steps(problem.kappa()).filter(|_| method == Method::Rk4);
    if let Some(steps) = numerics.steps_per_period.or_else(fixed) {
        // The given setting is used as it is; a run with half the step gives its error.
        let order = numerics.order.or(method.order()).filter(|_| problem.law != Law::Coulomb && method.order().is_some());
        let ((tally, record), (fine, fine_record)) = (by(problem, (steps, order))?, by(problem, (2 * steps, order))?);
        let off = (Ratios::of(problem, &tally).friction - Ratios::of(problem, &fine).friction).abs().max(ROUND_OFF_OF_SUMS);
        let record_error = record.zip(fine_record).map(|(record, fine)| record.distance(&fine, problem).max(off));
        return Ok(Found { setting: (steps, order), tally: Some(tally), error: off, record_error, growth: 1.0 });
    }
    // If errors fall unevenly, or if a coarse step covers many bristle lengths, the lowest rung
    // does not predict the next one.
    let (safety_factor, tolerance) = (if method == Method::Taylor { 1.0 } else { safety_factor(problem) }, numerics.tolerance);
    let first = usize::from(method != Method::Taylor && (safety_factor > 1.0 || problem.kappa() > SMOOTH_KAPPA));
    let start = ladder.start(tolerance).max(first);
    let mut whole = match method {
        Method::Linexp | Method::Frozen | Method::Taylor => Refinement::from_two_runs(problem, safety_factor),
        // Two runs of Runge-Kutta were found to share a common error; with long bristles, so were
        // three.
        _ if problem.kappa() < LONG_BRISTLES_KAPPA => Refinement::from_three_runs(problem, LONG_BRISTLES_FACTOR),
        // A narrow peak lies between the steps, at a different place in each run.
        _ if has_peak(problem) => Refinement::from_three_runs(problem, UNEVEN_FACTOR),
        _ => Refinement::from_three_runs(problem, 1.0),
    };
    if of_record {
        // A reported record has several moments in every period.
        let is_coarse =
            |rung: &usize| ladder.setting(*rung).is_some_and(|setting| shown_at(method, setting).0 < CURVE_STEPS_PER_PERIOD);
        let shown = (0..=CURVE_RUNG).rev().find(is_coarse).map_or(0, |coarse| coarse + 1);
        let found = whole.climb(&ladder, start.max(shown), tolerance, &mut |setting| by(problem, shown_at(method, setting)))?;
        return Ok(Found { setting: shown_at(method, found.setting), ..found });
    }
    let Some(pilot) = Pilot::new(method, problem) else {
        return whole.climb(&ladder, start, tolerance, &mut |setting| by(problem, setting));
    };
    let (two_suffice, lower) = (method == Method::Linexp || method == Method::Taylor, ladder.lower());
    let mut goal = pilot.goal(tolerance);
    let mut coarsest: Option<Found> = None;
    loop {
        let mut first_periods = match two_suffice {
            true => Refinement::from_two_runs(&pilot.problem, 1.0),
            false => Refinement::from_three_runs(&pilot.problem, 1.0),
        };
        let wanted = if method == Method::Linexp { ladder.start(goal).max(first) } else { start };
        let fits = |rung: &usize| lower.setting(rung + ladder.apart()).is_some();
        let start = (first..=wanted).rev().find(fits).unwrap_or(first);
        let found = match first_periods.climb(&lower, start, goal, &mut |setting| by(&pilot.problem, setting)) {
            Ok(found) => found,
            Err(error) if coarsest.is_none() => return Err(error),
            Err(_) => break,
        };
        if pilot.stands_for_the_record(found.error, found.growth, tolerance) {
            // If friction feeds energy in, the contact may still become too stiff for a series.
            let tally = if method == Method::Taylor { Some(by(problem, found.setting)?.0) } else { None };
            return Ok(Found { tally, error: UNEVEN_FACTOR * found.error * pilot.growth, ..found });
        }
        // An error that grows from the first half to the second may be an accident of a coarse run.
        let is_accurate = found.error <= goal;
        coarsest.get_or_insert(found);
        if !is_accurate || goal * FINER_GOAL < FINEST_GOAL {
            break;
        }
        goal *= FINER_GOAL;
    }
    let position = coarsest.map_or(first, |found| ladder.position(found.setting));
    // The pilot's setting is compared with a coarser run on the whole record.
    whole.climb(&ladder, position.saturating_sub(ladder.apart()).max(first), tolerance, &mut |setting| by(problem, setting))
}

/// Returns the setting with as many moments as a curve needs: shorter steps of the Taylor series
/// cost little.
fn shown_at(method: Method, setting: Setting) -> Setting {
    if method == Method::Taylor { (setting.0.max(CURVE_STEPS_PER_PERIOD), setting.1) } else { setting }
}

/// Returns the setting of a run that only provides curves.
fn for_curves(problem: &Problem, numerics: &Numerics, method: Method, setting: Setting) -> Setting {
    if method == Method::Taylor && numerics.steps_per_period.is_none() {
        return shown_at(method, setting);
    }
    if setting.0 >= CURVE_STEPS_PER_PERIOD || numerics.steps_per_period.is_some() {
        return setting;
    }
    Ladder::new(method, problem, numerics.order).setting(CURVE_RUNG).unwrap_or(setting)
}

/// Returns the setting of the run that adds up the energies.
///
/// Between resonance and excitation, energies flow back and forth, many times larger than those of
/// friction. Their means therefore need a finer step, but sums over many more steps have more
/// round-off. A Taylor series has them at a small part of the cost of linexp, which integrates them
/// by quadrature in steps of their own.
fn for_energies(problem: &Problem, numerics: &Numerics, method: Method, setting: Setting) -> Setting {
    let ladder = Ladder::new(method, problem, numerics.order);
    let most = setting.0.max(MAX_ENERGY_STEP_RATIO * ladder.setting(0).map_or(1, |first| first.0));
    let rung = ladder.position(setting).max(FIRST_ENERGY_RUNG);
    let mut finer = (0..=ENERGY_RUNGS_ABOVE).rev().filter_map(|finer| ladder.setting(rung + finer));
    let finer = finer.find(|finer| finer.0 <= most).unwrap_or(setting);
    if method == Method::Taylor { for_curves(problem, numerics, method, finer) } else { finer }
}

/// Returns `true` if results after the window are requested.
fn continues_after_window(problem: &Problem, numerics: &Numerics) -> bool {
    numerics.whole_run && problem.window_s.1 < problem.duration_s
}

/// Computes the final run. If it continues long after its window, or if a series adds up the
/// energies of linexp, a run of its own gives the sums of the window, and the other one only curves
/// and peaks.
fn shown<W: FnMut(&State)>(
    problem: &Problem,
    numerics: &Numerics,
    (method, setting, apart): (Method, Setting, bool),
    runs: &dyn Runs,
    watch: Option<&mut W>,
) -> Result<Tally, SolveError> {
    let window = problem.up_to_window();
    let whole = if watch.is_some() || continues_after_window(problem, numerics) { problem } else { &window };
    let searched = apart && numerics.steps_per_period.is_none();
    let finer = match method {
        _ if searched => for_energies(problem, numerics, method, setting),
        Method::Taylor => for_curves(problem, numerics, method, setting),
        _ => setting,
    };
    let by_series = searched && method == Method::Linexp && problem.law != Law::Coulomb;
    let separate = by_series || apart && whole.duration_s > LONG_RUN_RATIO * window.duration_s;
    let (by, energies) =
        if separate { (for_curves(problem, numerics, method, setting), false) } else { (finer, numerics.energies) };
    let tally = match watch {
        Some(watch) => method.run(whole, by, energies, watch)?,
        None => runs.run(whole, method, by, energies)?,
    };
    if !separate {
        return Ok(tally);
    }
    let Tally { peak_velocity_m_per_s, peak_displacement_m, peak_force_ratio, steps, reversals, .. } = tally;
    // Stiff bristles would need too many series.
    let is_soft = window.kappa() < SMOOTH_KAPPA && spring(&window) < RINGING_STIFFNESS;
    let series = (by_series && is_soft).then(|| runs.run(&window, Method::Taylor, ENERGY_SETTING, true));
    let of_window = match series {
        Some(Ok(of_window)) => of_window,
        _ => runs.run(&window, method, finer, true)?,
    };
    Ok(Tally { peak_velocity_m_per_s, peak_displacement_m, peak_force_ratio, steps, reversals, ..of_window })
}

/// Computes the final run, unless it is already known, and builds the solution.
fn answer<W: FnMut(&State)>(
    problem: &Problem,
    numerics: &Numerics,
    (method, why): (Method, String),
    found: Found,
    runs: &dyn Runs,
    watch: Option<&mut W>,
) -> Result<Solution, SolveError> {
    let setting = found.setting;
    // Energies are added up in a separate run. Friction always comes from the run without energies,
    // so that a request for energies does not change it.
    let apart = numerics.energies && method != Method::Midpoint;
    let plain = match found.tally {
        None if apart => Some(runs.run(&problem.up_to_window(), method, setting, false)?),
        tally => tally,
    };
    let shown = match plain.filter(|_| !apart && watch.is_none() && !continues_after_window(problem, numerics)) {
        Some(plain) => plain,
        None => shown(problem, numerics, (method, setting, apart), runs, watch)?,
    };
    let (mut ratios, mut error, mut record_error) = (Ratios::of(problem, &shown), found.error, found.record_error);
    if let Some(plain) = plain {
        let plain = Ratios::of(problem, &plain);
        ratios = Ratios { friction: plain.friction, power: plain.power.or(ratios.power), ..ratios };
    }
    let mut warnings = Vec::new();
    if method == Method::Frozen {
        let coupled = runs.run(&problem.up_to_window(), Method::Linexp, setting, false)?;
        let left_out = (ratios.friction - Ratios::of(problem, &coupled).friction).abs();
        warnings
            .push(format!("the effect of friction on the motion is left out; it changes the friction ratio by {left_out:.1e}"));
        error += left_out;
        if let Some(record_error) = &mut record_error {
            let recorded = |method| runs.recorded(problem, method, setting);
            *record_error += recorded(Method::Frozen)?.1.distance(&recorded(Method::Linexp)?.1, problem);
        }
    }
    if numerics.steps_per_period.is_none() {
        error = error.max(SMALLEST_STATED_ERROR * numerics.tolerance);
        record_error = record_error.map(|error| error.max(SMALLEST_STATED_ERROR * numerics.tolerance));
    }
    let mut solution = Solution {
        method,
        why,
        steps_per_period: Some(setting.0),
        order: setting.1,
        ratios,
        tally: Some(shown),
        error_estimate: None,
        record_error_estimate: None,
        tolerance_met: true,
        warnings,
        states: method.states(problem),
        orbit: None,
        ns_per_period: None,
    };
    state_errors(&mut solution, (error, record_error), numerics.tolerance);
    Ok(solution)
}
