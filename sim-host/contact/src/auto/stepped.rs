//! Answers by steps: the runs that find the settings, the run that is shown, and what to do where a method has no answer.

use super::ladder::{Ladder, Setting, stable_steps};
use super::pilot::Pilot;
use super::refine::{self, Found, ROUND_OFF_OF_SUMS, Ran};
use super::runs::Runs;
use super::{Numerics, Solution, ToleranceOf};
use crate::SolveError;
use crate::method::Method;
use crate::problem::{Law, Motion, Problem};
use crate::tally::{Ratios, State, Tally};
use crate::waveform::Shape;

/// A run goes on for long behind its window if it is so many times as long.
const LONG: f64 = 2.0;
/// Below this tolerance methods of order four take more time than the Taylor series, and linexp where errors fall unevenly, or where no period is like
/// another.
const ORDER_FOUR: f64 = 1e-6;
/// And where short bristles make the mass ring: there two runs of linexp were seen to agree on what both are off by.
const ORDER_FOUR_RINGING: f64 = 1e-4;
/// Below this one linexp does, whatever the contact.
const ORDER_SIX: f64 = 1e-10;
/// Steps a period that stability may ask of Runge-Kutta before midpoint is tried first.
const MANY_STEPS: f64 = 1000.0;
/// From this kappa on errors fall unevenly.
const SMOOTH: f64 = 30.0;
/// Contact spring, of `m w^2`, from which on the mass rings on its bristles.
const RINGS: f64 = 0.1;
/// From this contact spring on, of `m w^2`, it does so faster than it is shaken by far.
const STIFF: f64 = 30.0;
/// What estimates are multiplied by then; `evidence contacts` holds them against the truth.
const UNEVEN: f64 = 3.0;
const VERY_UNEVEN: f64 = 10.0;
/// And what the error of a pilot is multiplied by otherwise.
const OF_PILOT: f64 = 1.5;
/// Below this kappa bristles outlast many periods; and what estimates of the methods that step in time are multiplied by there.
const LONG_BRISTLES: f64 = 1.0;
const UNEVEN_IN_TIME: f64 = 10.0;
/// No less is stated of what settings are chosen for, of the tolerance: two coarse runs may agree better than they know.
const LEAST_STATED: f64 = 1e-3;
/// Bristles this many times shorter than the vibration are rigid.
const RIGID: f64 = 1e10;

/// The energies are added up so many rungs above what the friction needs, and not below this one.
const FINER: usize = 3;
const FIRST_ENERGIES: usize = 2;
/// Friction on the wrong side of a reversal is off by so many times the Coulomb force.
const REVERSED: f64 = 2.0;
/// Moments a period at which the Taylor series is shown, which takes few steps.
const STEPS_OF_CURVES: u32 = 12;
/// Nor beyond so many times the steps of the first rung.
const MOST_FOR_ENERGIES: u32 = 32;

/// The answer of the first method that has the tolerance; if none has, that with the smallest error.
pub fn chosen<W: FnMut(&State)>(
    problem: &Problem,
    numerics: &Numerics,
    runs: &dyn Runs,
    mut watch: Option<&mut W>,
) -> Result<Solution, SolveError> {
    let kappa = problem.kappa();
    // Dear, and at round-off whatever the stiffness.
    let reason = if of_record(numerics) { "tolerance of the whole record" } else { "tight tolerance or stiff contact" };
    let series = || (Method::Taylor, format!("{reason}: Taylor series with located reversals"));
    let choices = match problem.law {
        Law::Coulomb => vec![(Method::Linexp, "Coulomb friction: exact from reversal to reversal".to_owned())],
        Law::Dahl { .. } => {
            let exact = (Method::Linexp, format!("Dahl friction, kappa {kappa:.3}: exact flow, friction exact in slip"));
            let uneven = spring(problem) > RINGS || kappa > SMOOTH || !problem.waveform.is_periodic();
            let tight = match uneven {
                // All settings of the series have the same moments.
                _ if of_record(numerics) => f64::INFINITY,
                // Friction that holds the mass is no small change of its motion, as which linexp treats it.
                _ if spring(problem) > RINGS && problem.holds() => f64::INFINITY,
                _ if spring(problem) > RINGS && kappa > SMOOTH => ORDER_FOUR_RINGING,
                true => ORDER_FOUR,
                false => ORDER_SIX,
            };
            if numerics.tolerance < tight { vec![series(), exact] } else { vec![exact, series()] }
        }
        Law::Lugre { .. } => {
            let stable = stable_steps(problem);
            let located =
                format!("LuGre friction, stable from {:.0} steps on: Runge-Kutta with located reversals", stable.ceil().max(1.0));
            let bounded = format!("stiff bristles, kappa {kappa:.0}: friction exact in slip at the midpoint");
            let (located, bounded) = ((Method::Rk4Events, located), (Method::Midpoint, bounded));
            match stable > MANY_STEPS {
                _ if numerics.tolerance < ORDER_FOUR || of_record(numerics) => vec![series(), located, bounded],
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
                // Where the series is at round-off nothing else is nearer to the record.
                let enough = found.decisive() <= numerics.tolerance || (of_record(numerics) && method == Method::Taylor);
                if best.as_ref().is_none_or(|(.., best)| found.decisive() < best.decisive()) {
                    best = Some((method, why, found));
                }
                if enough {
                    break;
                }
            }
            Err(SolveError::Diverged { method, time_s }) => failed.push(format!("{method} at {time_s:e} s")),
            Err(SolveError::Refused { .. }) => failed.push(format!("{} at the first steps", method.name())),
            // It needs more parts of a step than it may.
            Err(SolveError::Unsuited { .. }) if method == Method::Taylor => {
                failed.push(format!("{} at its first step", method.name()))
            }
            Err(error) => return Err(error),
        }
    }
    if let Some((method, why, found)) = best {
        return answer(problem, numerics, (method, why), found, runs, watch);
    }
    if matches!(problem.law, Law::Dahl { .. }) && kappa > RIGID {
        return coulomb_limit(problem, numerics, runs, watch.take());
    }
    let reason = format!("the numbers grow without bound ({})", failed.join(", "));
    let advice = "give a smaller stiffness or bristle damping, a larger friction or mass, or a shorter run".into();
    Err(SolveError::Refused { reason, advice })
}

