//! Measured curves in the figures of a run, and their deviations from the simulated curves.
//!
//! ```text
//! r_i = y(x_i) - y_i        rms = sqrt(sum r_i^2 / n),  largest = max |r_i|
//! ```
//!
//! `y(x)` is interpolated linearly between the points of the simulated curve. Only measured points
//! within its range count.

use crate::metrics::Metrics;
use crate::numbers::number;
use report::{Figure, Series, Style, TableBlock};
use scene::Overlay;
use scene::figures::MEASURED;
use scene::metrics;
use scene::schema::unit_of;

/// Deviation of a simulated curve from a measured one.
#[derive(Clone, Debug, PartialEq)]
pub struct Residual {
    /// Name of the measured curve in the legend.
    pub name: String,
    /// Id of the figure with both curves.
    pub figure: String,
    /// Column of the simulated curve.
    pub quantity: String,
    /// Number of measured points within the range of the simulated curve.
    pub points: usize,
    /// Root mean square of the differences, in the unit of the quantity.
    pub rms: f64,
    /// Largest absolute difference.
    pub largest: f64,
}

/// Metrics of a unit: symbol, factor to the unit of the metrics, names of root mean square and
/// largest.
type UnitMetrics = (&'static str, f64, &'static str, &'static str);

/// Units of residuals.
const UNITS: [UnitMetrics; 14] = [
    ("N", 1.0, "overlay_rms_n", "overlay_max_n"),
    ("m/s", 1.0, "overlay_rms_m_per_s", "overlay_max_m_per_s"),
    ("Hz", 1.0, "overlay_rms_hz", "overlay_max_hz"),
    ("m", 1.0, "overlay_rms_m", "overlay_max_m"),
    ("mm", 1e-3, "overlay_rms_m", "overlay_max_m"),
    ("um", 1e-6, "overlay_rms_m", "overlay_max_m"),
    ("nm", 1e-9, "overlay_rms_m", "overlay_max_m"),
    ("W", 1.0, "overlay_rms_w", "overlay_max_w"),
    ("mW", 1e-3, "overlay_rms_w", "overlay_max_w"),
    ("V", 1.0, "overlay_rms_v", "overlay_max_v"),
    ("J", 1.0, "overlay_rms_j", "overlay_max_j"),
    ("rad/s", 1.0, "overlay_rms_rad_per_s", "overlay_max_rad_per_s"),
    ("S", 1.0, "overlay_rms_siemens", "overlay_max_siemens"),
    ("1", 1.0, "overlay_rms", "overlay_max"),
];

/// Returns the unit of a curve from the name of its column. A susceptance is in siemens, although
/// its suffix `_s` denotes seconds elsewhere.
fn unit(quantity: &str) -> String {
    if quantity.starts_with("susceptance") { "S".into() } else { unit_of(quantity).unwrap_or_else(|| "1".into()) }
}

/// Figures of a run with measured curves.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Overlaid {
    /// Figures of the run.
    pub figures: Vec<Figure>,
    /// Residuals of the measured curves that were drawn.
    pub residuals: Vec<Residual>,
    /// Measured curves that were not drawn, with the reasons: one sentence each.
    pub not_drawn: Vec<String>,
}

/// Draws the measured curves in their figures. `hz` is the excitation frequency, for an axis in
/// periods of the excitation.
pub fn lay(mut figures: Vec<Figure>, overlays: &[Overlay], hz: Option<f64>) -> Overlaid {
    let (mut residuals, mut not_drawn) = (Vec::new(), Vec::new());
    for overlay in overlays {
        match figures.iter_mut().find_map(|figure| over(figure, overlay, hz)) {
            Some(residual) => residuals.push(residual),
            None => not_drawn.push(not_drawn_because(&figures, overlay, hz)),
        }
    }
    Overlaid { figures, residuals, not_drawn }
}

