//! The detents of a knob: how deep and how late the friction follows their course.
//!
//! Of command, estimate and truth over whole detents the fundamental is compared, `2 / n sum r exp(i 2 pi x / p)`, every block by the way that was made in it:
//! its magnitude is half the depth, and its angle says how far behind the course the friction is.

use std::f64::consts::TAU;

use super::set_point::SetPoint;
use crate::instruments::View;
use crate::instruments::curves::{axis, mean};
use crate::metrics::Metrics;
use crate::record::Row;
use report::{Figure, Series, Style};

/// Detents that the figure shows, the last ones, and the points of a curve: a block alone is no whole number of periods.
const SHOWN: f64 = 3.0;
const POINTS: usize = 240;

/// What rises and falls by less than this has no depth.
const FLAT: f64 = 1e-6;

/// Blocks of a knob that is turned over detents, all of the same way.
pub(super) struct Detents<'a> {
    rows: &'a [Row],
    pitch_m: f64,
    coulomb_n: f64,
    set_point: SetPoint<'a>,
}

impl<'a> Detents<'a> {
    /// The whole detents that a knob is turned over while the last set point is held; none of less than two.
    pub(super) fn of(run: &'a View) -> Option<Self> {
        let friction = run.scene.controller.friction.as_ref().filter(|friction| friction.detent_pitch_m > 0.0)?;
        let coulomb_n = run.silent_friction_n()?;
        let (held, pitch_m) = (run.held()?, friction.detent_pitch_m);
        let place = |row: &Row| row.truth.belt_position_m / pitch_m;
        let (from, to) = (place(held.first()?), place(held.last()?));
        let (least, most) = (from.min(to).ceil(), from.max(to).floor());
        let within = |row: &&Row| (least..most).contains(&place(row));
        let first = held.iter().position(|row| within(&row))?;
        let rows = &held[first..=held.iter().rposition(|row| within(&row))?];
        (most - least >= 2.0).then_some(Detents { rows, pitch_m, coulomb_n, set_point: SetPoint::new(friction, coulomb_n) })
    }

    fn truth(&self, row: &Row) -> f64 {
        row.truth.friction_mean_n / self.coulomb_n
    }

    /// The fundamental over the detents, real and imaginary part; a block without a value counts as it would without friction.
    fn fundamental(&self, value: impl Fn(&Row) -> Option<f64>) -> (f64, f64) {
        let (mut re, mut im, mut way) = (0.0, 0.0, 0.0);
        for pair in self.rows.windows(2) {
            let moved_m = (pair[1].truth.belt_position_m - pair[0].truth.belt_position_m).abs();
            let (sin, cos) = (TAU * pair[1].truth.belt_position_m / self.pitch_m).sin_cos();
            let value = value(&pair[1]).unwrap_or(0.0);
            (re, im, way) = (re + value * cos * moved_m, im + value * sin * moved_m, way + moved_m);
        }
        (2.0 * re / way, 2.0 * im / way)
    }

    /// Adds depth and lag.
    pub(super) fn metrics(&self, metrics: &mut Metrics) {
        // Less than zero where the friction is lowest at a detent.
        let command = self.fundamental(|row| Some(self.set_point.at(row))).0;
        if command.abs() < FLAT {
            return;
        }
        let estimate = self.fundamental(|row| row.friction.map(|estimate| f64::from(estimate.ratio)));
        let (re, im) = self.fundamental(|row| Some(self.truth(row)));
        metrics.put("detent_depth", re.hypot(im) / command.abs());
        metrics.put("detent_depth_estimate", estimate.0.hypot(estimate.1) / command.abs());
        let (Some(first), Some(last)) = (self.rows.first(), self.rows.last()) else { return };
        let speed = (last.truth.belt_position_m - first.truth.belt_position_m) / (last.time_s - first.time_s);
        let behind_m = self.pitch_m / TAU * (im / command).atan2(re / command);
        metrics.put("detent_lag_ms", 1e3 * behind_m / speed);
    }

    /// Command, estimate and truth over the knob's position.
    pub(super) fn figure(&self) -> Figure {
        let place_m = |row: &Row| row.truth.belt_position_m;
        let last_m = self.rows.last().map_or(0.0, place_m);
        let shown = &self.rows[self.rows.partition_point(|row| (last_m - place_m(row)).abs() > SHOWN * self.pitch_m)..];
        let bins = || shown.chunks(shown.len().div_ceil(POINTS));
        let series = |name: &str, column: &str, style: Style, value: &dyn Fn(&Row) -> f64| {
            let (x, y) = bins().map(|bin| (1e3 * mean(bin, place_m), mean(bin, value))).unzip();
            Series { name: name.into(), csv_column: column.into(), x, y, style }
        };
        let estimate = |row: &Row| row.friction.map_or(f64::NAN, |estimate| f64::from(estimate.ratio));
        Figure {
            id: "detents".into(),
            title: "Detents: command, estimate, truth".into(),
            caption: "The friction ratio as the knob is turned over its last detents, at whole multiples of their distance. The command is that of the knob's true position; each point is a \
                      mean over some blocks."
                .into(),
            x: axis("way of the knob [mm]"),
            y: axis("friction ratio"),
            series: vec![
                series("truth", "friction_ratio_true", Style::Line, &|row| self.truth(row)),
                series("controller's estimate", "friction_ratio_estimate", Style::Line, &estimate),
                series("command", "friction_ratio_wanted", Style::Dashed, &|row| self.set_point.at(row)),
            ],
            interactive: true,
            ..Figure::default()
        }
    }
}