/// Bristles shorter than the round-off of the motion: friction is Coulomb's. Behind a reversal Dahl friction lags by the time in which
/// the slip, `a t^2 / 2` with `a = w Vv`, is a bristle's length: `w t = sqrt(2 / kappa)`; the mean is off by at most twice that over a
/// period.
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
    solution.warnings =
        vec![format!("the bristles are rigid (kappa {kappa:.1e}): solved with Coulomb friction, off by {lag:.1e} at most")];
    let error = solution.error_estimate.unwrap_or(0.0) + lag;
    // Within the lag friction is on the other side.
    let of_record = solution.record_error_estimate.map(|_| REVERSED);
    state_errors(&mut solution, (error, of_record), numerics.tolerance);
    Ok(solution)
}

/// States the error of the mean and that of the record, where the tolerance is of that.
fn state_errors(solution: &mut Solution, (error, of_record): (f64, Option<f64>), tolerance: f64) {
    (solution.error_estimate, solution.record_error_estimate) = (Some(error), of_record);
    solution.tolerance_met = of_record.unwrap_or(error) <= tolerance;
    if solution.tolerance_met {
        return;
    }
    let good = match of_record {
        Some(error) if error < REVERSED => {
            format!("the record is good to {error:.1e} (of the Coulomb force, the largest displacement and the largest velocity)")
        }
        Some(_) => "of the record only the beginning is known".to_owned(),
        None => format!("the friction ratio is good to {error:.1e}"),
    };
    solution.warnings.push(format!("the tolerance of {tolerance:e} is not met: {good}"));
}

/// Whether the tolerance is of the whole record.
fn of_record(numerics: &Numerics) -> bool {
    numerics.tolerance_of == ToleranceOf::Record
}

/// The answer of one method.
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

/// The contact spring, of `m w^2`; zero of a motion that is given, and of Coulomb friction.
fn spring(problem: &Problem) -> f64 {
    let omega = std::f64::consts::TAU * problem.waveform.frequency_hz();
    match (problem.law.stiffness_n_per_m(), problem.motion) {
        (Some(kt), Motion::Sdof { mass_kg, .. }) => kt / (mass_kg * omega * omega),
        _ => 0.0,
    }
}

/// Whether friction has a Stribeck peak.
fn has_peak(problem: &Problem) -> bool {
    matches!(problem.law, Law::Lugre { static_ratio, .. } if static_ratio != 1.0)
}

/// What an estimate is multiplied by. Where short bristles make the mass ring, `Kt / (m w^2)` no longer small, errors fall unevenly from rung to
/// rung, as they do where every change of the forcing is another; and more so where the bristles are stiffer than the mass is heavy, or where
/// friction is no small part of the force.
fn doubt(problem: &Problem) -> f64 {
    let spring = spring(problem);
    match spring > RINGS {
        true if problem.holds() || spring > STIFF => VERY_UNEVEN,
        true if problem.kappa() > SMOOTH => UNEVEN,
        _ if matches!(problem.waveform.shape(), Shape::Random { .. } | Shape::Measured) => UNEVEN,
        _ => 1.0,
    }
}