/// Returns the sentence that states why a measured curve was not drawn.
fn not_drawn_because(figures: &[Figure], overlay: &Overlay, hz: Option<f64>) -> String {
    let has = |figure: &&Figure| figure.series.iter().any(|series| series.csv_column == overlay.quantity);
    let named = overlay.figure.as_ref().filter(|id| figures.iter().all(|figure| figure.id != **id));
    let why = match (named, figures.iter().find(has)) {
        (Some(id), _) => format!("this run has no figure `{id}`"),
        (None, None) => format!("no figure of this run has the curve `{}`", overlay.quantity),
        (None, Some(figure)) if figure.map.is_some() => format!("the figure `{}` is a map", figure.id),
        (None, Some(figure)) => {
            let (id, axis) = (&figure.id, &figure.x.label);
            let simulated = figure.series.iter().find(|series| series.csv_column == overlay.quantity);
            match (places(figure, overlay, hz).and_then(|x| ends(&x)), simulated.and_then(|series| ends(&series.x))) {
                (Some((from, to)), Some((least, most))) => {
                    let [from, to, least, most] = [from, to, least, most].map(number);
                    format!(
                        "its points range from {from} to {to}, but the curve of figure `{id}` ranges from {least} to {most}, \
                         {axis}"
                    )
                }
                _ => format!(
                    "the axis of figure `{id}` is {axis}, but the unit of the points is {}",
                    overlay.x_unit.as_deref().unwrap_or("none")
                ),
            }
        }
    };
    let ids: Vec<String> = figures.iter().map(|figure| format!("`{}`", figure.id)).collect();
    let ids = if ids.is_empty() { "none".to_owned() } else { ids.join(", ") };
    format!("The curve `{}` is not drawn and not compared: {why}. Figures of this run: {ids}.", overlay.legend())
}

