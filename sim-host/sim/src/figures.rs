//! The figures of a study.

use crate::instruments::{DRIVEN, View, sweep};
use crate::overlay::{Residual, lay};
use crate::study::grid::GridResult;
use crate::study::sweep::figures as points;
use crate::study::{Outcome, Study, contact, monte_carlo};
use report::Figure;
use scene::Scene;

/// The measured curves of a study's scene against its simulated ones.
pub fn residuals(study: &Study) -> Vec<Residual> {
    if study.scene.overlay.is_empty() { Vec::new() } else { lay(&mut own(study), &study.scene.overlay, hz(study.scene)) }
}

/// Frequency by which periods of the excitation are counted.
fn hz(scene: &Scene) -> Option<f64> {
    scene.excitation.as_ref().map(|excitation| excitation.frequency_hz)
}

/// The figures of a study, the most telling first.
pub fn of(study: &Study) -> Vec<Figure> {
    let mut own = own(study);
    lay(&mut own, &study.scene.overlay, hz(study.scene));
    let sweeps = study.comparison.iter().flat_map(|comparison| &comparison.sweeps);
    own.into_iter().chain(sweeps.flat_map(sweep::figures)).chain(study.grid.iter().flat_map(of_grid)).collect()
}

/// The figures of the scene's own runs, without what was measured.
fn own(study: &Study) -> Vec<Figure> {
    match &study.outcome {
        Outcome::Driven(run) => {
            let view = View::new(&run.scene, &run.record);
            DRIVEN.iter().flat_map(|instrument| instrument.figures(&view)).collect()
        }
        Outcome::Contact(solved) => contact::figures::of(solved),
        Outcome::MonteCarlo(runs) => monte_carlo::figures::of(study.scene, runs),
    }
}

/// The figures of a scene's grid.
fn of_grid(grid: &GridResult) -> Vec<Figure> {
    let figures = points::of(&grid.design.shape(), &grid.keys(), &grid.metrics, |name| grid.column(name).ok_or(()));
    let named = |figure: Figure| Figure { id: format!("grid-{}", figure.id), ..figure };
    figures.into_iter().flatten().map(named).collect()
}
