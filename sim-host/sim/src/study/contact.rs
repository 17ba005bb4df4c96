//! A study of a contact alone.

pub mod figures;
pub mod metrics;
pub mod table;

use std::sync::atomic::AtomicBool;

use super::StudyError;
use super::across;
use super::answer::Answer;
use super::in_plane;
use super::playback::Playback;
use super::stopped::{interrupt_if, unless_stopped};
use crate::metrics::Metrics;
use crate::overlay::{self, Overlaid};
use contact::custom::{Expression, FrictionLaw};
use contact::{self, Clock, Law, Method, Numerics, Orbit, Problem, Solution, SolveError, State, ToleranceOf};
use scene::{Excited, Model, problem};

/// Maximum number of steps between progress reports and checks of the stop flag: some milliseconds.
const PROGRESS_STEPS: u32 = 1 << 16;

/// A solved contact study.
#[derive(Clone, Debug)]
pub struct Solved<'a> {
    /// Scene of the contact study.
    pub scene: Excited<'a>,
    /// Answer; `None` if the study was stopped before.
    pub answer: Option<Answer>,
    /// Recorded states.
    pub playback: Playback,
}

/// Solves a scene, records it and measures it.
pub(super) fn run<'a>(
    scene: Excited<'a>,
    (clock, law): (Option<Clock>, Option<&(dyn FrictionLaw + Sync)>),
    stop: &AtomicBool,
    mut progress: Option<&mut dyn FnMut(f64)>,
) -> Result<(Solved<'a>, Metrics, Option<Overlaid>), StudyError> {
    let mut playback = Playback::new(scene.duration_s, scene.excitation.frequency_hz);
    // A bin of a long run has too many steps to wait for its end.
    let mut steps = 0u32;
    let watch = &mut |state: &State| {
        steps = steps.wrapping_add(1);
        if playback.add(state) || steps.is_multiple_of(PROGRESS_STEPS) {
            interrupt_if(stop);
            if let Some(progress) = &mut progress {
                progress(state.time_s);
            }
        }
    };
    let answer = unless_stopped(|| answer(&scene, None, (stop, clock), law, Some(watch))).transpose()?;
    playback.finish();
    let mut metrics = measured(&scene, answer.as_ref());
    let solved = Solved { scene, answer, playback };
    let overlaid = (!scene.overlay.is_empty()).then(|| overlaid(&solved));
    overlay::put(overlaid.iter().flat_map(|laid| &laid.residuals), &mut metrics);
    Ok((solved, metrics, overlaid))
}

/// Returns the figures of a study with the measured curves of its scene.
fn overlaid(solved: &Solved) -> Overlaid {
    let scene = &solved.scene;
    let mut laid = overlay::lay(figures::all(solved), &scene.overlay, Some(scene.excitation.frequency_hz));
    if solved.answer.as_ref().is_some_and(|answer| answer.solution.method == Method::Closed) {
        let why = " A closed form has no time series: `--set integrator.method=linexp` computes one.";
        laid.not_drawn.iter_mut().for_each(|said| *said += why);
    }
    laid
}

/// Returns the metrics of a scene that is solved in closed form, and its measured curves over its
/// one period. `None` for a scene without measured curves or with steps.
pub(super) fn overlaid_closed_form(scene: &Excited) -> Option<(Metrics, Overlaid)> {
    let problem = problem::problem(scene, problem::law(&scene.model)?).ok()?;
    let closed = !scene.overlay.is_empty() && contact::closed_form(&problem, &problem::numerics(scene, None)).is_some();
    let (_, metrics, overlaid) = closed.then(|| run(*scene, (None, None), &AtomicBool::new(false), None))?.ok()?;
    Some((metrics, overlaid?))
}

/// Returns `true` if the wanted metrics of a scene (all, if `None`) compare it with a measurement,
/// and so need its complete run.
pub(super) fn needs_figures(scene: &Excited, wanted: Option<&[&str]>) -> bool {
    !scene.overlay.is_empty() && wanted.is_none_or(|wanted| wanted.iter().any(|metric| overlay::is_metric(metric)))
}

