//! Figures of a design.

use super::Drawn;
use crate::instruments::curves::axis;
use ::design::Point;
use report::{Axis, Figure, Marker, Panel, Series, Style};

const ALONG: &str = "distance from the back [mm]";

/// Returns all figures of a design, the most important first.
pub fn all(drawn: &Drawn) -> Vec<Figure> {
    let mut figures = vec![shape(drawn), stress(drawn)];
    figures.extend(drawn.solved.circuit.is_some().then(|| admittance(drawn)));
    figures
}

fn line(name: &str, csv_column: &str, x: Vec<f64>, y: Vec<f64>) -> Series {
    Series { name: name.into(), csv_column: csv_column.into(), x, y, style: Style::Line }
}

/// Returns a curve over the points along the axis.
fn along(drawn: &Drawn, name: &str, csv_column: &str, value: impl Fn(&Point) -> f64) -> Series {
    let points = &drawn.solved.operating.points;
    line(name, csv_column, points.iter().map(|point| 1e3 * point.x_m).collect(), points.iter().map(value).collect())
}

/// Returns the outline as a panel, symmetric to the axis.
fn outline(drawn: &Drawn) -> Panel {
    let radius = along(drawn, "outline", "axis_mm", |_| 0.0);
    let upper = along(drawn, "", "", |point| 1e3 * point.radius_m).y;
    let style = Style::Band { lower: upper.iter().map(|radius| -radius).collect(), upper };
    Panel { y: axis("radius [mm]"), series: vec![Series { style, ..radius }], repeats: false, hlines: Vec::new() }
}

fn shape(drawn: &Drawn) -> Figure {
    let nodes = drawn.solved.operating.nodes_m.iter().map(|node| Marker { x: 1e3 * node, y: 0.0, label: "node".into() });
    Figure {
        id: "mode-shape".into(),
        title: "Displacement along the axis".into(),
        caption: "In phase with the tip, at the operating point. Below: the outline, with holes filled to the same area.".into(),
        x: axis(ALONG),
        y: axis("displacement [µm]"),
        series: vec![along(drawn, "displacement", "displacement_um", |point| 1e6 * point.displacement_m)],
        hlines: vec![(0.0, String::new())],
        markers: nodes.collect(),
        panels: vec![outline(drawn)],
        ..Figure::default()
    }
}

fn stress(drawn: &Drawn) -> Figure {
    let solved = &drawn.solved;
    let held = |point: &Point| solved.preload_pa.iter().find(|(index, _)| *index == point.element).map_or(0.0, |(_, held)| *held);
    let at = |sign: f64| along(drawn, "", "", |point| 1e-6 * (sign * point.stress_pa.abs() - held(point))).y;
    let style = Style::Band { lower: at(-1.0), upper: at(1.0) };
    let series = vec![Series {
        style,
        ..along(drawn, "preload, with the extremes over a period", "stress_mpa", |point| -1e-6 * held(point))
    }];
    Figure {
        id: "stress".into(),
        title: "Stress along the axis: preload, and its extremes over a period".into(),
        caption: "At the operating point; tension is positive. Rings in tension leave their joints.".into(),
        x: axis(ALONG),
        y: axis("stress [MPa]"),
        series,
        hlines: vec![(0.0, String::new())],
        ..Figure::default()
    }
}

fn admittance(drawn: &Drawn) -> Figure {
    let points = drawn.solved.admittance(drawn.scene.design);
    let hz: Vec<f64> = points.iter().map(|(hz, _)| *hz).collect();
    let magnitude = points.iter().map(|(_, y)| y.norm()).collect();
    let phase = points.iter().map(|(_, y)| y.arg().to_degrees()).collect();
    Figure {
        id: "admittance-bode".into(),
        title: "Admittance".into(),
        caption: "At the electrodes, around the working mode, from the chain itself.".into(),
        x: axis("frequency [Hz]"),
        y: Axis { log: true, ..axis("admittance [S]") },
        series: vec![line("admittance", "admittance_s", hz.clone(), magnitude)],
        panels: vec![Panel {
            y: axis("phase [degrees]"),
            series: vec![line("phase", "phase_deg", hz, phase)],
            ..Panel::default()
        }],
        interactive: true,
        ..Figure::default()
    }
}