/// The settings that are asked for, or the cheapest of the method that meet the tolerance, with their run and its error.
fn find(problem: &Problem, numerics: &Numerics, method: Method, runs: &dyn Runs) -> Result<Found, SolveError> {
    let of_record = of_record(numerics);
    let problem = &if of_record && numerics.whole_run { problem.clone() } else { problem.of_window() };
    let ladder = Ladder::of(method, problem, numerics.order);
    let by = |problem: &Problem, setting: Setting| -> Result<Ran, SolveError> {
        match of_record {
            true => runs.recorded(problem, method, setting).map(|(tally, record)| (tally, Some(record))),
            false => runs.run(problem, method, setting, false).map(|tally| (tally, None)),
        }
    };
    let fixed = || method.steps(problem.kappa()).filter(|_| method == Method::Rk4);
    if let Some(steps) = numerics.steps_per_period.or_else(fixed) {
        // What was asked for is what is shown; half the step tells its error.
        let order = numerics.order.or(method.order()).filter(|_| problem.law != Law::Coulomb && method.order().is_some());
        let ((tally, record), (fine, fine_record)) = (by(problem, (steps, order))?, by(problem, (2 * steps, order))?);
        let off = (Ratios::of(problem, &tally).friction - Ratios::of(problem, &fine).friction).abs().max(ROUND_OFF_OF_SUMS);
        let record_error = record.zip(fine_record).map(|(record, fine)| record.distance(&fine, problem).max(off));
        return Ok(Found { setting: (steps, order), tally: Some(tally), error: off, record_error, growth: 1.0 });
    }
    // Where errors fall unevenly, or a step of order two is many bristles long, it says nothing of the next rung.
    let (doubt, tolerance) = (if method == Method::Taylor { 1.0 } else { doubt(problem) }, numerics.tolerance);
    let first = usize::from(method != Method::Taylor && (doubt > 1.0 || problem.kappa() > SMOOTH));
    let start = ladder.start(tolerance).max(first);
    let mut whole = match method {
        Method::Linexp | Method::Frozen | Method::Taylor => refine::Runs::of_two(problem, doubt),
        // Two runs of Runge-Kutta were seen to agree on what both are off by, and three where the bristles are long.
        _ if problem.kappa() < LONG_BRISTLES => refine::Runs::of_three(problem, UNEVEN_IN_TIME),
        // A narrow peak lies between the steps, now here, now there.
        _ if has_peak(problem) => refine::Runs::of_three(problem, UNEVEN),
        _ => refine::Runs::of_three(problem, 1.0),
    };
    if of_record {
        // A record that is shown has some moments in every period.
        let shown = (0..).find(|&rung| ladder.setting(rung).is_none_or(|setting| shown_at(method, setting).0 >= STEPS_OF_CURVES));
        let found = whole
            .climb(&ladder, start.max(shown.unwrap_or(0)), tolerance, &mut |setting| by(problem, shown_at(method, setting)))?;
        return Ok(Found { setting: shown_at(method, found.setting), ..found });
    }
    let Some(pilot) = Pilot::of(method, problem) else {
        return whole.climb(&ladder, start, tolerance, &mut |setting| by(problem, setting));
    };
    let goal = pilot.goal(tolerance);
    let mut first_periods = if method == Method::Linexp || method == Method::Taylor {
        refine::Runs::of_two(&pilot.problem, 1.0)
    } else {
        refine::Runs::of_three(&pilot.problem, 1.0)
    };
    let found = first_periods.climb(&ladder.lower(), start, goal, &mut |setting| by(&pilot.problem, setting))?;
    if pilot.stands_for_the_record(found.error, found.growth, tolerance) {
        // A contact that friction pumps may yet become too stiff for a series.
        let tally = if method == Method::Taylor { Some(by(problem, found.setting)?.0) } else { None };
        let doubt = if spring(problem) > RINGS { UNEVEN } else { OF_PILOT };
        return Ok(Found { tally, error: doubt * found.error * pilot.growth, ..found });
    }
    // What the pilot has found is compared with a coarser run on the whole record.
    whole.climb(&ladder, ladder.position(found.setting).saturating_sub(ladder.apart()).max(first), tolerance, &mut |setting| {
        by(problem, setting)
    })
}

/// The setting that shows as many moments as a curve needs: steps of the Taylor series may be shorter at little cost.
fn shown_at(method: Method, setting: Setting) -> Setting {
    if method == Method::Taylor { (setting.0.max(STEPS_OF_CURVES), setting.1) } else { setting }
}

