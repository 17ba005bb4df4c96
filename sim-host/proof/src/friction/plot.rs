//! The plot: what is wanted against what is had.

use super::Found;
use super::cases::Way;
use report::{Axis, Figure, Series, Style};

/// Wanted and true ratios of the first speed, by both laws and by bursts.
pub fn figure(campaign: &[Found]) -> Figure {
    let first = campaign.first().map(|found| (found.case.speed_m_per_s, found.case.told));
    let shown = campaign.iter().filter(|found| Some((found.case.speed_m_per_s, found.case.told)) == first);
    let series = shown.filter_map(|found| {
        let (law, style) = match found.case.way {
            Way::Amplitude => ("amplitude", Style::Points),
            Way::Bursts(1000.0) => ("bursts at 1 kHz", Style::Points),
            Way::Coulomb => ("Coulomb's law", Style::Dashed),
            _ => return None,
        };
        let micrometres = 1e6 * found.case.length_m;
        let had = || found.steps.iter().filter(|step| !step.is_refused());
        Some(Series {
            name: format!("{law}, {micrometres} um"),
            csv_column: format!("ratio_{}_{micrometres}um", law.replace([' ', '\''], "_")),
            x: had().map(|step| step.wanted).collect(),
            y: had().map(|step| step.truth).collect(),
            style,
        })
    });
    let ratio = |label: &str| Axis { label: label.into(), log: false, range: Some((0.0, 1.0)) };
    let diagonal = Series {
        name: "what is wanted".into(),
        csv_column: "wanted".into(),
        x: vec![0.0, 1.0],
        y: vec![0.0, 1.0],
        style: Style::Line,
    };
    Figure {
        id: "friction-switch".into(),
        title: "The friction switch: what is wanted and what is had".into(),
        caption: "True friction ratio over the wanted one, contacts of four Dahl lengths, speed told 2 % too low.".into(),
        x: ratio("wanted ratio"),
        y: ratio("true ratio"),
        series: std::iter::once(diagonal).chain(series).collect(),
        ..Figure::default()
    }
}
