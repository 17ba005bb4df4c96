//! Detents of a knob: depth and lag of the friction over its position.
//!
//! The fundamentals of command, estimate and truth over whole detents are compared,
//! `2 / n sum r exp(i 2 pi x / p)`, with each block weighted by its displacement. The magnitude is
//! half the depth, and the angle is the lag of the friction.

use std::f64::consts::TAU;

use super::set_point::SetPoint;
use crate::instruments::View;
use crate::instruments::curves::{axis, mean};
use crate::metrics::Metrics;
use crate::record::Row;
use report::{Figure, Series, Style};

/// Number of detents in the figure, the last ones.
const SHOWN_DETENTS: f64 = 3.0;
/// Maximum number of points of a curve; a single block does not contain whole vibration periods.
const MAX_POINTS: usize = 240;

/// Fundamental of the command below which the detents have no depth.
const MIN_FUNDAMENTAL: f64 = 1e-6;

/// Blocks of a knob turned over whole detents in one direction.
pub(super) struct Detents<'a> {
    rows: &'a [Row],
    pitch_m: f64,
    coulomb_n: f64,
    set_point: SetPoint<'a>,
}

impl<'a> Detents<'a> {
    /// Collects the whole detents that a knob passes while the last set point is held; `None` for
    /// fewer than two.
    pub(super) fn from_run(run: &'a View) -> Option<Self> {
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

    /// Returns the fundamental over the detents, real and imaginary part; a block without a value
    /// counts as zero.
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

    /// Adds depth and lag of the detents.
    pub(super) fn metrics(&self, metrics: &mut Metrics) {
        // Negative if the friction is lowest at a detent.
        let command = self.fundamental(|row| Some(self.set_point.at(row))).0;
        if command.abs() < MIN_FUNDAMENTAL {
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

    /// Returns the figure of command, estimate and truth over the knob's position.
    pub(super) fn figure(&self) -> Figure {
        let place_m = |row: &Row| row.truth.belt_position_m;
        let last_m = self.rows.last().map_or(0.0, place_m);
        let shown = &self.rows[self.rows.partition_point(|row| (last_m - place_m(row)).abs() > SHOWN_DETENTS * self.pitch_m)..];
        let bins = || shown.chunks(shown.len().div_ceil(MAX_POINTS));
        let series = |name: &str, column: &str, style: Style, value: &dyn Fn(&Row) -> f64| {
            let (x, y) = bins().map(|bin| (1e3 * mean(bin, place_m), mean(bin, value))).unzip();
            Series { name: name.into(), csv_column: column.into(), x, y, style }
        };
        let estimate = |row: &Row| row.friction.map_or(f64::NAN, |estimate| f64::from(estimate.ratio));
        Figure {
            id: "detents".into(),
            title: "Detents: command, estimate, truth".into(),
            caption:
                "Friction ratio over the last detents of the knob, which lie at whole multiples of their pitch. The command is \
                 that at the knob's true position; each point is a mean over several blocks."
                    .into(),
            x: axis("travel of the knob [mm]"),
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