fn over(figure: &mut Figure, overlay: &Overlay, hz: Option<f64>) -> Option<Residual> {
    if figure.map.is_some() || !overlay.lies_over(&figure.id, figure.series.iter().map(|series| series.csv_column.as_str())) {
        return None;
    }
    let x = places(figure, overlay, hz)?;
    let mut points: Vec<(f64, f64)> = x.into_iter().zip(overlay.values.iter().copied()).collect();
    if figure.interactive {
        // A plot with zoom needs sorted points.
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    let (x, y): (Vec<f64>, Vec<f64>) = points.into_iter().unzip();
    let simulated = figure.series.iter().find(|series| series.csv_column == overlay.quantity)?;
    let (least, most) = ends(&simulated.x).filter(|(least, most)| x.iter().any(|x| (least..=most).contains(&x)))?;
    let residual = residual(simulated, &x, &y).map(|(points, rms, largest)| Residual {
        name: overlay.legend(),
        figure: figure.id.clone(),
        quantity: overlay.quantity.clone(),
        points,
        rms,
        largest,
    });
    // A long measurement must not compress the run to a small part of its figure.
    if x.iter().any(|x| *x < least || *x > most) {
        figure.x.range.get_or_insert((least, most));
    }
    let csv_column = format!("{MEASURED}{}", overlay.quantity);
    figure.series.push(Series { name: overlay.legend(), csv_column, x, y, style: Style::Points });
    // A curve that is not monotonic in x has no residual, but is drawn.
    Some(residual.unwrap_or_else(|| Residual {
        name: overlay.legend(),
        figure: figure.id.clone(),
        quantity: overlay.quantity.clone(),
        points: 0,
        rms: f64::NAN,
        largest: f64::NAN,
    }))
}

/// Converts the measured points to the axis of a figure; `None` if they have another quantity.
fn places(figure: &Figure, overlay: &Overlay, hz: Option<f64>) -> Option<Vec<f64>> {
    let axis = figure.x.label.rsplit_once('[').and_then(|(_, rest)| rest.split(']').next());
    match (axis, hz) {
        (Some("periods of the excitation"), Some(hz)) => {
            Some(overlay.along(Some("s"))?.into_iter().map(|time_s| hz * time_s).collect())
        }
        _ => overlay.along(axis),
    }
}

/// Returns the smallest and the largest place, if there are any.
fn ends(places: &[f64]) -> Option<(f64, f64)> {
    let finite = places.iter().copied().filter(|x| x.is_finite());
    finite.fold(None, |ends: Option<(f64, f64)>, x| Some(ends.map_or((x, x), |(least, most)| (least.min(x), most.max(x)))))
}

/// Returns number of points, root mean square and largest difference; `None` if the curve is not
/// monotonic in x, or if no point is within its range.
fn residual(simulated: &Series, x: &[f64], y: &[f64]) -> Option<(usize, f64, f64)> {
    let ascends = simulated.x.is_sorted_by(|a, b| a <= b);
    let value = |place: f64| {
        let after = simulated.x.partition_point(|&x| x <= place);
        let (before, after) = (after.checked_sub(1)?, after.min(simulated.x.len().checked_sub(1)?));
        let [(x0, y0), (x1, y1)] = [before, after].map(|at| (simulated.x[at], simulated.y[at]));
        // The last place itself is within the range.
        let part = if place == x0 { 0.0 } else { (place - x0) / (x1 - x0) };
        (0.0..=1.0).contains(&part).then_some(if part == 0.0 { y0 } else { y0 + (y1 - y0) * part })
    };
    let differences: Vec<f64> = x
        .iter()
        .zip(y)
        .filter_map(|(&place, measured)| Some(value(place)? - measured))
        .filter(|difference| difference.is_finite())
        .collect();
    if !ascends || differences.is_empty() {
        return None;
    }
    let squares: f64 = differences.iter().map(|difference| difference * difference).sum();
    let largest = differences.iter().fold(0.0f64, |most, difference| most.max(difference.abs()));
    Some((differences.len(), (squares / differences.len() as f64).sqrt(), largest))
}

/// Returns `true` if a metric compares a measured curve with a simulated one.
pub fn is_metric(name: &str) -> bool {
    let name = metrics::of_one_run(name).map_or(name, |metric| metric.name);
    UNITS.iter().any(|(.., rms, max)| [*rms, *max].contains(&name))
}

/// Adds the residuals to the metrics: for several overlays in one unit, the worst.
pub(crate) fn put<'a>(residuals: impl IntoIterator<Item = &'a Residual>, metrics: &mut Metrics) {
    let residuals: Vec<&Residual> = residuals.into_iter().collect();
    if residuals.is_empty() {
        return;
    }
    let names = |which: fn(&UnitMetrics) -> &'static str| {
        let mut names: Vec<&'static str> = UNITS.iter().map(which).collect();
        names.dedup();
        names
    };
    let worst = |name: &str, value: fn(&Residual) -> f64| {
        let of = |residual: &&Residual| {
            let unit = unit(&residual.quantity);
            let (_, factor, ..) = UNITS.iter().find(|(symbol, _, rms, max)| *symbol == unit && [*rms, *max].contains(&name))?;
            Some(factor * value(residual)).filter(|value| value.is_finite())
        };
        residuals.iter().filter_map(of).reduce(f64::max)
    };
    for name in names(|unit| unit.2) {
        metrics.put(name, worst(name, |residual| residual.rms));
    }
    for name in names(|unit| unit.3) {
        metrics.put(name, worst(name, |residual| residual.largest));
    }
}

