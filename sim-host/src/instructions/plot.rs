//! The plot: what a sine with its cosine costs against how far it is off.

use super::{Measurement, Row};
use crate::report::{Axis, Figure, Marker, Series, Style};

/// Instructions against error, one series a family.
pub fn figure(measurement: &Measurement) -> Figure {
    let rows = &measurement.generators;
    let mut families: Vec<&str> = Vec::new();
    for row in rows {
        if !families.contains(&row.known.family) {
            families.push(row.known.family);
        }
    }
    Figure {
        id: "instructions".into(),
        title: "Sine with cosine on a Cortex-M4F: instructions against error".into(),
        caption: "Further left and lower is better. Half a step of a 12-bit converter is 2.4e-4 of its half range.".into(),
        x: Axis { label: "instructions a sample".into(), log: true, range: Some((2.5, 5000.0)) },
        y: Axis { label: "largest error of amplitude one".into(), log: true, range: Some((3e-8, 2e-2)) },
        series: families.iter().map(|family| series(rows, family)).collect(),
        markers: markers(rows),
        hlines: vec![(2.44e-4, "half a step of 12 bits".into())],
        ..Figure::default()
    }
}

fn series(rows: &[Row], family: &str) -> Series {
    let of = || rows.iter().filter(|row| row.known.family == family);
    Series {
        name: family.into(),
        csv_column: format!("largest_error_{}", family.replace(' ', "_")),
        x: of().map(|row| row.instructions).collect(),
        y: of().map(|row| row.quality.largest_error).collect(),
        style: Style::Points,
    }
}

/// A label at each point; what lies within one label's size of another shares it.
fn markers(rows: &[Row]) -> Vec<Marker> {
    let mut markers: Vec<Marker> = Vec::new();
    for row in rows {
        let (x, y) = (row.instructions, row.quality.largest_error);
        let near = |marker: &&mut Marker| (marker.x / x).ln().abs() < 0.02 && (marker.y / y).ln().abs() < 0.2;
        match markers.iter_mut().find(near) {
            Some(marker) => marker.label = format!("{}; {}", marker.label, row.known.name),
            None => markers.push(Marker { x, y, label: row.known.name.into() }),
        }
    }
    markers
}
