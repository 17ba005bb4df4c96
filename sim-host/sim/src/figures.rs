//! The figures of a study.

use crate::instruments::{DRIVEN, View, sweep};
use crate::study::{Outcome, Study, contact, monte_carlo};
use report::Figure;

/// The figures of a study, the most telling first.
pub fn of(study: &Study) -> Vec<Figure> {
    let own = match &study.outcome {
        Outcome::Driven(run) => {
            let view = View::new(&run.scene, &run.record);
            DRIVEN.iter().flat_map(|instrument| instrument.figures(&view)).collect()
        }
        Outcome::Contact(solved) => contact::figures::of(solved),
        Outcome::MonteCarlo(runs) => monte_carlo::figures::of(study.scene, runs),
    };
    let sweeps = study.comparison.iter().flat_map(|comparison| &comparison.sweeps);
    own.into_iter().chain(sweeps.flat_map(sweep::figures)).collect()
}
