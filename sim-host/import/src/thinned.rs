//! Figures of long measurements. A million measured points need not be written into the files of
//! several figures again.

use report::Figure;
use report::decimate::keep;

/// Largest number of points of a series; a longer one keeps its extremes.
const MAX_POINTS: usize = 20_000;

/// Thins the long series of a figure; its caption then states the number of points.
pub(crate) fn thinned(mut figure: Figure) -> Figure {
    let longest = figure.series.iter().map(|series| series.x.len()).max().unwrap_or(0);
    for series in figure.series.iter_mut().filter(|series| series.x.len() > MAX_POINTS) {
        let places = keep(&[&series.x, &series.y], MAX_POINTS);
        let at = |values: &[f64]| places.iter().map(|&place| values[place]).collect();
        (series.x, series.y) = (at(&series.x), at(&series.y));
    }
    if longest > MAX_POINTS {
        figure.caption += &format!(" Of {longest} points, {MAX_POINTS} with all extremes are shown.");
    }
    figure
}

#[cfg(test)]
mod tests {
    use report::Series;

    use super::*;

    #[test]
    fn a_long_series_keeps_its_extremes() {
        let x: Vec<f64> = (0..1_000_000).map(f64::from).collect();
        let mut y = vec![0.0; x.len()];
        y[123_456] = 7.0;
        let series = |x: &[f64], y: &[f64]| Series { x: x.to_vec(), y: y.to_vec(), ..Series::default() };
        let figure = Figure { series: vec![series(&x, &y), series(&x[..9], &y[..9])], ..Figure::default() };
        let [long, short] = &thinned(figure.clone()).series[..] else { panic!() };
        assert!(long.x.len() <= MAX_POINTS && long.y.contains(&7.0) && short.x == x[..9], "{}", long.x.len());
        assert!(thinned(figure).caption.contains("1000000"));
    }
}
