//! The figures of a study.

use crate::instruments::{self, View, sweep};
use crate::study::grid::GridResult;
use crate::study::sweep::figures as points;
use crate::study::{Outcome, Study, contact, monte_carlo};
use report::Figure;

/// The figures of a study, the most telling first.
pub fn of(study: &Study) -> Vec<Figure> {
    let own = study.overlaid.as_ref().map_or_else(|| own(study), |overlaid| overlaid.figures.clone());
    let sweeps = study.comparison.iter().flat_map(|comparison| &comparison.sweeps);
    own.into_iter().chain(sweeps.flat_map(sweep::figures)).chain(study.grid.iter().flat_map(of_grid)).collect()
}

/// The figures of the scene's own runs, without what was measured.
fn own(study: &Study) -> Vec<Figure> {
    match &study.outcome {
        Outcome::Driven(run) => instruments::figures(&View::new(&run.scene, &run.record)),
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
