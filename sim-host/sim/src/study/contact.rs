//! A study of a contact by itself.

pub mod figures;
pub mod metrics;
pub mod table;

use std::sync::atomic::AtomicBool;

use super::StudyError;
use super::across;
use super::answer::Answer;
use super::playback::Playback;
use super::stopped::{leave_if, unless_stopped};
use crate::metrics::Metrics;
use crate::overlay;
use contact::{self, Clock, Law, SolveError, State};
use scene::{Excited, Model, problem};

/// A contact study, solved.
#[derive(Clone, Debug)]
pub struct Solved<'a> {
    /// Scene of the contact study.
    pub scene: Excited<'a>,
    /// The answer; none if it was stopped before there was one.
    pub answer: Option<Answer>,
    /// What was seen on the way.
    pub playback: Playback,
}

/// Solves a scene, records and measures it.
pub(super) fn run<'a>(
    scene: Excited<'a>,
    clock: Option<Clock>,
    stop: &AtomicBool,
    mut progress: Option<&mut dyn FnMut(f64)>,
) -> Result<(Solved<'a>, Metrics), StudyError> {
    let mut playback = Playback::new(scene.duration_s, scene.excitation.frequency_hz);
    let watch = &mut |state: &State| {
        if playback.see(state) {
            leave_if(stop);
            if let Some(progress) = &mut progress {
                progress(state.time_s);
            }
        }
    };
    let answer = unless_stopped(|| answer(&scene, None, (stop, clock), Some(watch))).transpose()?;
    playback.finish();
    let mut metrics = measured(&scene, answer.as_ref());
    let solved = Solved { scene, answer, playback };
    if !scene.overlay.is_empty() {
        let hz = Some(scene.excitation.frequency_hz);
        overlay::put(&overlay::lay(&mut figures::of(&solved), &scene.overlay, hz), &mut metrics);
    }
    Ok((solved, metrics))
}

/// The numbers of a scene that is a cell of a grid, or as many as some metrics need; none of them if it is stopped.
pub(super) fn cell(scene: &Excited, wanted: Option<&[&str]>, stop: &AtomicBool) -> Result<Metrics, StudyError> {
    let answer = unless_stopped(|| answer(scene, wanted, (stop, None), None::<&mut fn(&State)>)).transpose()?;
    Ok(measured(scene, answer.as_ref()))
}

fn measured(scene: &Excited, answer: Option<&Answer>) -> Metrics {
    answer.map_or_else(Metrics::default, |answer| metrics::of(scene, answer))
}

fn answer<W: FnMut(&State)>(
    scene: &Excited,
    wanted: Option<&[&str]>,
    (stop, clock): (&AtomicBool, Option<Clock>),
    watch: Option<&mut W>,
) -> Result<Answer, SolveError> {
    // A Hertzian contact has Coulomb's law between its normal force and its friction.
    let problem = problem::problem(scene, problem::law(&scene.model).unwrap_or(Law::Coulomb))?;
    let (numerics, pause) = (problem::numerics(scene, wanted), || leave_if(stop));
    let (solution, across) = match scene.model {
        Model::Hertz(model) => {
            let (solution, across) = match watch {
                Some(watch) => across::solve(&problem, model, &numerics, (&pause, clock), watch)?,
                None => across::solve(&problem, model, &numerics, (&pause, clock), &mut |_: &State| leave_if(stop))?,
            };
            (solution, Some(across))
        }
        _ => match watch {
            Some(watch) => (contact::solve_with(&problem, &numerics, &pause, clock, watch)?, None),
            None => (contact::solve_unwatched(&problem, &numerics, &pause)?, None),
        },
    };
    Ok(Answer { problem, solution, across })
}
