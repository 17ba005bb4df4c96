//! Figures of friction, velocity and displacement over the whole run, by their extremes.

use super::TIME;
use crate::instruments::curves::axis;
use crate::study::contact::Solved;
use crate::study::playback::{Bin, Range};
use report::{Figure, Series, Style};

/// Quantity shown in each part of the run.
struct Quantity {
    id: &'static str,
    title: &'static str,
    axis: &'static str,
    /// Line in words, and name of its column.
    line: (&'static str, &'static str),
    middle: fn(&Bin) -> f64,
    extremes: fn(&Bin) -> Range,
}

const MICRO: f64 = 1e6;

const QUANTITIES: [Quantity; 3] = [
    Quantity {
        id: "friction-run",
        title: "Friction over the whole run",
        axis: "friction [N]",
        line: ("friction: mean and extremes", "friction_mean_n"),
        middle: Bin::mean_friction_n,
        extremes: |bin| bin.friction_n,
    },
    Quantity {
        id: "velocity-run",
        title: "Velocity over the whole run",
        axis: "velocity [m/s]",
        line: ("velocity x': extremes and their middle", "velocity_middle_m_per_s"),
        middle: |bin| bin.velocity_m_per_s.middle(),
        extremes: |bin| bin.velocity_m_per_s,
    },
    Quantity {
        id: "displacement-run",
        title: "Displacement over the whole run",
        axis: "displacement [µm]",
        line: ("displacement x: extremes and their middle", "displacement_middle_um"),
        middle: |bin| bin.displacement_m.times(MICRO).middle(),
        extremes: |bin| bin.displacement_m.times(MICRO),
    },
];

/// Returns the figures; none for a run that is already shown completely.
pub(super) fn all(solved: &Solved) -> Vec<Figure> {
    let (bins, hz) = (solved.playback.bins(), solved.scene.excitation.frequency_hz);
    if bins.len() < 2 {
        return Vec::new();
    }
    let figure = |quantity: &Quantity| {
        let (lower, upper) = bins.iter().map(quantity.extremes).map(|range| (range.least, range.most)).unzip();
        let series = Series {
            name: quantity.line.0.into(),
            csv_column: quantity.line.1.into(),
            x: bins.iter().map(|bin| hz * bin.end_s).collect(),
            y: bins.iter().map(quantity.middle).collect(),
            style: Style::Band { lower, upper },
        };
        Figure {
            id: quantity.id.into(),
            title: quantity.title.into(),
            caption: "The band contains all values of each part of the run.".into(),
            x: axis(TIME),
            y: axis(quantity.axis),
            series: vec![series],
            interactive: true,
            ..Figure::default()
        }
    };
    QUANTITIES.iter().map(figure).collect()
}