/// Returns the metrics of a grid cell; with `wanted`, only as many as these metrics need. Returns
/// no metrics if it is stopped.
pub(super) fn cell(scene: &Excited, wanted: Option<&[&str]>, stop: &AtomicBool) -> Result<Metrics, StudyError> {
    if needs_figures(scene, wanted) {
        return run(*scene, (None, None), stop, None).map(|(_, metrics, _)| metrics);
    }
    let answer = unless_stopped(|| answer(scene, wanted, (stop, None), None, None::<&mut fn(&State)>)).transpose()?;
    Ok(measured(scene, answer.as_ref()))
}

fn measured(scene: &Excited, answer: Option<&Answer>) -> Metrics {
    answer.map_or_else(Metrics::default, |answer| metrics::measure(scene, answer))
}

/// Returns the friction ratio of the steady state, and its motion, if they are known and wanted.
pub(super) fn steady(
    problem: &Problem,
    numerics: &Numerics,
    solution: &Solution,
    wanted: Option<&[&str]>,
    pause: &dyn Fn(),
) -> Option<(f64, Orbit)> {
    if let Some(orbit) = solution.orbit {
        return Some((solution.ratios.friction, orbit));
    }
    let is_wanted = wanted.is_none_or(|wanted| wanted.iter().any(|metric| metrics::STEADY.contains(metric)));
    if numerics.steady || !is_wanted || solution.method == Method::Closed {
        return None;
    }
    let lean = Numerics { steady: true, tolerance_of: ToleranceOf::Mean, energies: false, ..*numerics };
    let settled = contact::solve_unwatched(problem, &lean, pause).ok()?;
    Some((settled.ratios.friction, settled.orbit?))
}

fn answer<W: FnMut(&State)>(
    scene: &Excited,
    wanted: Option<&[&str]>,
    (stop, clock): (&AtomicBool, Option<Clock>),
    law: Option<&(dyn FrictionLaw + Sync)>,
    watch: Option<&mut W>,
) -> Result<Answer, SolveError> {
    // With vibration normal to the surface, friction is Coulomb's fraction of the normal force.
    let problem = problem::problem(scene, problem::law(&scene.model).unwrap_or(Law::Coulomb))?;
    let (numerics, pause) = (problem::numerics(scene, wanted), || interrupt_if(stop));
    if let Some(law) = law {
        let watch = watch.map(|watch| watch as &mut dyn FnMut(&State));
        let solution = contact::custom::solve(&problem, law, &numerics, (&pause, clock), watch)?;
        let steady = solution.orbit.map(|orbit| (solution.ratios.friction, orbit));
        return Ok(Answer { problem, solution, steady, across: None, in_plane: None });
    }
    if let Model::Expression(model) = scene.model {
        let law = Expression::new(&model.source())
            .map_err(|error| SolveError::Refused { reason: error.to_string(), advice: format!("correct `{}`", error.key) })?;
        return answer(scene, wanted, (stop, clock), Some(&law), watch);
    }
    if let Some(direction) = problem::direction(scene) {
        let (solution, in_plane) = in_plane::solve(&problem, direction, &numerics, (&pause, clock), watch)?;
        return Ok(Answer { problem, solution, steady: None, across: None, in_plane: Some(in_plane) });
    }
    let (solution, across) = match scene.model {
        Model::Hertz(model) => {
            let (solution, across) = match watch {
                Some(watch) => across::solve(&problem, model, &numerics, (&pause, clock), watch)?,
                None => across::solve(&problem, model, &numerics, (&pause, clock), &mut |_: &State| interrupt_if(stop))?,
            };
            (solution, Some(across))
        }
        Model::Compliant(model) => {
            let (solution, across) = across::solve_compliant(&problem, model, &numerics, clock, watch)?;
            (solution, Some(across))
        }
        _ => match watch {
            Some(watch) => (contact::solve_with(&problem, &numerics, &pause, clock, watch)?, None),
            None => (contact::solve_unwatched(&problem, &numerics, &pause)?, None),
        },
    };
    let steady = if across.is_none() { steady(&problem, &numerics, &solution, wanted, &pause) } else { None };
    Ok(Answer { problem, solution, steady, across, in_plane: None })
}
