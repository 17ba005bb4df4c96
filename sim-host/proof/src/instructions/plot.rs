//! The plot: what a sine with its cosine costs against how far it is off.

use super::{Measurement, Row};
use report::{Axis, Figure, Series, Style};

/// Instructions against error, a mark a generator.
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
        caption: "Further left and lower is better. Half a step of a 12-bit converter is 2.4e-4 of its half range. Several marks of one kind, \
                  from top to bottom, are in the order of the legend."
            .into(),
        x: Axis { label: "instructions a sample".into(), log: true, range: Some((2.5, 5000.0)) },
        y: Axis { label: "largest error of amplitude one".into(), log: true, range: Some((2e-8, 2e-2)) },
        series: families.iter().map(|family| series(rows, family)).collect(),
        hlines: vec![(2.44e-4, "half a step of 12 bits".into())],
        ..Figure::default()
    }
}

fn series(rows: &[Row], family: &str) -> Series {
    let of = || rows.iter().filter(|row| row.known.family == family);
    let column: String = family.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    Series {
        name: family.into(),
        csv_column: format!("largest_error_{column}"),
        x: of().map(|row| row.instructions).collect(),
        y: of().map(|row| row.quality.largest_error).collect(),
        style: Style::Points,
    }
}
