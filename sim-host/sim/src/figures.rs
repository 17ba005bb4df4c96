//! Figures of a study.

use crate::instruments::{self, View, sweep};
use crate::study::grid::GridResult;
use crate::study::sweep::figures as points;
use crate::study::{Outcome, Study, contact, design, monte_carlo};
use report::Figure;

/// Returns the figures of a study, the most important first.
pub fn of(study: &Study) -> Vec<Figure> {
    let own = study.overlaid.as_ref().map_or_else(|| own(study), |overlaid| overlaid.figures.clone());
    let sweeps = study.comparison.iter().flat_map(|comparison| &comparison.sweeps);
    own.into_iter().chain(sweeps.flat_map(sweep::figures)).chain(study.grid.iter().flat_map(of_grid)).collect()
}

/// Returns the figures of the scene's own runs, without measured curves.
fn own(study: &Study) -> Vec<Figure> {
    match &study.outcome {
        Outcome::Driven(run) => instruments::figures(&View::new(&run.scene, &run.record)),
        Outcome::Contact(solved) => contact::figures::all(solved),
        Outcome::Design(drawn) => design::figures::all(drawn),
        Outcome::MonteCarlo(runs) => monte_carlo::figures::all(study.scene, runs),
    }
}

/// Returns the figures of a scene's grid.
fn of_grid(grid: &GridResult) -> Vec<Figure> {
    let column = |name: &str| grid.column(name).ok_or(());
    let figures = points::all(&grid.design.shape(), &grid.keys(), &grid.metrics, &grid.grid.contours, column);
    let named = |figure: Figure| Figure { id: format!("grid-{}", figure.id), ..figure };
    figures.into_iter().flatten().map(named).collect()
}
