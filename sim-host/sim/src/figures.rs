//! The figures of a study.

mod contact;
mod driven;
mod monte_carlo;

use crate::study::{Outcome, Study};
use report::{Axis, Figure};

/// All figures that this study has something to show in, the most telling first.
pub fn of(study: &Study) -> Vec<Figure> {
    let own = match &study.outcome {
        Outcome::Driven(run) => driven::of(run),
        Outcome::Contact(solved) => contact::of(solved),
        Outcome::MonteCarlo(runs) => monte_carlo::of(study.scene, runs),
    };
    let sweeps = study.comparison.iter().flat_map(|comparison| &comparison.sweeps);
    own.into_iter().chain(sweeps.flat_map(driven::time_frequency::of)).collect()
}

fn axis(label: &str) -> Axis {
    Axis { label: label.into(), ..Axis::default() }
}
