//! Maps of a metric over two keys, with colours.

use super::{Data, axis, extremes, figure};
use report::{Figure, HeatMap};

/// Maximum number of cells of a map along an axis.
const MAX_CELLS: usize = 512;

/// Draws the map of the metric, with the second key, which changes fastest, along x. `rows` and
/// `columns` are the numbers of values of the keys.
pub(super) fn draw(data: &Data, (rows, columns): (u64, u64)) -> Figure {
    let (width, height) = (columns as usize, rows as usize);
    let (every_x, every_y) = (width.div_ceil(MAX_CELLS), height.div_ceil(MAX_CELLS));
    let cell = |x: usize, y: usize| data.results[y * width + x];
    let column = |x: usize| (0..height).step_by(every_y).map(|y| cell(x, y)).collect();
    let cells: Vec<Vec<f64>> = (0..width).step_by(every_x).map(column).collect();
    let range = extremes(&data.results);
    let thinned = if every_x * every_y > 1 {
        format!(" Of the values of the keys, 1 in {every_x} and 1 in {every_y} is drawn.")
    } else {
        String::new()
    };
    let title = format!("{} over {} and {}", data.words(), data.key(1).0, data.key(0).0);
    let (x, y) = (&data.values[1], &data.values[0]);
    Figure {
        x: data.axis(1),
        y: data.axis(0),
        interactive: true,
        map: Some(HeatMap {
            x: edges((x[0], x[(cells.len() - 1) * every_x]), cells.len(), data.logs[1]),
            y: edges((y[0], y[(cells[0].len() - 1) * every_y * width]), cells[0].len(), data.logs[0]),
            columns: cells,
            range,
            label: axis(data.metric).label,
            csv_column: data.metric.to_owned(),
            ..HeatMap::default()
        }),
        ..figure("map", title, &format!("Each cell is a separate run; cells without a value are hatched.{thinned}"), data)
    }
}

/// Returns the outer edges of cells with this first and last centre.
fn edges((first, last): (f64, f64), count: usize, log: bool) -> (f64, f64) {
    let parts = 2.0 * (count.max(2) - 1) as f64;
    if log {
        let half = (last / first).powf(1.0 / parts);
        (first / half, last * half)
    } else {
        let half = (last - first) / parts;
        (first - half, last + half)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cell_centres_are_at_the_points() {
        assert_eq!(edges((1.0, 3.0), 3, false), (0.5, 3.5));
        let (from, to) = edges((1.0, 100.0), 3, true);
        assert!((from - 10f64.powf(-0.5)).abs() < 1e-12 && (to - 10f64.powf(2.5)).abs() < 1e-9, "{from}, {to}");
    }

    /// The first key increases upwards, the second to the right.
    #[test]
    fn a_cell_is_at_its_keys() {
        let keys = ["a".to_owned(), "b".to_owned()];
        let values = [vec![1.0, 1.0, 1.0, 2.0, 2.0, 2.0], vec![10.0, 20.0, 30.0, 10.0, 20.0, 30.0]];
        let data =
            Data { keys: &keys, values: &values, metric: "m", logs: &[false; 2], results: (0..6).map(f64::from).collect() };
        let map = draw(&data, (2, 3)).map.expect("a map");
        assert_eq!(map.columns, [[0.0, 3.0], [1.0, 4.0], [2.0, 5.0]]);
        assert_eq!((map.x, map.y, map.range), ((5.0, 35.0), (0.5, 2.5), (0.0, 5.0)));
    }
}