/// The setting of a run that is only to be looked at.
fn for_curves(problem: &Problem, numerics: &Numerics, method: Method, setting: Setting) -> Setting {
    if method == Method::Taylor && numerics.steps_per_period.is_none() {
        return shown_at(method, setting);
    }
    let ladder = Ladder::of(method, problem, numerics.order);
    let shown = ladder.setting(FIRST_ENERGIES + FINER).filter(|shown| shown.0 > setting.0);
    shown.filter(|_| numerics.steps_per_period.is_none()).unwrap_or(setting)
}

/// The setting of the run that adds up the energies. Between resonance and excitation they flow to and fro, by many times what friction takes, so their
/// means need a finer step than the friction's; but sums over many more steps have only more round-off.
fn for_energies(problem: &Problem, numerics: &Numerics, method: Method, setting: Setting) -> Setting {
    let ladder = Ladder::of(method, problem, numerics.order);
    let most = setting.0.max(MOST_FOR_ENERGIES * ladder.setting(0).map_or(1, |first| first.0));
    let rung = ladder.position(setting).max(FIRST_ENERGIES);
    let mut finer = (0..=FINER).rev().filter_map(|finer| ladder.setting(rung + finer));
    let finer = finer.find(|finer| finer.0 <= most).unwrap_or(setting);
    if method == Method::Taylor { for_curves(problem, numerics, method, finer) } else { finer }
}

/// Whether somebody asks for what is behind the window.
fn goes_on(problem: &Problem, numerics: &Numerics) -> bool {
    numerics.whole_run && problem.window_s.1 < problem.duration_s
}

/// The run that is shown. Where it goes on for long behind its window, what is of the window is that of a shorter one: energies take many steps.
fn shown<W: FnMut(&State)>(
    problem: &Problem,
    numerics: &Numerics,
    (method, setting, apart): (Method, Setting, bool),
    runs: &dyn Runs,
    watch: Option<&mut W>,
) -> Result<Tally, SolveError> {
    let window = problem.of_window();
    let whole = if watch.is_some() || goes_on(problem, numerics) { problem } else { &window };
    let finer = match method {
        _ if apart && numerics.steps_per_period.is_none() => for_energies(problem, numerics, method, setting),
        Method::Taylor => for_curves(problem, numerics, method, setting),
        _ => setting,
    };
    let long = apart && whole.duration_s > LONG * window.duration_s;
    let (by, energies) = if long { (for_curves(problem, numerics, method, setting), false) } else { (finer, numerics.energies) };
    let tally = match watch {
        Some(watch) => method.run(whole, by, energies, watch)?,
        None => runs.run(whole, method, by, energies)?,
    };
    if !long {
        return Ok(tally);
    }
    let Tally { peak_velocity_m_per_s, peak_displacement_m, peak_force_ratio, steps, reversals, .. } = tally;
    let of_window = runs.run(&window, method, finer, true)?;
    Ok(Tally { peak_velocity_m_per_s, peak_displacement_m, peak_force_ratio, steps, reversals, ..of_window })
}

/// Runs what is to be shown, if it has not been, and puts the answer together.
fn answer<W: FnMut(&State)>(
    problem: &Problem,
    numerics: &Numerics,
    (method, why): (Method, String),
    found: Found,
    runs: &dyn Runs,
    watch: Option<&mut W>,
) -> Result<Solution, SolveError> {
    let setting = found.setting;
    // Energies are added up in a run of their own; the friction is that of the run without them, so that it is the same whether or not somebody asks for them.
    let apart = numerics.energies && method != Method::Midpoint;
    let plain = match found.tally {
        None if apart => Some(runs.run(&problem.of_window(), method, setting, false)?),
        tally => tally,
    };
    let shown = match plain.filter(|_| !apart && watch.is_none() && !goes_on(problem, numerics)) {
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
        let coupled = runs.run(&problem.of_window(), Method::Linexp, setting, false)?;
        let left_out = (ratios.friction - Ratios::of(problem, &coupled).friction).abs();
        warnings
            .push(format!("what friction does to the motion is left out; with it the friction ratio moves by {left_out:.1e}"));
        error += left_out;
        if let Some(record_error) = &mut record_error {
            let recorded = |method| runs.recorded(problem, method, setting);
            *record_error += recorded(Method::Frozen)?.1.distance(&recorded(Method::Linexp)?.1, problem);
        }
    }
    if numerics.steps_per_period.is_none() {
        error = error.max(LEAST_STATED * numerics.tolerance);
        record_error = record_error.map(|error| error.max(LEAST_STATED * numerics.tolerance));
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
        ns_per_period: None,
    };
    state_errors(&mut solution, (error, record_error), numerics.tolerance);
    Ok(solution)
}
