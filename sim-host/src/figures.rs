//! The figures of a study.

mod contact;
mod driven;

use crate::report::{Axis, Figure};
use crate::study::{Outcome, Study};

/// All figures that this study has something to show in, the most telling first.
pub fn of(study: &Study) -> Vec<Figure> {
    match &study.outcome {
        Outcome::Driven(run) => driven::of(run),
        Outcome::Contact(solved) => contact::of(solved),
    }
}

fn axis(label: &str) -> Axis {
    Axis { label: label.into(), ..Axis::default() }
}