/// Returns the residuals as a table.
pub fn table(residuals: &[Residual]) -> TableBlock {
    let rows = residuals.iter().map(|residual| {
        let unit = unit(&residual.quantity);
        let shown = |value: f64| if value.is_finite() { format!("{} {unit}", number(value)) } else { "–".to_owned() };
        let cells = [residual.name.clone(), residual.figure.clone(), residual.quantity.clone(), residual.points.to_string()];
        cells.into_iter().chain([shown(residual.rms), shown(residual.largest)]).collect()
    });
    let caption = "Simulated minus measured, at the measured points within the range of the simulated curve";
    let header = ["measured curve", "figure", "simulated curve", "points", "rms", "largest"];
    TableBlock::new("overlays", "Measured and simulated", caption, &header, rows.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(x: &[f64], y: &[f64]) -> Series {
        Series { name: "friction".into(), csv_column: "friction_n".into(), x: x.into(), y: y.into(), style: Style::Line }
    }

    #[test]
    fn residuals_use_points_within_the_simulated_range() {
        let curve = line(&[0.0, 1.0, 2.0], &[0.0, 2.0, 2.0]);
        let (points, rms, largest) = residual(&curve, &[-1.0, 0.0, 0.5, 2.0, 2.1], &[9.0, 0.0, 1.5, 1.0, 9.0]).unwrap();
        assert_eq!((points, largest), (3, 1.0));
        assert!((rms - (1.25f64 / 3.0).sqrt()).abs() < 1e-15, "{rms}");
        assert_eq!(residual(&curve, &[3.0], &[0.0]), None);
        assert_eq!(residual(&line(&[0.0, 1.0, 0.5], &[0.0; 3]), &[0.2], &[0.0]), None);
    }

    #[test]
    fn curve_without_a_figure_is_reported_with_the_reason() {
        let figure = Figure {
            id: "friction".into(),
            x: report::Axis { label: "time [s]".into(), ..report::Axis::default() },
            series: vec![line(&[0.0, 1.0], &[0.0, 2.0])],
            ..Figure::default()
        };
        let overlay = |quantity: &str, figure: Option<&str>, unit: &str| {
            let read = serde_json::json!({ "quantity": quantity, "figure": figure, "x_unit": unit, "x": [0.5], "values": [1.0] });
            serde_json::from_value::<Overlay>(read).expect("an overlay")
        };
        let beyond = Overlay { x: [2.5].into(), ..overlay("friction_n", None, "s") };
        let overlays = [
            overlay("friction_n", None, "s"),
            overlay("friction_n", Some("hysteresis"), "s"),
            overlay("load_cell_n", None, "s"),
            overlay("friction_n", None, "m"),
            beyond,
        ];
        let laid = lay(vec![figure], &overlays, None);
        assert_eq!((laid.residuals.len(), laid.figures[0].series.len(), laid.not_drawn.len()), (1, 2, 4));
        let why = [
            "no figure `hysteresis`",
            "no figure of this run has the curve `load_cell_n`",
            "the axis of figure `friction` is time [s], but the unit of the points is m",
            "its points range from 2.5 to 2.5, but the curve of figure `friction` ranges from 0 to 1, time [s]",
        ];
        for (said, why) in laid.not_drawn.iter().zip(why) {
            assert!(said.contains(why) && said.ends_with("Figures of this run: `friction`."), "{said}");
        }
    }

    #[test]
    fn every_unit_has_its_metrics() {
        for (unit, _, rms, max) in UNITS {
            for name in [rms, max] {
                let metric = metrics::metric(name).unwrap_or_else(|| panic!("no metric {name}"));
                assert!(unit.ends_with(metric.unit) || unit == "1", "{unit} {}", metric.unit);
            }
        }
        assert_eq!((unit("friction_n"), unit("power_mw"), unit("susceptance_true_s")), ("N".into(), "mW".into(), "S".into()));
    }

    #[test]
    fn worst_of_two_curves_in_one_unit_counts() {
        let of = |quantity: &str, rms: f64| Residual {
            name: String::new(),
            figure: String::new(),
            quantity: quantity.into(),
            points: 1,
            rms,
            largest: 2.0 * rms,
        };
        let mut metrics = Metrics::default();
        put(&[of("displacement_um", 3.0), of("belt_true_mm", 2.0), of("friction_n", f64::NAN)], &mut metrics);
        assert_eq!((metrics.get("overlay_rms_m"), metrics.get("overlay_max_m")), (Some(2e-3), Some(4e-3)));
        assert_eq!(metrics.get("overlay_rms_n"), None);
    }
}
