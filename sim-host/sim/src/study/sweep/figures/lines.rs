//! Curves of a metric over a key, single or as a family, and separate points.

use super::{Data, MAX_DOTS, MAX_FAMILY, axis, figure};
use crate::numbers::distinct;
use report::{Figure, Series, Style};

/// Draws the metric over the only key.
pub(super) fn curve(data: &Data) -> Figure {
    let mut points: Vec<(f64, f64)> = data.values[0].iter().copied().zip(data.results.iter().copied()).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (x, y) = points.into_iter().unzip();
    let title = format!("{} over {}", data.words(), data.key(0).0);
    Figure {
        x: data.axis(0),
        y: axis(data.metric),
        series: vec![series(axis(data.metric).label, data.metric, x, y, Style::Line)],
        interactive: true,
        ..figure("curve", title, "Each point is a separate run.", data)
    }
}

/// Draws the metric over the key with more values, with a curve for each value of the other, or for
/// some of them. `rows` and `columns` are the numbers of values; the second key changes fastest.
pub(super) fn family(data: &Data, (rows, columns): (u64, u64)) -> Figure {
    let along = usize::from(columns >= rows);
    let (long, short) = (rows.max(columns), rows.min(columns));
    let place = |line: usize, at: usize| if along == 1 { line * columns as usize + at } else { at * columns as usize + line };
    let curves = short.min(MAX_FAMILY) as usize;
    let lines: Vec<usize> = (0..curves).map(|n| n * (short as usize - 1) / (curves - 1).max(1)).collect();
    let (words, unit) = data.key(1 - along);
    let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
    let texts = distinct(&lines.iter().map(|&line| data.values[1 - along][place(line, 0)]).collect::<Vec<_>>());
    let curve = |(&line, value): (&usize, &String)| {
        let mut points: Vec<usize> = (0..long as usize).map(|at| place(line, at)).collect();
        points.sort_by(|&a, &b| data.values[along][a].total_cmp(&data.values[along][b]));
        let of = |column: &[f64]| points.iter().map(|&point| column[point]).collect();
        series(
            format!("{words} = {value}{unit}"),
            &format!("{}_at_{value}", data.metric),
            of(&data.values[along]),
            of(&data.results),
            Style::Line,
        )
    };
    Figure {
        x: data.axis(along),
        y: axis(data.metric),
        series: lines.iter().zip(&texts).map(curve).collect(),
        interactive: true,
        ..figure(
            "family",
            format!("{} over {}", data.words(), data.key(along).0),
            &format!(
                "A curve for {} of {short} values of `{}`. Each point is a separate run.",
                if curves < short as usize { "some" } else { "each" },
                data.keys[1 - along]
            ),
            data,
        )
    }
}

/// Draws the metric over one of many keys; all others have different values at each point.
pub(super) fn dots(data: &Data, key: usize) -> Figure {
    let every = data.results.len().div_ceil(MAX_DOTS);
    let of = |column: &[f64]| column.iter().copied().step_by(every).collect();
    let name = &data.keys[key];
    let figure = figure(
        "over",
        format!("{} over {}", data.words(), data.key(key).0),
        "Points of the sample, at most 2000; all other keys have different values at each point.",
        data,
    );
    Figure {
        id: format!("{}-{}", figure.id, name.replace('.', "-")),
        x: data.axis(key),
        y: axis(data.metric),
        series: vec![series(axis(data.metric).label, data.metric, of(&data.values[key]), of(&data.results), Style::Points)],
        ..figure
    }
}

fn series(name: String, csv_column: &str, x: Vec<f64>, y: Vec<f64>, style: Style) -> Series {
    Series { name, csv_column: csv_column.to_owned(), x, y, style }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The legend has key, unit and all digits that distinguish the curves.
    #[test]
    fn a_family_names_key_value_and_unit() {
        let keys = ["rig.slider.load_n".to_owned(), "rig.slider.speed_m_per_s".to_owned()];
        let names = |speeds: [f64; 2]| {
            let values = [vec![1.0, 1.0, 2.0, 2.0, 3.0, 3.0], speeds.repeat(3)];
            let data =
                Data { keys: &keys, values: &values, metric: "m", logs: &[false; 2], results: (0..6).map(f64::from).collect() };
            family(&data, (3, 2)).series.into_iter().map(|series| series.name).collect::<Vec<_>>()
        };
        assert_eq!(names([0.038, 0.068]), ["speed = 0.038 m/s", "speed = 0.068 m/s"]);
        assert_eq!(names([0.05, 0.050_001]), ["speed = 0.05 m/s", "speed = 0.050001 m/s"]);
    }
}
