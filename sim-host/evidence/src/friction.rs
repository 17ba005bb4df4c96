//! The friction switch: runs the suite `friction.toml`, and plots result over set point.

use crate::evidence::{Error, Evidence, Options, built_in};
use report::{Axis, Figure, Series, Style};
use sim::study::suite::{CaseResult, SuiteResult};

/// Text of the suite.
pub(crate) const SUITE: &str = include_str!("../suites/friction.toml");

/// Runs the suite of the friction switch.
pub fn run(options: &mut Options) -> Result<Evidence, Error> {
    built_in(("friction", SUITE), options, |result, report| {
        report.figures.push(figure(result));
        Ok(())
    })
}

/// Plots true ratios over set points for the contacts at the first speed, by both laws and by
/// bursts.
fn figure(result: &SuiteResult) -> Figure {
    let series = |case: &CaseResult| {
        let (contact, way) =
            case.case.name.strip_suffix(" Hz").unwrap_or(&case.case.name).split_once(", 38 mm/s, speed -2 %: ")?;
        let (law, style) = match way {
            "amplitude" => (way, Style::Points),
            "boosted bursts, 1000" => ("bursts at 1 kHz", Style::Points),
            "amplitude by Coulomb's law" => ("Coulomb's law", Style::Dashed),
            _ => return None,
        };
        let held = || case.steps.iter().filter(|step| !step.is_refused());
        Some(Series {
            name: format!("{law}, {contact}"),
            csv_column: format!("ratio_{}_{}", law.replace([' ', '\''], "_"), contact.replace(' ', "")),
            x: held().map(|step| step.set_point).collect(),
            y: held().map(|step| step.truth).collect(),
            style,
        })
    };
    let ratio = |label: &str| Axis { label: label.into(), log: false, range: Some((0.0, 1.0)), ..Axis::default() };
    let diagonal = Series {
        name: "set point".into(),
        csv_column: "set_point".into(),
        x: vec![0.0, 1.0],
        y: vec![0.0, 1.0],
        style: Style::Line,
    };
    Figure {
        id: "friction-switch".into(),
        title: "The friction switch: set point and result".into(),
        caption: "True friction ratio over its set point, contacts of four Dahl lengths, nominal speed 2 % too low.".into(),
        x: ratio("set point of the ratio"),
        y: ratio("true ratio"),
        series: std::iter::once(diagonal).chain(result.cases.iter().filter_map(series)).collect(),
        ..Figure::default()
    }
}
