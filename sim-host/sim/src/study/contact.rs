//! A study of a contact by itself.

use std::f64::consts::TAU;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use super::StudyError;
use super::film::Film;
use super::stopped::{leave_if, unless_stopped};
use crate::metrics::{self, Metrics};
use contact::hertz::{self, HertzProblem};
use contact::tally::Ratios;
use contact::{self, Law, Method, Problem, Solution, State, Trouble};
use scene::{Excited, Hertz, Model, problem};

/// A contact study, solved.
#[derive(Clone, Debug)]
pub struct Solved<'a> {
    /// The scene.
    pub scene: Excited<'a>,
    /// The answer; none if it was stopped before there was one.
    pub answer: Option<Answer>,
    /// What was seen on the way.
    pub film: Film,
}

/// A problem and its solution.
#[derive(Clone, Debug)]
pub struct Answer {
    /// The problem.
    pub problem: Problem,
    /// Its solution.
    pub solution: Solution,
}

/// Solves a scene, films it and measures it.
pub(super) fn conduct<'a>(
    scene: Excited<'a>,
    stop: &AtomicBool,
    mut progress: Option<&mut dyn FnMut(f64)>,
) -> Result<(Solved<'a>, Metrics), StudyError> {
    let mut film = Film::new(scene.duration_s, scene.excitation.frequency_hz);
    let watch = &mut |state: &State| {
        if film.see(state) {
            leave_if(stop);
            if let Some(progress) = &mut progress {
                progress(state.time_s);
            }
        }
    };
    let answer = unless_stopped(|| answer(&scene, stop, watch)).transpose()?;
    film.finish();
    let metrics = measured(&scene, answer.as_ref());
    Ok((Solved { scene, answer, film }, metrics))
}

/// The numbers of a scene that is a cell of a grid; none of them if it is stopped.
pub(super) fn cell(scene: &Excited, stop: &AtomicBool) -> Result<Metrics, StudyError> {
    let answer = unless_stopped(|| answer(scene, stop, &mut |_: &State| leave_if(stop))).transpose()?;
    Ok(measured(scene, answer.as_ref()))
}

fn measured(scene: &Excited, answer: Option<&Answer>) -> Metrics {
    answer.map_or_else(Metrics::default, |answer| metrics::contact::of(scene, &answer.problem, &answer.solution))
}

fn answer(scene: &Excited, stop: &AtomicBool, watch: &mut impl FnMut(&State)) -> Result<Answer, Trouble> {
    // A Hertzian contact has Coulomb's law between its normal force and its friction.
    let problem = problem::problem(scene, problem::law(&scene.model).unwrap_or(Law::Coulomb))?;
    let solution = match scene.model {
        Model::Hertz(model) => hertz(&problem, model, watch)?,
        _ => contact::solve_with(&problem, &problem::numerics(scene), &|| leave_if(stop), watch)?,
    };
    Ok(Answer { problem, solution })
}

/// Vibration across the surface, in closed form: the body moves by `vibration / w` about its mean distance.
fn hertz(problem: &Problem, model: &Hertz, watch: &mut impl FnMut(&State)) -> Result<Solution, Trouble> {
    let omega = TAU * problem.waveform.frequency_hz();
    let across = HertzProblem {
        normal_n: problem.coulomb_n / model.mu,
        stiffness_n_per_m15: model.stiffness_n_per_m15,
        amplitude_m: problem.vibration_m_per_s() / omega,
        shape: problem.waveform.shape(),
    };
    let began = Instant::now();
    let found = hertz::solve(&across)?;
    let ns = began.elapsed().as_secs_f64() * 1e9;
    for point in hertz::period(&across, &found) {
        watch(&State {
            time_s: point.phase_turns / problem.waveform.frequency_hz(),
            x_m: point.deflection_m - found.mean_deflection_m,
            v_m_per_s: -problem.vibration_m_per_s() * (TAU * point.phase_turns).sin(),
            // Friction is in proportion to the contact area, and that to the deflection.
            force_n: problem.coulomb_n * point.deflection_m.max(0.0) / found.static_deflection_m,
        });
    }
    Ok(Solution {
        method: Method::Closed,
        why: format!(
            "vibration across a Hertzian contact, quasi-static: in contact for {:.1} % of the period",
            100.0 * found.contact_share
        ),
        steps_per_period: None,
        order: None,
        // The slip does not vary, so power goes as force.
        ratios: Ratios { friction: found.friction_ratio, power: Some(found.friction_ratio), ..Ratios::default() },
        tally: None,
        error_estimate: None,
        warnings: Vec::new(),
        states: 0,
        ns_per_period: ns / (problem.duration_s * problem.waveform.frequency_hz()),
    })
}
